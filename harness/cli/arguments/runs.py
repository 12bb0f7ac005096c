"""Commands that compute, and those that look after what was computed: their options."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.arguments.shared import add_device, add_execution, add_settings, add_study
from harness.cli.arguments.values import finite_number, positive_count, size_in_bytes

if TYPE_CHECKING:
    from harness.cli.arguments.parser import Commands


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
