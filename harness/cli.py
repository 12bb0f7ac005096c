"""The command line. What computes is imported by the command that needs it: help is at once."""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from harness import HarnessError
from harness.arguments import BAD_INPUT, make_parser
from harness.cases import COMPLETED, Case, cases_of
from harness.definition import study_names
from harness.progress import tell as _tell
from harness.study import load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import UnknownSceneError, scene_class, scene_names

if TYPE_CHECKING:
    import xarray as xr


DONE, INCOMPLETE = 0, 1


class Terminated(KeyboardInterrupt):
    """SIGTERM has come; ends a run as Ctrl-C does."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: the command line without the program's name; default: that of the process.

    Returns:
        Exit code: 0 done, 1 a case did not complete or a bound is not reached,
        2 bad input or unusable files, 130 Ctrl-C, 141 the reader of its output has gone,
        143 SIGTERM.
    """
    options = make_parser().parse_args(arguments)
    try:
        code = COMMANDS[options.command](options)
    except BrokenPipeError:
        # Whoever read the output has gone, as in `harness run ... | head`: nobody is to be told.
        null = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(null, stream.fileno())
        return 128 + signal.SIGPIPE
    except (HarnessError, UnknownSceneError, OSError) as error:
        _tell(str(error))
        return BAD_INPUT
    except Terminated:
        return 128 + signal.SIGTERM
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    return code


def _run(options: argparse.Namespace) -> int:
    from harness.run_study import on_cluster, on_this_machine, run_study
    from harness.upkeep import result_file

    signal.signal(signal.SIGTERM, _raise_terminated)
    if options.dask is not None and options.case_timeout < math.inf:
        raise HarnessError("--case-timeout ends workers of this machine; leave it out with --dask")
    if options.dask is not None and (
        options.threads or options.device != "cpu" or options.batch > 1
    ):
        raise HarnessError(
            "--threads, --device and --batch are of this machine; leave them out with --dask"
        )
    study = load_study(options.study, options.set)
    cases = cases_of(study)
    run = (
        on_this_machine(
            study,
            options.workers,
            options.case_timeout,
            device=options.device,
            threads=options.threads,
            batch=options.batch,
        )
        if options.dask is None
        else on_cluster(study, options.dask)
    )
    dataset = run_study(study, options.out, run, fresh=options.fresh)
    _show(dataset, options.out)
    print(result_file(options.out, study))
    incomplete = _list_incomplete(cases, dataset)
    return _list_misses(dataset) or incomplete


def _show(dataset: xr.Dataset, folder: Path) -> None:
    """Print the table and draw the pictures, as far as the scene has what they show."""
    from harness.compare import NothingToCompareError
    from harness.cone_factor_table import cone_factor_table
    from harness.plots import NothingToDrawError, draw

    try:
        print(cone_factor_table(dataset))
    except NothingToCompareError as error:
        _tell(str(error))
    try:
        print(*draw(dataset, folder), sep="\n")
    except (NothingToCompareError, NothingToDrawError) as error:
        _tell(str(error))


def _list_misses(dataset: xr.Dataset) -> int:
    from harness.gate import ATTRIBUTE, misses

    lines = misses(dataset)
    for line in lines:
        _tell(f"tolerance missed: {line}")
    if not lines and ATTRIBUTE in dataset.attrs:
        _tell("all tolerances are kept")
    return INCOMPLETE if lines else DONE


def _list_incomplete(cases: Sequence[Case], dataset: xr.Dataset) -> int:
    outcomes = zip(cases, dataset.status.values.flat, dataset.message.values.flat, strict=True)
    lost = [outcome for outcome in outcomes if outcome[1] != COMPLETED]
    for case, status, message in lost:
        _tell(f"{case.label}: {status}: {message}")
    return INCOMPLETE if lost else DONE


def _status(options: argparse.Namespace) -> int:
    from harness.upkeep import outcomes, status_rows

    study = load_study(options.study, options.set)
    cases = cases_of(study)
    stand = outcomes(study, cases, options.out)
    print(*status_rows(cases, stand), sep="\n")
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def _collect(options: argparse.Namespace) -> int:
    from harness.upkeep import collect_and_write, outcomes_of, result_file, summary
    from harness.whole_files import prepare

    study = load_study(options.study, options.set)
    cases = cases_of(study)
    prepare(options.out)
    stand = outcomes_of(collect_and_write(study, cases, options.out))
    _tell(summary(stand))
    print(result_file(options.out, study))
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def _clean(options: argparse.Namespace) -> int:
    from harness.upkeep import leftovers

    study = load_study(options.study, options.set)
    found = leftovers(study, cases_of(study), options.out)
    for path, what in found.items():
        print(f"{path}: {what}")
    if not found:
        _tell("nothing to remove")
        return DONE
    if not options.yes and not _confirmed(f"remove {len(found)} files?"):
        _tell("nothing removed")
        return INCOMPLETE
    for path in found:
        path.unlink(missing_ok=True)
    _tell(f"{len(found)} files removed")
    return DONE


def _confirmed(question: str) -> bool:
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _rerun(options: argparse.Namespace) -> int:
    from harness.progress import Display
    from harness.rerun import read_for_rerun, rerun, verdict
    from harness.run_study import check_device

    signal.signal(signal.SIGTERM, _raise_terminated)
    check_device(options.device)
    case, before = read_for_rerun(options.file, options.case)
    with Display(1, sys.stderr) as display:
        again = rerun(case, display, device=options.device, threads=options.threads)
    same, words = verdict(before, again)
    print(f"{case.key}: {words}")
    return DONE if same else INCOMPLETE


