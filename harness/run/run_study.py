"""Run the cases of a study that are not done, here or on a cluster, and collect their results.

Progress is shown as a bar on a terminal, and as a line for each case that has ended.
"""

import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import TextIO

import psutil
import xarray as xr
from tqdm import tqdm

from harness.archive.atomic_files import ArchiveError, check_folder, prepare
from harness.archive.case_files import Outcome, case_folder, check_no_link, discard
from harness.archive.conventions import COMPLETED, DAMAGED, UNREADABLE
from harness.archive.study_files import check_place, study_file
from harness.errors import HarnessError, counted, shortened, tell, written
from harness.run import collect_and_clean as results
from harness.run.pool import Watcher, cases_at_once, run_cases
from harness.run.resources import (
    DEFAULTS,
    RunOptions,
    check_device,
    costliest_first,
    default_memory_limit,
    tell_of_likely_failures,
    tell_of_long_cases,
)
from harness.study.cases import Case
from harness.study.study import Study

NOTICED = 0.05
"""Shortest time to start or to compile that is shown [s]."""


class Display(AbstractContextManager["Display"]):
    """A `Watcher` that shows the progress of `total` cases, with a bar if `stream` is a terminal.

    At the end of its context the bar is removed.
    """

    def __init__(self, total: int, stream: TextIO) -> None:
        self.total = total
        self.stream = stream
        self.done = 0
        self.running: dict[str, float] = {}
        self.bar = tqdm(
            total=total,
            desc=f"0/{total} cases, ",
            file=stream,
            disable=not stream.isatty(),
            leave=False,
            miniters=0,
            smoothing=0,  # the time left follows from the mean speed so far
            bar_format="{bar:24} {desc}after {elapsed}, {remaining} left",
        )
        self.bar._time = time.monotonic  # its own clock may be set back, and the bar would stop
        self.bar.start_t = self.bar.last_print_t = time.monotonic()

    def __exit__(self, *_: object) -> None:
        self.bar.close()

    def advanced(self, case: Case, fraction: float) -> None:
        """Show that the fraction 0 to 1 of a case is done."""
        self.running[case.key] = fraction
        self._update()

    def finished(self, case: Case, outcome: Outcome) -> None:
        """Print the line of a case that has ended."""
        self.done += 1
        self.running.pop(case.key, None)
        label, message = map(shortened, (case.label, outcome.message))
        result = ", ".join(filter(None, (outcome.status, outcome.headline, message)))
        line = f"[{self.done}/{self.total}] {label}: {result}, {_times(outcome)}"
        self._update()
        with written(self.stream):
            tqdm.write(line, file=self.stream)

    def _update(self) -> None:
        """Set the bar to the number of cases done, running ones by their fraction."""
        progress = sum(self.running.values())
        text = f"{self.done}/{self.total} cases, "
        if count := len(self.running):
            # Imports, set-up and compilation come before the first step.
            state = f"running, at {progress / count:.0%}" if progress else "setting up"
            text += f"{count} {state}, "
        self.bar.set_description_str(text, refresh=False)
        with written(self.stream):
            self.bar.update(self.done + progress - self.bar.n)


def _times(outcome: Outcome) -> str:
    """The computing time of a case, and in brackets the times to start and to compile."""
    start, compiling = outcome.start_seconds, outcome.compile_seconds
    others = [
        f"{seconds:.1f} s to {what}"
        for seconds, what in ((start, "start"), (compiling, "compile"))
        if seconds >= NOTICED
    ]
    computing = f"{outcome.seconds - start - compiling:.1f} s"
    return f"{computing} ({', '.join(others)})" if others else computing


RunCases = Callable[[Sequence[Case], Path, Watcher], None]
"""A function that runs cases, writes their files to a folder, and reports to a watcher."""


