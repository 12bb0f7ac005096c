"""Elasticity, the criteria of Tresca and von Mises, and the watch of their yield."""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.errors import SceneError, SimulationDiverged
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import real, vec1, vec2, vec3, vec4
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.materials.material import Material
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.materials.yield_check import BLOCK
from mpm_warp.parts.history import History
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import Recording, greatest_shear, principal
from tests.mpm_warp.materials.conftest import points_on, returned

TIME_STEP = 1e-3
SOIL = Recording(shear_modulus=2.0, poissons_ratio=0.48, density=1.0)


def deformed(gradients: Any, start: Any = (0, 0, 0, 0)) -> tuple[Floats, Floats]:
    """Stress after a step at velocity gradients (rr, rz, zr, zz, tt), and what the law was told."""
    simulation = points_on(gradients, SOIL, round(1.0 / TIME_STEP), start)
    simulation.advance(1)
    return simulation.array("particle.stress"), simulation.array("particle.state")


def test_stress_of_a_step_from_rest_is_hookes_of_the_strain_that_the_law_is_told() -> None:
    """dt (K tr D + 2 G dev D), and the law is told the length of the step."""
    gradients = np.random.default_rng(4).normal(size=(100, 5))
    rr, rz, zr, zz, tt = gradients.T
    strain = TIME_STEP * np.stack([rr, zz, 0.5 * (rz + zr), tt], axis=-1)
    stress, told = deformed(gradients)
    np.testing.assert_allclose(told[:, :4], strain, rtol=1e-12)
    np.testing.assert_array_equal(told[:, 4:], [[1.0, TIME_STEP]] * 100)
    volume = strain[:, [0, 1, 3]].sum(axis=1)
    expected = 2.0 * SOIL.shear_modulus * strain
    mean = SOIL.bulk_modulus - 2.0 / 3.0 * SOIL.shear_modulus
    expected[:, [0, 1, 3]] += (mean * volume)[:, None]
    np.testing.assert_allclose(stress, expected, rtol=1e-12, atol=1e-15)


def test_spin_turns_the_stress_and_nothing_else() -> None:
    """However far: its invariants stay, and a quarter turn exchanges r and z."""
    quarter = 2.0 * np.tan(0.25 * np.pi) / TIME_STEP  # Cayley: tan of half the angle
    turns = [(0.0, -quarter, quarter, 0.0, 0.0), (0.0, 300.0, -300.0, 0.0, 0.0)]
    after, told = deformed(turns, (3.0, -1.0, 0.5, 2.0))
    np.testing.assert_allclose(after[0], [-1.0, 3.0, -0.5, 2.0], atol=1e-12)
    rr, zz, rz, tt = after[1]
    assert rr + zz == pytest.approx(2.0)
    assert (rr - zz) ** 2 + 4.0 * rz**2 == pytest.approx(17.0)
    assert tt == 2.0
    np.testing.assert_array_equal(told[:, :4], 0.0)


STRENGTH = 2.5
ELASTIC = {"shear_modulus": 100.0, "poissons_ratio": 0.3, "density": 4.0}


TRESCA, VON_MISES = (criterion(strength=STRENGTH, **ELASTIC) for criterion in (Tresca, VonMises))


def trials(spread: float, count: int = 2000) -> Floats:
    return np.random.default_rng(1).normal(scale=spread, size=(count, 4))


def deviators(stress: Floats) -> Floats:
    """(rr, zz, rz, tt), shape [n, 4]."""
    mean = stress[:, [0, 1, 3]].mean(axis=1, keepdims=True)
    return np.asarray(stress - mean * [1.0, 1.0, 0.0, 1.0])


def root_of_j2(stress: Floats) -> Floats:
    """Root of half the sum of the squares of all nine components of the deviator, [n]."""
    return np.asarray(np.sqrt(0.5 * deviators(stress) ** 2 @ [1.0, 1.0, 2.0, 1.0]))


@pytest.mark.parametrize("clay", [TRESCA, VON_MISES])
def test_returns_keep_pressure_directions_and_what_is_inside(clay: Material) -> None:
    trial = trials(20.0)
    after = returned(clay, trial)
    pressure = trial[:, [0, 1, 3]].sum(axis=1)
    np.testing.assert_allclose(after[:, [0, 1, 3]].sum(axis=1), pressure, atol=1e-12)
    # Same principal directions: the deviators in the plane are parallel.
    cross = (trial[:, 0] - trial[:, 1]) * after[:, 2] - (after[:, 0] - after[:, 1]) * trial[:, 2]
    np.testing.assert_allclose(cross, 0.0, atol=1e-11)
    inside = trials(0.3)
    np.testing.assert_array_equal(returned(clay, inside), inside)


