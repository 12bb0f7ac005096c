"""Cases in worker processes: none lost, none done twice, whatever becomes of the workers."""

import math
import multiprocessing
import re
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from textwrap import dedent
from typing import NoReturn

import numpy as np
import pytest
import xarray as xr

from harness.archive import case_files
from harness.archive.atomic_files import ArchiveError
from harness.archive.conventions import COMPLETED, CRASHED, TIMED_OUT
from harness.compare.differences import differing
from harness.pictures.stability import shows_stability, stability_rows
from harness.run import pool
from harness.run.pool import WorkerProcess, cases_at_once, end_all, run_cases, share_of_cores
from harness.run.resources import DEFAULTS, RunOptions
from harness.study.cases import Case
from harness.study.study import Study, load_study
from tests.harness.conftest import DONE, SMALL, study_in

from .conftest import Record, kill_workers, run

pytestmark = pytest.mark.slow

Begun = Callable[..., WorkerProcess]


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """The study done by one worker, a case after the other."""
    folder = tmp_path_factory.mktemp("one")
    return run(study_in(folder, dedent(SMALL), name="small"), folder, 1, Record())


@pytest.mark.parametrize(
    ("workers", "options"),
    [(2, RunOptions()), (1, RunOptions(threads=1)), (1, RunOptions(threads=2))],
)
def test_every_case_is_run_once_and_has_the_same_bits(
    workers: int, options: RunOptions, one: xr.Dataset, tmp_path: Path, small: Study
) -> None:
    record = Record()
    dataset = run(small, tmp_path, workers, record, options)
    assert record.statuses(small.cases) == [COMPLETED] * 3
    assert "time_step" in one
    assert differing(one, dataset) == []
    assert (dataset.case_time >= dataset.run_time).all()
    assert not multiprocessing.active_children()


@pytest.fixture
def begun(folder: Path, small: Study) -> Iterator[Begun]:
    """Makes workers that have taken on the first of the cases."""
    workers = []

    def made(options: RunOptions = DEFAULTS) -> WorkerProcess:
        workers.append(WorkerProcess(folder, options))
        workers[-1].begin(small.cases[0])
        return workers[-1]

    yield made
    end_all(workers)


