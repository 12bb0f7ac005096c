"""The time loop on small scenes whose answer is known without a simulation."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mpm_warp.materials.materials import LinearElastic, Tresca
from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.scenes.cone_self_similar import ConeSelfSimilar
from mpm_warp.travel import Travel

from mpm_warp.grid.fitted import Grid, GroundGrid
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

ELASTIC = LinearElastic(shear_modulus=1e6, poissons_ratio=0.3, density=1000.0)
CONE = ConePenetration(cells_per_radius=2, domain_radius=10, domain_above=4, domain_below=4)


@pytest.fixture
def scene(rectilinear: Grid) -> Scene:
    """Elastic soil that floats freely: nothing but grid and material."""
    return Scene(
        grid=rectilinear,
        material=ELASTIC,
        particles_per_side=2,
        time_step_fraction=0.5,
    )


def test_each_part_of_a_scene_adds_its_own_arrays_and_kernels(scene: Scene) -> None:
    grid = scene.grid
    fixed = dataclasses.replace(scene, fixed=Fixed.axis_and_ends(grid))
    far = dataclasses.replace(scene, far_field=FarField.around(grid, ELASTIC))
    viscous = dataclasses.replace(scene, bulk_viscosity=0.1)
    bare = set(make_plan(scene).arrays)
    assert {n.split(".")[0] for n in set(make_plan(fixed).arrays) - bare} == {"fixed"}
    assert {n.split(".")[0] for n in set(make_plan(far).arrays) - bare} == {"far_field"}
    assert set(make_plan(viscous).arrays) - bare == {"cell.viscosity", "cell.dilation_rate"}


def test_a_step_from_rest_has_hookes_stress(scene: Scene) -> None:
    """sigma = dt (K tr D + 2 G dev D), D the mean over the cell of the nodes' velocity."""
    simulation = Simulation(scene)
    random = np.random.default_rng(1)
    velocity = random.normal(size=simulation.array("particle.velocity").shape)
    simulation.arrays["particle.velocity"].assign(velocity)
    column, row = simulation.array("particle.cell").copy().T
    simulation.advance(1)
    grid = scene.grid
    nodal = simulation.array("node.motion")[grid.cell_nodes, :2]
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    integrals = (
        nodal[..., 0] * r,
        nodal[..., 1] * z,
        0.5 * (nodal[..., 0] * z + nodal[..., 1] * r),
        nodal[..., 0] * hoop,
    )
    strain = np.stack([it.sum(axis=1) / grid.cell_volumes for it in integrals], axis=-1)
    strain *= simulation.plan.time_step
    expected = 2.0 * ELASTIC.shear_modulus * strain
    mean = ELASTIC.bulk_modulus - 2.0 / 3.0 * ELASTIC.shear_modulus
    expected[:, [0, 1, 3]] += mean * strain[:, [0, 1, 3]].sum(axis=1)[:, None]
    stress = simulation.array("particle.stress")
    cell = row * grid.column_count + column
    np.testing.assert_allclose(stress, expected[cell], rtol=1e-9, atol=1e-9 * np.abs(stress).max())


def test_a_linear_velocity_arrives_at_the_nodes_amid_a_regular_lattice(scene: Scene) -> None:
    """v = a + b z on rows of one height: what the particles on either side add cancels."""
    regular = dataclasses.replace(scene.grid, rows=np.array([0.0, 0.5, 1.0, 1.5]))
    simulation = Simulation(dataclasses.replace(scene, grid=regular))
    velocity = simulation.array("particle.velocity").copy()
    velocity[:, 1] = 2.0 + 3.0 * simulation.array("particle.position")[:, 1]
    simulation.arrays["particle.velocity"].assign(velocity)
    simulation.advance(1)
    before = simulation.array("node.motion")[:, 3].reshape(4, -1)
    np.testing.assert_allclose(before[1:-1], [[3.5] * 5, [5.0] * 5], rtol=1e-12)


