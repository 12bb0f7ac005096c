"""What the command line takes: its commands and their options."""

import math
import textwrap
from importlib import metadata
from pathlib import Path
from typing import Any

from harness.cli.help import HELP, epilog
from harness.cli.parser import BYTES, Parser, html_file, number, positive_count, share
from mpm_warp.execution import THREAD_COUNTS

SHELLS = ("bash", "zsh", "fish")
"""Shells that the command line can be completed in."""


def _shared(name: str, metavar: str, meaning: str, **options: Any) -> Parser:
    """An argument that several commands take."""
    shared = Parser(add_help=False)
    shared.value(name, metavar, meaning, **options)
    return shared


RESULTS = Path("results")
STUDY = _shared("study", "STUDY", "name of a study, or a TOML file")
SUBJECT = _shared("subject", "NAME", "of a scene or a study, or a TOML file")
OUT = _shared("--out", "DIR", "folder of the results; default: results", type=Path, default=RESULTS)
SET = _shared(
    "--set",
    "KEY=VALUE",
    "set a parameter; a list, as in 'KEY=[1, 2]', varies it; repeatable",
    action="append",
    default=[],
)
THREADS = _shared(
    "--threads",
    "N",
    "threads of a case, 1, 2 or 4; the result does not change; default: idle cores help",
    type=int,
    choices=THREAD_COUNTS,
)
DEVICE = _shared("--device", "NAME", "cpu, the default, or a GPU: cuda:0, ...", default="cpu")
RESULT = _shared("file", "FILE", "result of a study, netCDF", type=Path)
RESULT_OR_CASE = _shared("file", "FILE", "of a case, or result of a study", type=Path)
CASE = _shared("case", "CASE", "its key, where FILE has many", nargs="?")
BESIDE = _shared("--out", "DIR", "default: the folder of FILE", type=Path)


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

    def add(name: str, function: str, *shared: Parser) -> Parser:
        command = commands.add_parser(
            name,
            help=HELP[name].summary,
            parents=shared,
            description=textwrap.fill(HELP[name].description, 80),
            epilog=epilog(name),
        )
        command.set_defaults(function=function)
        return command

    _add_options_of_new(add("new", "studies.new"))
    add("list", "studies.list_names")
    add("describe", "studies.describe", SUBJECT)
    add("schema", "studies.schema").value(
        "of",
        "KIND",
        "study, the default, or site: files of `harness interpret`",
        nargs="?",
        choices=("study", "site"),
        default="study",
    )
    add("plan", "studies.show_plan", SUBJECT, SET)
    _add_options_of_run(add("run", "run.run", STUDY, OUT, SET, THREADS, DEVICE))

    status = add("status", "archive.status", OUT, SET)
    status.value(
        "study",
        "STUDY",
        "name of a study, a TOML file, or a result; without it, or with a scene: all results",
        nargs="?",
    )
    status.flag("--traceback", "print the place in the program where a case failed")
    add("collect", "archive.collect", STUDY, OUT, SET)
    add("clean", "archive.clean", STUDY, OUT, SET).flag("--yes", "remove without asking")
    add("rerun", "run.rerun_case", RESULT_OR_CASE, CASE, THREADS, DEVICE)

    verify = add("verify", "run.verify_scenes")
    verify.flag(
        "--quick", "run the cheapest check of each scene alone, where it is short: a minute"
    )
    verify.value("--scene", "NAME", "default: all", nargs="+", action="extend", default=[])
    verify.flag("--extreme", "run the extreme cases instead")
    verify.path("--out", "DIR", "write dataset, table and picture there")
    add("bench", "run.bench", OUT, SET, DEVICE)

    add("references", "studies.references").value(
        "id", "ID", "name of one reference or band; default: all", nargs="?"
    )
    compare = add("compare", "results.compare", RESULT)
    compare.path("other", "OTHER", "a result to set beside it", nargs="?")
    compare.value(
        "--tolerance",
        "X",
        "largest relative difference allowed between FILE and OTHER; default: 0",
        type=number("a number >= 0", or_zero=True),
    )
    compare.flag(
        "--standards",
        "cone factors on four meshes or more: their error by the least squares of Eca and "
        "Hoekstra, beside the uncertainty stated",
    )
    plot = add("plot", "results.plot", RESULT, BESIDE)
    plot.value(
        "--format",
        "FORMAT",
        "png, the default, pdf or svg; several are allowed",
        nargs="+",
        choices=("png", "pdf", "svg"),
        default=["png"],
    )
    view = add("view", "results.view", RESULT_OR_CASE, CASE, BESIDE)
    view.flag("--vtk", "write points, grid and surface for ParaView too")
    report = add("report", "results.report")
    report.path("file", "FILE", "result of a study", nargs="+")
    report.add_argument(
        "-o",
        "--out",
        type=html_file,
        default=Path("report.html"),
        metavar="HTML",
        help="default: report.html",
    )
    recommend = add("recommend", "results.show_recommendation")
    recommend.value("scene", "SCENE", "name of a scene, as cone_penetration")
    recommend.value(
        "--error", "X", "largest relative error, as 1%% or 0.01", type=share, required=True
    )
    recommend.path("--results", "DIR", "default: results", default=RESULTS)

    _add_options_of_interpret(add("interpret", "interpret.interpret_site", OUT))
    _add_options_of_benchmark(add("benchmark", "run.benchmark", OUT))

    add("help", "completion.show_help").add_argument(
        "about", nargs="?", metavar="COMMAND", choices=tuple(HELP)
    )
    add("completion", "completion.completion").value(
        "shell", "SHELL", ", ".join(SHELLS), choices=SHELLS
    )

    for command in commands.choices.values():
        command.flag("--debug", "print where an error of the program arises")
    return parser


