"""Commands that run the cases of studies and look after their files.

What computes is imported by the command that needs it: help is at once.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.cli.exit_codes import DONE, INCOMPLETE, end_at_sigterm
from harness.cli.result_commands import list_misses, show
from harness.errors import HarnessError, tell
from harness.study.cases import COMPLETED, DAMAGED, Case, cases_of
from harness.study.study import load_study

if TYPE_CHECKING:
    import xarray as xr


def run(options: argparse.Namespace) -> int:
    """Run a study, show its result and list what is missing."""
    from harness.run.collect_and_clean import result_file
    from harness.run.run_study import on_cluster, on_this_machine, run_study

    end_at_sigterm()
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
    runner = (
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
    dataset = run_study(study, options.out, runner, fresh=options.fresh)
    show(dataset, options.out)
    print(result_file(options.out, study))
    incomplete = _list_incomplete(cases, dataset)
    return list_misses(dataset) or incomplete


def _list_incomplete(cases: Sequence[Case], dataset: xr.Dataset) -> int:
    outcomes = zip(cases, dataset.status.values.flat, dataset.message.values.flat, strict=True)
    lost = [outcome for outcome in outcomes if outcome[1] != COMPLETED]
    for case, status, message in lost:
        tell(f"{case.label}: {status}: {message}")
    return INCOMPLETE if lost else DONE


def status(options: argparse.Namespace) -> int:
    """Print how the cases of a study stand."""
    from harness.run.collect_and_clean import outcomes, status_rows

    study = load_study(options.study, options.set)
    cases = cases_of(study)
    stand = outcomes(study, cases, options.out)
    print(*status_rows(cases, stand), sep="\n")
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def collect(options: argparse.Namespace) -> int:
    """Write the dataset of a study out of the case files that there are."""
    from harness.archive.atomic_files import prepare
    from harness.run.collect_and_clean import (
        check_begun,
        collect_and_write,
        outcomes_of,
        result_file,
        summary,
    )

    study = load_study(options.study, options.set)
    cases = cases_of(study)
    check_begun(study, cases, options.out)
    prepare(options.out)
    dataset = collect_and_write(study, cases, options.out)
    for message in dataset.message.values[dataset.status.values == DAMAGED]:
        tell(f"{message}; `harness run` runs the case again")
    stand = outcomes_of(dataset)
    tell(summary(stand))
    print(result_file(options.out, study))
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def clean(options: argparse.Namespace) -> int:
    """Remove files that are no results of the study, where the user agrees."""
    from harness.run.collect_and_clean import counted, leftovers

    study = load_study(options.study, options.set)
    found = leftovers(study, cases_of(study), options.out)
    for path, what in found.items():
        print(f"{path}: {what}")
    if not found:
        tell("nothing to remove")
        return DONE
    if not options.yes and not _confirmed(f"remove {counted(len(found), 'file')}?"):
        tell("nothing removed")
        return INCOMPLETE
    for path in found:
        path.unlink(missing_ok=True)
    tell(f"{counted(len(found), 'file')} removed")
    return DONE


def _confirmed(question: str) -> bool:
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    answer = sys.stdin.readline()
    if not answer:  # closed: nobody can answer
        print(file=sys.stderr)
    return answer.strip().lower() in ("y", "yes")


def rerun_case(options: argparse.Namespace) -> int:
    """Run one case again and compare it with its file, bit by bit."""
    from harness.run.progress import Display
    from harness.run.rerun import read_for_rerun, rerun, verdict
    from harness.run.run_study import check_device

    end_at_sigterm()
    check_device(options.device)
    case, before = read_for_rerun(options.file, options.case)
    with Display(1, sys.stderr) as display:
        again = rerun(case, display, device=options.device, threads=options.threads)
    same, words = verdict(before, again)
    print(f"{case.key}: {words}")
    return DONE if same else INCOMPLETE


def bench(options: argparse.Namespace) -> int:
    """Measure what a step costs."""
    from harness.compare.step_cost_table import bench_rows
    from harness.run.collect_and_clean import result_file
    from harness.run.run_study import on_this_machine, run_study

    end_at_sigterm()
    study = load_study("bench", options.set)
    cases = cases_of(study)
    runner = on_this_machine(study, None, math.inf, device=options.device)
    dataset = run_study(study, options.out, runner, fresh=True)
    print(*bench_rows(dataset), sep="\n")
    print(result_file(options.out, study))
    return _list_incomplete(cases, dataset)