def test_a_rigid_motion_along_the_axis_leaves_no_stress_and_keeps_momentum(scene: Scene) -> None:
    simulation = Simulation(scene)
    velocity = simulation.array("particle.velocity").copy()
    velocity[:, 1] = 0.7
    simulation.arrays["particle.velocity"].assign(velocity)
    start = simulation.array("particle.position").copy()
    simulation.advance(20)
    np.testing.assert_allclose(simulation.array("particle.velocity")[:, 1], 0.7, rtol=1e-12)
    risen = simulation.array("particle.position") - start
    np.testing.assert_allclose(risen[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(risen[:, 1], 0.7 * simulation.time, rtol=1e-9)
    np.testing.assert_allclose(simulation.array("particle.stress"), 0.0, atol=1e-7)


def test_a_node_with_hardly_any_mass_is_accelerated_as_if_half_full(scene: Scene) -> None:
    """All particles but a speck of mass are gone from one cell; its stress still pulls."""
    simulation = Simulation(scene)
    stress = simulation.array("particle.stress").copy()
    stress[:, :2] = 1e3
    mass = simulation.array("particle.mass").copy()
    mass[(simulation.array("particle.cell") == [0, 0]).all(axis=1)] *= 1e-9
    simulation.arrays["particle.stress"].assign(stress)
    simulation.arrays["particle.mass"].assign(mass)
    simulation.advance(1)
    grid, step = scene.grid, simulation.plan.time_step
    pull = 1e3 * np.abs(grid.gradient_integrals[0, 0, :2]).sum()
    bound = step * pull / (0.5 * ELASTIC.density * grid.node_volumes[0])
    assert 0.0 < np.abs(simulation.array("node.motion")[0, :2]).max() <= bound


def test_momentum_along_the_axis_is_kept_while_waves_run(scene: Scene) -> None:
    simulation = Simulation(scene)
    random = np.random.default_rng(2)
    velocity = random.normal(size=simulation.array("particle.velocity").shape)
    simulation.arrays["particle.velocity"].assign(velocity)
    mass = simulation.array("particle.mass")
    before = mass @ velocity[:, 1]
    simulation.advance(50)
    after = mass @ simulation.array("particle.velocity")[:, 1]
    assert after == pytest.approx(before, abs=1e-12 * mass.sum())


def test_spin_turns_the_stress_by_its_angle(scene: Scene) -> None:
    """A rotation of the grid's velocity in the (r, z) plane, far from the axis: no hoop strain."""
    far = dataclasses.replace(
        scene.grid,
        columns=np.linspace(0.0, 1.0, 7),
        rows=np.linspace(0.0, 1.4, 7),
        surface_radius=np.full(7, 1e6),
        outer_radius=1e6 + 1.0,
    )
    # A step so short that the stress does not accelerate the soil by much beside its spin.
    simulation = Simulation(dataclasses.replace(scene, grid=far, time_step_fraction=1e-4))
    stress = np.zeros_like(simulation.array("particle.stress"))
    stress[:] = [3e4, -1e4, 5e3, 2e3]
    simulation.arrays["particle.stress"].assign(stress)
    spin = 1e-3 / simulation.plan.time_step
    centre = np.array([1e6 + 0.5, 0.7])
    velocity = (simulation.array("particle.position") - centre) @ np.array([[0, -spin], [spin, 0]])
    simulation.arrays["particle.velocity"].assign(velocity)
    simulation.advance(1)
    cell = simulation.array("particle.cell")
    amid = ((cell > 0) & (cell < 5)).all(axis=1)  # a linear field arrives where soil is all around
    after = simulation.array("particle.stress")[amid].mean(axis=0)
    # d sigma_rr = 2 W_rz sigma_rz dt, d sigma_rz = W_rz (sigma_zz - sigma_rr) dt
    angle = 1e-3
    assert after[0] - 3e4 == pytest.approx(2.0 * angle * 5e3, rel=1e-2)
    assert after[1] + 1e4 == pytest.approx(-2.0 * angle * 5e3, rel=1e-2)
    assert after[2] - 5e3 == pytest.approx(angle * (-1e4 - 3e4), rel=1e-2)


def test_undisturbed_soil_in_the_window_stays_exactly_at_rest() -> None:
    """Without a penetrometer nothing happens, however far the window travels."""
    scene, _ = CONE.build()
    grid = dataclasses.replace(scene.grid, surface_radius=np.zeros_like(scene.grid.surface_radius))
    empty = dataclasses.replace(scene, grid=grid, contact=None, fixed=Fixed.axis_and_ends(grid))
    simulation = Simulation(empty)
    count = simulation.particle_count
    Travel(simulation).advance_to(0.5 * CONE.cone_radius)
    assert np.abs(simulation.array("particle.velocity")).max() == 0.0
    assert np.abs(simulation.array("particle.stress")).max() == 0.0
    layer = simulation.plan.arrays["layer.mass"].shape[0]
    inside = simulation.array("particle.cell")[:, 0] >= 0
    assert abs(inside.sum() - count) <= layer
    # What entered carries on the lattice of what was there: layers at equal distances.
    heights = np.sort(simulation.array("particle.position")[inside, 1]).reshape(-1, layer)
    spacing = (grid.rows[1] - grid.rows[0]) / scene.particles_per_side
    np.testing.assert_allclose(np.diff(heights.mean(axis=1)), spacing, rtol=1e-9)


def test_the_far_field_pushes_back_like_an_elastic_cavity() -> None:
    """From rest: m dv / dt = - k u - c v with the dashpot implicit, to rounding."""
    scene, _ = CONE.build()
    far = scene.far_field
    assert far is not None
    simulation = Simulation(scene)
    pushed = 1e-3 * np.linspace(1.0, 2.0, len(far.nodes))
    simulation.arrays["far_field.displacement"].assign(pushed)
    simulation.advance(1)
    mass, step = simulation.array("node.mass")[far.nodes], simulation.plan.time_step
    expected = -step * far.spring * pushed / (mass + step * far.dashpot[:, 0])
    np.testing.assert_allclose(simulation.array("node.motion")[far.nodes, 0], expected, rtol=1e-12)
    moved = simulation.array("far_field.displacement") - pushed
    np.testing.assert_allclose(moved, step * expected, rtol=1e-9)


def test_the_springs_of_the_far_field_rise_with_the_soil() -> None:
    """After a row of travel each spring is one row higher, and the lowest is undisturbed."""
    scene, _ = CONE.build()
    # Springs without stiffness, in soil at rest: nothing else changes their displacement.
    grid = dataclasses.replace(scene.grid, surface_radius=np.zeros_like(scene.grid.surface_radius))
    assert scene.far_field is not None
    limp = dataclasses.replace(scene.far_field, spring=0.0 * scene.far_field.spring)
    fixed = Fixed.axis_and_ends(grid)
    still = dataclasses.replace(scene, grid=grid, contact=None, fixed=fixed, far_field=limp)
    simulation = Simulation(still)
    count = simulation.array("far_field.displacement").shape[0]
    simulation.arrays["far_field.displacement"].assign(np.arange(1.0, count + 1.0))
    Travel(simulation).advance_to(float(grid.rows[1] - grid.rows[0]))
    np.testing.assert_array_equal(
        simulation.array("far_field.displacement"), np.arange(float(count))
    )


def test_the_same_scene_gives_the_same_bits() -> None:
    stresses = []
    for _ in range(2):
        simulation = Simulation(CONE.build()[0])
        Travel(simulation).advance_to(0.3 * CONE.cone_radius)
        stresses.append(simulation.array("particle.stress").copy())
    np.testing.assert_array_equal(*stresses)


def test_strength_bounds_the_stress_of_every_particle() -> None:
    scene, _ = CONE.build()
    assert isinstance(scene.material, Tresca)
    simulation = Simulation(scene)
    Travel(simulation).advance_to(CONE.cone_radius)
    stress = simulation.array("particle.stress")
    centre = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    principal = np.stack([centre - radius, centre + radius, stress[:, 3]])
    assert np.ptp(principal, axis=0).max() <= 2.0 * scene.material.strength * (1.0 + 1e-9)


def test_a_cell_at_the_surface_of_the_ground_bears_stress_as_far_as_it_is_filled() -> None:
    scene = ConeSelfSimilar(cells_per_radius=4).simulated_scene()
    assert isinstance(scene.grid, GroundGrid)
    row = int(np.searchsorted(scene.grid.rows, -1.0))
    half_up = 0.5 * (scene.grid.rows[row] + scene.grid.rows[row + 1])
    ground = dataclasses.replace(scene.grid, ground_level=half_up)
    simulation = Simulation(dataclasses.replace(scene, grid=ground, bulk_viscosity=None))
    simulation.array("particle.stress")[:] = [-3.0, -2.0, 1.0, -2.5]
    simulation.advance(1)
    stress = simulation.array("cell.stress").reshape(ground.row_count, -1, 4)
    whole, half, none = (stress[it, ground.column_count // 2] for it in (row - 1, row, row + 1))
    np.testing.assert_allclose(whole, [-3.0, -2.0, 1.0, -2.5], rtol=1e-12)
    # The lower half of a cell with vertical sides is half of its volume.
    np.testing.assert_allclose(half, 0.5 * whole, rtol=1e-9)
    np.testing.assert_array_equal(none, 0.0)
