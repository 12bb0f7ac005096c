"""A case in a worker: what it costs, and how it ends where its scene raises an exception."""

import io
import math
from pathlib import Path
from typing import NoReturn

import pytest
import xarray as xr

from harness.archive import case_files
from harness.run.pool import run_cases
from harness.run.resources import RunOptions
from harness.run.run_study import Display
from harness.run.worker import compute, run_case
from harness.study.cases import Case
from harness.study.study import Study
from mpm_warp import GravityColumn, SceneError, SimulationDiverged, scene_class
from mpm_warp.errors import UnfinishedRun
from mpm_warp.fields.declaration import Value
from mpm_warp.fields.flat import values_of
from mpm_warp.planning import make_plan
from mpm_warp.results import variable
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

pytestmark = pytest.mark.slow


def case_of(scene: str, **parameters: Value) -> Case:
    values = values_of(scene_class(scene)(**parameters))
    version = scene_class(scene).version
    return Case(scene=scene, scene_version=version, parameters=values, label=scene)


@pytest.mark.parametrize(
    "case",
    [case_of("material_point", step_count=1000), case_of("gravity_column", cell_count=4)],
    ids=lambda case: case.label,
)
def test_every_case_tells_its_times_apart_its_work_and_its_memory(case: Case) -> None:
    dataset = compute(case).dataset
    for name in ("run_time", "setup_time", "compile_time", "case_time"):
        assert dataset[name].attrs["units"] == "s"
        assert dataset[name] > 0
    apart = dataset.run_time + dataset.setup_time + dataset.compile_time
    assert apart < dataset.case_time
    assert dataset.particle_updates == dataset.particle_count * dataset.step_count
    assert dataset.peak_memory.attrs["units"] == "byte"
    assert "since it ran the case" in dataset.peak_memory.attrs["description"]


def test_memory_stays_flat_from_case_to_case(tmp_path: Path) -> None:
    """A worker that kept the arrays of each case would grow by their size each time."""
    case_count, warm, size = 40, 10, {"size": 4000, "samples": 1}
    scene = scene_class("step_cost")(**size).build()
    assert scene is not None
    arrays = sum(array.byte_count for array in make_plan(scene).arrays.values())
    cases = [
        case_of("step_cost", **size, sample_time=0.01 + 1e-6 * number)
        for number in range(case_count)
    ]
    run_cases(cases, tmp_path, 1, Display(case_count, io.StringIO()))
    results = [case_files.read_case(tmp_path, case) for case in cases]
    peaks = [int(result.peak_memory) for result in results if result is not None]
    assert max(peaks) - peaks[warm] < 0.25 * (case_count - warm) * arrays


def test_other_numbers_in_a_repeat_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = GravityColumn.run
    results: list[xr.Dataset] = []

    def drifting(scene: GravityColumn, *given: object) -> xr.Dataset:
        result = run(scene)
        numbers = [name for name, values in result.items() if values.dtype.kind == "f"]
        results.append(result.assign(result[numbers] + len(results) * 1e-15))
        return results[-1]

    monkeypatch.setattr(GravityColumn, "run", drifting)
    outcome = run_case(
        case_of("gravity_column", cell_count=4), tmp_path, options=RunOptions(repeats=2)
    )
    assert outcome.status == "failed"
    assert "run 2 gave another " in outcome.message


class Cavitated(Exception):
    """Of a scene of another package, which names its status."""

    status = "cavitated"


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (ArithmeticError("on\ntwo lines"), "failed", "ArithmeticError: on two lines"),
        (Cavitated("too fast"), "cavitated", "too fast"),
        (SceneError("bodies 0 and 1 overlap"), "refused", "bodies 0 and 1 overlap"),
        (SimulationDiverged("at once"), "diverged", "at once"),
        (UnfinishedRun("too short", xr.Dataset({"work": 3.0})), "unfinished", "too short"),
    ],
)
def test_an_exception_of_the_scene_is_the_outcome(
    error: Exception,
    status: str,
    message: str,
    tmp_path: Path,
    small: Study,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*given: object) -> NoReturn:
        raise error

    monkeypatch.setattr(ConePenetration, "run", fail)
    case = small.cases[0]
    outcome = run_case(case, tmp_path)
    assert (outcome.status, outcome.message) == (status, message)
    result = case_files.read_case(tmp_path, case)
    assert result.attrs["message"] == message
    assert ("work" in result) == (status == "unfinished")
    # An end that has a name needs no place in the program.
    assert ("traceback" in result.attrs) == (status == "failed")


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_headline_that_is_no_number_is_no_result_and_is_kept(
    tmp_path: Path, small: Study, monkeypatch: pytest.MonkeyPatch, number: float
) -> None:
    def end(*given: object) -> xr.Dataset:
        factor = variable(number, unit="1", meaning="cone factor", role="headline")
        return xr.Dataset({"cone_factor": factor, "work": 3.0})

    monkeypatch.setattr(ConePenetration, "run", end)
    case = small.cases[0]
    outcome = run_case(case, tmp_path)
    assert outcome.status == "unfinished"
    assert outcome.message.startswith("cone factor is not a finite number: ")
    kept = case_files.read_case(tmp_path, case)
    assert float(kept.work) == 3.0
    assert not case_files.is_complete(tmp_path, case)
