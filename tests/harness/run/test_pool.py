"""Cases in worker processes: none lost, none done twice, whatever becomes of the workers."""

import math
import multiprocessing
import re
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import NoReturn

import pytest

from harness.archive import case_files
from harness.archive.atomic_files import ArchiveError
from harness.archive.conventions import COMPLETED, CRASHED, TIMED_OUT
from harness.compare.differences import differing
from harness.run import pool
from harness.run.pool import WorkerProcess, cases_at_once, end_all, run_cases, share_of_cores
from harness.run.resources import DEFAULTS, RunOptions
from harness.study.cases import Case
from harness.study.study import Study, load_study
from tests.harness.conftest import DONE, prepared

from .conftest import Record, kill_workers, run

pytestmark = pytest.mark.slow

Begun = Callable[..., WorkerProcess]


def test_every_case_is_run_once_and_has_its_own_result(tmp_path: Path, stub: Study) -> None:
    record = Record()
    dataset = run(stub, tmp_path, 2, record)
    assert record.statuses(stub.cases) == [COMPLETED] * 3
    assert dataset.answer.values.tolist() == [0.0, 1.0, 2.0]
    assert (dataset.case_time >= dataset.run_time).all()
    assert not multiprocessing.active_children()


def test_the_number_of_workers_and_of_threads_changes_no_bit(tmp_path: Path, small: Study) -> None:
    one, two = (
        run(small, tmp_path / str(count), count, Record(), RunOptions(threads=count))
        for count in (1, 2)
    )
    assert "time_step" in one
    assert differing(one, two) == []


@pytest.fixture
def begun(stub_folder: Path, stub: Study) -> Iterator[Begun]:
    """Makes workers that have taken on a case which does not end."""
    case = load_study(str(stub.source), ["seconds=1000"]).cases[0]
    workers = []

    def made(options: RunOptions = DEFAULTS) -> WorkerProcess:
        workers.append(WorkerProcess(stub_folder, options))
        workers[-1].begin(case)
        return workers[-1]

    yield made
    end_all(workers)


