"""Options that a command is given: nothing is ignored, nothing is lost."""

from multiprocessing import connection
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from harness.cli.main import main
from harness.cli.options import make_parser
from harness.run import pool
from tests.harness.conftest import Refusal

pytestmark = pytest.mark.slow


COUNT = "must be an integer from 1 to 999999"
SIZE = "must be > 0, as 8e9 or 8GB"
WRONG = {
    "report a.nc -o b.nc": "'b.nc' is not allowed: must end in .html",
    "compare a.nc b.nc --tolerance=-1": "must be a number >= 0",
    "compare a.nc --tolerance=0.5": "is for two results",
    "recommend s --error=0%": "'0%' is not allowed: must be > 0, as 1% or 0.01",
    "run mesh_size --threads=3": "choose from 1, 2, 4",
    "run mesh_size --device=cuda:7": "--device cuda:7: there is none here; known: cpu",
    "run mesh_size --device=gpu": "--device gpu: there is none here; known: cpu",
    **{f"run mesh_size --workers={it}": COUNT for it in ("0", "-1", "two", "1.5", "9" * 5000)},
    "run mesh_size --batch=0": COUNT,
    "run mesh_size --batch=2 --dask=tcp://h:1": "leave them out with --dask",
    "run bench --workers=2": "cases are timed one at a time, without --workers",
    "run bench --batch=2": "cases are timed one at a time, without --batch",
    **{
        f"run mesh_size --case-timeout={it}": f"'{it}' is not allowed: must be a number > 0"
        for it in ("0", "-1", "soon", "nan", "inf")
    },
    **{
        f"run mesh_size --memory-limit={it}": SIZE
        for it in ("0", "-1GB", "much", "GB", "inf", "nan")
    },
}


@pytest.mark.parametrize("line", WRONG)
def test_an_option_that_is_not_allowed_is_one_line(
    line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    try:
        code: str | int | None = main(line.split())
    except SystemExit as end:
        code = end.code
    assert code == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert WRONG[line] in told
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ["8GB", "8e9", "8000MB", "8gb", "8000000000", "8000000000B"])
def test_a_size_has_a_unit_or_none(text: str) -> None:
    assert make_parser().parse_args(["run", "s", "--memory-limit", text]).memory_limit == 8e9


@pytest.mark.parametrize(("text", "share"), [("2%", 0.02), ("0.02", 0.02), ("0.5%", 0.005)])
def test_an_error_is_a_share(text: str, share: float) -> None:
    assert make_parser().parse_args(["recommend", "s", "--error", text]).error == share


def test_bytes_that_are_no_text_are_refused(refusal: Refusal) -> None:
    """The result holds the command line; every case would be computed, and none be kept."""
    line = refusal(["run", "mesh_size", "--out", b"bad\xff".decode(errors="surrogateescape")])
    assert line.endswith("is not text, which results could not keep")


def test_scenes_may_be_named_one_by_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--scene", "material_point", "--scene", "gravity_column"]) == 0
    out = capsys.readouterr().out
    assert "material_point" in out
    assert "gravity_column" in out


def test_a_limit_beyond_what_the_system_can_wait_for_is_waited_for(
    small_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waits: list[float | None] = []

    def noted(them: list[Any], left: float | None) -> list[Any]:
        waits.append(left)
        return connection.wait(them, left)

    monkeypatch.setattr(pool, "wait", noted)
    run = ["run", str(small_file), "--set=adhesion_factor=0", f"--out={tmp_path}"]
    assert main([*run, "--case-timeout=1e9"]) == 0
    assert max(left for left in waits if left is not None) <= pool.LONGEST_WAIT


def test_uncertainty_is_measured_on_request(
    tmp_path: Path, small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["run", str(small_file), f"--out={tmp_path}", "--uncertainty"]
    values = ("adhesion_factor=0", "cells_per_radius=2.31", "domain_radius=8", "domain_above=3")
    command += [f"--set={value}" for value in (*values, "domain_below=4")]
    assert main(command) == 0, capsys.readouterr().err
    (result,) = tmp_path.glob("*.nc")
    with xr.open_dataset(result) as dataset:
        assert (dataset.uncertainty == "measured").all()
        assert (dataset.uncertainty_run_time > 0.0).all()


@pytest.mark.parametrize(
    ("study", "scene"), [("sliding_block", "sliding_block"), ("cyclic_ball", "cyclic_ball")]
)
def test_a_scene_without_a_measured_uncertainty_is_refused(
    tmp_path: Path, refusal: Refusal, study: str, scene: str
) -> None:
    line = refusal(["run", study, "--uncertainty", f"--out={tmp_path}"])
    assert line == (
        f"harness: --uncertainty: no measured uncertainty in {scene}; these scenes have one: "
        "ball_penetration, cone_penetration, sounding, t_bar_penetration"
    )
    assert not list(tmp_path.iterdir())
