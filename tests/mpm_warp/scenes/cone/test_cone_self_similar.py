"""The load of a cone from first touch, which has one exponent."""

import math

import pytest

from mpm_warp.scenes.cone.cone_self_similar import ConeSelfSimilar

pytestmark = pytest.mark.slow


def test_load_of_a_cone_from_first_touch() -> None:
    """The depth is known to a cell at worst, of the cells that the cone is in on average."""
    cells = 10
    scene = ConeSelfSimilar(cells_per_radius=cells)
    mean_depth = 0.4 * cells * math.sqrt(3.0)
    assert float(scene.run().error) <= 2.0 / mean_depth
