"""What the top of the window takes off u2 and Nc: windows of two heights, and two kinds of top.

Each row of `studies/window_error_u2.csv` is a cone in a window by default, or quick, and in one
that is taller: extents above the shoulder over the radius, u2, and the half width of u2 in the
first; u2 and its half width are without what is told of the top. Each of
`studies/top_error.csv` is one by default, and long with a top that holds the radial motion too
(`tests/held_top.py`): the radial pressure F - s over su in both, and the cone factor, less all that
is known but of the top. t is fitted to some of these.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from mpm_warp import ConePenetration
from mpm_warp.uncertainty import pore_pressure as law
from mpm_warp.uncertainty.cone import POINTS
from tests.mpm_warp.uncertainty.test_pore_pressure import radial_error

STUDIES = Path(__file__).parents[3] / "studies"
PAIRS = np.loadtxt(STUDIES / "window_error_u2.csv", delimiter=",", skiprows=1)
HELD = np.loadtxt(STUDIES / "top_error.csv", delimiter=",", skiprows=1)
HELD_LEFT = 0.03
"""What the cone factor below a held top differs by from that in a window three times as tall, at
Ir 100, Delta 0 and -0.7, and at 250 and -0.8."""


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


def test_u2_is_that_below_a_top_that_holds_the_radial_motion() -> None:
    """With 95 %, also in the cases that t is not fitted to, and without bias."""
    is_within, is_fitted, differences = [], [], []
    for index, adhesion, anisotropy, above, size, factor, held, _, _, fitted in HELD:
        of_cone = {"rigidity_index": index, "stress_anisotropy": anisotropy}
        known, left = of_top(above, **of_cone, adhesion_factor=adhesion, cell_size=size)
        of_mean = law.NOISE["shoulder"] * factor
        differences.append(held - factor - known)
        is_within.append(abs(differences[-1]) <= math.hypot(left, of_mean))
        is_fitted.append(bool(fitted))
    within, of_fit = np.array(is_within), np.array(is_fitted)
    assert (~of_fit).sum() >= 24
    assert within[of_fit].mean() >= 0.95
    assert within[~of_fit].mean() >= 0.95
    assert abs(np.mean(differences)) <= 3.0 * np.std(differences) / math.sqrt(len(differences))


def test_where_the_horizontal_stress_is_larger_the_top_takes_off_more() -> None:
    """By the cube of sqrt(Ir) / A, and more of it is left open."""
    at = {"cell_size": 0.35, "adhesion_factor": 0.0, "rigidity_index": 100.0}
    more = []
    for above in (13.0, 26.0):
        (known, left), (known_below, left_below) = (
            of_top(above, stress_anisotropy=anisotropy, **at) for anisotropy in (0.4, -0.4)
        )
        assert left_below > left
        more.append(known_below - known)
    assert more[0] == pytest.approx(8.0 * more[1])
    assert more[1] > 0.0


def test_the_cone_factor_is_that_below_a_top_that_holds_the_radial_motion() -> None:
    """Within what is stated of window and noise, with 95 %; below Delta 0 it would be too low."""
    is_within, differences = [], []
    for index, adhesion, anisotropy, *_, factor, held, _ in HELD:
        test = ConePenetration(
            rigidity_index=index, adhesion_factor=adhesion, stress_anisotropy=anisotropy
        )
        laws = test.laws(way=0.0)
        left = laws.half_widths()
        parts = [float(left[part]) for part in ("domain", "top", "noise", "range")]
        differences.append(held - factor - float(laws.top_of_horizontal))
        is_within.append(abs(differences[-1]) <= math.hypot(*parts, POINTS * factor, HELD_LEFT))
    assert np.mean(is_within) >= 0.95
    below = np.array(differences)[HELD[:, 2] < 0.0]
    assert abs(np.mean(below)) <= 0.03