@pytest.mark.parametrize(("clay", "measured"), [(TRESCA, greatest_shear), (VON_MISES, root_of_j2)])
def test_returned_stress_is_on_the_yield_surface_as_the_law_measures_it(
    clay: Material, measured: Callable[[Floats], Floats], floating: Scene
) -> None:
    parts = (History(),)
    soil = dataclasses.replace(floating, material=clay, particles_per_side=13, parts=parts)
    simulation = Simulation(soil)

    def share_of_strength(stress: Floats) -> Floats:
        simulation.assign("particle.stress", stress)
        simulation.launch(simulation.plan.between_steps["yield_share"])
        return simulation.array("yield.share").copy()

    trial = trials(20.0, simulation.plan.particle_count)
    before = share_of_strength(trial)
    np.testing.assert_allclose(before, measured(trial) / STRENGTH, rtol=1e-13)
    after = share_of_strength(returned(clay, trial))
    np.testing.assert_allclose(after, np.minimum(before, 1.0), rtol=1e-13)


def nearest_on_hexagon(values: Floats) -> Floats:
    """Brute force: the nearest point of the Tresca hexagon to principal deviators, [n, 3]."""
    corners = np.array([[-2.0, -2.0, 4.0], [-4.0, 2.0, 2.0]]) * STRENGTH / 3.0
    share = np.linspace(0.0, 1.0, 20001)[:, None]
    # With the principal stresses in order only one side can be the nearest.
    side = (1.0 - share) * corners[0] + share * corners[1]
    mean = values.mean(axis=1, keepdims=True)
    distances = np.sum(((values - mean)[:, None, :] - side) ** 2, axis=2)
    return side[np.argmin(distances, axis=1)] + mean


def test_tresca_returns_to_the_nearest_point() -> None:
    trial = trials(20.0, 300)
    outside = np.ptp(principal(trial), axis=1) > 2.0 * STRENGTH
    after = principal(returned(TRESCA, trial[outside]))
    # The brute force has 20000 points on a side of length 2 sqrt(2) su.
    np.testing.assert_allclose(after, nearest_on_hexagon(principal(trial[outside])), atol=1e-3)


def test_tresca_returns_far_stresses_and_those_equal_in_the_plane() -> None:
    """The latter to a corner; the rounding of the others is that of their size."""
    far = returned(TRESCA, trials(2e6))
    assert np.ptp(principal(far), axis=1).max() <= 2.0 * STRENGTH * (1 + 1e-14) + 2e-8
    hoop = np.array([50.0, -50.0])
    after = returned(TRESCA, hoop[:, None] * [0.0, 0.0, 0.0, 1.0])
    mean, sign = hoop / 3.0, np.sign(hoop)
    plane, tt = mean - sign * 2.0 / 3.0 * STRENGTH, mean + sign * 4.0 / 3.0 * STRENGTH
    expected = np.stack([plane, plane, 0.0 * hoop, tt], axis=-1)
    np.testing.assert_allclose(after, expected, rtol=1e-14)


def test_von_mises_ends_on_its_surface_radially() -> None:
    trial = trials(20.0)
    scale = np.minimum(1.0, STRENGTH / root_of_j2(trial))
    after = deviators(returned(VON_MISES, trial))
    np.testing.assert_allclose(after, deviators(trial) * scale[:, None], atol=1e-12)


def test_wave_speeds_are_those_of_the_elastic_moduli() -> None:
    """E = 2 G (1 + nu); the constrained modulus E (1 - nu) / ((1 + nu) (1 - 2 nu)) is rho cp^2."""
    material = LinearElastic(**ELASTIC)
    youngs = 2.0 * 100.0 * 1.3
    constrained = youngs * 0.7 / (1.3 * 0.4)
    assert material.pressure_wave_speed == pytest.approx((constrained / 4.0) ** 0.5)
    assert material.shear_wave_speed == pytest.approx(5.0)
    assert material.bulk_modulus == pytest.approx(youngs / (3.0 * 0.4))


SU = 1e3
CLAY = Tresca(shear_modulus=1e6, poissons_ratio=0.3, density=1e3, strength=SU)


def clay_of(floating: Scene, **changes: object) -> Simulation:
    return Simulation(dataclasses.replace(floating, material=CLAY, **changes))


def test_yield_is_watched_to_rounding_of_the_stress_and_no_further(floating: Scene) -> None:
    """Under a mean stress of 1e4 su the rounding is that of the mean stress."""
    simulation = clay_of(floating)
    mean, eps = 1e7, float(np.finfo(float).eps)

    def look(beyond: float) -> None:
        radius = SU * (1.0 + beyond)
        simulation.array("particle.stress")[7] = [mean + radius, mean - radius, 0.0, mean]
        simulation.check()

    look(beyond=10 * eps * mean / SU)
    with pytest.raises(SimulationDiverged, match=r"stress of particle 7 .*yield surface by .*e-10"):
        look(beyond=200 * eps * mean / SU)


