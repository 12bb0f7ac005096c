"""What is stated of the error of a cone factor, and when nothing is."""

import dataclasses
import functools
import math

import numpy as np
import pytest
import xarray as xr

from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.uncertainty import cone, laws
from mpm_warp.uncertainty.further_runs import CARRIED_ON
from tests.mpm_warp.uncertainty.conftest import readings, steady_run

TEST = ConePenetration()
CELL = math.sqrt(3.0) / 5.0
NOT_IN = (
    "law: the error is known in tresca, not in {}, but further runs may measure it (uncertainty = "
    "measured)"
)
CHANGING = NOT_IN.format("clay that softens or has a rate effect")
PARTS = (
    *("mesh", "growth", "domain", "bottom", "top", "range"),
    *("steadiness", "speed", "limit", "points", "noise"),
)

MEASURED: dict[str, dict[tuple[float, ...], dict[float, float]]] = {"window": {}, "growth": {}}
"""Nc as simulated by extents of the window over the default ones, or by growth of the cells; by
rigidity index, adhesion factor and Delta."""
for _effect, *_case, _value, _simulated in (row.values() for row in readings("window_and_growth")):
    _series = MEASURED[_effect].setdefault(tuple(map(float, _case)), {})
    _series[float(_value)] = float(_simulated)


def known_error(test: ConePenetration, *, rise: float = 0.0, samples: int = 60) -> xr.Dataset:
    """What is stated of the first samples of a run with the cone factor 10."""
    scene, run = test.build(), steady_run(test, 10.0, rise=rise)
    run = run.isel(penetration=slice(samples))
    return xr.Dataset(cone.known_error(test.error_of(run), test, scene))


def test_the_cone_factor_is_what_was_simulated_and_its_correction() -> None:
    """The half width is made of its parts; what a bound takes off is given back."""
    known = known_error(TEST)
    mesh = laws.mesh_error(
        rigidity_index=100.0, adhesion_factor=0.0, cell_size=CELL, cell_growth=0.4
    )
    speed = 0.07 * 100.0 * TEST.speed_ratio**2
    bottom = -0.04 * 100.0 / 14.0**2
    correction = -mesh - speed - bottom
    assert float(known.cone_factor_correction) == pytest.approx(correction, rel=1e-12)
    assert float(known.cone_factor) == pytest.approx(10.0 + correction, rel=1e-12)
    assert float(known.cone_factor_normal) == float(known.cone_factor)
    parts = [float(known[f"cone_factor_uncertainty_{name}"]) for name in PARTS]
    assert min(parts) >= 0.0
    assert float(known.cone_factor_uncertainty) == pytest.approx(math.hypot(*parts), rel=1e-12)
    bounded = dataclasses.replace(TEST, poissons_ratio_bound=TEST.poissons_ratio - 0.01)
    difference = float(known_error(bounded).cone_factor - known.cone_factor)
    assert difference == pytest.approx(0.01 * laws.EFFECTS["bound"].size, rel=1e-9)


NOISE, WINDOW, TOP = (laws.EFFECTS[it].half_width for it in ("noise", "domain", "top"))
SMOOTH = {"rigidity_index": 20.0, "adhesion_factor": 0.0}


@pytest.mark.parametrize(
    ("part", "changes", "expected"),
    [
        # The same on all meshes; larger in stiff clay, whose meshes are not as fine, and less for a
        # rough cone, linear over the square of the adhesion factor.
        *(("limit", SMOOTH | {"cells_per_radius": it}, 0.045) for it in (3.0, 12.0)),
        ("limit", {"rigidity_index": 300.0}, 0.035),
        ("limit", {"rigidity_index": 1000.0, "cells_per_radius": 12.0}, 0.07),
        ("limit", {"adhesion_factor": 1.0}, 0.02),
        ("limit", {"adhesion_factor": 0.5}, 0.045 - 0.25 * (0.045 - 0.02)),
        # With the width of the cells.
        *(
            ("noise", {"cells_per_radius": it / math.sqrt(3.0)}, NOISE * math.sqrt(3.0) / it)
            for it in (5, 10)
        ),
        # From Ir 50 on the window is as large over the plastic zone as at Ir 100.
        *(("domain", {"rigidity_index": it}, WINDOW * min(1.0, it / 50.0)) for it in (25.0, 50.0)),
        ("domain", {}, WINDOW),
        # (-Delta)^1.5 sqrt(Ir) over the extent above.
        ("top", {"stress_anisotropy": -0.09}, TOP * 0.09**1.5 * 10.0 / 13.0),
    ],
)
def test_a_part_of_the_half_width(part: str, changes: dict[str, float], expected: float) -> None:
    known = known_error(dataclasses.replace(TEST, **changes))
    found = float(known[f"cone_factor_uncertainty_{part}"])
    assert found == pytest.approx(expected, rel=1e-12)


