"""What the top of the window takes off u2, held beside windows of two heights.

Each row of `studies/window_error_u2.csv` is a cone in a window by default, or quick, and in one
that is taller: extents above the shoulder over the radius, u2, and the half width of u2 in the
first; u2 and its half width are without what is told of the top.
"""

import math
from pathlib import Path

import numpy as np

from mpm_warp.uncertainty import pore_pressure as law
from tests.mpm_warp.uncertainty.test_pore_pressure import radial_error

MEASURED = Path(__file__).parents[3] / "studies" / "window_error_u2.csv"
PAIRS = np.loadtxt(MEASURED, delimiter=",", skiprows=1)


def of_top(above: float, **of_cone: float) -> tuple[float, float]:
    """What the top of a window takes off u2, and what of it is left open."""
    (known, left), (without, of_others) = (
        radial_error(5.0, above=it, **of_cone) for it in (above, math.inf)
    )
    return float(known - without), math.sqrt(left**2 - of_others**2)


def test_u2_is_the_same_in_windows_of_all_heights() -> None:
    """Within the half width in the window by default, and mostly within what is told of its top."""
    over = []
    for index, anisotropy, adhesion, rows, above, factor, half_width, taller, in_taller in PAIRS:
        of_cone = {"rigidity_index": index, "stress_anisotropy": anisotropy}
        of_cone |= {"adhesion_factor": adhesion, "cell_size": math.sqrt(3.0) / rows}
        (known, left), (known_taller, left_taller) = (
            of_top(it, **of_cone) for it in (above, taller)
        )
        difference = abs(factor + known - in_taller - known_taller)
        assert difference <= math.hypot(half_width, left)
        of_means = law.NOISE["shoulder"] * math.hypot(factor, in_taller)
        over.append(difference / math.hypot(left, left_taller, of_means))
    assert np.mean(np.array(over) <= 1.0) >= 0.9


def test_the_top_of_the_window_counts_by_its_height() -> None:
    at = {"cell_size": 0.2, "adhesion_factor": 0.5, "rigidity_index": 150.0}
    np.testing.assert_allclose(of_top(13.0, **at), 2.0 * np.array(of_top(26.0, **at)))
    assert of_top(13.0, **at)[0] > 0.0
