"""The error of a sounding by further runs of cone tests in the clay at some of its depths."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp.errors import ParameterError, UnfinishedRun
from mpm_warp.results import variable
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.sounding.curves import error_of_samples
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.uncertainty.further_runs import CARRIED_ON
from mpm_warp.uncertainty.laws import EFFECTS
from mpm_warp.uncertainty.samples import MeasuredError, measured_by
from tests.mpm_warp.scenes.sounding.conftest import changed

SOFTENING: dict[str, Any] = {"remoulded_strength_ratio": 0.5, "ductility": 20.0}
LAYERS = (
    "depth [m], strength [kPa], rigidity_index [1]; 0, 10, 50; 13, 10, 50; 13, 30, 80; 20, 30, 80"
)
CORRECTION, HALF_WIDTH = {50.0: 0.1, 80.0: 0.3}, 0.12
"""What the tests measure, by rigidity index."""


def measured(rigidity_index: float) -> xr.Dataset:
    """What a cone test with further runs leaves behind, as far as a sounding asks."""
    values = {
        "cone_factor_correction": CORRECTION[rigidity_index],
        "cone_factor_uncertainty": HALF_WIDTH,
        "run_time": 3.0,
        "particle_updates": 1e6,
    }
    stated = {name: variable(it, meaning=name) for name, it in values.items()}
    return xr.Dataset(stated | {"why_no_uncertainty": variable("", unit=None, meaning="why")})


def test_tests_are_in_clay_as_at_the_ends_and_beside_each_border() -> None:
    sounding = changed(
        uncertainty="measured", cells_per_radius=3.0, speed_ratio=0.05, profile=LAYERS, **SOFTENING
    )
    tests = sounding.tests_by_depth
    assert list(tests) == pytest.approx([12.0, 12.95, 13.05, 15.0])
    assert [it.rigidity_index for it in tests.values()] == pytest.approx([50.0, 50.0, 80.0, 80.0])
    speeds = [
        it.speed_ratio * np.sqrt(it.rigidity_index * it.undrained_shear_strength)
        for it in tests.values()
    ]
    assert speeds == pytest.approx(4 * [speeds[0]])
    for test in tests.values():
        assert test.uncertainty == "measured"
        assert test.domain_above == sounding.domain_above
        assert test.remoulded_strength_ratio == 0.5
        assert test.run_size().step_count > 0.0
    uniform = changed(uncertainty="measured", cells_per_radius=3.0, speed_ratio=0.05)
    assert list(uniform.tests_by_depth) == pytest.approx([15.0])


def test_between_the_depths_the_error_is_linear_and_less_certain() -> None:
    error = MeasuredError(
        depth=np.array([1.0, 2.0, 4.0]),
        correction=np.array([0.1, 0.3, 0.3]),
        half_width=np.array([0.2, 0.2, np.nan]),
    )
    correction, half_width = error.at(np.array([0.5, 1.5, 3.0]))
    np.testing.assert_allclose(correction, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(half_width, [0.2, np.hypot(0.2, 0.1), np.nan])


def test_a_sample_has_what_was_measured_and_its_own_noise() -> None:
    """Uniform strength, so no border counts."""
    sounding = Sounding(from_depth=1.0, to_depth=5.0, **SOFTENING)
    strength = sounding.undrained_shear_strength
    depth = np.linspace(1.0, 5.0, len(sounding.samples))
    error = error_of_samples(
        sounding,
        depth,
        np.full_like(depth, 10.0 * strength),
        measured=measured_by([5.0], [measured(50.0)]),
    )
    assert error.reason == ""
    np.testing.assert_array_equal(error.correction, CORRECTION[50.0])
    half_width = np.hypot(HALF_WIDTH, EFFECTS["sample"].half_width)
    np.testing.assert_allclose(error.half_width / strength, half_width)


def test_where_no_error_was_found_samples_are_marked() -> None:
    sounding = Sounding(from_depth=1.0, to_depth=3.0, **SOFTENING)
    depth = np.array([1.5, 2.5])
    tests: list[xr.Dataset | str] = [measured(50.0), measured(80.0), "further runs: it diverged"]
    error = error_of_samples(
        sounding, depth, np.full(2, 2e5), measured=measured_by([1.0, 2.0, 3.0], tests)
    )
    assert np.isnan(error.half_width).tolist() == [False, True]
    assert 0.1 < error.correction[1] < 0.4  # by the laws of Tresca
    assert error.reason == f"further runs: it diverged, from 2.5 to 2.5 m: {CARRIED_ON}"


@pytest.mark.slow
def test_a_sounding_runs_its_tests_and_takes_their_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []

    def compute(test: ConePenetration, *_: object) -> xr.Dataset:
        made.append(test)
        if len(made) == 4:
            raise UnfinishedRun("it ended early", curves=xr.Dataset())
        return measured(round(test.rigidity_index))

    monkeypatch.setattr(ConePenetration, "compute", compute)
    method = {"uncertainty": "measured", "cells_per_radius": 2.31, "speed_ratio": 0.03}
    sounding = changed(**method, profile=LAYERS, from_depth=12.7, **SOFTENING)
    fractions: list[float] = []
    result = sounding.run(fractions.append)
    assert len(made) == 4
    assert fractions == sorted(fractions)
    assert float(result.uncertainty_run_time) == 9.0
    half_width = result.net_resistance_uncertainty
    near = (result.depth > 13.0 - 10.0 * sounding.cone_radius) & (result.depth < 13.1)
    assert np.isfinite(half_width[(result.depth < 13.0) & ~near]).all()
    assert np.isnan(half_width[near | (result.depth > 13.1)]).all()
    assert str(result.why_no_uncertainty.values).startswith("further runs: it ended early, from ")
    assert "; border: the resistance feels another layer" in str(result.why_no_uncertainty.values)


def test_cells_too_wide_for_the_laws_are_refused() -> None:
    with pytest.raises(ParameterError, match="cells at the cone must be <= 0"):
        Sounding(uncertainty="measured", cells_per_radius=1.5)