def on_this_machine(
    study: Study, worker_count: int | None, options: RunOptions = DEFAULTS
) -> RunCases:
    """A function that runs the cases of a study in worker processes on this machine.

    The default number of workers is that of the cores. Only one case runs at a time if the study
    asks for timed runs, or its scenes measure the machine; a timed case has one thread by default.
    The memory limit of the options is for all running cases together.
    """
    check_device(options.device)
    repeats = study.timing_repeats
    alone = repeats > 0 or any(part.scene.runs_alone for part in study.parts)
    if alone and (worker_count or 1) > 1:
        raise HarnessError(f"{study.name}: cases are timed one at a time, without --workers")
    workers = 1 if alone else worker_count or cases_at_once(options.threads)
    if repeats:
        tell(f"timed alone, {repeats} warm runs a case; load now {psutil.getloadavg()[0]:.1f}")
    threads = 1 if options.threads is None and repeats else options.threads
    memory = options.memory_limit or default_memory_limit()

    def run(cases: Sequence[Case], folder: Path, watcher: Watcher) -> None:
        run_cases(
            # One worker needs the same time in any order; the user can follow that of the study.
            costliest_first(cases) if workers > 1 else cases,
            folder,
            workers,
            watcher,
            replace(
                options,
                threads=threads,
                repeats=repeats,
                memory_limit=memory / max(1, min(workers, len(cases))),
            ),
        )

    return run


def on_cluster(study: Study, address: str) -> RunCases:
    """A function that runs the cases of a study on the Dask cluster with this scheduler."""
    if study.timing_repeats:
        raise HarnessError("[timing] repeats: cases are timed on this machine, without --dask")
    try:
        # Dask is an optional dependency.
        from harness.run.cluster import connect, run_on_cluster
    except ModuleNotFoundError as error:
        raise HarnessError(f"--dask: {error}: pip install 'mpm-warp[cluster]'") from None
    client = connect(address)

    def run(cases: Sequence[Case], folder: Path, watcher: Watcher) -> None:
        with client:
            run_on_cluster(cases, folder, client, watcher)

    return run


def run_study(study: Study, out: Path, run: RunCases, *, fresh: bool) -> xr.Dataset:
    """Run the cases of a study that are not done, or all if `fresh`; return the collected results.

    A case is done if it has completed, with all timed runs that the study asks for. Done cases
    computed by other sources of the simulator are kept, and a line says so. Completed cases are
    also collected if the run is interrupted.
    """
    folder = case_folder(out, study)
    check_folder(out)
    check_no_link(out, study)
    check_place(study_file(out, study))
    results.read_reference(study)  # if it cannot be read, no case is run in vain
    prepare(out)
    prepare(folder)
    if fresh:
        discard(folder, study.cases)
    outcomes = results.outcomes(study, out)
    pending = _pending(study, outcomes, folder)
    done_count = sum(outcome.status == COMPLETED for outcome in outcomes)
    try:
        tell(f"{study.name}: {counted(len(study.cases), 'case')}, {done_count} done already")
        results.tell_of_other_sources(study.name, outcomes)
        tell_of_long_cases(pending)
        tell_of_likely_failures(pending)
        with Display(len(pending), sys.stderr) as display:
            run(pending, folder, display)
    except (KeyboardInterrupt, HarnessError, OSError) as error:
        outcomes = results.outcomes(study, out)
        can_write = not isinstance(error, ArchiveError)
        if can_write and any(outcome.status == COMPLETED for outcome in outcomes):
            results.collect_and_write(study, out)
        tell(f"{results.summary(outcomes)}; the same command goes on with the rest")
        raise
    return results.collect_and_write(study, out)


def _pending(study: Study, outcomes: Sequence[Outcome], folder: Path) -> list[Case]:
    """The cases to run; their damaged files are removed. What cannot be read is kept."""
    pending = []
    for case, outcome in zip(study.cases, outcomes, strict=True):
        if outcome.status == DAMAGED:
            tell(f"{outcome.message}; the case is run again")
            discard(folder, [case])
        if outcome.status == UNREADABLE:
            tell(f"{outcome.message}; kept: move it away, or `harness run --fresh` replaces it")
        elif outcome.status != COMPLETED:
            pending.append(case)
    return pending
