"""Bar and column that strike a wall against the exact shock, and the shock relations."""

import math

import pytest

from mpm_warp.scenes.elastic.impact import TRAVEL, Impact, Shock, StruckBar, StruckColumn

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("struck", [StruckBar, StruckColumn])
@pytest.mark.parametrize("speed_ratio", [0.1, 0.5, 0.9])
def test_shock(struck: type[Impact], speed_ratio: float) -> None:
    """It is as sharp as a cell, over the half of its way in which its speed is taken."""
    cells = 40
    result = struck(speed_ratio=speed_ratio, cell_count=cells).run()
    assert float(result.error) <= 1.0 / (0.5 * TRAVEL * cells)


def test_shock_relations_hold_and_become_those_of_waves() -> None:
    fast, slow = (Shock(modulus=8.0, density=2.0, speed=ratio * 2.0) for ratio in (0.5, 1e-3))
    stretch = 1.0 - fast.speed / fast.front_speed
    assert -8.0 * math.log(stretch) == pytest.approx(2.0 * fast.front_speed * fast.speed)
    assert fast.stress == pytest.approx(8.0 * math.log(stretch))
    assert slow.front_speed == pytest.approx(2.0, rel=1e-3)
    assert slow.stress == pytest.approx(-2.0 * 2.0 * slow.speed, rel=1e-3)
