"""Options that a command is given: nothing is ignored, nothing is lost."""

from multiprocessing import connection
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from harness.cli.main import main
from harness.run import pool
from tests.harness.conftest import Refusal

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["report", "a.nc", "-o", "b.nc"], "'b.nc' is not allowed: must end in .html"),
        (["run", "mesh_size", "--case-timeout=nan"], "must be a number > 0"),
        (["compare", "a.nc", "b.nc", "--tolerance=-1"], "must be a number >= 0"),
    ],
)
def test_an_option_that_is_not_allowed_is_one_line(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(arguments)
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line


@pytest.mark.parametrize("option", ["--workers=2", "--batch=2"])
@pytest.mark.parametrize("timing", ["", "[timing]\nrepeats = 1\n"])
def test_what_is_timed_runs_alone(
    option: str, timing: str, small_file: Path, tmp_path: Path, refusal: Refusal
) -> None:
    small_file.write_text(small_file.read_text() + timing)
    study = str(small_file) if timing else "bench"
    line = refusal(["run", study, option, f"--out={tmp_path}"])
    assert line.endswith(f"cases are timed one at a time, without {option.partition('=')[0]}")


def test_a_tolerance_for_two_results_is_not_ignored_where_there_is_one(
    tmp_path: Path, refusal: Refusal
) -> None:
    line = refusal(["compare", str(tmp_path / "a.nc"), "--tolerance=0.5"])
    assert "is for two results" in line


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
    assert main(["run", str(small_file), f"--out={tmp_path}", "--case-timeout=1e9"]) == 0
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
    ("study", "scene"), [("sliding_block", "sliding_block"), ("thin_layer", "sounding")]
)
def test_a_scene_without_a_measured_uncertainty_is_refused(
    tmp_path: Path, refusal: Refusal, study: str, scene: str
) -> None:
    line = refusal(["run", study, "--uncertainty", f"--out={tmp_path}"])
    assert line == (
        f"harness: --uncertainty: no measured uncertainty in {scene}; these scenes have one: "
        "ball_penetration, cone_penetration, t_bar_penetration"
    )
    assert not list(tmp_path.iterdir())
