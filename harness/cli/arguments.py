"""What the command line takes: its commands and their options."""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from harness.cli.argument_values import (
    finite_number,
    html_file,
    positive_count,
    share,
    size_in_bytes,
)
from harness.cli.command_help import HELP, epilog
from harness.cli.exit_codes import BAD_INPUT
from harness.errors import LONGEST_LINE, printable, shortened
from mpm_warp.execution import THREAD_COUNTS

SHELLS = ("bash", "zsh", "fish")
"""Shells that the command line can be completed in."""

if TYPE_CHECKING:
    _Commands = argparse._SubParsersAction["_Parser"]


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like all others, and that takes no options cut short."""

    def __init__(self, **options: Any) -> None:
        layout = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=layout, **options)

    def error(self, message: str) -> NoReturn:
        line = shortened(printable(message), LONGEST_LINE)
        self.exit(BAD_INPUT, f"{self.prog}: {line}; see {self.prog} --help\n")


class _Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> NoReturn:
        from importlib.metadata import PackageNotFoundError, version

        try:
            print(f"harness {version('mpm-warp')}")
        except PackageNotFoundError:
            print("harness, of a source tree that is not installed")
        parser.exit()


def make_parser() -> argparse.ArgumentParser:
    """The parser; the attribute `command` of what it parses is the name of the command."""
    parser = _Parser(
        prog="harness",
        description="Parametric studies of the material point method.",
        epilog="first steps:\n"
        "  harness run adhesion_factor    the main job, in some seconds\n"
        "  harness new my_study           a study of your own, to be edited and run\n"
        "  harness help COMMAND           options and examples of a command",
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")

    _add_definitions(commands)

    run = commands.add_parser("run", help="run a study; run it again to go on where it stopped")
    _add_study(run)
    where = run.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=positive_count,
        metavar="N",
        help="processes, each with a case at a time; default: one for each core, or for each "
        "--threads of them",
    )
    where.add_argument(
        "--dask", metavar="ADDRESS", help="run on a Dask cluster, by its scheduler's address"
    )
    _add_execution(run)
    run.add_argument(
        "--batch",
        type=positive_count,
        default=1,
        metavar="N",
        help="cases that a process computes together, to fill a GPU; default: 1",
    )
    run.add_argument(
        "--snapshots",
        metavar="LIST",
        help="keep the soil of each case at these moments, for `harness view`: 5,10 of the "
        "penetration over the cone radius",
    )
    run.add_argument(
        "--uncertainty",
        action="store_true",
        help="measure the uncertainty of each cone factor by further runs of its case, some ten "
        "times as long; the same as --set uncertainty=measured",
    )
    run.add_argument("--fresh", action="store_true", help="run what is done already again")
    run.add_argument(
        "--case-timeout",
        type=finite_number("a number > 0", lambda it: it > 0),
        default=math.inf,
        metavar="SECONDS",
        help="end a case that computes for longer; default: none is ended",
    )
    run.add_argument(
        "--memory-limit",
        type=size_in_bytes,
        metavar="SIZE",
        help="memory that the cases at work may take together, as 8e9 or 8GB; one that needs more "
        "than its share is refused; default: most of this machine's",
    )

    status = commands.add_parser("status", help="list how the cases of a study stand")
    status.add_argument(
        "study",
        nargs="?",
        metavar="STUDY",
        help="name of a study, a TOML file, or a result; none, or a scene: all results",
    )
    _add_settings(status)
    status.add_argument(
        "--traceback", action="store_true", help="print where in the program failed cases failed"
    )

    collect = commands.add_parser("collect", help="write the dataset of what is done of a study")
    _add_study(collect)

    clean = commands.add_parser("clean", help="remove files that are no results of a study")
    _add_study(clean)
    clean.add_argument("--yes", action="store_true", help="remove without asking")

    rerun = commands.add_parser("rerun", help="run a case again and compare every bit")
    rerun.add_argument("file", type=Path, metavar="FILE", help="of a case, or result of a study")
    rerun.add_argument("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
    _add_execution(rerun)

    verify = commands.add_parser("verify", help="hold scenes against their exact solutions")
    verify.add_argument(
        "--scene", nargs="+", action="extend", default=[], metavar="NAME", help="default: all"
    )
    verify.add_argument("--extreme", action="store_true", help="run the extreme cases instead")
    verify.add_argument(
        "--out", type=Path, metavar="DIR", help="write dataset, table and picture there"
    )

    bench = commands.add_parser("bench", help="measure what a step costs on this machine")
    _add_settings(bench)
    _add_device(bench)

    _add_results(commands)

    about = commands.add_parser("help", help="print the commands, or the options of one")
    about.add_argument("about", nargs="?", metavar="COMMAND", choices=tuple(HELP))

    completion = commands.add_parser("completion", help="let a shell complete by the Tab key")
    completion.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))

    for name, command in commands.choices.items():
        command.description = textwrap.fill(HELP[name][0], 80)
        command.epilog = epilog(name)
    return parser


def _add_definitions(commands: _Commands) -> None:
    """The commands that take or write definitions of studies."""
    new = commands.add_parser("new", help="write a study of your own, to be edited and run")
    new.add_argument("name", metavar="NAME", help="of the study; its file is NAME.toml")
    new.add_argument(
        "--scene", default="cone_penetration", metavar="SCENE", help="default: cone_penetration"
    )

    commands.add_parser("list", help="list studies and scenes")

    describe = commands.add_parser("describe", help="describe a scene, or a study")
    _add_subject(describe)

    commands.add_parser("schema", help="print a JSON schema of studies, for editors")

    plan = commands.add_parser("plan", help="say what a scene or a study takes, before it runs")
    _add_subject(plan)
    _add_set(plan)


def options_of(parser: argparse.ArgumentParser, command: str) -> list[str]:
    """The options of a command, as ``--out``."""
    (commands,) = (it for it in parser._actions if isinstance(it.choices, dict))
    assert isinstance(commands.choices, dict)
    return [
        option
        for action in commands.choices[command]._actions
        for option in action.option_strings
        if option.startswith("--")
    ]


def _add_results(commands: _Commands) -> None:
    """The commands that take results of studies."""
    references = commands.add_parser("references", help="list what results are compared with")
    references.add_argument("id", nargs="?", metavar="ID", help="name of one; default: all")

    compare = commands.add_parser("compare", help="compare a result with the references")
    compare.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    compare.add_argument(
        "other", type=Path, nargs="?", metavar="OTHER", help="a result to set beside it"
    )
    compare.add_argument(
        "--tolerance",
        type=finite_number("a number >= 0", lambda it: it >= 0),
        metavar="X",
        help="relative difference allowed between FILE and OTHER; default: none",
    )

    plot = commands.add_parser("plot", help="draw the pictures of a result")
    plot.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    plot.add_argument("--out", type=Path, metavar="DIR", help="default: the folder of FILE")
    plot.add_argument(
        "--format",
        nargs="+",
        choices=("png", "pdf", "svg"),
        default=["png"],
        metavar="FORMAT",
        help="png, the default, pdf or svg; several are allowed",
    )

    view = commands.add_parser("view", help="draw the soil of a case around its penetrometer")
    view.add_argument("file", type=Path, metavar="FILE", help="result of a study, or of a case")
    view.add_argument("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
    view.add_argument("--out", type=Path, metavar="DIR", help="default: the folder of FILE")
    view.add_argument(
        "--vtk", action="store_true", help="write points, grid and surface for ParaView too"
    )

    report = commands.add_parser("report", help="write one page of HTML on results")
    report.add_argument("file", type=Path, nargs="+", metavar="FILE", help="result of a study")
    report.add_argument("-o", "--out", type=html_file, default=Path("report.html"), metavar="HTML")

    recommend = commands.add_parser("recommend", help="name the cheapest settings for an error")
    recommend.add_argument("scene", metavar="SCENE")
    recommend.add_argument(
        "--error", type=share, required=True, metavar="X", help="largest error, as 1%% or 0.01"
    )
    recommend.add_argument(
        "--results", type=Path, default=Path("results"), metavar="DIR", help="default: results"
    )


def _add_study(command: argparse.ArgumentParser) -> None:
    command.add_argument("study", metavar="STUDY", help="name of a study, or a TOML file")
    _add_settings(command)


def _add_subject(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "subject", metavar="NAME", help="of a scene or a study, or the TOML file of a study"
    )


def _add_settings(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--out", type=Path, default=Path("results"), metavar="DIR", help="default: results"
    )
    _add_set(command)


def _add_set(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a parameter; a list, as in 'KEY=[1, 2]', varies it; repeatable",
    )


def _add_execution(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--threads",
        type=int,
        choices=THREAD_COUNTS,
        metavar="N",
        help="threads of a case, 1, 2 or 4, which do not change it; default: those that are idle",
    )
    _add_device(command)


def _add_device(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--device", default="cpu", metavar="NAME", help="cpu, the default, or a GPU: cuda:0, ..."
    )
