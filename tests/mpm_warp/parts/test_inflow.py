"""Soil that enters below the window: layer by layer, with all that particles carry."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import Approach, ConePenetration, FarField, Scene, Simulation, Window
from mpm_warp.materials.material import PROPERTIES
from mpm_warp.planning import make_plan
from tests.mpm_warp.conftest import Recording, assert_same_bits, greatest_shear, layers


def test_undisturbed_soil_in_the_window_stays_exactly_at_rest(empty: Scene) -> None:
    """Without a penetrometer nothing happens, however far the window travels."""
    simulation = Simulation(empty)
    count = simulation.particle_count
    simulation.travel_to(0.5)
    assert np.abs(simulation.array("particle.velocity")).max() == 0.0
    assert np.abs(simulation.array("particle.stress")).max() == 0.0
    layer = simulation.plan.arrays["layer.mass"].shape[0]
    inside = simulation.array("particle.cell")[:, 0] >= 0
    assert abs(inside.sum() - count) <= layer
    # What entered carries on the lattice of what was there: layers at equal distances.
    heights = np.sort(simulation.array("particle.position")[inside, 1]).reshape(-1, layer)
    grid = empty.grid
    spacing = (grid.rows[1] - grid.rows[0]) / empty.particles_per_side
    np.testing.assert_allclose(np.diff(heights.mean(axis=1)), spacing, rtol=1e-9)


def test_a_layer_brings_every_array_of_the_particles_along(cone: Scene) -> None:
    """Whatever a material or a part adds: a launch for each, and the values of the first layer."""
    soil = Recording(shear_modulus=2e6, poissons_ratio=0.3, density=1700.0)
    plan = make_plan(dataclasses.replace(cone, material=soil))
    of_particles = {name for name in plan.arrays if name.startswith("particle.")}
    assert "particle.state" in of_particles
    for name in of_particles:
        word = name.removeprefix("particle.")
        layer, launch = plan.arrays[f"layer.{word}"], plan.between_steps[f"enter.{word}"]
        assert layer.dtype == plan.arrays[name].dtype
        assert launch.arrays == ("layer.slots", f"layer.{word}", name)
    mass, cell = plan.arrays["layer.mass"].initial, plan.arrays["layer.cell"].initial
    lowest = cone.grid.cell_volumes[: cone.grid.column_count]
    # One layer of two: a half of each cell of the lowest row.
    assert mass.sum() == pytest.approx(0.5 * soil.density * lowest.sum(), rel=1e-12)
    np.testing.assert_array_equal(cell[:, 1], 0)


def test_soil_that_enters_has_no_state_velocity_or_stress(cone: Scene) -> None:
    """Nor velocity nor stress, in slots whose particles had all of them when they left above."""
    soil = Recording(shear_modulus=2e6, poissons_ratio=0.3, density=1700.0)
    simulation = Simulation(dataclasses.replace(cone, material=soil))
    height = float(np.diff(cone.grid.rows)[0])
    # Three rows have left; the last layer has entered in this very step.
    enters = (6 - 0.5) * 0.5 * height
    simulation.travel_to(enters)
    entered = simulation.array("layer.slots")
    state = simulation.array("particle.state")
    for name in ("state", "velocity", "stress"):
        np.testing.assert_array_equal(simulation.array(f"particle.{name}")[entered], 0.0)
    np.testing.assert_array_equal(simulation.array("particle.cell")[entered, 1], 0)
    # Others have aged since they entered, and those that were there from the first step on.
    inside = simulation.array("particle.cell")[:, 0] >= 0
    ages = np.unique(state[inside, 4])
    assert ages[0] == 0.0
    assert ages[-1] == simulation.step_count
    assert len(ages) == 7  # of six layers, and of what was there
    np.testing.assert_allclose(state[:, 5], state[:, 4] * simulation.plan.time_step, rtol=1e-9)


@pytest.mark.parametrize("approach", [None, Approach(speed=3.0, travel=1.2, slowing_travel=0.4)])
def test_soil_enters_however_the_steps_are_parted(cone: Scene, approach: Approach | None) -> None:
    """By travel, to a time, in one go and one by one: the same bits in every array of the run."""
    window = dataclasses.replace(cone[Window], approach=approach)
    scene = cone.with_parts(window)
    travelled = Simulation(scene)
    travelled.travel_to(1.5)
    steps = travelled.step_count
    to_a_time, in_one_go, one_by_one, in_parts = (Simulation(scene) for _ in range(4))
    to_a_time.advance_to(travelled.time)
    in_one_go.advance(steps)
    for _ in range(steps):
        one_by_one.advance(1)
    for distance in (0.1, 0.2, 0.7, 0.71, 1.5):
        in_parts.travel_to(distance)
    spacing = float(np.diff(cone.grid.rows)[0]) / cone.particles_per_side
    assert round(1.5 / spacing) >= 5  # layers
    for other in (to_a_time, in_one_go, one_by_one, in_parts):
        assert other.step_count == steps
        assert other.travel == travelled.travel
        assert_same_bits(travelled, other)


def test_the_window_stays_as_full_as_it_was(cone: Scene) -> None:
    """As many particles have entered as have left, but for the layer that is about to."""
    simulation = Simulation(cone)
    grid, material = cone.grid, cone.material
    simulation.travel_to(3.0)
    mass = simulation.array("particle.mass")[simulation.array("particle.cell")[:, 0] >= 0].sum()
    layer = simulation.array("layer.mass").sum()
    assert abs(mass - material.density * grid.cell_volumes.sum()) < layer


def test_soil_that_enters_has_the_properties_of_its_depth(empty: Scene) -> None:
    """Strength that grows linearly: at rest each point has that of where it is in the ground."""
    rows = empty.grid.rows
    growing = layers((-rows[-1], 1, 0.2), (10, 3, 1))
    soil = dataclasses.replace(empty.material, variation=growing)
    simulation = Simulation(dataclasses.replace(empty.without(FarField), material=soil))
    simulation.travel_to(2.0 * float(rows[1] - rows[0]))
    inside = simulation.array("particle.cell")[:, 0] >= 0
    place = simulation.array("particle.position")[inside] - [0.0, simulation.travel]
    assert place[:, 1].min() < rows[0]  # some have entered
    expected = soil.properties_at(place)
    # They enter where the steps bring them, which is known to rounding.
    np.testing.assert_allclose(simulation.array(PROPERTIES)[inside], expected, rtol=1e-9)


def test_soil_enters_within_its_yield_surface() -> None:
    """Stiff soil near a penetrometer: the elastic ground around says more than its strength."""
    test = ConePenetration(rigidity_index=500, domain_below=4, cells_per_radius=1.5)
    simulation = Simulation(test.build())
    simulation.travel_to(4.0 * test.cone_radius)
    before = simulation.array("layer.slots").copy()
    while np.array_equal(simulation.array("layer.slots"), before):
        simulation.advance(1)
    strength = test.undrained_shear_strength
    assert greatest_shear(simulation.array("layer.stress")).max() > 2.0 * strength
    entered = simulation.array("layer.slots")
    carried = greatest_shear(simulation.array("particle.stress")[entered])
    assert carried.max() <= strength * (1 + 1e-12)
