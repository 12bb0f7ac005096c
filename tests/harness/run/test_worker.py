"""A case in a worker: how it ends where its scene raises an exception."""

import math
import re
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
import xarray as xr

from harness.archive import case_files
from harness.cli.main import main
from harness.run.worker import run_case
from harness.study.study import Study, load_study
from mpm_warp.errors import SceneError, SimulationDiverged
from mpm_warp.results import variable
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

pytestmark = pytest.mark.slow


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
    assert result is not None
    assert result.attrs["message"] == message
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
    assert kept is not None
    assert float(kept.work) == 3.0
    assert not case_files.is_complete(tmp_path, case)


def test_an_unfinished_case_keeps_its_scalars_and_is_not_collected(
    tmp_path: Path, small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results"
    settings = ["--set", "adhesion_factor=0", "--set", "steady_tolerance=[0, 0.003]"]
    assert main(["run", str(small_file), "--out", str(out), *settings]) == 1
    assert re.search(
        r"unfinished: the resistance still changes by \d+% at the", capsys.readouterr().err
    )
    study = load_study(str(small_file), settings[1::2])
    folder = case_files.case_folder(out, study)
    finished, unfinished = (case_files.read_case(folder, case) for case in study.cases)
    assert finished is not None
    assert unfinished is not None
    assert unfinished.attrs["status"] == "unfinished"
    assert float(unfinished.cone_factor) == float(finished.cone_factor)
    with xr.open_dataset(out / "small.nc") as collected:
        assert np.isfinite(collected.cone_factor).values.ravel().tolist() == [True, False]
