"""Where the work of the penetrometer goes."""

from __future__ import annotations

import pytest
import xarray as xr

from mpm_warp.errors import InaccurateRun
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.energy_balance import LARGEST_RESIDUAL, MEANING, check_balance

pytestmark = pytest.mark.slow


def run(adhesion_factor: float, energy_audit: str) -> xr.Dataset:
    return ConePenetration(
        cells_per_radius=2,
        penetration=3,
        domain_radius=20,
        domain_above=6,
        domain_below=6,
        steady_tolerance=0,
        adhesion_factor=adhesion_factor,
        energy_audit=energy_audit,
    ).run()


@pytest.fixture(scope="module")
def rough() -> xr.Dataset:
    return run(0.5, "balance")


def shares(results: xr.Dataset) -> dict[str, float]:
    return {name: float(results[f"work_share_{name}"]) for name in MEANING}


def test_the_balance_closes_and_changes_nothing(rough: xr.Dataset) -> None:
    assert abs(float(rough.energy_residual)) < LARGEST_RESIDUAL
    assert sum(shares(rough).values()) + float(rough.energy_residual) == pytest.approx(1.0)
    plain = run(0.5, "transfers")
    xr.testing.assert_identical(rough.penetration_resistance, plain.penetration_resistance)
    xr.testing.assert_identical(rough.energy_error, plain.energy_error)
    assert not [name for name in plain if str(name).startswith("work_share")]


def test_a_smooth_cone_loses_nothing_by_sliding(rough: xr.Dataset) -> None:
    """Its soil takes all of the work; a rough one loses what the adhesion takes along its way."""
    smooth = shares(run(0.0, "balance"))
    assert smooth["sliding"] == pytest.approx(0.0, abs=1e-3)
    assert smooth["plastic"] + smooth["elastic"] == pytest.approx(1.0, abs=0.02)
    # On the shaft, 6 radii long, soil hardly moves: at an adhesion of 0.5 su that is 6 of Nc.
    on_shaft = 6.0 / (6.0 + float(rough.cone_factor_simulated))
    assert shares(rough)["sliding"] > 0.9 * on_shaft


@pytest.mark.parametrize("residual", [0.011, -0.011, float("nan")])
def test_a_balance_that_does_not_close_is_no_result(residual: float) -> None:
    with pytest.raises(InaccurateRun, match="not found again, more than 1%"):
        check_balance(xr.Dataset({"energy_residual": residual}))
