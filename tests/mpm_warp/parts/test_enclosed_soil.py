"""Soil around a cell that no point is in: its pressure follows its volume, and it is no hole."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.materials.elasticity import Isotropic
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.enclosed_soil import EnclosedSoil
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def empty(simulation: Simulation, column: int, row: int) -> None:
    """Give the points of a cell to the next one."""
    cell = simulation.array("particle.cell")
    cell[(cell == [column, row]).all(axis=1)] = [column + 1, row]


def test_a_cell_without_points_bears_a_pressure_that_follows_its_volume(floating: Scene) -> None:
    """And no shear; one with points has their mean stress as ever."""
    soil, stress = floating.material, np.array([-3.0, -2.0, 1.0, -2.5])
    assert isinstance(soil, Isotropic)
    simulation = Simulation(floating.with_parts(EnclosedSoil()))
    strain = np.array([0.3, -0.2, 7.0, 0.1])
    for _ in range(2):
        simulation.array("particle.stress")[:] = stress
        simulation.array("cell.motion")[:, :4] = strain
        simulation.advance(1)
        empty(simulation, 1, 1)
    cells = simulation.array("cell.stress").reshape(floating.grid.row_count, -1, 4)
    mean = stress[[0, 1, 3]].mean() + soil.bulk_modulus * strain[[0, 1, 3]].sum()
    np.testing.assert_allclose(cells[1, 1], mean * np.array([1.0, 1.0, 0.0, 1.0]), rtol=1e-12)
    np.testing.assert_allclose(cells[0, 1], stress, rtol=1e-12)


def test_a_surface_that_has_no_soil_beside_it_moves_with_the_body(cone: Scene) -> None:
    """Along its normal, at each node; without the part such a node stays where it is."""
    contact, speed = dataclasses.replace(cone[SurfaceContact], speed=2.0), 2.0
    bare = len(contact.nodes) // 2
    row = int(contact.nodes[bare]) // (cone.grid.column_count + 1)
    for parts, into_body in (((contact, EnclosedSoil()), 0.0), ((contact,), 1.0)):
        simulation = Simulation(dataclasses.replace(cone, parts=parts, time_step_fraction=1e-6))
        empty(simulation, 0, row - 1)
        empty(simulation, 0, row)
        simulation.advance(1)
        assert simulation.array("node.mass")[contact.nodes[bare]] == 0.0
        past = simulation.array("node.velocities")[contact.nodes[bare], :2] + [0.0, speed]
        expected = into_body * speed * contact.normals[bare, 1]
        assert past @ contact.normals[bare] == pytest.approx(expected, abs=1e-12)
        assert contact.normals[bare, 1] > 0.1
        np.testing.assert_array_equal(simulation.array("contact.impulse")[bare], 0.0)