def _list(options: argparse.Namespace) -> int:
    print("studies:")
    for name in study_names():
        print(f"  {name:24} {load_study(name).title}")
    print("scenes:")
    for name in scene_names():
        print(f"  {name:24} {scene_class(name).summary}")
    return DONE


def _describe(options: argparse.Namespace) -> int:
    scene = scene_class(options.scene)
    print(f"{options.scene}: {scene.summary}\n")
    for name, parameter in parameters_of(scene).items():
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        default = "derived" if parameter.default is None else f"{parameter.default}{unit}"
        print(f"{name:26} {default:16} {parameter.meaning}; {parameter.allowed}")
    return DONE


def _schema(options: argparse.Namespace) -> int:
    import json

    from harness.schema import study_schema

    print(json.dumps(study_schema(), indent=2))
    return DONE


def _plan(options: argparse.Namespace) -> int:
    from harness.plan_text import plan_text
    from harness.worker import start_warp_in_silence

    start_warp_in_silence()
    scene = scene_class(options.scene)()
    plan = scene.plan()
    if plan is None:
        raise HarnessError(f"{options.scene}: the scene runs no grid, it has no plan")
    print(plan_text(plan, scene.step_count_bound(plan)))
    return DONE


def _verify(options: argparse.Namespace) -> int:
    from harness.case_files import write_netcdf
    from harness.verify import as_dataset, checks_of, heading, table_rows, verify
    from harness.whole_files import prepare, write_whole
    from harness.worker import start_warp_in_silence

    checks = checks_of(options.scene, extreme=options.extreme)
    start_warp_in_silence()
    if options.out is not None:
        prepare(options.out)
    lines, results = [heading()], []
    print(lines[0])
    for check in checks:
        results.append(verify(check))
        lines.append(table_rows(results[-1]))
        print(lines[-1], flush=True)
    if options.out is not None:
        from harness.work_precision import draw_work_precision

        dataset = as_dataset(results)
        write_netcdf(dataset, options.out / "verify.nc")
        write_whole("\n".join([*lines, ""]).encode(), options.out / "verify.txt")
        draw_work_precision(dataset, options.out / "verify.png")
    return INCOMPLETE if any(result.shortfalls for result in results) else DONE


def _bench(options: argparse.Namespace) -> int:
    from harness.bench import bench_rows
    from harness.run_study import on_this_machine, run_study
    from harness.upkeep import result_file

    signal.signal(signal.SIGTERM, _raise_terminated)
    study = load_study("bench", options.set)
    cases = cases_of(study)
    run = on_this_machine(study, 1, math.inf, device=options.device)
    dataset = run_study(study, options.out, run, fresh=True)
    print(*bench_rows(dataset), sep="\n")
    print(result_file(options.out, study))
    return _list_incomplete(cases, dataset)


def _compare(options: argparse.Namespace) -> int:
    from harness.archive import read_study
    from harness.compare import NothingToCompareError
    from harness.cone_factor_table import cone_factor_table
    from harness.gate import ATTRIBUTE

    dataset = read_study(options.file)
    if options.other is not None:
        return _compare_two(dataset, read_study(options.other), options.tolerance)
    try:
        print(cone_factor_table(dataset))
    except NothingToCompareError as error:
        if ATTRIBUTE not in dataset.attrs:
            raise HarnessError(f"{options.file}: {error}") from None
    return _list_misses(dataset)


def _compare_two(first: xr.Dataset, second: xr.Dataset, tolerance: float) -> int:
    from harness.gate import difference_rows, differences

    found, lonely = differences(first, second)
    print(*difference_rows(found, tolerance), *lonely, sep="\n")
    return INCOMPLETE if lonely or any(it.size > tolerance for it in found) else DONE


def _plot(options: argparse.Namespace) -> int:
    from harness.archive import read_study
    from harness.plots import NothingToDrawError, draw
    from harness.whole_files import prepare

    dataset = read_study(options.file)
    folder = options.out or options.file.parent
    prepare(folder)
    try:
        pictures = draw(dataset, folder)
    except NothingToDrawError as error:
        raise HarnessError(f"{options.file}: {error}") from None
    print(*pictures, sep="\n")
    return DONE


def _report(options: argparse.Namespace) -> int:
    from harness.archive import read_study
    from harness.report import write_report

    write_report([read_study(file) for file in options.file], options.out)
    print(options.out)
    return DONE


def _recommend(options: argparse.Namespace) -> int:
    from harness.recommend import recommend

    scene_class(options.scene)
    found = recommend(options.scene, options.error, sorted(options.results.glob("*.nc")))
    if found is None:
        print(f"{options.scene}: no settings in {options.results} reach {options.error:.2%}")
        return INCOMPLETE
    print(f"{options.scene}: {found}")
    return DONE


def _raise_terminated(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated


COMMANDS = {
    "run": _run,
    "status": _status,
    "collect": _collect,
    "clean": _clean,
    "rerun": _rerun,
    "list": _list,
    "describe": _describe,
    "schema": _schema,
    "plan": _plan,
    "verify": _verify,
    "bench": _bench,
    "compare": _compare,
    "plot": _plot,
    "report": _report,
    "recommend": _recommend,
}
"""What each command does; it returns the exit code."""
