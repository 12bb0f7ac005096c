"""Extreme cases, shortened, against their exact answers: whole in `harness verify --extreme`."""

from __future__ import annotations

import math

import pytest
from mpm_warp.scenes.elastic_column_wave import ElasticColumnWave


def test_energy_of_many_load_cycles() -> None:
    """Within a period energy swings by omega dt; its mean over one may lack a step of that."""
    cycles = 100
    result = ElasticColumnWave(cell_count=10, period_count=cycles).run()
    steps = float(result.step_count) / cycles
    assert float(result.energy_drift) <= 2.0 * math.pi / steps**2
    # The first and the last period are sampled, of the others some.
    assert float(result.phase[0]) == 0.0
    assert float(result.phase[-1]) == pytest.approx(cycles, rel=1e-3)
    assert len(result.phase) < 11 * steps
