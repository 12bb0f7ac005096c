"""The laws of the error of u1 and u2, held beside readings of the same case on several meshes."""

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty import pore_pressure as law
from mpm_warp.uncertainty.pore_pressure import deviator_near_shaft, face_error, shoulder_error

Series = dict[int, float]
"""As simulated over su, by the rows of cells beside the face."""
ErrorLaw = Callable[..., tuple[law.Value, law.Value]]
"""Gives the correction of a value, and its half width."""
MEASURED = Path(__file__).parents[3] / "studies" / "mesh_error_u2.csv"
FEWEST_ROWS = 5
"""The fewest that the law is fitted to."""


def measured_u2(quantity: str) -> dict[tuple[float, float], Series]:
    """A quantity on several meshes, by the rigidity index and the adhesion factor."""
    series: dict[tuple[float, float], Series] = {}
    with MEASURED.open() as file:
        for row in csv.DictReader(file):
            case = float(row["rigidity_index"]), float(row["adhesion_factor"])
            series.setdefault(case, {})[int(row["rows_on_face"])] = float(row[quantity])
    return series


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
LAST_CHANGE = """
-6.1 0.0 0.6 -1.5 -0.4 -7.2 -6.8 -0.1 -0.2 1.1 0.1 -1.1 0.6 -6.9 0.4 -5.3 0.3 -0.8 -1.3 -5.8 -0.4
-2.8 -0.7 -5.6 -1.9 -1.3 -6.5 -1.3 0.4 -3.4 0.3 -0.0 -2.5 -1.1 -0.0 0.8 0.5 0.3 -6.4 -0.4 -0.9
-1.0 -0.9 -6.3 -7.1 0.2 0.1 -3.3 1.0 -0.3 -5.6 -4.9 -6.6 -0.6 -2.9 0.3"""
STILL_CAME = """
-0.9 0.4 -0.2 -0.2 0.2 0.1 -1.1 -0.5 0.3 -0.6 -0.2 0.8 -0.2 1.0 0.1 0.8 -1.3 1.0 -0.7 -0.5 0.0 0.7
-0.3 0.8 -0.7 -0.2 1.3 -0.0 0.2 -0.3 -0.3 -0.1 0.6 0.5 -0.3 -0.4 -0.4 -0.0 0.6 0.0 -0.5 0.1 -0.2
0.7 0.7 0.8 0.7 -0.2 -0.6 0.2 -0.5 -0.4 -0.7 -0.3 -1.0 -0.2"""
"""Change of the mean of F - s at the end of a run, and what its mean 8 to 16 radii beyond differs
by [%].

Of 56 random clays, five rows and more: by default, Ir 20 to 400 and Delta -0.5 to 0.5, and at 0.7
to 2 times the speed, Ir 25 to 800.
"""


def over_half_width(
    error: ErrorLaw, index: float, adhesion: float, readings: Series
) -> list[float]:
    """Differences of corrected values from that of the finest mesh, over both half widths."""
    stated = []
    for rows, reading in readings.items():
        correction, half_width = error(
            reading,
            cell_size=math.sqrt(3.0) / rows,
            adhesion_factor=adhesion,
            rigidity_index=index,
            inertia=0.0,
        )
        stated.append((reading + float(correction), float(half_width)))
    best, of_best = stated.pop()
    return [abs(value - best) / math.hypot(half_width, of_best) for value, half_width in stated]


def radial_error(
    factor: law.Value, *, inertia: law.Value = 0.0, **of_cone: Any
) -> tuple[law.Value, law.Value]:
    """Correction of a radial stress, which makes it u2; of a slow cone, where nothing is said."""
    return shoulder_error(factor, 0.0, inertia=inertia, **of_cone)


def test_u2_of_all_meshes_is_one_value(monkeypatch: pytest.MonkeyPatch) -> None:
    """With 95 %: also of coarser meshes than the law is fitted to, and of clays between.

    What all meshes have in common does not count.
    """
    for common in ("NEAR_SHAFT", "LAYER_LEFT", "POWER_LEFT", "SHOULDER_WINDOW_LEFT"):
        monkeypatch.setattr(law, common, 0.0)
    over = [
        difference
        for (index, adhesion), readings in measured_u2("radial_stress_factor").items()
        for difference in over_half_width(radial_error, index, adhesion, readings)
    ]
    assert len(over) >= 160
    assert np.mean(np.array(over) <= 1.0) >= 0.95