def test_a_case_has_its_threads_from_the_first_step_on(
    stub_folder: Path, stub: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent = []
    send = WorkerProcess._send

    def noted(worker: WorkerProcess, message: Case | int) -> None:
        sent.append(message)
        send(worker, message)

    monkeypatch.setattr(WorkerProcess, "_send", noted)
    run_cases(stub.cases, stub_folder, 1, Record(), RunOptions(threads=2))
    assert sent == [2, *stub.cases]


def test_given_more_workers_than_windows_waits_for_the_first_are_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    worker = SimpleNamespace(connection=None, deadline=math.inf, has_message=True)
    counts = list[int]()
    monkeypatch.setattr(pool, "wait", lambda objects, timeout: counts.append(len(objects)))
    assert len(pool._wait_for_messages(100 * [worker])) == 100
    assert counts[0] < 63


def test_cases_at_work_share_the_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harness.run.pool.usable_cores", lambda: 8)
    assert [share_of_cores(cases) for cases in (1, 2, 3, 4, 5, 8, 20)] == [4, 4, 2, 2, 1, 1, 1]
    assert [cases_at_once(threads) for threads in (None, 1, 2, 4)] == [8, 8, 4, 2]
    monkeypatch.setattr("harness.run.pool.usable_cores", lambda: 1)
    assert share_of_cores(1) == 1
    assert cases_at_once(2) == 1


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_a_dead_worker_takes_one_case(
    tmp_path: Path, stub: Study, number: signal.Signals, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr("multiprocessing.connection._ConnectionBase.poll")  # Windows: it raises
    study = load_study(str(stub.source), ["seconds=[1000, 0]", "number=1"])

    def kill(case: Case, fraction: float) -> None:
        if case == study.cases[0]:
            kill_workers(number)

    record = Record(kill)
    dataset = run(study, tmp_path, 1, record)
    assert dataset.status.values.ravel().tolist() == [CRASHED, COMPLETED]
    message = dataset.message.values.ravel()[0]
    assert re.fullmatch(rf"worker killed by {number.name}, at \d+% of the case", message)
    assert dataset.answer.isnull().values.ravel().tolist() == [True, False]
    assert record.outcomes[study.cases[0].key].status == CRASHED


def test_a_case_that_takes_too_long_is_ended_alone(tmp_path: Path, stub: Study) -> None:
    long, short = load_study(str(stub.source), ["seconds=[10, 0]", "number=1"]).cases
    folder, fractions = prepared(stub, tmp_path), list[float]()

    def follow(case: Case, fraction: float) -> None:
        if case == long:
            fractions.append(fraction)

    record = Record(follow)
    run_cases([long, short], folder, 1, record, RunOptions(time_limit=1))
    assert record.outcomes[short.key].status == COMPLETED
    kept = case_files.read_outcome(folder, long)
    assert (kept.status, record.outcomes[long.key].status) == (TIMED_OUT, TIMED_OUT)
    assert kept.message == f"ended after 1 s, at {fractions[-1]:.0%} of the case"
    assert kept.seconds >= 1
    assert not list(folder.glob(".*"))
    assert not multiprocessing.active_children()


def test_a_result_of_a_worker_that_died_after_it_is_kept(stub_folder: Path, stub: Study) -> None:
    case = stub.cases[0]

    def kill(case: Case, fraction: float) -> None:
        """Kill the worker as it begins, after another has written the result."""
        if not case_files.case_file(stub_folder, case).exists():
            case_files.write_case(stub_folder, case, DONE, COMPLETED)
            kill_workers()

    record = Record(kill)
    run_cases([case], stub_folder, 1, record)
    assert record.outcomes[case.key].status == COMPLETED
    assert case_files.read_outcome(stub_folder, case).status == COMPLETED


def test_what_another_run_has_completed_is_not_run(stub_folder: Path, stub: Study) -> None:
    first, *others = stub.cases

    def complete(case: Case, fraction: float) -> None:
        """Another run in the same folder has done the rest before the first case ends."""
        for other in others:
            case_files.write_case(stub_folder, other, DONE, COMPLETED)

    record = Record(complete)
    run_cases([first, *others], stub_folder, 1, record)
    messages = [record.outcomes[case.key].message for case in (first, *others)]
    assert messages == ["", "by another run", "by another run"]
    kept = [case_files.read_case(stub_folder, case) for case in others]
    assert not any(result is None or "answer" in result for result in kept)


def test_an_exception_in_a_watcher_ends_the_workers(tmp_path: Path, stub: Study) -> None:
    def interrupt(case: Case, fraction: float) -> NoReturn:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(stub, tmp_path, 2, Record(interrupt))
    assert not multiprocessing.active_children()


def test_a_result_that_cannot_be_written_ends_the_run(tmp_path: Path, stub: Study) -> None:
    record = Record()
    cases = stub.cases
    with pytest.raises(ArchiveError, match=f"{cases[0].key}.*No such file or directory"):
        run_cases(cases, tmp_path / "not there", 1, record)
    assert record.outcomes == {}
    assert not multiprocessing.active_children()


def test_the_time_of_a_case_begins_with_its_computation(begun: Begun) -> None:
    """Not when the worker has taken it on: it imports, sets up and compiles first."""
    worker = begun(RunOptions(time_limit=1.0))
    worker.connection.poll(60)
    assert worker.receive() == 0.0
    assert worker.deadline == math.inf
    worker.connection.poll(60)
    assert worker.receive() == 0.0
    assert worker.deadline <= time.monotonic() + 1.0


def test_no_time_passes_while_all_are_stopped(
    begun: Begun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by Ctrl-Z; a limit of 10 s, of which 5 are gone, and an hour's stop."""
    worker = begun(RunOptions(time_limit=10.0))
    worker.began, clock = 1000.0, [1005.0]
    with monkeypatch.context() as patched:
        patched.setattr(WorkerProcess, "_can_read", False)
        patched.setattr(time, "monotonic", lambda: clock[-1])
        patched.setattr(pool, "wait", lambda _, left: clock.append(clock[-1] + left + 3600.0))
        assert pool._wait_for_messages([worker]) == []
        assert clock[-1] == 1005.0 + pool.LONGEST_WAIT + 3600.0  # however long the limit
        patched.setattr(pool, "wait", lambda _, left: clock.append(clock[-1] + left))
        assert pool._wait_for_messages([worker]) == []
        clock.append(clock[-1] + 5.0)
        assert pool._wait_for_messages([worker]) == [worker]


def test_a_worker_at_work_cleans_up_and_an_idle_one_ends_at_once(
    begun: Begun, stub_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is at work may have a file half-written, and is told to end by a signal it can catch."""
    monkeypatch.setattr(pool, "GRACE", 120.0)  # on a machine under load it takes its time
    busy, idle = begun(), WorkerProcess(stub_folder)
    busy.connection.poll(60)
    assert busy.receive() == 0.0
    end_all([busy, idle])
    assert busy.process.exitcode == 128 + signal.SIGTERM
    assert idle.process.exitcode == -signal.SIGKILL
