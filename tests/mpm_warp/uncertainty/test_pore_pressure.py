"""The laws of the error of u1 and u2, held beside readings of the same case on several meshes."""

import math

import numpy as np
import pytest
import xarray as xr

from mpm_warp.uncertainty.laws import BOUND_ERROR
from mpm_warp.uncertainty.pore_pressure import (
    BOUND,
    NOISE,
    SETTLING,
    face_error,
    share_of_wedge,
    shoulder_error,
    stated_pressures,
    stated_sleeve,
)

Series = dict[int, float]
"""As simulated over su, by the rows of cells beside the face."""
U2: dict[str, tuple[float, float, Series]] = {
    "smooth": (100, 0.0, {4: 5.58, 5: 5.73, 7: 5.82, 10: 5.87}),
    "smooth, small window": (100, 0.0, {5: 5.66, 10: 5.85, 20: 5.73}),
    "half rough": (100, 0.5, {5: 4.42, 10: 3.96, 14: 3.93}),
    "rough": (100, 1.0, {3: 4.33, 5: 4.34, 7: 4.20, 10: 4.12}),
    "rough, small window": (100, 1.0, {5: 4.10, 10: 3.98, 14: 3.92}),
    "between, coarse": (100, 0.75, {4: 4.69, 5: 4.21, 7: 4.13, 10: 4.08}),
    "soft": (50, 0.0, {5: 4.63, 7: 4.82, 10: 4.91}),
    "softer": (30, 0.0, {4: 3.46, 5: 3.73, 7: 3.98, 10: 4.08, 14: 4.05}),
    "softer, half rough": (30, 0.5, {4: 3.34, 5: 3.34, 7: 3.34, 10: 3.36, 14: 3.40}),
    "softer, rough": (30, 1.0, {4: 3.27, 5: 3.30, 7: 3.37, 10: 3.44, 14: 3.51}),
    "stiff, half rough": (300, 0.5, {5: 6.35, 7: 6.19, 10: 6.19, 14: 6.05}),
    "stiff, rough": (300, 1.0, {4: 5.47, 5: 5.15, 7: 5.07, 10: 5.03, 14: 4.96}),
    "stiff": (500, 0.0, {5: 8.19, 7: 8.17, 10: 8.12}),
    "stiffest, rough": (956, 0.92, {5: 8.48, 10: 7.75}),
}
"""Rigidity index, adhesion factor and readings."""
U1: dict[str, tuple[float, float, Series]] = {
    "smooth": (100, 0.0, {3: 9.04, 4: 8.83, 5: 8.94, 7: 9.04, 10: 9.07}),
    "smooth, small window": (100, 0.0, {5: 8.89, 10: 9.03, 20: 9.18}),
    "half rough": (100, 0.5, {5: 9.10, 10: 9.09, 14: 9.11}),
    "rough": (100, 1.0, {3: 9.38, 5: 9.58, 7: 9.58, 10: 9.67}),
    "soft": (50, 0.0, {5: 7.25, 10: 7.50}),
    "softest, half rough": (20, 0.5, {3: 5.15, 5: 5.29, 7: 5.17, 10: 5.21, 20: 5.19, 28: 5.18}),
    "soft, half rough": (50, 0.5, {3: 7.30, 5: 7.48, 7: 7.33, 10: 7.43, 20: 7.42, 28: 7.43}),
    "stiff, half rough": (300, 0.5, {5: 11.40, 10: 11.28}),
    "stiff, rough": (300, 1.0, {3: 11.53, 5: 11.85, 7: 11.73, 10: 11.86, 14: 11.91, 20: 11.96}),
    "stiff": (500, 0.0, {5: 12.55, 7: 12.24, 10: 12.41}),
    "stiffest, rough": (1000, 1.0, {3: 14.05, 5: 14.49, 7: 14.31, 10: 14.42}),
}
LAST_CHANGE = """-0.6 0.0 -0.2 -2.5 -1.3 -6.6 -2.8 -6.9 -1.8 1.3 -3.3 2.4 3.2 -13.5 -0.4 -0.3 9.0
-2.5 -0.7 0.3 0.3 -0.4 -1.8 -4.0 -3.7 0.2 -3.8 -5.2 -2.0 -0.2 -1.5 -2.4 -1.7"""
STILL_CAME = """0.2 0.9 -0.2 -0.6 -0.2 -1.0 -1.2 1.3 0.2 -0.3 0.0 -0.1 -0.6 -0.5 -0.4 1.1 1.6
0.5 -0.3 -0.0 0.1 0.1 -0.7 -2.4 -0.4 0.7 -0.7 0.3 1.3 0.7 -0.4 0.3 0.9"""
"""Change of the mean of u2 at the end of a run, and what its mean 8 to 16 radii beyond differs by,
in percent of u2: Ir 28 to 800, all adhesion factors, 3 to 7 rows, speeds 0.02 to 0.06."""


