"""Strength and stiffness by depth: what points carry, and what their stress makes of it."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import Anisotropic, FarField, Scene, SceneError, Simulation, Variation
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import PROPERTIES
from mpm_warp.planning import make_plan
from tests.mpm_warp.conftest import assert_same_bits, greatest_shear, layers

TWO_LAYERS = layers((0, 1, 0.25), (2, 2, 0.25), (2, 0.5, 1), (5, 0.5, 1), origin_depth=3.0)


def varied(scene: Scene, variation: Variation | None) -> Scene:
    """The scene with a material that varies, in surroundings that a far field would not be."""
    material = dataclasses.replace(scene.material, variation=variation)
    return dataclasses.replace(scene.without(FarField), material=material)


def test_ratios_are_linear_between_depths_and_jump_where_two_are_equal() -> None:
    """A place at a jump has what is below it; beyond the ends the ground goes on."""
    height = 3.0 - np.array([-1.0, 0.0, 1.0, 2.0 - 1e-9, 2.0, 4.0, 9.0])
    place = np.stack([np.ones_like(height), height], axis=-1)
    expected = [1.0, 1.0, 1.5, 2.0, 0.5, 0.5, 0.5]
    np.testing.assert_allclose(TWO_LAYERS.at(place, TWO_LAYERS.strength_ratio), expected, atol=1e-8)


def test_points_carry_the_properties_of_their_depth(cone: Scene) -> None:
    plan = make_plan(varied(cone, TWO_LAYERS))
    position, properties = (plan.arrays[name].initial for name in ("particle.position", PROPERTIES))
    below = position[:, 1] <= 1.0
    stiff, strength = cone.material.properties[:2], 2
    ratio = np.where(below, 1.0, 0.25)
    np.testing.assert_array_equal(properties[:, :2], ratio[:, None] * np.array(stiff))
    np.testing.assert_array_equal(properties[below, strength], 0.5 * 20e3)


@pytest.mark.parametrize("criterion", CRITERIA.values())
def test_ratios_of_one_give_the_bits_of_uniform_clay(cone: Scene, criterion: type) -> None:
    """In every array: what varies goes by the same arithmetic."""
    elastic = {name: getattr(cone.material, name) for name in ("shear_modulus", "poissons_ratio")}
    clay = criterion(density=1700.0, strength=20e3, **elastic)
    scene = dataclasses.replace(cone, material=clay)
    uniform, variable = (Simulation(varied(scene, it)) for it in (None, layers((0, 1, 1))))
    for simulation in (uniform, variable):
        simulation.travel_to(1.0)
    assert_same_bits(uniform, variable)


def test_stress_of_a_step_is_that_of_each_point_s_own_stiffness(cone: Scene) -> None:
    """One step of the same motion, elastic: a quarter of the stress where a quarter as stiff."""
    uniform, layered = (Simulation(varied(cone, it)) for it in (None, TWO_LAYERS))
    for simulation in (uniform, layered):
        velocity = 1e-3 * simulation.array("particle.position")
        simulation.assign("particle.velocity", velocity)
        simulation.advance(1)
    ratio = layered.array(PROPERTIES)[:, :1] / cone.material.properties[0]
    inside = uniform.array("particle.cell")[:, 0] >= 0
    of_uniform, of_layered = (it.array("particle.stress")[inside] for it in (uniform, layered))
    assert np.abs(of_uniform).max() > 0.0
    scale = np.abs(of_uniform).max()
    np.testing.assert_allclose(of_layered, ratio[inside] * of_uniform, atol=1e-12 * scale)


def test_each_point_yields_at_its_own_strength(cone: Scene) -> None:
    layered = Simulation(varied(cone, TWO_LAYERS))
    layered.travel_to(0.5)
    inside = layered.array("particle.cell")[:, 0] >= 0
    stress, own = layered.array("particle.stress")[inside], layered.array(PROPERTIES)[inside, 2]
    shear = greatest_shear(stress)
    assert (shear <= own * (1.0 + 1e-9)).all()
    # Some soil of either layer yields.
    yields = shear > own * (1.0 - 1e-6)
    assert yields[own == 0.5 * 20e3].any()
    assert yields[own > 1.0 * 20e3].any()


ANISOTROPIC = Anisotropic(
    shear_modulus=100.0,
    poissons_ratio=0.4,
    density=1.0,
    strength_compression=1.0,
    strength_extension=0.7,
    strength_simple_shear=0.8,
    strength_horizontal=0.8,
)


def test_materials_of_rows_are_of_one_law_which_has_more_than_ratios(cone: Scene) -> None:
    clay = cone.material
    for law, rows, said in (
        (clay, (clay,) * 4, "Tresca: variation.rows: stiffness and strength vary by the ratios"),
        (ANISOTROPIC, (clay,) * 4, r"Anisotropic: variation.rows\[0\] = .* must be of type Aniso"),
        (ANISOTROPIC, (1, 2, 3, 4), r"Anisotropic: variation.rows\[0\] = 1 must be of type Aniso"),
    ):
        variation = dataclasses.replace(TWO_LAYERS, rows=rows)
        with pytest.raises(SceneError, match=said):
            dataclasses.replace(law, variation=variation)
    nothing = np.zeros(0)
    with pytest.raises(SceneError, match="depth has no rows"):
        Variation(depth=nothing, strength_ratio=nothing, stiffness_ratio=nothing)


def test_stress_at_rest_does_not_follow_the_soil(cone: Scene) -> None:
    scene = varied(cone, TWO_LAYERS)
    with pytest.raises(SceneError, match="stress_at_rest: not together"):
        dataclasses.replace(scene, stress_at_rest=np.array([1.0, 0.0, 0.0, 1.0]))