class Fit(NamedTuple):
    """S and the limits of F - s, by least squares of all meshes over their half widths."""

    slopes: Floats
    limits: Floats
    slopes_of_clays: Floats
    left: Floats
    """Deviations of the meshes over their standard deviations."""


def fitted_to_all_clays(power: float) -> Fit:
    """With h to a power; half widths are those that the reading in cells has."""
    measured = measured_u2("radial_stress_factor")
    units = np.eye(np.size(law.SHOULDER_ERROR)).reshape(-1, *np.shape(law.SHOULDER_ERROR))
    at = law.SHOULDER_INDICES, law.SHOULDER_ADHESION
    of_clays = np.array([[law._of_table(unit, *at, *case) for unit in units] for case in measured])
    design, given = [], []
    for clay, ((index, _), readings) in enumerate(measured.items()):
        for rows, reading in readings.items():
            size = math.sqrt(3.0) / rows
            read = float(law._by_index(law.READ_IN_CELLS, index)) * size
            deviation = 0.5 * reading * math.hypot(read, law.SHOULDER_LEFT)
            if rows >= FEWEST_ROWS:
                row = np.concatenate([np.eye(len(measured))[clay], of_clays[clay] * size**power])
                design.append(row / deviation)
                given.append(reading / deviation)
    found = np.linalg.lstsq(np.array(design), np.array(given))[0]
    limits, slopes = np.split(found, [len(measured)])
    left = np.array(given) - np.array(design) @ found
    return Fit(slopes.reshape(np.shape(law.SHOULDER_ERROR)), limits, of_clays @ slopes, left)


def test_the_law_of_u2_is_that_of_the_meshes_measured() -> None:
    """The code has one decimal; meshes deviate from it as far as the half widths tell."""
    fit = fitted_to_all_clays(law.SHOULDER_POWER)
    np.testing.assert_allclose(law.SHOULDER_ERROR, fit.slopes, atol=0.06)
    freedom = fit.left.size - fit.limits.size - fit.slopes.size
    assert sum(fit.left**2) / freedom == pytest.approx(1.0, abs=2.0 * (2.0 / freedom) ** 0.5)


def test_the_limit_of_u2_is_known_as_far_as_the_power_of_its_law_is() -> None:
    """Of all powers that the meshes do not exclude, with 95 %."""
    fits = {power: fitted_to_all_clays(power) for power in np.arange(0.5, 3.0, 0.125)}
    own = fits[law.SHOULDER_POWER]
    not_excluded = {
        power: fit for power, fit in fits.items() if sum(fit.left**2) < sum(own.left**2) + 1.96**2
    }
    assert min(not_excluded) < law.SHOULDER_POWER < max(not_excluded)
    half_width = np.hypot(law.POWER_LEFT * own.slopes_of_clays, law.SHOULDER_LEFT * own.limits)
    for fit in not_excluded.values():
        assert np.mean(np.abs(fit.limits - own.limits) <= half_width) >= 0.95


NEAR_SHAFT_ON_FINE_ROWS: dict[tuple[float, float], Series] = {
    (20, 0.0): {40: -1.18, 56: -1.18, 80: -1.13},
    (20, 1.0): {40: -0.60, 56: -0.58},
    (50, 0.25): {56: -1.15},
    (100, 0.0): {40: -0.90, 56: -0.79, 80: -0.70, 112: -0.72},
    (100, 0.25): {56: -1.02, 80: -0.93, 112: -0.95},
    (100, 0.5): {80: -0.99, 112: -1.02},
    (100, 1.0): {40: -0.58, 56: -0.54},
    (200, 0.25): {56: -0.48},
    (300, 0.25): {40: -0.10},
    (300, 0.5): {40: -0.54, 80: -0.39},
    (300, 0.0): {80: 0.36},
    (300, 1.0): {40: -0.48, 80: -0.45},
    (600, 1.0): {28: -0.45},
}
"""Mean deviator within 0.06 radii of the shaft at the height of the filter, over su: 28, 80 and 112
rows, and those of Ir 50 and 200, by `tests/shaft_layer.py`, others by cells of one shape (40 and 56
rows, on a GPU)."""


