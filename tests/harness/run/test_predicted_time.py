"""The order in which cases are run follows from the time that they are predicted to take."""

from __future__ import annotations

from pathlib import Path

import pytest

from harness.run import run_study
from harness.run.predicted_time import UPDATE_RATE, costliest_first, predicted_time
from harness.run.run_study import on_this_machine
from harness.study.cases import Case
from harness.study.study import Study, load_study

from .conftest import Record

pytestmark = pytest.mark.slow


@pytest.fixture
def mixed(small_file: Path) -> Study:
    """Four cases; of those of one length both take as long."""
    return load_study(str(small_file), ["penetration=[1, 3]", "adhesion_factor=[0, 1]"])


def lengths(cases: list[Case]) -> list[tuple[object, object]]:
    return [(it.parameters["penetration"], it.parameters["adhesion_factor"]) for it in cases]


def test_the_costliest_case_is_first_and_equal_ones_stay_in_their_order(mixed: Study) -> None:
    assert sorted(lengths(list(mixed.cases))) == [(1, 0), (1, 1), (3, 0), (3, 1)]
    times = [predicted_time(case) for case in mixed.cases]
    assert len(set(times)) == 2
    ordered = costliest_first(mixed.cases)
    assert lengths(ordered) == [(3, 0), (3, 1), (1, 0), (1, 1)]
    # A predicted time is that of points times steps, at the speed that is told of everywhere.
    size = mixed.parts[0].scene(**ordered[0].parameters).run_size()
    assert size is not None
    assert predicted_time(ordered[0]) == size.particle_updates / UPDATE_RATE


def test_a_case_of_unknown_time_is_last(small_file: Path) -> None:
    refused, sound = load_study(str(small_file), ["adhesion_factor=[0, 1]"]).cases
    refused = Case(**{**vars(refused), "parameters": {**refused.parameters, "penetration": -1.0}})
    assert predicted_time(refused) == 0.0
    assert costliest_first([refused, sound]) == [sound, refused]


@pytest.mark.parametrize(("workers", "first"), [(1, 1), (2, 3)])
def test_several_workers_begin_with_the_costliest_and_one_goes_by_the_study(
    workers: int, first: int, mixed: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[Case] = []

    def note(cases: list[Case], *_: object, **__: object) -> None:
        given.extend(cases)

    monkeypatch.setattr(run_study, "run_cases", note)
    on_this_machine(mixed, workers, 100.0)(mixed.cases, tmp_path, Record())
    assert given[0].parameters["penetration"] == first
    assert len(given) == len(mixed.cases)
    assert (given == list(mixed.cases)) == (workers == 1)
