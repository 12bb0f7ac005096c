"""Adhesion beside soil that softens or varies: that of the strength beside each node."""

import dataclasses
import math

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.variation import Variation
from mpm_warp.parts.boundaries import FarField
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

DELTA = 0.25


@pytest.fixture
def softening(cone: Scene) -> Scene:
    """The scene with clay that softens."""
    clay = EinavRandolph(
        shear_modulus=2e6,
        poissons_ratio=0.3,
        density=1700.0,
        strength=20e3,
        criterion=Tresca,
        rate_factor=0.0,
        reference_strain_rate=1.0,
        remoulded_strength_ratio=DELTA,
        ductility=10.0,
    )
    return dataclasses.replace(cone, material=clay)


def test_adhesion_follows_the_mean_strength_in_the_cells_beside_a_node(softening: Scene) -> None:
    """By mass; the points of one row of cells are remoulded, so nodes above and below mix."""
    simulation = Simulation(softening)
    row = softening.grid.row_count - 2
    cell = simulation.array("particle.cell")
    simulation.array("particle.state")[(cell[:, 0] == 0) & (cell[:, 1] == row)] = 1.0
    simulation.advance(AUDIT_INTERVAL)
    mass = simulation.array("particle.mass")
    in_row = [mass[(cell[:, 0] == 0) & (cell[:, 1] == it)].sum() for it in range(row + 2)]
    share = np.ones(len(softening[SurfaceContact].nodes))
    # Nodes are numbered upward; the last is the upper end of the last row of cells.
    share[-3] = (in_row[row - 1] + DELTA * in_row[row]) / (in_row[row - 1] + in_row[row])
    share[-2] = (DELTA * in_row[row] + in_row[row + 1]) / (in_row[row] + in_row[row + 1])
    expected = share * softening[SurfaceContact].adhesion_forces
    np.testing.assert_allclose(simulation.array("contact.adhesion"), expected, rtol=1e-12)


def test_adhesion_beside_intact_soil_is_what_was_given(softening: Scene) -> None:
    simulation = Simulation(softening)
    simulation.advance(AUDIT_INTERVAL)
    adhesion = simulation.array("contact.adhesion")
    np.testing.assert_allclose(adhesion, softening[SurfaceContact].adhesion_forces, rtol=1e-14)


def test_soil_whose_strength_stays_needs_nothing_of_it(cone: Scene) -> None:
    plan = make_plan(cone)
    assert not {"contact.first_adhesion", "contact.strength_sum"} & set(plan.arrays)
    assert "sum_of_strength" not in {launch.name for launch in plan.launches}


def test_a_surface_elsewhere_than_along_the_first_column_is_refused(softening: Scene) -> None:
    nodes = softening[SurfaceContact].nodes.copy()
    nodes[3] += 1
    elsewhere = dataclasses.replace(softening[SurfaceContact], nodes=nodes)
    with pytest.raises(SceneError, match=r"nodes\[3\] is not in the first column"):
        softening.with_parts(elsewhere)


def test_adhesion_is_that_of_the_soil_which_has_come_beside_the_surface(cone: Scene) -> None:
    """Twice as strong below the tip: after a way of two cone heights all of the face has it."""
    two = Variation(
        depth=np.zeros(2), strength_ratio=np.array([1.0, 2.0]), stiffness_ratio=np.ones(2)
    )
    soil = dataclasses.replace(cone.material, variation=two)
    simulation = Simulation(dataclasses.replace(cone.without(FarField), material=soil))
    contact = cone[SurfaceContact]
    ratio = simulation.array("contact.adhesion") / contact.adhesion_forces
    # The tip, at the very border, belongs to what is below it.
    np.testing.assert_allclose(ratio, [2.0] + [1.0] * (len(ratio) - 1))
    height = math.sqrt(3.0)
    simulation.travel_to(2.0 * height)
    ratio = simulation.array("contact.adhesion") / contact.adhesion_forces
    on_face = cone.grid.rows[cone.grid.rows >= 0.0] < height
    np.testing.assert_allclose(ratio[on_face], 2.0)