def test_the_worst_particle_of_every_block_is_found(floating: Scene) -> None:
    """How far it is outside, over the strength; blocks without one are within.

    Slots that hold no particle are not looked at.
    """
    simulation = clay_of(floating, particles_per_side=10)
    count = simulation.plan.particle_count
    planted = {5: 1.5, 6: 1.2, BLOCK: 1.1, BLOCK + 1: 10.0, count - 1: 2.0}
    for particle, factor in planted.items():
        simulation.array("particle.stress")[particle, 2] = factor * SU
    simulation.array("particle.cell")[BLOCK + 1] = -1
    simulation.launch(simulation.plan.between_steps["yield_check"])
    margin = simulation.array("yield.margin")
    expected = np.full(-(-count // BLOCK), -1.0)
    expected[[0, 1, -1]] = [0.5, 0.1, 1.0]
    np.testing.assert_allclose(margin, expected, atol=1e-12)
    assert simulation.array("yield.particle")[[0, 1, -1]].tolist() == [5, BLOCK, count - 1]


def test_a_material_that_never_yields_has_no_return_and_no_check(floating: Scene) -> None:
    trial = trials(1e6)
    np.testing.assert_array_equal(returned(LinearElastic(**ELASTIC), trial), trial)
    plan = make_plan(floating)
    assert plan.between_steps == {}
    assert not {"yield.margin", "yield.particle"} & set(plan.arrays)


@wp.func
def without_state(stress: vec4, strain: vec4, time_step: real, properties: vec2):
    return stress


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("properties", (), "properties is empty, must have a number at least"),
        ("properties", (2.0, np.nan), r"properties\[1\] = nan must be a finite number"),
        ("properties", "soft", "properties = array.* must be an array of numbers"),
        ("ground_shear_modulus", -1.0, "ground_shear_modulus = -1 Pa must be > 0"),
        ("ground_shear_modulus", np.nan, "ground_shear_modulus = nan Pa must be a finite number"),
        ("pressure_wave_speed", 0.0, "pressure_wave_speed = 0 m/s must be > 0"),
        ("state", "strain", "state = 'strain' must be of type tuple or list"),
        ("update", lambda law: None, r"update\(\) = None must be of type Function"),
        (
            "update",
            lambda law: without_state,
            r".* = without_state takes \(.*, properties\), must take \(.*, properties, state\)",
        ),
        (
            "yield_function",
            lambda law: without_state,
            r".* must take \(stress, properties, state\)",
        ),
        # Kernels would write beyond what has not a row for each point.
        pytest.param(
            *("state_at", lambda *_: np.zeros(6), r"state_at has shape \(6,\), must have"),
            id="start",
        ),
    ],
)
def test_a_law_without_its_numbers_or_functions_is_refused(
    name: str, given: Any, message: str, floating: Scene
) -> None:
    """Before a kernel is compiled, which would speak of arguments of its own."""
    own = type("Own", (Recording,), {name: given})(**ELASTIC)
    with pytest.raises(SceneError, match=rf"^Own\.{message}"):
        make_plan(dataclasses.replace(floating, material=own))


@wp.func
def unknown_inside(stress: vec4, strain: vec4, time_step: real, properties: vec2, state: vec1):
    return never_defined * strain, state  # type: ignore[name-defined]  # noqa: F821


@wp.func
def one_result(stress: vec4, strain: vec4, time_step: real, properties: vec2, state: vec1):
    return stress


@pytest.mark.parametrize(
    ("update", "message"),
    [
        (
            unknown_inside,
            r"function unknown_inside in .*test_material\.py: .* never_defined, in: return never_d",
        ),
        (one_result, "function .* in: sigma, remembered = law.update"),
    ],
)
def test_a_function_that_warp_cannot_compile_is_refused_in_one_line(
    update: Any, message: str, floating: Scene
) -> None:
    """Warp has a few lines for each function on the way to it."""
    own = type("Own", (LinearElastic,), {"update": lambda law: update})(**ELASTIC)
    with pytest.raises(SceneError, match=f"^no kernel can be made of the {message}[^\n]*$"):
        Simulation(dataclasses.replace(floating, material=own))


@wp.func
def strength_lost(stress: vec4, properties: vec3, state: vec1) -> vec2:
    return vec2(stress[2], stress[0] / stress[0])


class LosingStrength(Tresca):
    """Its strength is not a number where there is no radial stress."""

    def yield_function(self) -> Any:
        return strength_lost


def test_a_strength_and_a_state_that_are_no_numbers_are_noticed(floating: Scene) -> None:
    """The stress of such a point may be sound for long, and is that of another law."""
    losing = dataclasses.replace(floating, material=LosingStrength(strength=SU, **ELASTIC))
    simulation = Simulation(losing)
    simulation.array("particle.stress")[:, 0] = 1.0
    simulation.check()
    simulation.array("particle.stress")[7, 0] = 0.0
    with pytest.raises(SimulationDiverged, match=r"stress of particle 7 .* by nan of the strength"):
        simulation.check()
    remembering = Simulation(dataclasses.replace(floating, material=SOIL))
    remembering.array("particle.state")[3, 1] = np.nan
    with pytest.raises(SimulationDiverged, match=r"state of particle 3 at .* is .*nan"):
        remembering.check()
