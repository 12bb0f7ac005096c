"""A study is run: what is not done yet, on this machine or on a cluster; then it is collected.

Progress is a bar on a terminal, and a line for each case that has ended.
"""

import os
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import TextIO

import xarray as xr
from tqdm import tqdm

from harness.archive.atomic_files import ArchiveError, prepare
from harness.archive.case_files import Outcome, case_folder, check_no_link, discard
from harness.archive.conventions import COMPLETED, DAMAGED
from harness.archive.study_files import check_place, study_file
from harness.errors import HarnessError, coloured, counted, shortened, tell
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
"""Seconds to start or to compile that are shown, at least."""


class Display(AbstractContextManager["Display"]):
    """A `Watcher` that shows so many cases as they run, with a bar where the stream is a terminal.

    It is a context that leaves the terminal's line clean.
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
        self.bar._time = time.monotonic  # by its own clock it would stand still if that is set back
        self.bar.start_t = self.bar.last_print_t = time.monotonic()

    def __exit__(self, *_: object) -> None:
        self.bar.close()

    def advanced(self, case: Case, fraction: float) -> None:
        """A running case has come to `fraction`, 0 to 1."""
        self.running[case.key] = fraction
        self._update()

    def finished(self, case: Case, outcome: Outcome) -> None:
        """A case has ended, well or not."""
        self.done += 1
        self.running.pop(case.key, None)
        status = coloured(outcome.status, is_good=outcome.status == COMPLETED, stream=self.stream)
        label, message = map(shortened, (case.label, outcome.message))
        told = ", ".join(filter(None, (status, outcome.headline, message)))
        line = f"[{self.done}/{self.total}] {label}: {told}, {_times(outcome)}"
        self._update()
        tqdm.write(line, file=self.stream)
        self.stream.flush()

    def _update(self) -> None:
        """Bring the bar to the cases done, and the mean progress of those running."""
        told = [f"{self.done}/{self.total} cases"]
        if self.running:
            mean = sum(self.running.values()) / len(self.running)
            # Nothing is computed before all is imported, set up and compiled.
            told.append(
                f"{len(self.running)} {f'running, at {mean:.0%}' if mean else 'setting up'}"
            )
        self.bar.set_description_str(", ".join([*told, ""]), refresh=False)
        self.bar.update(self.done + sum(self.running.values()) - self.bar.n)


def _times(outcome: Outcome) -> str:
    """The time that a case computed, and apart from it those to start and to compile."""
    start, compiling = outcome.start_seconds, outcome.compile_seconds
    apart = [
        f"{seconds:.1f} s to {what}"
        for seconds, what in ((start, "start"), (compiling, "compile"))
        if seconds >= NOTICED
    ]
    computing = f"{outcome.seconds - start - compiling:.1f} s"
    return f"{computing} ({', '.join(apart)})" if apart else computing


RunCases = Callable[[Sequence[Case], Path, Watcher], None]
"""Runs cases, keeps their results in a folder, and reports to a watcher."""


def on_this_machine(
    study: Study, worker_count: int | None, options: RunOptions = DEFAULTS
) -> RunCases:
    """How to run the cases of a study in worker processes here; None: as many as there are cores.

    If the study asks for timed runs, or its scenes measure the machine, one process runs alone,
    with one thread where no number is given. The memory of the options is for all cases at work.

    Raises:
        HarnessError: there is no such device, or cases to be timed are to run at the same time.
    """
    check_device(options.device)
    repeats = study.timing_repeats
    alone = repeats > 0 or any(part.scene.runs_alone for part in study.parts)
    if alone and (worker_count or 1) > 1:
        raise HarnessError(f"{study.name}: cases are timed one at a time, without --workers")
    workers = 1 if alone else worker_count or cases_at_once(options.threads)
    if repeats:
        tell(f"timed alone, {repeats} warm runs a case; load now {os.getloadavg()[0]:.1f}")
    threads = 1 if options.threads is None and repeats else options.threads
    memory = options.memory_limit or default_memory_limit()

    def run(cases: Sequence[Case], folder: Path, watcher: Watcher) -> None:
        run_cases(
            # One worker takes as long in any order, and the order of the study can be followed.
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
    """How to run the cases of a study on the Dask cluster whose scheduler has this address.

    Raises:
        HarnessError: the study asks for timed runs, Dask is missing, or nobody answers there.
    """
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
    """Run the cases of a study that are not done, or all of them if `fresh`, and collect it.

    A case is done when it has completed, and been timed as often as its study asks for. Done cases
    that were computed by other sources of the simulator are kept, and one line says so. However
    the run ends, what is done is in the archive, and collected.
    """
    folder = case_folder(out, study)
    check_no_link(out, study)
    check_place(study_file(out, study))
    prepare(out)
    prepare(folder)
    if fresh:
        discard(folder, study.cases)
    stand = results.outcomes(study, out)
    pending = _pending(study, stand, folder)
    done_count = len(study.cases) - len(pending)
    try:
        tell(f"{study.name}: {counted(len(study.cases), 'case')}, {done_count} done already")
        results.tell_of_other_sources(study, stand)
        tell_of_long_cases(pending)
        tell_of_likely_failures(pending)
        with Display(len(pending), sys.stderr) as display:
            run(pending, folder, display)
    except (KeyboardInterrupt, HarnessError, OSError) as error:
        stand = results.outcomes(study, out)
        can_write = not isinstance(error, ArchiveError)
        if can_write and any(outcome.status == COMPLETED for outcome in stand):
            results.collect_and_write(study, out)
        tell(f"interrupted; {results.summary(stand)}; the same command goes on with the rest")
        raise
    return results.collect_and_write(study, out)


def _pending(study: Study, stand: Sequence[Outcome], folder: Path) -> list[Case]:
    """The cases that are to be run; damaged files of theirs are removed."""
    pending = []
    for case, outcome in zip(study.cases, stand, strict=True):
        if outcome.status == DAMAGED:
            tell(f"{outcome.message}; the case is run again")
            discard(folder, [case])
        if outcome.status != COMPLETED:
            pending.append(case)
    return pending
