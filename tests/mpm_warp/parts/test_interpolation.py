"""Conservative velocity interpolation: its divergence, its kernels, and what it is for."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import ConePenetration, ConservativeInterpolation, Grid, Scene, Simulation
from mpm_warp.grid.fitted import GAUSS_POINTS, Floats, bilinear
from mpm_warp.parts.interpolation import interpolation_weights
from mpm_warp.sampling import ContactForces
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from tests.mpm_warp.conftest import cells_of

DIFFERENCE = 1e-4
"""Of natural coordinates, in a difference quotient; the field is a quartic at most."""


def weights_of_nodes(grid: Grid) -> Floats:
    """What P/w, Q/w and S/h of the velocity interpolation owe to the velocities of the nodes.

    Of each cell: weights [1/m] of the radial velocities of the four nodes in the order of
    `Grid.cell_nodes`, then that of T; shape [cell_count, 5, 3].
    """
    radius, height = np.moveaxis(grid.node_positions[grid.cell_nodes], -1, 0)
    left, right = 0.5 * (radius[:, 0] + radius[:, 2]), 0.5 * (radius[:, 1] + radius[:, 3])
    middle, width, tall = 0.5 * (left + right), right - left, height[:, 2] - height[:, 0]
    rise = 0.5 * (radius[:, 2] - radius[:, 0] + radius[:, 3] - radius[:, 1])
    centroid = (0.5 * left + width / 3.0) / middle
    on_axis = left == 0.0

    first, last, along = np.zeros((3, grid.cell_count, 5))
    first[:, 4] = np.where(on_axis, 1.0 / 3.0, centroid) / tall
    last[:, 4] = (1.0 - centroid) / tall
    for side, weight in enumerate((-right, left)):
        by_left = np.divide(weight, 4.0 * middle * left, out=np.zeros_like(left), where=~on_axis)
        by_right = np.where(on_axis, 0.0, weight / (4.0 * middle * right))
        first[:, [side, side + 2]] = by_left[:, None]
        last[:, [side, side + 2]] = by_right[:, None]
    for node, (sign_xi, sign_eta) in enumerate(((-1, -1), (1, -1), (-1, 1), (1, 1))):
        twist = sign_xi * sign_eta / width
        hoop = 0.5 * sign_eta / middle - 0.25 * rise / middle**2
        along[:, node] = 0.5 * (twist + hoop)
    along[:, 4] = -0.5 * rise / (tall * width)
    return np.stack([first, last - first, along], axis=-1)


def velocity(grid: Grid, nodal: Floats, cell: Floats, xi: Floats, eta: Floats) -> Floats:
    """Velocity (r, z) at natural coordinates of cells, from that of all nodes; [count, 2]."""
    corner = nodal[grid.cell_nodes[cell]]
    shape = bilinear(xi, eta)[0]
    v = np.einsum("nc,cnk->ck", shape, corner)
    weights = weights_of_nodes(grid)[cell]
    twist = corner[:, :, 1] @ [1.0, -1.0, -1.0, 1.0]
    rates = np.einsum("cn,cnk->kc", corner[..., 0], weights[:, :4]) + twist * weights[:, 4].T
    d_xi = xi * (1 - xi) * (rates[0] + xi * rates[1])
    d_eta = eta * (1 - eta) * rates[2]
    r, z = np.moveaxis(grid.node_positions[grid.cell_nodes[cell]], -1, 0)
    r_xi = 0.5 * (r[:, 1] - r[:, 0] + r[:, 3] - r[:, 2])
    r_eta = 0.5 * (r[:, 2] - r[:, 0] + r[:, 3] - r[:, 1])
    internal = np.stack([r_xi * d_xi + r_eta * d_eta, (z[:, 2] - z[:, 0]) * d_eta], axis=-1)
    return np.asarray(v + internal)


def divergence(grid: Grid, nodal: Floats, xi: float, eta: float) -> Floats:
    """Of that velocity about the axis, in every cell of a grid of upright cells, [cell_count]."""
    cell = np.arange(grid.cell_count)

    def at(x: float, y: float) -> Floats:
        ones = np.ones(grid.cell_count)
        return velocity(grid, nodal, cell, x * ones, y * ones)

    r, z = np.moveaxis(grid.node_positions[grid.cell_nodes], -1, 0)
    d_r = (at(xi + DIFFERENCE, eta) - at(xi - DIFFERENCE, eta))[:, 0] / (2 * DIFFERENCE)
    d_z = (at(xi, eta + DIFFERENCE) - at(xi, eta - DIFFERENCE))[:, 1] / (2 * DIFFERENCE)
    radius = r[:, 0] + xi * (r[:, 1] - r[:, 0])
    hoop = at(xi, eta)[:, 0] / np.maximum(radius, 1e-12)
    return np.asarray(d_r / (r[:, 1] - r[:, 0]) + d_z / (z[:, 2] - z[:, 0]) + hoop)


def mean_divergence(grid: Grid, nodal: Floats) -> Floats:
    """Of the bilinear velocity, over each cell."""
    corner, integrals = nodal[grid.cell_nodes], grid.gradient_integrals
    flux = np.einsum("cnk,cnk->c", integrals[..., :2], corner)
    flux += np.einsum("cn,cn->c", integrals[..., 2], corner[..., 0])
    return np.asarray(flux / grid.cell_volumes)


@pytest.fixture
def nodal(rectilinear: Grid) -> Floats:
    """Any velocities of the nodes that leave the axis where it is."""
    velocities = np.random.default_rng(3).normal(size=(rectilinear.node_count, 2))
    velocities[rectilinear.node_positions[:, 0] == 0.0, 0] = 0.0
    return velocities


def test_the_divergence_is_that_of_the_cell_at_each_height_and_along_each_edge(
    rectilinear: Grid, nodal: Floats
) -> None:
    """On the axis everywhere; along an edge, so that nothing gathers at a wall."""
    mean = mean_divergence(rectilinear, nodal)
    on_axis = np.arange(rectilinear.cell_count) % rectilinear.column_count == 0
    for xi, eta in ((0.1, 0.9), (0.5, 0.2), (0.9, 0.6)):
        there = divergence(rectilinear, nodal, xi, eta)
        np.testing.assert_allclose(there[on_axis], mean[on_axis], rtol=1e-6)
    points, weights = np.polynomial.legendre.leggauss(4)
    abscissae = 0.5 + 0.5 * points
    radius = rectilinear.node_positions[rectilinear.cell_nodes, 0]
    share = weights * (radius[:, :1] + abscissae * (radius[:, 1:2] - radius[:, :1]))
    for eta in (0.1, 0.5, 0.9):
        across = np.stack([divergence(rectilinear, nodal, x, eta) for x in abscissae], axis=-1)
        at_height = np.sum(across * share, axis=-1) / share.sum(axis=-1)
        np.testing.assert_allclose(at_height, mean, rtol=1e-6)
    for edge in (0.0, 1.0):
        along = np.mean([divergence(rectilinear, nodal, edge, it) for it in GAUSS_POINTS], axis=0)
        np.testing.assert_allclose(along[~on_axis], mean[~on_axis], rtol=1e-6)


def test_particles_move_with_the_interpolated_velocity(floating: Scene, fitted: Grid) -> None:
    parts = (ConservativeInterpolation(),)
    scene = dataclasses.replace(floating, grid=fitted, particles_per_side=3, parts=parts)
    simulation = Simulation(scene)
    position = simulation.array("particle.position").copy()
    cell = cells_of(simulation)
    random = np.random.default_rng(5).normal(size=position.shape)
    simulation.assign("particle.velocity", random)
    simulation.advance(1)
    corners = fitted.node_positions[fitted.cell_nodes[cell]]
    eta = (position[:, 1] - corners[:, 0, 1]) / (corners[:, 2, 1] - corners[:, 0, 1])
    left = (1 - eta) * corners[:, 0, 0] + eta * corners[:, 2, 0]
    right = (1 - eta) * corners[:, 1, 0] + eta * corners[:, 3, 0]
    xi = (position[:, 0] - left) / (right - left)
    moved = simulation.plan.time_step * velocity(
        fitted, simulation.array("node.velocities")[:, :2], cell, xi, eta
    )
    # Elsewhere a surface may push them back.
    free = ~((cell % fitted.column_count == 0) & (xi < 0.2))
    expected = position + moved
    found = simulation.array("particle.position")
    np.testing.assert_allclose(found[free], expected[free], atol=1e-12)
    assert np.abs(moved).max() > 1e-5


def test_weights_in_plane_strain_are_those_far_from_the_axis(fitted: Grid) -> None:
    far = 1e7
    distant = dataclasses.replace(
        fitted, surface_radius=far + fitted.surface_radius, fitted_radius=far + fitted.outer_radius
    )
    planar = interpolation_weights(dataclasses.replace(fitted, planar=True))
    np.testing.assert_allclose(planar, interpolation_weights(distant), atol=10 / far)


def test_no_soil_piles_up_beside_a_rough_shaft() -> None:
    """After 160 radii no cell has more of it than an undisturbed lattice can put there.

    A box with n layers of particles to its side holds n + 1 layers at most.
    """
    cone = ConePenetration(
        friction_coefficient=1.0,
        poissons_ratio=0.2,
        cells_per_radius=1.5,
        penetration=160,
        domain_radius=20,
        domain_above=7,
        domain_below=7,
    )
    scene = cone.build()
    grid, simulation, resistance = scene.grid, Simulation(scene), []
    contact_forces = ContactForces(simulation)
    for penetration in (35, 40, 155, 160):
        simulation.travel_to(penetration * cone.cone_radius)
        forces = scene[PenetrometerContact].forces(contact_forces.take())
        resistance.append(forces.face_normal + forces.face_shear)
    present = simulation.array("particle.cell")[:, 0] >= 0
    mass = np.bincount(
        cells_of(simulation)[present],
        weights=simulation.array("particle.mass")[present],
        minlength=grid.cell_count,
    )
    filling = mass / (scene.material.density * grid.cell_volumes)
    assert filling.max() < (1 + 1 / scene.particles_per_side) ** 2
    # And it is steady: means over five radii, 120 radii apart.
    assert resistance[3] == pytest.approx(resistance[1], rel=cone.steady_tolerance)