@pytest.mark.parametrize("case", NEAR_SHAFT_ON_FINE_ROWS)
def test_the_layer_beside_the_shaft_is_that_of_the_finest_rows(case: tuple[float, float]) -> None:
    """Less what rows are told to make it thicker, by 0.5 radii over their number."""
    index, adhesion = case
    at = {"rigidity_index": index, "adhesion_factor": adhesion}
    share, in_layer, beside = map(float, law._layer(**at))
    assert deviator_near_shaft(**at) == pytest.approx(share * in_layer + (1 - share) * beside)
    left = math.hypot(law.NEAR_SHAFT, law.LAYER_LEFT * (beside - in_layer))
    for rows, deviator in NEAR_SHAFT_ON_FINE_ROWS[case].items():
        on_rows = min(1.0, share + 0.5 / rows / 0.06)
        assert on_rows * in_layer + (1.0 - on_rows) * beside == pytest.approx(deviator, abs=left)


def test_without_a_layer_the_first_column_is_as_the_soil_beside_it() -> None:
    """Beside smooth shafts in stiff clay."""
    measured = measured_u2("radial_deviator_factor")
    for index in (300.0, 600.0):
        finest = measured[index, 0.0][max(measured[index, 0.0])]
        expected = np.interp(math.log(index), np.log(law.BESIDE_LAYER[0]), law.BESIDE_LAYER[1])
        assert finest == pytest.approx(expected, abs=law.NEAR_SHAFT)


def test_u2_depends_on_no_deviator_but_that_near_the_shaft() -> None:
    """Of the same radial stress u2 is the same, whatever deviator the cells have."""
    at = {"cell_size": 0.35, "adhesion_factor": 0.25, "rigidity_index": 100.0}
    values = []
    for deviator in (-1.2, 0.1):
        pressure = 5.6 + deviator
        correction, half_width = shoulder_error(pressure, deviator, **at, inertia=0.0)
        values.append((pressure + float(correction), float(half_width)))
    assert values[0] == pytest.approx(values[1])


@pytest.mark.parametrize("case", U1)
def test_u1_of_all_meshes_is_one_value(case: str) -> None:
    assert max(over_half_width(face_error, *U1[case])) <= 1.0


def test_the_deviator_near_the_shaft_goes_with_the_strength_there() -> None:
    at = {"cell_size": 0.35, "adhesion_factor": 0.5, "rigidity_index": 100.0}
    (whole, _), (half, _) = (
        shoulder_error(4.2, -1.2, **at, inertia=0.0, strength_ratio=ratio) for ratio in (1.0, 0.5)
    )
    assert half - whole == pytest.approx(-0.5 * deviator_near_shaft(100.0, 0.5))


