"""What the command line takes: its commands and their options."""

from __future__ import annotations

import textwrap

from harness.cli.arguments.definitions import add_definitions
from harness.cli.arguments.help import HELP, epilog
from harness.cli.arguments.parser import Parser, Version
from harness.cli.arguments.results import add_results
from harness.cli.arguments.runs import add_runs

SHELLS = ("bash", "zsh", "fish")
"""Shells that the command line can be completed in."""


def make_parser() -> Parser:
    """The parser; the attribute `command` of what it parses is the name of the command."""
    parser = Parser(
        prog="harness",
        description="Parametric studies of cone penetration by the material point method.",
        epilog="first steps:\n"
        "  harness run adhesion_factor    the main job, in half a minute\n"
        "  harness new my_study           a study of your own, to be edited and run\n"
        "  harness help COMMAND           options and examples of a command",
    )
    parser.add_argument("--version", action=Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")

    add_definitions(commands)
    add_runs(commands)
    add_results(commands)

    about = commands.add_parser("help", help="print the commands, or the options of one")
    about.add_argument("about", nargs="?", metavar="COMMAND", choices=tuple(HELP))

    completion = commands.add_parser("completion", help="let a shell complete by the Tab key")
    completion.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))

    for name, command in commands.choices.items():
        command.add_argument(
            "--debug", action="store_true", help="print where an error of the program arises"
        )
        command.description = textwrap.fill(HELP[name][0], 80)
        command.epilog = epilog(name)
    return parser