def test_a_case_has_its_threads_from_the_first_step_on(
    folder: Path, small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent = []
    send = WorkerProcess._send

    def noted(worker: WorkerProcess, message: Case | int) -> None:
        sent.append(message)
        send(worker, message)

    monkeypatch.setattr(WorkerProcess, "_send", noted)
    run_cases(small.cases, folder, 1, Record(), RunOptions(threads=2))
    assert sent == [2, *small.cases]


def test_cases_at_work_share_the_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harness.run.pool.usable_cores", lambda: 8)
    assert [share_of_cores(cases) for cases in (1, 2, 3, 4, 5, 8, 20)] == [4, 4, 2, 2, 1, 1, 1]
    assert [cases_at_once(threads) for threads in (None, 1, 2, 4)] == [8, 8, 4, 2]
    monkeypatch.setattr("harness.run.pool.usable_cores", lambda: 1)
    assert share_of_cores(1) == 1
    assert cases_at_once(2) == 1


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_the_death_of_a_worker_takes_one_case(
    tmp_path: Path, small_file: Path, number: signal.Signals
) -> None:
    settings = ["adhesion_factor=0", "penetration=[200, 1]"]
    study = load_study(str(small_file), settings)

    def kill(case: Case, fraction: float) -> None:
        if case == study.cases[0]:
            kill_workers(number)

    record = Record(kill)
    dataset = run(study, tmp_path, 1, record)
    assert dataset.status.values.tolist() == [CRASHED, COMPLETED]
    message = dataset.message.values[0]
    assert re.fullmatch(rf"worker killed by {number.name}, at \d+% of the case", message)
    assert dataset.cone_factor.isnull().values.tolist() == [True, False]
    assert record.outcomes[study.cases[0].key].status == CRASHED


def test_a_case_that_takes_too_long_is_ended_and_the_others_go_on(
    long_and_short: tuple[Path, Case, Case],
) -> None:
    folder, long, short = long_and_short
    fractions: list[float] = []

    def follow(case: Case, fraction: float) -> None:
        if case == long:
            fractions.append(fraction)

    record = Record(follow)
    run_cases([long, short], folder, 1, record, RunOptions(time_limit=5))
    assert record.outcomes[short.key].status == COMPLETED
    kept = case_files.read_outcome(folder, long)
    assert (kept.status, record.outcomes[long.key].status) == (TIMED_OUT, TIMED_OUT)
    assert kept.message == f"ended after 5 s, at {fractions[-1]:.0%} of the case"
    assert kept.seconds >= 5
    assert not list(folder.glob(".*"))
    assert not multiprocessing.active_children()


def test_a_result_written_by_a_worker_that_died_before_it_could_tell_is_kept(
    folder: Path, small: Study
) -> None:
    case = small.cases[0]

    def kill(case: Case, fraction: float) -> None:
        """Kill the worker as it begins, after another has written the result."""
        if not case_files.case_file(folder, case).exists():
            case_files.write_case(folder, case, DONE, COMPLETED)
            kill_workers()

    record = Record(kill)
    run_cases([case], folder, 1, record)
    assert record.outcomes[case.key].status == COMPLETED
    assert case_files.read_outcome(folder, case).status == COMPLETED


def test_what_another_run_has_completed_meanwhile_is_not_run_again(
    folder: Path, small: Study
) -> None:
    first, *others = small.cases

    def complete(case: Case, fraction: float) -> None:
        """Another run in the same folder has done the rest before the first case ends."""
        for other in others:
            case_files.write_case(folder, other, DONE, COMPLETED)

    record = Record(complete)
    run_cases([first, *others], folder, 1, record)
    messages = [record.outcomes[case.key].message for case in (first, *others)]
    assert messages == ["", "by another run", "by another run"]
    kept = [case_files.read_case(folder, case) for case in others]
    assert not any(result is None or "penetration_resistance" in result for result in kept)


def test_an_exception_in_a_watcher_ends_the_workers(tmp_path: Path, small: Study) -> None:
    def interrupt(case: Case, fraction: float) -> NoReturn:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(small, tmp_path, 2, Record(interrupt))
    assert not multiprocessing.active_children()


def test_a_case_that_its_scene_refuses_says_why_and_the_map_shows_it(tmp_path: Path) -> None:
    study = study_in(
        tmp_path,
        'title = "t"\nscene = "sliding_block"\ndesign = "latin_hypercube"\nsamples = 4\nseed = 1\n'
        "stability_map = true\n[fixed]\ntravel = 0.1\n"
        "[vary]\ncells_per_length = { from = 6, to = 13 }\n",
    )
    dataset = run(study, tmp_path, 2, Record())
    expected = np.where(dataset.cells_per_length < 10, "refused", COMPLETED)
    assert dataset.status.values.tolist() == expected.tolist()
    assert set(expected.tolist()) == {"refused", COMPLETED}
    for message in dataset.message.values[expected == "refused"].tolist():
        assert re.fullmatch(r"height_ratio = .* must be 3 cells high or more", message)
    assert shows_stability(dataset)
    assert dataset.attrs["stability_map"] == "cells_per_length"  # in the order of the study
    assert any("refused" in cell for row in stability_rows(dataset) for cell in row)


def test_a_result_that_cannot_be_written_ends_the_run(tmp_path: Path, small: Study) -> None:
    record = Record()
    cases = small.cases
    with pytest.raises(ArchiveError, match=f"{cases[0].key}.*No such file or directory"):
        run_cases(cases, tmp_path / "not there", 1, record)
    assert record.outcomes == {}
    assert not multiprocessing.active_children()


def test_the_time_of_a_case_begins_with_its_computation(begun: Begun, small: Study) -> None:
    """Not when the worker has taken it on: it imports, sets up and compiles first."""
    worker = begun(RunOptions(time_limit=1.0))
    worker.connection.poll(60)
    assert worker.receive() == 0.0
    assert worker.deadline == math.inf
    worker.connection.poll(60)
    assert worker.receive() == 0.0
    assert worker.deadline <= time.monotonic() + 1.0


def test_while_all_processes_are_stopped_no_time_of_a_case_passes(
    begun: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by Ctrl-Z; a limit of 10 s, of which 5 are gone, and an hour's stop."""
    worker = begun(RunOptions(time_limit=10.0))
    worker.began, clock = 1000.0, [1005.0]
    with monkeypatch.context() as patched:
        patched.setattr(worker.connection, "poll", lambda: False)
        patched.setattr(time, "monotonic", lambda: clock[-1])
        patched.setattr(pool, "wait", lambda _, left: clock.append(clock[-1] + left + 3600.0))
        assert pool._wait_for_messages([worker]) == []
        patched.setattr(pool, "wait", lambda _, left: clock.append(clock[-1] + left))
        assert pool._wait_for_messages([worker]) == []
        clock.append(clock[-1] + 5.0)
        assert pool._wait_for_messages([worker]) == [worker]


def test_a_worker_at_work_cleans_up_and_an_idle_one_ends_at_once(
    begun: Begun, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is at work may have a file half-written, and is told to end by a signal it can catch."""
    monkeypatch.setattr(pool, "GRACE", 120.0)  # on a machine under load it takes its time
    busy, idle = begun(), WorkerProcess(folder)
    busy.connection.poll(60)
    assert busy.receive() == 0.0
    end_all([busy, idle])
    assert busy.process.exitcode == 128 + signal.SIGTERM
    assert idle.process.exitcode == -signal.SIGKILL