def check(error: object, series: tuple[float, float, Series]) -> None:
    """Each mesh has the corrected value of the finest within its half width and that of this."""
    index, adhesion, readings = series
    stated = []
    for rows, reading in readings.items():
        correction, half_width = error(  # type: ignore[operator]
            reading, cell_size=math.sqrt(3.0) / rows, adhesion_factor=adhesion, rigidity_index=index
        )
        stated.append((reading + float(correction), float(half_width)))
    best, of_best = stated[-1]
    for value, half_width in stated:
        assert abs(value - best) <= math.hypot(half_width, of_best)


@pytest.mark.parametrize("case", U2)
def test_u2_of_all_meshes_is_one_value(case: str) -> None:
    check(shoulder_error, U2[case])


@pytest.mark.parametrize("case", U1)
def test_u1_of_all_meshes_is_one_value(case: str) -> None:
    check(face_error, U1[case])


def test_half_width_by_default_and_fine() -> None:
    """Of a smooth cone 4 % and 2 %; of one whose wedge is thinner than a cell, a fifth."""
    for rows, share in ((5, 0.04), (10, 0.02)):
        _, half_width = shoulder_error(
            5.8, cell_size=math.sqrt(3.0) / rows, adhesion_factor=0.0, rigidity_index=100.0
        )
        assert half_width <= share * 5.8
    _, half_width = shoulder_error(
        4.8, cell_size=math.sqrt(3.0) / 5, adhesion_factor=0.25, rigidity_index=100.0
    )
    assert 0.2 * 4.8 <= half_width <= 0.25 * 4.8


def test_beyond_the_range_the_half_width_grows_without_a_jump() -> None:
    for error, edges in ((face_error, (20.0, 1000.0)), (shoulder_error, (50.0, 500.0))):
        indices = np.array([0.25, 0.5, 1.0, 1.0, 2.0, 4.0]) * np.repeat(edges, 3)
        _, half_width = error(6.0, cell_size=0.35, adhesion_factor=0.0, rigidity_index=indices)
        assert half_width[0] > half_width[1] > half_width[2]
        assert half_width[3] < half_width[4] < half_width[5]
        assert half_width[2] == pytest.approx(half_width[3])


def test_share_of_the_wedge() -> None:
    np.testing.assert_array_equal(share_of_wedge(np.array([0.0, 0.25, 0.5, 1.0])), [0, 0.5, 1, 1])


@pytest.mark.parametrize("is_known", [True, False])
def test_stated_pressures(is_known: bool) -> None:
    """What is still to come is half of the last change; without a law nothing is corrected.

    What a bound of Poisson's ratio takes off is that of the cone factor.
    """
    curve = ("penetration", np.append(np.full(20, 5.2e4), np.full(20, 5.0e4)))
    places = ("face", "shoulder")
    recorded = xr.Dataset(
        {f"excess_pore_pressure_{it}": curve for it in places}
        | {f"pore_pressure_factor_{it}": 5.0 for it in places}
    )
    stated = stated_pressures(
        recorded,
        strength=1e4,
        cell_size=0.2,
        adhesion_factor=1.0,
        rigidity_index=100.0,
        bounded=0.02,
        is_known=is_known,
    )
    for place, error in zip(places, (face_error, shoulder_error), strict=True):
        off, of_laws = error(5.0, cell_size=0.2, adhesion_factor=1.0, rigidity_index=100.0)
        off += 0.02 * BOUND_ERROR
        name = f"pore_pressure_factor_{place}"
        value, correction, half_width = (
            float(stated[it].values) for it in (name, f"{name}_correction", f"{name}_uncertainty")
        )
        assert value == pytest.approx(5.0 + (off if is_known else 0.0))
        assert correction == pytest.approx(off if is_known else 0.0)
        of_mean = math.hypot(0.5 * 0.2, 5.0 * NOISE[place])
        expected = math.hypot(of_laws, of_mean, 0.02 * BOUND[place]) if is_known else math.nan
        assert half_width == pytest.approx(expected, nan_ok=True)


def test_what_still_comes_of_u2_is_within_its_half_width() -> None:
    """With 95 %, in runs that were not used to set it."""
    change, came = (np.array(them.split(), dtype=float) for them in (LAST_CHANGE, STILL_CAME))
    within = np.abs(came) <= np.hypot(SETTLING * change, 100.0 * NOISE["shoulder"])
    assert within.mean() >= 0.95


def test_the_sleeve_friction_may_be_as_low_as_beside_remoulded_clay() -> None:
    recorded = xr.Dataset({"sleeve_friction_factor": 0.3})
    stated = stated_sleeve(recorded, remoulded=0.2 * 0.5)
    assert float(stated["sleeve_friction_factor_uncertainty"].values) == pytest.approx(0.2)
