"""Scenes against exact solutions: verdicts, table, files and exit codes."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.run import verify
from harness.run.verify import Check
from mpm_warp import GravityColumn, Verification
from tests.harness.conftest import Command

pytestmark = pytest.mark.slow

CHECK = Check(
    scene="gravity_column",
    verification=Verification(
        resolution="cell_count", resolutions=(2, 4), bounds={"error": 0.01}, least_order=1.0
    ),
)


def verified(*errors: float, messages: tuple[str, ...] = ("", "")) -> verify.Verified:
    results = tuple(xr.Dataset({"error": error, "run_time": 1.0}) for error in errors)
    return verify.Verified(check=CHECK, results=results, messages=messages)


def test_passes_within_bound_and_order_and_falls_short_elsewhere() -> None:
    result = verified(0.02, 0.005)
    assert result.order == pytest.approx(2)
    assert result.shortfalls == ()
    assert verify.table_rows(result).splitlines()[-1].endswith("pass")
    assert verified(0.08, 0.02).shortfalls == ("error 0.02 > 0.01",)
    assert verified(0.008, 0.007).shortfalls == ("order 0.19 < 1",)
    assert len(verified(0.02, np.nan).shortfalls) == 2


def test_a_failed_run_is_a_row_with_a_message() -> None:
    check = dataclasses.replace(
        CHECK, verification=dataclasses.replace(CHECK.verification, settings={"cell_count": 1})
    )
    result = verify.Verified(check=check, results=(None, None), messages=("", "Diverged: at once"))
    assert "Diverged: at once" in verify.table_rows(result)
    assert np.isnan(verify.as_dataset([result])["error"]).all()


@pytest.mark.parametrize(
    ("extreme", "some"),
    [
        (False, {"material_point", "elastic_column_wave", "thick_cylinder"}),
        (True, {"flying_block", "stretched_bar", "struck_bar"}),
    ],
)
def test_every_scene_with_a_solution_is_checked(extreme: bool, some: set[str]) -> None:
    """By the extreme checks when asked for, and by no others then."""
    checks = verify.checks_of(extreme=extreme)
    assert some <= {check.scene for check in checks}
    assert {check.verification.extreme for check in checks} == {extreme}
    assert "cone_penetration" not in {check.scene for check in checks}


def test_quick_checks_are_the_cheapest_of_their_scenes_and_short() -> None:
    everything = verify.checks_of()
    chosen = verify.quick(everything)
    assert len({it.scene for it in chosen}) == len(chosen)
    assert {"cavity_sphere", "cone_bearing", "material_point"} <= {it.scene for it in chosen}
    for check in chosen:
        alike = [it.predicted_time for it in everything if it.scene == check.scene]
        assert check.predicted_time == min(alike) < verify.QUICK_TIME


def test_checks_side_by_side_give_the_same_in_their_order(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("harness.run.verify.QUICK_TIME", 0.0)
    monkeypatch.setattr("harness.run.verify.usable_cores", lambda: 2)
    checks = [*verify.checks_of(["gravity_column"]), *verify.checks_of(["element_test"])[:1]]
    for found in zip(verify.verified_in_turn(checks), map(verify.verify, checks), strict=True):
        one, other = (it.values("error") for it in found)
        assert one == other


def test_a_check_of_one_resolution_has_files_without_an_order_and_replaces_no_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    once = dataclasses.replace(CHECK.verification, resolutions=(2,), least_order=None)
    monkeypatch.setattr(GravityColumn, "verifications", (once,))
    verified = "verify", "--scene", "gravity_column", "--out", tmp_path
    for _ in range(2):  # files of its own are replaced
        assert command(*verified).out.splitlines()[-1].endswith("pass")
    with xr.open_dataset(tmp_path / "verify.nc") as dataset:
        assert dataset["error"].shape == (1, 1)
        assert np.isnan(dataset["order"]).all()
        assert dataset["passed"].item() == 1
    assert "pass" in (tmp_path / "verify.txt").read_text()
    assert (tmp_path / "verify.png").read_bytes().startswith(b"\x89PNG")
    for name in ("verify.nc", "verify.txt", "verify.png"):
        own = (tmp_path / name).read_bytes()
        (tmp_path / name).write_text("mine")
        told = command(*verified, code=2)
        assert f"{name}: was not written by this program" in told.err
        assert "gravity_column" not in told.out
        assert (tmp_path / name).read_text() == "mine"
        (tmp_path / name).write_bytes(own)


def test_command_says_what_falls_short(monkeypatch: pytest.MonkeyPatch, command: Command) -> None:
    impossible = dataclasses.replace(GravityColumn.verifications[0], bounds={"error": 0.0})
    monkeypatch.setattr(GravityColumn, "verifications", (impossible,))
    assert "FALLS SHORT: error" in command("verify", "--scene", "gravity_column", code=1).out


def test_scenes_are_named_and_one_without_a_quick_check_is_told(
    command: Command,
) -> None:
    named = ("--scene", "material_point", "gravity_column", "--scene", "circular_footing")
    told = command("verify", "--quick", *named)
    assert "--quick: these scenes have no quick check: circular_footing" in told.err
    assert "material_point" in told.out
    assert "gravity_column" in told.out
