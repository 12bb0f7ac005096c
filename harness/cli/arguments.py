"""What the command line takes: its commands and their options."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from harness.cli.exit_codes import BAD_INPUT
from mpm_warp.execution import THREAD_COUNTS

UNITS = {"K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
"""First letters of units of memory, in bytes."""

if TYPE_CHECKING:
    _Commands = argparse._SubParsersAction["_Parser"]


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like all others, and that takes no options cut short."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def make_parser() -> argparse.ArgumentParser:
    """The parser; the attribute `command` of what it parses is the name of the command."""
    parser = _Parser(prog="harness", description="Parametric studies of the material point method.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")

    run = commands.add_parser("run", help="run a study; run it again to go on where it stopped")
    _add_study(run)
    where = run.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=_count,
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
        type=_count,
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
    run.add_argument("--fresh", action="store_true", help="run what is done already again")
    run.add_argument(
        "--case-timeout",
        type=_number("a number > 0", lambda number: number > 0),
        default=math.inf,
        metavar="SECONDS",
        help="end a case that computes for longer; default: none is ended",
    )
    run.add_argument(
        "--memory-limit",
        type=_bytes,
        metavar="SIZE",
        help="memory that the cases at work may take together, as 8e9 or 8GB; one that needs more "
        "than its share is refused; default: most of this machine's",
    )

    status = commands.add_parser("status", help="list how the cases of a study stand")
    _add_study(status)

    collect = commands.add_parser("collect", help="write the dataset of what is done of a study")
    _add_study(collect)

    clean = commands.add_parser("clean", help="remove files that are no results of a study")
    _add_study(clean)
    clean.add_argument("--yes", action="store_true", help="remove without asking")

    rerun = commands.add_parser("rerun", help="run a case again and compare every bit")
    rerun.add_argument("file", type=Path, metavar="FILE", help="of a case, or result of a study")
    rerun.add_argument("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
    _add_execution(rerun)

    commands.add_parser("list", help="list studies and scenes")

    describe = commands.add_parser("describe", help="list the parameters of a scene")
    describe.add_argument("scene", metavar="SCENE")

    commands.add_parser("schema", help="print a JSON schema of studies, for editors")

    plan = commands.add_parser("plan", help="list the kernels and arrays of a scene")
    plan.add_argument("scene", metavar="SCENE")

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
    return parser


def _add_results(commands: _Commands) -> None:
    """The commands that take results of studies."""
    compare = commands.add_parser("compare", help="compare a result with the references")
    compare.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    compare.add_argument(
        "other", type=Path, nargs="?", metavar="OTHER", help="a result to set beside it"
    )
    compare.add_argument(
        "--tolerance",
        type=_number("a number >= 0", lambda number: number >= 0),
        metavar="X",
        help="relative difference allowed between FILE and OTHER; default: none",
    )

    plot = commands.add_parser("plot", help="draw the pictures of a result")
    plot.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    plot.add_argument("--out", type=Path, metavar="DIR", help="default: the folder of FILE")

    view = commands.add_parser("view", help="draw the soil of a case around its penetrometer")
    view.add_argument("file", type=Path, metavar="FILE", help="result of a study, or of a case")
    view.add_argument("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
    view.add_argument("--out", type=Path, metavar="DIR", help="default: the folder of FILE")
    view.add_argument(
        "--vtk", action="store_true", help="write points, grid and surface for ParaView too"
    )

    report = commands.add_parser("report", help="write one page of HTML on results")
    report.add_argument("file", type=Path, nargs="+", metavar="FILE", help="result of a study")
    report.add_argument("-o", "--out", type=_page, default=Path("report.html"), metavar="HTML")

    recommend = commands.add_parser("recommend", help="name the cheapest settings for an error")
    recommend.add_argument("scene", metavar="SCENE")
    recommend.add_argument(
        "--error", type=_share, required=True, metavar="X", help="largest error, as 1%% or 0.01"
    )
    recommend.add_argument(
        "--results", type=Path, default=Path("results"), metavar="DIR", help="default: results"
    )


def _add_study(command: argparse.ArgumentParser) -> None:
    command.add_argument("study", metavar="STUDY", help="name of a study, or a TOML file")
    _add_settings(command)


def _add_settings(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--out", type=Path, default=Path("results"), metavar="DIR", help="default: results"
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a parameter; a list, as in KEY=[1,2], varies it; repeatable",
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


def _number(meaning: str, holds: Callable[[float], bool]) -> Callable[[str], float]:
    """What reads a finite number for which something holds, described in words."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and holds(number)):
            raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be {meaning}")
        return number

    return read


def _bytes(text: str) -> float:
    """A size in bytes, or with a decimal unit."""
    number, unit = text.upper().removesuffix("B"), 1.0
    if text.upper().endswith("B") and number[-1:] in UNITS:
        number, unit = number[:-1], UNITS[number[-1]]
    try:
        size = float(number) * unit
    except ValueError:
        size = math.nan
    if not 0 < size < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be > 0, as 8e9 or 8GB")
    return size


def _page(text: str) -> Path:
    # A result in its place, the page's name forgotten, would be lost.
    if not text.endswith(".html"):
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must end in .html")
    return Path(text)


def _share(text: str) -> float:
    try:
        share = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        share = math.nan
    if not 0 < share < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be > 0, as 1% or 0.01")
    return share


def _count(text: str) -> int:
    if not text.isdecimal() or len(text) > 6 or int(text) < 1:
        shown = text if len(text) < 20 else f"{text[:20]}..."
        raise argparse.ArgumentTypeError(
            f"{shown!r} is not allowed: must be an integer from 1 to 999999"
        )
    return int(text)
