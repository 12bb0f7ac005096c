from __future__ import annotations

import multiprocessing
import os
import signal
from pathlib import Path
from typing import NoReturn

import pytest
import xarray as xr

from harness import archive
from harness.cases import COMPLETED, CRASHED, Case, Outcome, cases_of
from harness.runner import Watcher, run_cases
from harness.study import Study, load_study
from harness.worker import run_case
from mpm_warp.scenes.cone_penetration import ConePenetration


class Record:
    """A watcher that remembers the outcomes, by the cases' keys."""

    def __init__(self) -> None:
        self.outcomes: dict[str, Outcome] = {}

    def advanced(self, case: Case, fraction: float) -> None:
        assert 0 <= fraction <= 1

    def finished(self, case: Case, outcome: Outcome) -> None:
        assert case.key not in self.outcomes
        self.outcomes[case.key] = outcome


def run(study: Study, out: Path, workers: int, watcher: Watcher) -> xr.Dataset:
    """Run a study in `out` and collect it."""
    folder = archive.case_folder(out, study)
    archive.prepare(folder)
    run_cases(cases_of(study), folder, workers, watcher)
    return archive.collect(study, cases_of(study), folder)


def test_every_case_is_run_once_and_kept(tmp_path: Path, small: Study) -> None:
    record = Record()
    dataset = run(small, tmp_path, 2, record)
    assert [record.outcomes[case.key].status for case in cases_of(small)] == [COMPLETED] * 3
    assert dataset.status.values.tolist() == [COMPLETED] * 3
    assert dataset.cone_factor.notnull().all()
    assert not multiprocessing.active_children()


def test_the_number_of_workers_does_not_change_a_bit(tmp_path: Path, small: Study) -> None:
    one = run(small, tmp_path / "1", 1, Record())
    two = run(small, tmp_path / "2", 2, Record())
    timings = [name for name in one.data_vars if one[name].attrs.get("units") == "s"]
    assert "run_time" in timings
    xr.testing.assert_equal(one.drop_vars(timings), two.drop_vars(timings))


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_the_death_of_a_worker_takes_one_case(
    tmp_path: Path, small_file: Path, number: signal.Signals
) -> None:
    settings = ["adhesion_factor=0", "penetration=[200, 1]"]
    study = load_study(str(small_file), settings)

    class Killer(Record):
        def advanced(self, case: Case, fraction: float) -> None:
            if case.parameters["penetration"] == 200:
                (worker,) = multiprocessing.active_children()
                assert worker.pid is not None
                os.kill(worker.pid, number)

    record = Killer()
    dataset = run(study, tmp_path, 1, record)
    assert dataset.status.values.tolist() == [CRASHED, COMPLETED]
    message = dataset.message.values[0]
    assert message.startswith(f"worker killed by {number.name} after ")
    assert dataset.cone_factor.isnull().values.tolist() == [True, False]
    assert record.outcomes[cases_of(study)[0].key].status == CRASHED


def test_an_exception_in_a_watcher_ends_the_workers(tmp_path: Path, small: Study) -> None:
    class Interrupter(Record):
        def advanced(self, case: Case, fraction: float) -> NoReturn:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(small, tmp_path, 2, Interrupter())
    assert not multiprocessing.active_children()


def test_an_exception_of_the_scene_is_the_outcome(
    tmp_path: Path, small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(scene: object, progress: object) -> NoReturn:
        raise ArithmeticError("on\ntwo lines")

    monkeypatch.setattr(ConePenetration, "run", fail)
    case = cases_of(small)[0]
    outcome = run_case(case, tmp_path)
    assert (outcome.status, outcome.message) == ("failed", "ArithmeticError: on two lines")
    result = archive.read_case(tmp_path, case)
    assert result is not None
    assert result.attrs["message"] == outcome.message


def test_an_exception_may_name_the_status(
    tmp_path: Path, small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    class DivergedError(Exception):
        status = "diverged"

    def diverge(scene: object, progress: object) -> NoReturn:
        raise DivergedError("too fast")

    monkeypatch.setattr(ConePenetration, "run", diverge)
    assert run_case(cases_of(small)[0], tmp_path).status == "diverged"


def test_a_result_that_cannot_be_written_is_missing(tmp_path: Path, small: Study) -> None:
    record = Record()
    case = cases_of(small)[0]
    run_cases([case], tmp_path / "not there", 1, record)
    outcome = record.outcomes[case.key]
    assert outcome.status == "missing"
    assert case.key in outcome.message
