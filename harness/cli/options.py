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


def _shared(*names: str, **options: Any) -> Parser:
    """An argument that several commands take."""
    shared = Parser(add_help=False)
    shared.add_argument(*names, **options)
    return shared


STUDY = _shared("study", metavar="STUDY", help="name of a study, or a TOML file")
SUBJECT = _shared("subject", metavar="NAME", help="of a scene or a study, or a TOML file")
OUT = _shared(
    "--out",
    type=Path,
    default=Path("results"),
    metavar="DIR",
    help="folder of the results; default: results",
)
QUICK = _shared(
    "--quick",
    action="store_true",
    help="run the cheapest check of each scene alone, where it is short: a minute",
)
SET = _shared(
    "--set",
    action="append",
    default=[],
    metavar="KEY=VALUE",
    help="set a parameter; a list, as in 'KEY=[1, 2]', varies it; repeatable",
)
THREADS = _shared(
    "--threads",
    type=int,
    choices=THREAD_COUNTS,
    metavar="N",
    help="threads of a case, 1, 2 or 4; the result does not change; default: idle cores help",
)
DEVICE = _shared(
    "--device", default="cpu", metavar="NAME", help="cpu, the default, or a GPU: cuda:0, ..."
)
RESULT = _shared("file", type=Path, metavar="FILE", help="result of a study, netCDF")
RESULT_OR_CASE = _shared("file", type=Path, metavar="FILE", help="of a case, or result of a study")
CASE = _shared("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
BESIDE = _shared("--out", type=Path, metavar="DIR", help="default: the folder of FILE")


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
    schema = add("schema", "studies.schema")
    schema.add_argument(
        "of",
        nargs="?",
        choices=("study", "site"),
        default="study",
        metavar="KIND",
        help="study, the default, or site: files of `harness interpret`",
    )
    add("plan", "studies.show_plan", SUBJECT, SET)
    _add_options_of_run(add("run", "run.run", STUDY, OUT, SET, THREADS, DEVICE))

    status = add("status", "archive.status", OUT, SET)
    status.add_argument(
        "study",
        nargs="?",
        metavar="STUDY",
        help="name of a study, a TOML file, or a result; without it, or with a scene: all results",
    )
    status.flag("--traceback", "print the place in the program where a case failed")
    add("collect", "archive.collect", STUDY, OUT, SET)
    clean = add("clean", "archive.clean", STUDY, OUT, SET)
    clean.flag("--yes", "remove without asking")
    add("rerun", "run.rerun_case", RESULT_OR_CASE, CASE, THREADS, DEVICE)

    verify = add("verify", "run.verify_scenes", QUICK)
    verify.add_argument(
        "--scene", nargs="+", action="extend", default=[], metavar="NAME", help="default: all"
    )
    verify.flag("--extreme", "run the extreme cases instead")
    verify.path("--out", "DIR", "write dataset, table and picture there")
    add("bench", "run.bench", OUT, SET, DEVICE)

    references = add("references", "studies.references")
    references.add_argument(
        "id", nargs="?", metavar="ID", help="name of one reference or band; default: all"
    )
    compare = add("compare", "results.compare", RESULT)
    compare.path("other", "OTHER", "a result to set beside it", nargs="?")
    compare.add_argument(
        "--tolerance",
        type=number("a number >= 0", or_zero=True),
        metavar="X",
        help="largest relative difference allowed between FILE and OTHER; default: 0",
    )
    compare.flag(
        "--standards",
        "cone factors on four meshes or more: their error by the least squares of Eca and "
        "Hoekstra, beside the uncertainty stated",
    )
    plot = add("plot", "results.plot", RESULT, BESIDE)
    plot.add_argument(
        "--format",
        nargs="+",
        choices=("png", "pdf", "svg"),
        default=["png"],
        metavar="FORMAT",
        help="png, the default, pdf or svg; several are allowed",
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
    recommend.add_argument("scene", metavar="SCENE", help="name of a scene, as cone_penetration")
    recommend.add_argument(
        "--error",
        type=share,
        required=True,
        metavar="X",
        help="largest relative error, as 1%% or 0.01",
    )
    recommend.path("--results", "DIR", "default: results", default=Path("results"))

    _add_options_of_interpret(add("interpret", "interpret.interpret_site", OUT))

    _add_options_of_benchmark(add("benchmark", "run.benchmark", OUT))

    about = add("help", "completion.show_help")
    about.add_argument("about", nargs="?", metavar="COMMAND", choices=tuple(HELP))
    completion = add("completion", "completion.completion")
    completion.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))

    for command in commands.choices.values():
        command.flag("--debug", "print where an error of the program arises")
    return parser


def _add_options_of_new(new: Parser) -> None:
    new.add_argument("name", metavar="NAME", help="of the study; its file is NAME.toml")
    new.path(
        "--interpret",
        "TEST",
        "write a site file for this measured test: CSV, .gef, .xml (BRO) or .ags",
    )
    new.add_argument(
        "--scene", default="cone_penetration", metavar="SCENE", help="default: cone_penetration"
    )


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
    run.flag(
        "--uncertainty",
        "measure the uncertainty of each cone or resistance factor by further runs, which "
        "take some ten times as long; the same as --set uncertainty=measured",
    )
    run.flag("--fresh", "run all cases, those that are done too")
    run.add_argument(
        "--case-timeout",
        type=number("a number > 0"),
        default=math.inf,
        metavar="SECONDS",
        help="end a case that computes for longer; default: no limit",
    )
    run.add_argument(
        "--memory-limit",
        type=number("> 0, as 8e9 or 8GB", BYTES),
        metavar="SIZE",
        help="memory that all running cases may take together, as 8e9 or 8GB; a case that needs "
        "more than its share is refused; default: 90%% of this machine's",
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
    benchmark.add_argument(
        "--against",
        default="mpm_warp_standard",
        metavar="NAME",
        help="submission that others are compared with where no exact value is known; default: "
        "mpm_warp_standard",
    )


def _version() -> str:
    try:
        return f"harness {metadata.version('mpm-warp')}"
    except metadata.PackageNotFoundError:
        return "harness, of a source tree that is not installed"
