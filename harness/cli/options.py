"""The parser of the command line: how the values of its options are read, and their defaults."""

import math
import textwrap
from importlib import metadata
from pathlib import Path
from typing import Any

from harness.cli.help import HELP, Option, epilog
from harness.cli.parser import BYTES, Parser, html_file, number, positive_count, share
from mpm_warp.execution import THREAD_COUNTS

RESULTS = Path("results")
PATHS = ("DIR", "FILE", "OTHER", "TEST", "CSV", "SITE")
"""What values that are paths are called."""
VALUES: dict[str, dict[str, Any]] = {
    "--out": {"default": RESULTS},
    "--set": {"action": "append", "default": []},
    "--threads": {"type": int, "choices": THREAD_COUNTS},
    "--device": {"default": "cpu"},
    "new --scene": {"default": "cone_penetration"},
    "run --workers": {"type": positive_count},
    "run --batch": {"type": positive_count, "default": 1},
    "run --case-timeout": {"type": number("a number > 0"), "default": math.inf},
    "run --memory-limit": {"type": number("> 0, as 8e9 or 8GB", BYTES)},
    "schema of": {"choices": ("study", "site"), "default": "study"},
    "verify --scene": {"action": "extend", "default": []},
    "interpret --check": {"nargs": "?", "const": "quick", "choices": ("quick", "standard")},
    "benchmark action": {"choices": ("run", "score")},
    "benchmark --accuracy": {"choices": ("quick", "standard", "fine"), "default": "standard"},
    "benchmark --against": {"default": "mpm_warp_standard"},
    "compare --tolerance": {"type": number("a number >= 0", or_zero=True)},
    "plot --format": {"choices": ("png", "pdf", "svg"), "default": ["png"]},
    "report --out": {"type": html_file, "default": Path("report.html")},
    "recommend --error": {"type": share, "required": True},
    "recommend --results": {"default": RESULTS},
    "help about": {"choices": tuple(HELP)},
    "completion shell": {"choices": ("bash", "zsh", "fish")},
}
"""How values are read that are neither a text nor a path, by the keys of the options."""
EITHER = ("run --workers", "run --dask")
"""Options of which one alone may be given."""


def make_parser() -> Parser:
    """The parser.

    Of what it parses the attribute `command` is the name of the command, and `function` its module
    in `harness.cli.commands` and its function, which takes the options and returns the exit code.
    """
    parser = Parser(
        prog="harness",
        description="Parametric studies of cone penetration by the material point method.",
        epilog="first steps:\n"
        "  harness run adhesion_factor    the main job, in half a minute\n"
        "  harness new my_study           a study of your own, to be edited and run\n"
        "  harness help COMMAND           options and examples of a command",
    )
    parser.add_argument("--version", action="version", version=_version())
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")
    for name, told in HELP.items():
        command = commands.add_parser(
            name,
            help=told.summary,
            description=textwrap.fill(told.description, 80),
            epilog=epilog(name),
        )
        command.set_defaults(function=told.function)
        either = command.add_mutually_exclusive_group() if name == "run" else command
        for option in told.options:
            place = either if option.key in EITHER else command
            place.add_argument(*option.names, **_as_argument(option))
        debug = "print where an error of the program arises"
        command.add_argument("--debug", action="store_true", help=debug)
    return parser


def _as_argument(option: Option) -> dict[str, Any]:
    """What `argparse` has to know of an option."""
    if not option.value and option.key not in VALUES:
        return {"action": "store_true", "help": option.meaning}
    argument: dict[str, Any] = {"help": option.meaning.replace("%", "%%") or None}
    name = option.value.removesuffix("...").strip("[]")
    if name:
        argument["metavar"] = name
    if option.value != name:
        argument["nargs"] = "+" if option.value.endswith("...") else "?"
    if name in PATHS:
        argument["type"] = Path
    return argument | VALUES.get(option.key, {})


def _version() -> str:
    try:
        return f"harness {metadata.version('mpm-warp')}"
    except metadata.PackageNotFoundError:
        return "harness, of a source tree that is not installed"
