"""Cases that a process computes together: the same bits, and none ends with another."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterable
from pathlib import Path

import pytest

from harness.archive import case_files
from harness.archive.case_files import Outcome
from harness.archive.conventions import COMPLETED, CRASHED, TIMED_OUT
from harness.compare.differences import differing
from harness.run.pool import run_cases
from harness.study.cases import Case
from harness.study.study import Study, load_study

from .conftest import Record, collected, prepared, run

pytestmark = pytest.mark.slow


def run_together(folder: Path, cases: Iterable[Case]) -> list[int]:
    """How many cases each of some was run with, itself among them."""
    kept = [case_files.read_case(folder, case) for case in cases]
    return [it.attrs["cases_together"] for it in kept if it is not None]


def test_cases_that_are_run_together_have_the_same_bits(tmp_path: Path, small: Study) -> None:
    alone = run(small, tmp_path / "alone", 1, Record())
    folder = prepared(small, tmp_path / "together")
    record = Record()
    run_cases(small.cases, folder, 1, record, batch=10)
    together = collected(small, folder)
    assert differing(alone, together) == []
    assert record.statuses(small.cases) == [COMPLETED] * 3
    assert run_together(folder, small.cases) == [3, 3, 3]
    assert (together.case_time >= together.run_time).all()


def test_a_batch_leaves_no_worker_without_a_case(tmp_path: Path, small: Study) -> None:
    folder = prepared(small, tmp_path)
    run_cases(small.cases, folder, 2, Record(), batch=10)
    assert run_together(folder, small.cases) == [2, 2, 1]


def test_the_death_of_a_worker_at_many_cases_takes_none_of_those_that_can_be_run_alone(
    tmp_path: Path, small_file: Path
) -> None:
    study = load_study(str(small_file), ["adhesion_factor=[0, 1]", "penetration=[1, 20]"])
    folder = prepared(study, tmp_path)

    class Killer(Record):
        """Kills the first worker as soon as a case is done."""

        def finished(self, case: Case, outcome: Outcome) -> None:
            super().finished(case, outcome)
            if len(self.outcomes) == 1:
                (worker,) = multiprocessing.active_children()
                worker.kill()

    record = Killer()
    run_cases(study.cases, folder, 1, record, batch=4)
    assert record.statuses(study.cases) == [COMPLETED] * 4
    assert set(run_together(folder, study.cases)) == {1, 4}


def test_a_case_that_takes_too_long_does_not_end_those_it_is_run_with(
    long_and_short: tuple[Path, Case, Case],
) -> None:
    folder, long, short = long_and_short
    record = Record()
    run_cases([long, short], folder, 1, record, time_limit=4, batch=2)
    assert record.statuses([long, short]) == [TIMED_OUT, COMPLETED]


def test_a_death_in_a_batch_is_laid_on_the_case_that_causes_it_alone(
    tmp_path: Path, small_file: Path
) -> None:
    study = load_study(str(small_file), ["adhesion_factor=0", "penetration=[200, 1, 2]"])
    folder = prepared(study, tmp_path)

    class Killer(Record):
        """Kills each worker that has come on with the long case."""

        def advanced(self, case: Case, fraction: float) -> None:
            if case.parameters["penetration"] == 200 and fraction > 0:
                for worker in multiprocessing.active_children():
                    worker.kill()

    record = Killer()
    run_cases(study.cases, folder, 1, record, batch=3)
    assert record.statuses(study.cases) == [CRASHED, COMPLETED, COMPLETED]
