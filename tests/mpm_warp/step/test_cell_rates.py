"""The mean velocity gradient of a cell, and the stress that it gives the soil in it."""

import numpy as np

from mpm_warp.materials.elasticity import Isotropic
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def test_a_step_from_rest_has_hookes_stress(floating: Scene) -> None:
    """sigma = dt (K tr D + 2 G dev D), D the mean over the cell of the nodes' velocity."""
    simulation = Simulation(floating)
    random = np.random.default_rng(1)
    velocity = random.normal(size=simulation.array("particle.velocity").shape)
    simulation.assign("particle.velocity", velocity)
    column, row = simulation.array("particle.cell").copy().T
    simulation.advance(1)
    grid, soil = floating.grid, floating.material
    assert isinstance(soil, Isotropic)
    nodal = simulation.array("node.velocities")[grid.cell_nodes, :2]
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    integrals = (
        nodal[..., 0] * r,
        nodal[..., 1] * z,
        0.5 * (nodal[..., 0] * z + nodal[..., 1] * r),
        nodal[..., 0] * hoop,
    )
    strain = np.stack([it.sum(axis=1) / grid.cell_volumes for it in integrals], axis=-1)
    strain *= simulation.plan.time_step
    expected = 2.0 * soil.shear_modulus * strain
    mean = soil.bulk_modulus - 2.0 / 3.0 * soil.shear_modulus
    expected[:, [0, 1, 3]] += mean * strain[:, [0, 1, 3]].sum(axis=1)[:, None]
    stress = simulation.array("particle.stress")
    cell = row * grid.column_count + column
    np.testing.assert_allclose(stress, expected[cell], rtol=1e-9, atol=1e-9 * np.abs(stress).max())
