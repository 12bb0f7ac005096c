"""Cavity expansion: the closed form, the grid that follows the wall, and the two together."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpm_warp.scenes.cavity_cylinder import CavityCylinder
from mpm_warp.scenes.cavity_sphere import CavitySphere

from mpm_warp.grid.fitted import Grid
from mpm_warp.simulation import Simulation

RADII = np.array([1.01, 1.05, 1.1, 1.2, 1.5, 2.0, 4.0])


@pytest.mark.parametrize(
    ("rigidity_index", "pressures"),
    [
        (100.0, [1.681, 3.232, 3.856, 4.422, 5.020, 5.320, 5.543]),
        (500.0, [3.288, 4.840, 5.464, 6.029, 6.627, 6.927, 7.151]),
    ],
)
def test_closed_form_has_its_tabulated_values(
    rigidity_index: float, pressures: list[float]
) -> None:
    computed = CavityCylinder(rigidity_index=rigidity_index).exact(RADII)
    np.testing.assert_allclose(computed, pressures, atol=5e-4)  # given to three decimals


def test_the_grid_that_followed_the_wall_is_the_grid_around_it() -> None:
    """Integrals and volumes brought up to date on the device are those of a new grid."""
    scene = CavityCylinder(cells_per_radius=2, rigidity_index=10.0).simulated_scene()
    simulation = Simulation(scene)
    simulation.advance(2000)
    radius = simulation.array("wall.motion")[:, 2]
    assert radius[0] > 1.0
    grid = Grid(
        columns=scene.grid.columns,
        rows=scene.grid.rows,
        surface_radius=radius.copy(),
        outer_radius=scene.grid.outer_radius,
    )
    integrals = simulation.array("cell.integrals")
    np.testing.assert_allclose(integrals, grid.gradient_integrals, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(simulation.array("cell.volume"), grid.cell_volumes, rtol=1e-9)


@pytest.mark.parametrize(
    ("rigidity_index", "material"), [(50.0, "tresca"), (100.0, "tresca"), (50.0, "von_mises")]
)
def test_pressure_follows_the_closed_form(rigidity_index: float, material: str) -> None:
    cells = 4
    scene = CavityCylinder(rigidity_index=rigidity_index, material=material, cells_per_radius=cells)
    result = scene.run()
    # Beside the wall the stress falls by 2 su per radius: that of half a cell, over the limit.
    limit = 1.0 + math.log(rigidity_index)
    assert float(result["error"]) <= 2.0 / (2 * cells) / limit
    # At the end the cavity is four times as wide, and the half cell with it a quarter as much.
    last = float(result["cavity_pressure"][-1] - result["cavity_pressure_exact"][-1])
    assert abs(last) <= 2.0 / (2 * cells) / 4.0


def test_around_a_sphere_von_mises_yields_at_less_than_tresca() -> None:
    """As soil of Tresca with sqrt(3)/2 of the strength, and of that rigidity index."""
    von_mises = CavitySphere(rigidity_index=100.0, material="von_mises").exact(RADII)
    weaker = CavitySphere(rigidity_index=100.0 / math.sqrt(0.75)).exact(RADII)
    np.testing.assert_allclose(von_mises, math.sqrt(0.75) * weaker, rtol=1e-12)