def test_the_error_of_the_mesh_is_interpolated_between_those_measured() -> None:
    """Over ln(Ir), and over the square of the adhesion factor."""
    table = laws.TABLE
    indices = table.rigidity_index.tolist()
    at_50, at_100 = (indices.index(index) for index in (50.0, 100.0))
    for column, power in (("slope", 1.0), ("curvature", laws.CURVATURE_POWER)):
        smooth, rough = table.columns[column].T

        def found(
            index: float, adhesion: float, column: str = column, power: float = power
        ) -> float:
            """B or Q, by meshes that do not grow; Q alone is in `curvature_error`."""
            clay = {"rigidity_index": index, "adhesion_factor": adhesion, "cell_size": 0.2}
            of_curvature = laws.curvature_error(**clay)
            whole = laws.mesh_error(**clay, cell_growth=1e-9)
            of_column = whole - of_curvature if column == "slope" else of_curvature
            return float(of_column) / 0.2**power

        approx = functools.partial(pytest.approx, rel=1e-6)
        assert found(100.0, 0.0) == approx(smooth[at_100])
        assert found(100.0, 0.5) == approx(0.75 * smooth[at_100] + 0.25 * rough[at_100])
        assert found(math.sqrt(5000.0), 1.0) == approx(0.5 * (rough[at_50] + rough[at_100]))


@pytest.mark.parametrize("column", ["slope", "curvature"])
def test_the_table_of_the_mesh_is_fine_enough(column: str) -> None:
    """What its interpolation is off by is within the half width of B, on the default mesh."""
    power = {"slope": 1.0, "curvature": laws.CURVATURE_POWER}[column]
    off = np.abs(laws.TABLE.left_out(column)) * CELL**power
    assert off.max() <= laws.EFFECTS["mesh"].half_width * CELL


@pytest.mark.parametrize("case", MEASURED["window"])
def test_a_window_of_twice_the_extents_has_the_same_factor(case: tuple[float, ...]) -> None:
    test = ConePenetration(
        rigidity_index=case[0], adhesion_factor=case[1], cells_per_radius=2.31, cell_growth=0.4
    )
    twice = {name: 2.0 * extent for name, extent in test.default_extents.items()}
    corrected, half_widths = [], []
    for changed, simulated in zip(({}, twice), MEASURED["window"][case].values(), strict=True):
        run = dataclasses.replace(test, **changed, approach=None, penetration=None)
        laws = run.laws(penetration=run.penetration)
        corrected.append(simulated + float(laws.correction))
        half_widths += [float(laws.half_widths()[it]) for it in ("domain", "bottom", "noise")]
    assert abs(corrected[1] - corrected[0]) <= math.hypot(*half_widths)


@pytest.mark.parametrize("case", MEASURED["growth"])
def test_cells_that_grow_more_have_the_same_factor(case: tuple[float, ...]) -> None:
    growths = MEASURED["growth"][case]
    corrected = [
        simulated - laws.EFFECTS["growth"].size * laws.growth_measure(CELL, growth)
        for growth, simulated in growths.items()
    ]
    half_widths = [laws.growth_uncertainty(CELL, growth) for growth in growths]
    for value, half_width in zip(corrected[1:], half_widths[1:], strict=True):
        assert abs(value - corrected[0]) <= math.hypot(half_width, half_widths[0])


@pytest.mark.parametrize(
    ("part", "changes"),
    [
        ("mesh", {"cells_per_radius": 2.3}),
        ("growth", {"cell_growth": 0.8}),
        ("domain", {"domain_above": 10.0}),
        ("domain", {"domain_radius": 20.0}),
        ("bottom", {"domain_below": 10.0}),
        ("top", {"stress_anisotropy": -0.1}),
        ("speed", {"speed_ratio": 0.1}),
        ("bound", {"poissons_ratio_bound": 0.48}),
    ],
)
def test_a_worse_choice_has_a_larger_part(part: str, changes: dict[str, float]) -> None:
    worse = dataclasses.replace(TEST, **changes)
    name = f"cone_factor_uncertainty_{part}"
    before = known_error(TEST)
    after = known_error(worse)
    assert float(after[name]) > float(before[name])


