"""Runs of fewer steps than their curves have samples."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpm_warp.scenes.cavity_cylinder import CavityCylinder
from mpm_warp.scenes.circular_footing import CircularFooting


@pytest.mark.parametrize("displacement", [1e-3, 0.1])
def test_a_footing_pressed_by_a_few_steps_has_a_sample_a_step_and_no_plateau(
    displacement: float,
) -> None:
    result = CircularFooting(cells_per_radius=4, displacement=displacement).run()
    assert result.sizes["displacement"] == int(result.step_count)
    assert np.isfinite(result.resistance).all()
    assert math.isnan(float(result.bearing_capacity))


def test_a_cavity_expanded_by_a_few_steps_has_a_sample_a_step() -> None:
    result = CavityCylinder(
        expansion=1.1, cells_per_radius=1, rigidity_index=10, poissons_ratio=0.4, speed_ratio=0.3
    ).run()
    assert result.sizes["expansion"] == int(result.step_count)
    assert np.isfinite(result.cavity_pressure).all()
