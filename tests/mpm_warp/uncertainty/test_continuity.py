"""No effect makes a step where it begins: the correction of a result goes on, with or without U."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp import BallPenetration, ConePenetration, Sounding, TBarPenetration
from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes.cone.pore_pressure import PLACES
from mpm_warp.scenes.full_flow.penetration import NOT_MEASURED
from mpm_warp.scenes.sounding.curves import sounding_curves
from mpm_warp.uncertainty import cone
from mpm_warp.uncertainty.shoulder import RADIAL_FACTOR, RADIAL_STRESS
from tests.mpm_warp.uncertainty.conftest import steady_run

FOLLOWING_THE_CLAY = ("cells_per_radius", "speed_ratio", "poissons_ratio_bound")
"""Choices of the method that follow the clay."""
STEP = 1e-3
"""Largest relative step of a result that is allowed."""
NEEDED: dict[str, dict[str, float]] = {
    "rate_factor": {"reference_strain_rate": 1e-5},
    "remoulded_strength_ratio": {"ductility": 10.0},
    "ductility": {"remoulded_strength_ratio": 0.999999},
    "reference_strain_rate": {"rate_factor": 1e-9},
    "layer_strength_ratio": {"layer_top": 2.0},
    "layer_thickness": {"layer_top": 2.0},
}
"""What has to be given together with a parameter; it has no effect alone."""
UNBOUNDED = {"ductility": 1e6, "reference_strain_rate": 1.0, "layer_top": 2.0}
"""Values of parameters whose default is that there is no such effect."""


def numbers(scene: type[Any]) -> list[str]:
    """All parameters that may change by a little, without those of other laws."""
    own = parameters_of(scene)
    return [name for name, it in own.items() if it.kind is float and hasattr(scene(), name)]


def beside(test: Any, name: str) -> list[Any]:
    """The test, and it with a value of a parameter just below and above its own."""
    value = getattr(test, name)
    value = UNBOUNDED.get(name, 0.5) if value is None else float(value)
    near = [value * (1.0 - 1e-7), value * (1.0 + 1e-7)] if value else [1e-9]
    allowed = parameters_of(type(test))[name].bounds
    kept = [it for it in near if allowed.maximum is None or it <= allowed.maximum]
    given = {key: it for key, it in NEEDED.get(name, {}).items() if getattr(test, key) is None}
    changed = [replace(test, **given, **{name: it}) for it in kept]
    assert changed
    return [test, *changed]


def cone_results(test: ConePenetration) -> xr.Dataset:
    """Nc, u1 and u2 as stated of the same run."""
    strength = test.undrained_shear_strength
    run = steady_run(test, 10.0)
    run["cone_factor_shear"] = test.adhesion_factor * np.sqrt(3.0)
    constant = "penetration", np.full(60, 5.0 * strength)
    run = run.assign({RADIAL_STRESS: constant, RADIAL_FACTOR: 5.0, "sleeve_friction_factor": 0.5})
    run = run.assign({f"pore_pressure_factor_{it}": 5.0 for it in PLACES})
    run = run.assign({f"excess_pore_pressure_{it}": constant for it in PLACES})
    scene = test.build()
    run = run.assign(cone.known_error(test.error_of(run), test, scene))
    return run.assign(test.beside_shaft(run, scene))


def sounding_results(test: Sounding) -> xr.Dataset:
    """Net resistance and u2 as stated of the same readings, at most depths."""
    count = test.lead_count + len(test.samples)
    strength = test.undrained_shear_strength
    names = ("penetration_resistance", "sleeve_friction", "excess_pore_pressure_shoulder")
    curves = {it: ("penetration", np.full(count, 10.0 * strength)) for it in names}
    curves |= {RADIAL_STRESS: ("penetration", np.full(count, 4.0 * strength))}
    curves |= {"contact_share": ("penetration", np.ones(count))}
    return sounding_curves(test, xr.Dataset(curves), [])


def check_no_step(values: list[xr.Dataset], *names: str) -> None:
    for name in names:
        first, *others = (np.atleast_1d(it[name].values)[:200] for it in values)
        for other in others:
            np.testing.assert_allclose(other, first[: other.size], rtol=STEP, err_msg=name)


BASE = {"rigidity_index": 120.0, "adhesion_factor": 0.5}
BASES: dict[str, dict[str, Any]] = {
    "soft": {"rigidity_index": 50.0},
    "quick": {"accuracy": "quick"},
    "very stiff": {"rigidity_index": 450.0},
    "fine": {"accuracy": "fine"},
    "fast clay": {"rate_factor": 0.1, "reference_strain_rate": 1e-5},
    "soft clay": {"remoulded_strength_ratio": 0.2, "ductility": 10.0},
    "soil shears": {"friction_coefficient": 0.05, "rate_factor": 0.0, "adhesion_factor": 1.0},
}
EDGES: list[tuple[str, float]] = [
    ("rigidity_index", 2000.0),
    ("rigidity_index", 10.0),
    ("stress_anisotropy", 0.95),
    ("poissons_ratio", 0.4),
    ("speed_ratio", 0.03**0.5),
    ("cell_growth", 1.0),
    ("cell_growth", 0.5),  # of u2
    ("domain_below", 7.4),
    ("domain_above", 0.74 * 13.0),
    ("penetration", 14.5),
]


def check_cone_test(test: ConePenetration, name: str) -> None:
    """Neither the correction nor the method by default, of which the simulated value depends."""
    tests = beside(test, name)
    names = ["cone_factor", *(f"pore_pressure_factor_{it}" for it in ("face", "shoulder"))]
    check_no_step([cone_results(it) for it in tests], *names)
    first, *others = ([float(getattr(it, own)) for own in FOLLOWING_THE_CLAY] for it in tests)
    for other in others:
        np.testing.assert_allclose(other, first, rtol=1e-6, err_msg=name)


@pytest.mark.parametrize("base", BASES)
def test_no_parameter_of_a_cone_test_makes_a_step_at_its_value(base: str) -> None:
    for name in numbers(ConePenetration):
        check_cone_test(ConePenetration(**BASE | BASES[base]), name)


@pytest.mark.parametrize(("name", "edge"), EDGES)
def test_no_edge_of_the_laws_is_a_step(name: str, edge: float) -> None:
    check_cone_test(ConePenetration(**BASE | {name: edge}), name)


@pytest.mark.parametrize(
    ("given", "names"),
    [({}, numbers(Sounding)), *(({it: edge}, [it]) for it, edge in (EDGES[0], EDGES[6]))],
    ids=["all", "edge of the laws", "edge of those of u2"],
)
def test_no_parameter_of_a_sounding_makes_a_step_at_its_value(
    given: dict[str, Any], names: list[str]
) -> None:
    for name in names:
        tests = beside(Sounding(adhesion_factor=0.5, **given), name)
        check_no_step([*map(sounding_results, tests)], "net_resistance", "excess_pore_pressure")


@pytest.mark.parametrize("kind", [BallPenetration, TBarPenetration])
def test_further_runs_of_a_body_are_made_where_an_effect_begins(kind: Any) -> None:
    """They are all that is known of its error; without them nothing is corrected."""
    for asked, reasons in (("measured", []), ("none", [NOT_MEASURED])):
        test = kind(uncertainty=asked)
        for name in numbers(kind):
            for it in beside(test, name):
                assert it._why_no_uncertainty() == reasons


@pytest.mark.slow
def test_a_small_effect_changes_a_simulated_result_by_little() -> None:
    test = ConePenetration(accuracy="quick", adhesion_factor=0.5)
    results = [
        it.run()
        for name in ("friction_coefficient", "rate_factor", "remoulded_strength_ratio")
        for it in beside(test, name)[name != "friction_coefficient" :]
    ]
    names = [f"pore_pressure_factor_{it}" for it in ("face", "shoulder")]
    check_no_step(results, "cone_factor", "cone_factor_simulated", *names)
    assert [np.isnan(it.cone_factor_uncertainty).item() for it in results] == [
        False,
        True,
        True,
        True,
    ]
