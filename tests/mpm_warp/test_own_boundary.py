"""A boundary is one file: one that only this file knows, in the scene of a cone."""

import dataclasses

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import one, real, vec4
from mpm_warp.parts.boundaries import FarField
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.planning import make_plan
from mpm_warp.scene import Part, Scene
from mpm_warp.simulation import Simulation

TRAVEL = 1.5


@dataclasses.dataclass(frozen=True)
class ViscousSide(Part):
    """Dashpots along the outer side, stiffer with depth: v <- v / (1 + dt c (1 + travel)).

    Attributes:
        rate: c [1/s], >= 0.
    """

    rate: float

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        grid = scene.grid
        nodes = grid.node(grid.column_count, np.arange(grid.row_count + 1))
        plan.add_array("side.nodes", "int", nodes, (grid.node_count,))
        plan.add_array("side.rate", "real", np.full(len(nodes), self.rate))
        plan.add_launch(viscous_side, len(nodes))

    def follow(self, run: Run, scene: Scene, travel: float, *, by_a_row: bool) -> None:
        run.assign("side.rate", self.rate * (1.0 + travel))


@wp.kernel(module="tests.viscous_side", enable_backward=False)
def viscous_side(
    offset: int,
    side_nodes: wp.array(dtype=int),
    side_rate: wp.array(dtype=real),
    time_step: real,
    node_velocities: wp.array(dtype=vec4),
):
    k = offset + wp.tid()
    v = node_velocities[side_nodes[k]]
    slowed = one + time_step * side_rate[k]
    node_velocities[side_nodes[k]] = vec4(v[0] / slowed, v[1] / slowed, v[2], v[3])


@pytest.fixture
def open_side(cone: Scene) -> Scene:
    """The cone without a far field: nothing is at the side."""
    return cone.without(FarField)


def after(scene: Scene) -> tuple[Simulation, Floats]:
    simulation = Simulation(scene)
    simulation.travel_to(TRAVEL)
    simulation.check()
    return simulation, simulation.array("particle.stress").copy()


def test_it_adds_its_own_arrays_and_one_launch_in_its_place(open_side: Scene) -> None:
    """Before the contact, though it is the last of the parts; all else is what it was."""
    before, plan = make_plan(open_side), make_plan(open_side.with_parts(ViscousSide(1.0)))
    assert set(plan.arrays) - set(before.arrays) == {"side.nodes", "side.rate"}
    names, added = ([it.name for it in each.step] for each in (before, plan))
    place = names.index("surface_contact")
    assert added == [*names[:place], "viscous_side", *names[place:]]
    assert len(plan.audited_step) == len(before.audited_step) + 1
    assert plan.between_steps.keys() == before.between_steps.keys()


def test_it_acts_and_follows_the_window(open_side: Scene) -> None:
    """With dashpots of no strength not a bit of the result is another."""
    _, expected = after(open_side)
    _, without_effect = after(open_side.with_parts(ViscousSide(0.0)))
    np.testing.assert_array_equal(without_effect, expected)
    simulation, slowed = after(open_side.with_parts(ViscousSide(1e4)))
    assert np.abs(slowed - expected).max() > 1.0
    rate = simulation.array("side.rate")
    assert np.all(rate == rate[0])
    layer = float(np.diff(open_side.grid.rows)[0]) / open_side.particles_per_side
    assert TRAVEL - layer <= rate[0] / 1e4 - 1.0 <= TRAVEL + layer