def _add_options_of_new(new: Parser) -> None:
    new.value("name", "NAME", "of the study; its file is NAME.toml")
    test = "write a site file for this measured test: CSV, .gef, .xml (BRO) or .ags"
    new.path("--interpret", "TEST", test)
    new.value("--scene", "SCENE", "default: cone_penetration", default="cone_penetration")


def _add_options_of_run(run: Parser) -> None:
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
    together = "cases that a process computes together, to fill a GPU; default: 1"
    run.value("--batch", "N", together, type=positive_count, default=1)
    run.value(
        "--snapshots",
        "LIST",
        "keep the soil of each case, for `harness view`, at these penetrations over the cone "
        "radius, as 5,10",
    )
    run.flag(
        "--uncertainty",
        "measure the uncertainty of each cone or resistance factor by further runs, which "
        "take some ten times as long; the same as --set uncertainty=measured",
    )
    run.flag("--fresh", "run all cases, those that are done too")
    seconds = number("a number > 0")
    longest = "end a case that computes for longer; default: no limit"
    run.value("--case-timeout", "SECONDS", longest, type=seconds, default=math.inf)
    run.value(
        "--memory-limit",
        "SIZE",
        "memory that all running cases may take together, as 8e9 or 8GB; a case that needs "
        "more than its share is refused; default: 90%% of this machine's",
        type=number("> 0, as 8e9 or 8GB", BYTES),
    )


def _add_options_of_interpret(interpret: Parser) -> None:
    interpret.path("site", "SITE", "TOML file of a test and its ground", nargs="+")
    interpret.path(
        "--laboratory", "CSV", "strengths to draw beside: columns depth [m] and strength [kPa]"
    )
    interpret.flag(
        "--sharpen", "strength by the resistance without what borders of layers do to it"
    )
    interpret.add_argument(
        "--check",
        nargs="?",
        const="quick",
        choices=("quick", "standard"),
        help="simulate the sounding through the ground that was found, beside the measured one; "
        "quick, the default, or standard",
    )


def _add_options_of_benchmark(benchmark: Parser) -> None:
    benchmark.add_argument("action", choices=("run", "score"), metavar="run|score")
    benchmark.path("folder", "DIR", "a submission, or a folder of them", nargs="?")
    benchmark.add_argument(
        "--accuracy",
        choices=("quick", "standard", "fine"),
        default="standard",
        help="of a run; default: standard",
    )
    benchmark.value(
        "--against",
        "NAME",
        "submission that others are compared with where no exact value is known; default: "
        "mpm_warp_standard",
        default="mpm_warp_standard",
    )


def _version() -> str:
    try:
        return f"harness {metadata.version('mpm-warp')}"
    except metadata.PackageNotFoundError:
        return "harness, of a source tree that is not installed"
