"""What the command line takes: its commands and their options."""

from __future__ import annotations

import argparse
import math
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.help import HELP, epilog
from harness.cli.parser import (
    Parser,
    Version,
    finite_number,
    html_file,
    positive_count,
    share,
    size_in_bytes,
)
from mpm_warp.execution import THREAD_COUNTS

if TYPE_CHECKING:
    from harness.cli.parser import Commands


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


def add_study(command: argparse.ArgumentParser) -> None:
    """A study, and what is changed of it."""
    command.add_argument("study", metavar="STUDY", help="name of a study, or a TOML file")
    add_settings(command)


def add_subject(command: argparse.ArgumentParser) -> None:
    """A scene or a study."""
    command.add_argument(
        "subject", metavar="NAME", help="of a scene or a study, or the TOML file of a study"
    )


def add_settings(command: argparse.ArgumentParser) -> None:
    """Where results are, and what is changed of the study."""
    command.add_argument(
        "--out",
        type=Path,
        default=Path("results"),
        metavar="DIR",
        help="folder of the results; default: results",
    )
    add_set(command)


def add_set(command: argparse.ArgumentParser) -> None:
    """What is changed of a study or scene."""
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a parameter; a list, as in 'KEY=[1, 2]', varies it; repeatable",
    )


def add_execution(command: argparse.ArgumentParser) -> None:
    """How a case is computed: its threads and its device."""
    command.add_argument(
        "--threads",
        type=int,
        choices=THREAD_COUNTS,
        metavar="N",
        help="threads of a case, 1, 2 or 4; the result does not change; default: idle cores help",
    )
    add_device(command)


def add_device(command: argparse.ArgumentParser) -> None:
    """What computes."""
    command.add_argument(
        "--device", default="cpu", metavar="NAME", help="cpu, the default, or a GPU: cuda:0, ..."
    )


def add_definitions(commands: Commands) -> None:
    """The commands that take or write definitions of studies."""
    new = commands.add_parser("new", help="write a study of your own, to be edited and run")
    new.add_argument("name", metavar="NAME", help="of the study; its file is NAME.toml")
    new.add_argument(
        "--scene", default="cone_penetration", metavar="SCENE", help="default: cone_penetration"
    )

    commands.add_parser("list", help="list studies and scenes")

    describe = commands.add_parser("describe", help="describe a scene, or a study")
    add_subject(describe)

    commands.add_parser("schema", help="print a JSON schema of studies, for editors")

    plan = commands.add_parser("plan", help="print what a scene or a study costs, before it runs")
    add_subject(plan)
    add_set(plan)


def add_runs(commands: Commands) -> None:
    """The commands that run cases, and those on the files of a study."""
    _add_run(commands)
    _add_looking_after(commands)
    _add_measuring(commands)


def _add_run(commands: Commands) -> None:
    """The command that runs a study."""
    run = commands.add_parser("run", help="run a study; run it again to go on where it stopped")
    add_study(run)
    where = run.add_mutually_exclusive_group()
    where.add_argument(
        "--workers",
        type=positive_count,
        metavar="N",
        help="processes, each with a case at a time; default: as many as there are cores, over "
        "--threads",
    )
    where.add_argument(
        "--dask", metavar="ADDRESS", help="run on the Dask cluster whose scheduler has this address"
    )
    add_execution(run)
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
        help="keep the soil of each case, for `harness view`, at these penetrations over the cone "
        "radius, as 5,10",
    )
    run.add_argument(
        "--uncertainty",
        action="store_true",
        help="measure the uncertainty of each cone or resistance factor by further runs, which "
        "take some ten times as long; the same as --set uncertainty=measured",
    )
    run.add_argument("--fresh", action="store_true", help="run all cases, those that are done too")
    run.add_argument(
        "--case-timeout",
        type=finite_number("a number > 0", lambda it: it > 0),
        default=math.inf,
        metavar="SECONDS",
        help="end a case that computes for longer; default: no limit",
    )
    run.add_argument(
        "--memory-limit",
        type=size_in_bytes,
        metavar="SIZE",
        help="memory that all running cases may take together, as 8e9 or 8GB; a case that needs "
        "more than its share is refused; default: 90%% of this machine's",
    )


def _add_looking_after(commands: Commands) -> None:
    """The commands on the cases of a study that have been run."""
    status = commands.add_parser("status", help="list the cases of a study with their status")
    status.add_argument(
        "study",
        nargs="?",
        metavar="STUDY",
        help="name of a study, a TOML file, or a result; without it, or with a scene: all results",
    )
    add_settings(status)
    status.add_argument(
        "--traceback",
        action="store_true",
        help="print the place in the program where a case failed",
    )

    collect = commands.add_parser("collect", help="write the dataset of the cases that are done")
    add_study(collect)

    clean = commands.add_parser("clean", help="remove files that are no results of a study")
    add_study(clean)
    clean.add_argument("--yes", action="store_true", help="remove without asking")

    rerun = commands.add_parser("rerun", help="run a case again and compare every bit")
    rerun.add_argument("file", type=Path, metavar="FILE", help="of a case, or result of a study")
    rerun.add_argument("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
    add_execution(rerun)


def _add_measuring(commands: Commands) -> None:
    """The commands that measure errors and speed of the simulator."""
    verify = commands.add_parser("verify", help="compare scenes with their exact solutions")
    verify.add_argument(
        "--scene", nargs="+", action="extend", default=[], metavar="NAME", help="default: all"
    )
    verify.add_argument("--extreme", action="store_true", help="run the extreme cases instead")
    verify.add_argument(
        "--out", type=Path, metavar="DIR", help="write dataset, table and picture there"
    )

    bench = commands.add_parser("bench", help="measure what a step costs on this machine")
    add_settings(bench)
    add_device(bench)


def add_results(commands: Commands) -> None:
    """The commands that take results of studies."""
    references = commands.add_parser("references", help="list what results are compared with")
    references.add_argument(
        "id", nargs="?", metavar="ID", help="name of one reference or band; default: all"
    )

    compare = commands.add_parser(
        "compare", help="compare a result with references, or with another result"
    )
    compare.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    compare.add_argument(
        "other", type=Path, nargs="?", metavar="OTHER", help="a result to set beside it"
    )
    compare.add_argument(
        "--tolerance",
        type=finite_number("a number >= 0", lambda it: it >= 0),
        metavar="X",
        help="largest relative difference allowed between FILE and OTHER; default: 0",
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
    report.add_argument(
        "-o",
        "--out",
        type=html_file,
        default=Path("report.html"),
        metavar="HTML",
        help="default: report.html",
    )

    recommend = commands.add_parser("recommend", help="name the cheapest settings for an error")
    recommend.add_argument("scene", metavar="SCENE", help="name of a scene, as cone_penetration")
    recommend.add_argument(
        "--error",
        type=share,
        required=True,
        metavar="X",
        help="largest relative error, as 1%% or 0.01",
    )
    recommend.add_argument(
        "--results", type=Path, default=Path("results"), metavar="DIR", help="default: results"
    )