def test_how_thick_the_layer_is_leaves_u2_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is no layer, as at Ir 300 beside a smooth shaft, nothing is open."""
    left, half_widths = law.LAYER_LEFT, []
    for share in (left, 0.0):
        monkeypatch.setattr(law, "LAYER_LEFT", share)
        errors = (
            radial_error(5.4, cell_size=0.06, adhesion_factor=0.0, rigidity_index=index)
            for index in (100.0, 300.0)
        )
        half_widths.append([float(half_width) for _, half_width in errors])
    (of_layer, without_layer), (of_rest, the_same) = half_widths
    assert without_layer == the_same
    beside, in_layer = law.BESIDE_LAYER[1][1], law.IN_LAYER[1][0]
    assert of_layer == pytest.approx(math.hypot(of_rest, left * (beside - in_layer)))


@pytest.mark.parametrize(
    ("adhesion_factor", "shares"),
    [(0.0, (0.05, 0.04)), (0.5, (0.065, 0.05)), (1.0, (0.06, 0.045))],
)
def test_half_width_by_default_and_fine(
    adhesion_factor: float, shares: tuple[float, float]
) -> None:
    """Of u2 at Ir 100, without what is still to come."""
    readings = measured_u2("radial_stress_factor")[100.0, adhesion_factor]
    for rows, inertia, share in zip((5, 10), (0.09, 0.2), shares, strict=True):
        off, half_width = radial_error(
            readings[rows],
            cell_size=math.sqrt(3.0) / rows,
            adhesion_factor=adhesion_factor,
            rigidity_index=100.0,
            inertia=inertia,
        )
        assert half_width <= share * (readings[rows] + off)


def test_the_error_of_wide_cells_does_not_grow_and_its_half_width_does() -> None:
    (at_widest, of_widest), (beyond, of_beyond) = (
        radial_error(5.3, cell_size=size, adhesion_factor=0.25, rigidity_index=100.0)
        for size in (law.WIDEST, 0.58)
    )
    assert beyond == at_widest
    assert of_beyond > of_widest


def test_beyond_the_range_the_half_width_grows_without_a_jump() -> None:
    for error in (face_error, radial_error):
        indices = np.outer([20.0, 1000.0], [0.25, 0.5, 1.0 - 1e-9, 1.0 + 1e-9, 2.0, 4.0])
        of_cone = {"cell_size": 0.35, "adhesion_factor": 0.0, "inertia": 0.0}
        _, (below, above) = error(6.0, rigidity_index=indices, **of_cone)
        assert below[0] > below[1] > below[2]
        assert above[3] < above[4] < above[5]
        for half_width in (below, above):
            assert half_width[2] == pytest.approx(half_width[3])


INERTIA_OF_U1 = (
    (22.0, (6.081, 6.059, 6.075, 6.150, 6.258)),
    (100.0, (9.214, 9.337, 9.417, 9.675, 10.156)),
    (140.0, (9.925, 10.067, 10.181, 10.424, 10.931)),
    (500.0, (12.559, 12.600, 12.603, 12.762, 12.938)),
    (900.0, (13.760, 13.757, 13.836, 13.959, 14.210)),
)
"""u1 at i = 0.1, 0.3, 0.6, 1.2, 2.4 by default, but for the speed; adhesion factor 0.8, 0.4, 0.35,
0.5, 0.35."""
INERTIA_OF_U2: dict[tuple[float, int], tuple[dict[float, float], ...]] = {
    (22.0, 6): ({0.1: 3.321, 0.3: 3.204, 0.6: 3.062, 1.2: 2.635, 2.4: 2.083},),
    (50.0, 6): ({0.04: 5.285, 0.2: 5.235, 0.4: 5.174}, {0.04: 4.941, 0.2: 4.933}),
    (100.0, 5): (
        {0.04: 6.098, 0.2: 6.080, 0.4: 6.002},
        {0.04: 5.535, 0.2: 5.630, 0.4: 5.613},
    ),
    (200.0, 5): (
        {0.05: 6.358, 0.2: 6.296, 0.4: 6.374},
        {0.05: 6.471, 0.2: 6.398, 0.4: 6.338},
    ),
    (300.0, 5): ({0.05: 6.578, 0.3: 6.508},),
    (500.0, 6): ({0.1: 7.400, 0.45: 7.359}, {0.1: 6.854, 0.45: 6.840}),
    (500.0, 4): ({0.1: 7.264, 0.45: 7.467}, {0.1: 7.178, 0.45: 6.671}),
    (900.0, 4): ({0.2: 9.22, 0.81: 8.72}, {0.2: 7.96, 0.81: 8.19}),
}
"""F - s over i, by rigidity index and rows beside the face: means over 8 to 14 radii, adhesion
factor 0.3 and 0.8 (0.5 at 300); u2 by default at 22, adhesion factor 0.8."""


def test_what_inertia_changes_of_u1_is_within_the_half_width() -> None:
    """Of both runs, at any speed against the slowest."""
    inertias = np.array([0.1, 0.3, 0.6, 1.2, 2.4])
    for index, factors in INERTIA_OF_U1:
        of_cone = {"cell_size": 0.33, "adhesion_factor": 0.5, "rigidity_index": index}
        _, half_width = face_error(np.array(factors), inertia=inertias, **of_cone)
        change = np.abs(np.array(factors) - factors[0])
        assert (change <= np.hypot(half_width, half_width[0])).all()


def test_what_inertia_changes_of_u2_is_within_its_part_of_the_half_width() -> None:
    """At any speed against the slowest, but for 0.6 % of both means."""
    for (index, rows), series in INERTIA_OF_U2.items():
        at = {
            "cell_size": math.sqrt(3.0) / rows,
            "adhesion_factor": 0.5,
            "rigidity_index": index,
        }
        for readings in series:
            slowest = readings[min(readings)]
            _, at_rest = radial_error(slowest, **at)
            for inertia, reading in readings.items():
                _, half_width = radial_error(slowest, inertia=inertia, **at)
                by_inertia = math.sqrt(half_width**2 - at_rest**2)
                assert abs(reading - slowest) <= math.hypot(by_inertia, 0.006 * slowest)


IN_SMALL_WINDOWS = (
    (100.0, 0.5, 40.0, (9.209, 4.085), {6.0: (8.708, 3.346), 10.0: (9.082, 3.903)}),
    (100.0, 0.0, 40.0, (9.289, 4.885), {6.0: (8.813, 4.194), 10.0: (9.170, 4.545)}),
    (400.0, 0.3, 80.0, (12.16, 6.894), {6.0: (15.22, 11.13), 10.0: (11.69, 5.608)}),
)
"""u1 and u2 with the default radius of the window, and with others, by default otherwise."""


def test_a_small_window_is_a_part_of_the_half_widths_of_u1_and_u2() -> None:
    """And a window that is larger than by default is none."""
    for index, adhesion, default, of_default, others in IN_SMALL_WINDOWS:
        of_cone = {
            "cell_size": 0.35,
            "adhesion_factor": adhesion,
            "rigidity_index": index,
            "inertia": 0.09,
        }
        for radius, factors in others.items():
            for error, factor, other in zip(
                (face_error, radial_error), of_default, factors, strict=True
            ):
                _, half_width = error(other, extent_ratio=default / radius, **of_cone)
                assert abs(other - factor) <= half_width
                assert error(other, extent_ratio=0.5, **of_cone) == error(other, **of_cone)


TALLER = {
    50.0: (0.042, 0.031, 0.042, 0.057),
    100.0: (0.075, 0.048, 0.058, 0.006),
    200.0: (0.057, 0.022, 0.051, 0.030),
    400.0: (0.001, 0.047, 0.029, 0.019),
}
"""What F - s gains in a window twice as tall, by rigidity index, on 5 rows, means over 10 radii;
adhesion factor 0.3, 0.8, and 0.5 with Delta -0.4 and 0.4."""


def test_what_a_taller_window_adds_to_u2_is_corrected() -> None:
    """A window without a top gains a third more, if what lacks goes with 1 / extent squared."""
    gained = np.array(list(TALLER.values()))
    for whole in (gained, 4.0 / 3.0 * gained):
        assert (np.abs(whole - law.SHOULDER_WINDOW) <= law.SHOULDER_WINDOW_LEFT).mean() >= 0.95
    at = {"cell_size": 1e-9, "adhesion_factor": 0.0, "inertia": 0.0}
    for index, felt in ((100.0, 1.0), (25.0, 0.5)):
        correction, _ = radial_error(6.0, rigidity_index=index, **at)
        added = float(correction) - deviator_near_shaft(index, 0.0)
        assert added == pytest.approx(felt * law.SHOULDER_WINDOW)


@pytest.mark.parametrize(("place", "stiffest"), [("shoulder", 300.0), ("face", 500.0)])
def test_in_very_stiff_clay_three_rows_tell_nothing(place: str, stiffest: float) -> None:
    for index, rows, word in ((0.9, 3, ""), (1.1, 3, "mesh"), (1.1, 4, "")):
        stated = stated_of(
            why_none="", rigidity_index=index * stiffest, cell_size=math.sqrt(3.0) / rows
        )
        name = f"pore_pressure_factor_{place}"
        assert str(stated[f"{name}_why_no_uncertainty"].values).partition(":")[0] == word
        assert math.isnan(float(stated[f"{name}_uncertainty"].values)) == bool(word)


@pytest.mark.parametrize("is_known", [True, False])
def test_stated_pressures(is_known: bool) -> None:
    """What is still to come is half of the last change; without a law nothing is corrected.

    What a bound of Poisson's ratio takes off is another of u1 and u2.
    """
    at = {"cell_size": 0.2, "adhesion_factor": 1.0, "rigidity_index": 100.0, "inertia": 0.1}
    stated = stated_of(why_none="" if is_known else "law: of one's own", **at)
    errors = face_error(5.0, **at), shoulder_error(5.0, -0.4, **at)
    for place, (of_mesh, of_laws) in zip(("face", "shoulder"), errors, strict=True):
        off = of_mesh + 0.02 * law.BOUND_EFFECT[place]
        name = f"pore_pressure_factor_{place}"
        value, correction, half_width = (
            float(stated[it].values) for it in (name, f"{name}_correction", f"{name}_uncertainty")
        )
        assert value == pytest.approx(5.0 + (off if is_known else 0.0))
        assert correction == pytest.approx(off if is_known else 0.0)
        of_mean = math.hypot(law.SETTLING * 0.2, 5.0 * law.NOISE[place])
        expected = math.hypot(of_laws, of_mean, 0.02 * law.BOUND[place]) if is_known else math.nan
        assert half_width == pytest.approx(expected, nan_ok=True)
        why = str(stated[f"{name}_why_no_uncertainty"].values)
        assert why == ("" if is_known else "law: of one's own")


def stated_of(*, why_none: str, **of_cone: float) -> dict[str, xr.Variable]:
    """What is stated of a run whose pressures have fallen from 5.2 to 5 su."""
    curve = ("penetration", np.append(np.full(20, 5.2e4), np.full(20, 5.0e4)))
    recorded = xr.Dataset(
        {f"excess_pore_pressure_{it}": curve for it in ("face", "shoulder")}
        | {f"pore_pressure_factor_{it}": 5.0 for it in ("face", "shoulder")}
        | {"radial_deviator_shoulder": ("penetration", np.full(40, -4e3))}
        | {"radial_deviator_factor_shoulder": -0.4}
    )
    given = {"cell_size": 0.2, "adhesion_factor": 1.0, "rigidity_index": 100.0, "inertia": 0.0}
    return law.stated_pressures(
        recorded, strength=1e4, bounded=0.02, why_none=why_none, **given | of_cone
    )


def test_u2_of_random_cases_is_that_of_finer_runs() -> None:
    """With 95 %, within the half widths of both; no case was used to set the law."""
    cases = np.genfromtxt(MEASURED.with_name("held_out_u2.csv"), delimiter=",", names=True)
    half_width = np.hypot(cases["u2_uncertainty"], cases["u2_fine_uncertainty"])
    assert len(cases) == 24
    assert np.mean(np.abs(cases["u2"] - cases["u2_fine"]) <= half_width) >= 0.95


def test_what_still_comes_of_u2_is_within_its_half_width() -> None:
    """With 95 %, in runs that were not used to set it."""
    change, came = (np.array(them.split(), dtype=float) for them in (LAST_CHANGE, STILL_CAME))
    within = np.abs(came) <= np.hypot(law.SETTLING * change, 100.0 * law.NOISE["shoulder"])
    assert within.mean() >= 0.95


def test_the_sleeve_friction_may_be_as_low_as_beside_remoulded_clay() -> None:
    recorded = xr.Dataset({"sleeve_friction_factor": 0.3})
    stated = law.stated_sleeve(recorded, remoulded=0.2 * 0.5)
    assert float(stated["sleeve_friction_factor_uncertainty"].values) == pytest.approx(0.2)
