"""Elastic soil at rest and waves along a column, against exact solutions and a modal analysis."""

import cmath
import math
from typing import Any

import pytest

from mpm_warp import ElasticColumnWave, GravityColumn, ThickCylinder
from mpm_warp.scenes.elastic.column_wave import PERIOD
from mpm_warp.scenes.elastic.wave_decay import wave_factor
from tests.mpm_warp.scenes.conftest import order_and_errors

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("settlement_ratio", [1e-4, 1e-5])
def test_gravity_column_is_exact_for_small_strain(settlement_ratio: float) -> None:
    # Linear cells give the stress of their middle exactly; what is left is the strain at the base.
    result = GravityColumn(cell_count=8, settlement_ratio=settlement_ratio).run()
    assert float(result.error) <= 2 * settlement_ratio


@pytest.mark.parametrize(
    ("cells", "changed"),
    [
        (10, {"poissons_ratio": 0.0}),
        (10, {"poissons_ratio": 0.3}),
        (10, {"poissons_ratio": 0.49}),
        (5, {"section": "plane_strain"}),
    ],
)
def test_thick_cylinder_is_of_second_order(cells: int, changed: dict[str, Any]) -> None:
    order, error, _ = order_and_errors(ThickCylinder, "cell_count", cells, **changed)
    assert order == pytest.approx(2, abs=0.1)
    assert error <= (2 / cells) ** 2  # (h/a)^2


def test_sudden_load_arrives_with_the_wave() -> None:
    cells = 50
    # A front is as sharp as a cell, which it passes twice on its way up and down.
    result = ElasticColumnWave(excitation="sudden_load", cell_count=cells).run()
    assert float(result.error) <= 1 / cells


@pytest.mark.parametrize("cells", [10, 20])
def test_standing_wave_has_the_frequency_that_is_derived(cells: int) -> None:
    """What it lags behind after a period, at most, is 2 pi times what its frequency is low by."""
    scene = ElasticColumnWave(cell_count=cells, period_count=2)
    result = scene.run()
    frequency, time_step = 2 * math.pi / PERIOD, float(result.time_step)
    turned = cmath.phase(wave_factor(scene.build(), frequency, time_step))
    low = 1 - turned / (frequency * time_step)
    assert 0 < low < (math.pi / (2 * cells)) ** 2  # of second order in k h
    assert float(result.error) <= 2 * math.pi * low


def test_standing_wave_is_of_second_order() -> None:
    order, *_ = order_and_errors(ElasticColumnWave, "cell_count", 20)
    assert order == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(("cells", "cycles"), [(10, 10), (10, 100), (20, 10)])
def test_energy_of_a_standing_wave_decays_as_is_derived(cells: int, cycles: int) -> None:
    """Within a period energy swings by omega dt; its mean over one may lack a step of that.

    Of many cycles the first and the last are sampled, and some of the others.
    """
    result = ElasticColumnWave(cell_count=cells, period_count=cycles).run()
    steps = float(result.step_count) / cycles
    assert float(result.energy_departure) <= 2 * math.pi / steps**2
    # The least that nine or ninety-nine periods take is far more than that.
    assert float(result.energy_drift) > 0.9 * (1 - (1 - float(result.energy_decay)) ** (cycles - 1))
    assert (result.energy <= result.energy[: round(steps)].max()).all()
    assert float(result.phase[0]) == 0.0
    assert float(result.phase[-1]) == pytest.approx(cycles, rel=1e-3)
    assert len(result.phase) < 11 * steps