@pytest.mark.parametrize(
    ("name", "inside", "edge", "beyond"),
    [
        ("stress_anisotropy", 0.49, 0.5, 0.9),
        ("stress_anisotropy", -0.49, -0.5, -0.9),
        ("rigidity_index", 1000.0 / 1.01, 1000.0, 2000.0),
        ("rigidity_index", 20.2, 20.0, 10.0),
        ("poissons_ratio", 0.46, 0.45, 0.4),
    ],
)
def test_beyond_what_was_tested_the_laws_go_on_and_are_less_certain(
    name: str, inside: float, edge: float, beyond: float
) -> None:
    """Without a jump at the edge, and with a part of its own that grows from there."""
    tests = [dataclasses.replace(TEST, **{name: it}) for it in (inside, edge, beyond)]
    within, at_edge, carried_on = (known_error(it) for it in tests)
    assert float(at_edge.cone_factor) == pytest.approx(float(within.cone_factor), abs=0.02)
    parts = [float(it.cone_factor_uncertainty_range) for it in (within, at_edge, carried_on)]
    assert parts[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert parts[2] > 0.04
    assert float(carried_on.cone_factor_uncertainty) > float(at_edge.cone_factor_uncertainty)
    assert carried_on.why_no_uncertainty == ""


def test_growth_other_than_that_of_the_meshes_measured_leaves_a_share_of_its_effect_open() -> None:
    assert laws.growth_uncertainty(CELL, laws.GROWTH_OF_MESHES) == 0.0
    small = 0.5 * CELL
    size, half_width = laws.EFFECTS["growth"]
    quarter_and_third = half_width / size + laws.GROWTH_SHARE
    for growth in (0.2, 0.5):
        measures = (laws.growth_measure(small, it) for it in (growth, laws.GROWTH_OF_MESHES))
        left = quarter_and_third * size * abs(np.subtract(*measures))
        assert laws.growth_uncertainty(small, growth) == pytest.approx(left)


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"material": "von_mises"}, NOT_IN.format("von_mises")),
        ({"remoulded_strength_ratio": 0.5, "ductility": 10.0}, CHANGING),
        ({"rate_factor": 0.1, "reference_strain_rate": 0.1}, CHANGING),
        ({"apex_angle": 90.0}, "cone: the apex angle is 90 degrees, not 60"),
        ({"friction_coefficient": 0.04}, "contact: the contact has friction"),
        ({"rigidity_index": 9.0}, "rigidity index: the rigidity index is not 10 to 2000"),
        ({"stress_anisotropy": -0.96}, "Delta: the stress anisotropy is beyond 0.95"),
        ({"poissons_ratio": 0.39}, "Poisson's ratio: Poisson's ratio is below 0.4"),
        ({"speed_ratio": 0.2}, "speed: the speed is too high"),
        ({"domain_below": 7.0}, "window: the bottom of the window is too near"),
        ({"domain_above": 0.69 * 13.0}, "window: the top of the window is too near"),
        ({"approach_speed_ratio": 0.5}, "approach: the approach is too fast"),
        ({"cell_growth": 1.1}, "mesh: cell_growth is above 1"),
        ({"cells_per_radius": 1.2}, "mesh: the cells are too wide"),
        ({"penetration": 14.0}, "settling: soil that the cone has not passed is still beside it"),
    ],
)
def test_where_the_laws_do_not_hold_there_is_no_u_and_the_correction_goes_on(
    changes: dict[str, object], why: str
) -> None:
    test = dataclasses.replace(TEST, **changes)
    known = known_error(test)
    assert known.why_no_uncertainty == f"{why}: {CARRIED_ON}"
    assert known.largest_part_of_uncertainty == ""
    assert np.isnan(known.cone_factor_uncertainty)
    assert float(known.cone_factor) == 10.0 + float(known.cone_factor_correction) > 10.04


def test_a_resistance_that_still_changes_is_less_certain() -> None:
    """The largest part of U is told with what makes it smaller."""
    rising = known_error(TEST, rise=0.2)
    assert float(rising.cone_factor_uncertainty_steadiness) == pytest.approx(0.3)
    assert float(rising.cone_factor_uncertainty) > 0.3
    share = float(rising.cone_factor_uncertainty_steadiness / rising.cone_factor_uncertainty) ** 2
    assert rising.largest_part_of_uncertainty == (
        f"steadiness, {share:.0%} of U^2: more penetration, or a lower steady_tolerance"
    )
    parts = {name.removeprefix("cone_factor_uncertainty_") for name in map(str, rising)}
    assert parts & cone.REMEDIES.keys() == cone.REMEDIES.keys()


def test_a_run_that_is_too_short_has_not_settled() -> None:
    short = dataclasses.replace(TEST, penetration=2.0)
    known = known_error(short, samples=9)
    assert float(known.cone_factor_settled) == 0.0
    assert float(known_error(TEST).cone_factor_settled)
