"""Particles at the start, and slots that hold none."""

import dataclasses
import itertools

import numpy as np

from mpm_warp.parts.window import Window
from mpm_warp.plan.launch import share_bounds
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def test_particles_start_at_rest_without_stress_with_the_mass_of_the_soil(floating: Scene) -> None:
    simulation = Simulation(floating)
    assert np.all(simulation.array("particle.velocity") == 0.0)
    assert np.all(simulation.array("particle.stress") == 0.0)
    mass = floating.material.density * floating.grid.cell_volumes.sum()
    np.testing.assert_allclose(simulation.array("particle.mass").sum(), mass, rtol=1e-12)


def test_every_share_has_as_many_particles_and_as_many_empty_slots(cone: Scene) -> None:
    """The empty ones at its end, outside every cell and without mass."""
    plan = make_plan(cone)
    cell, mass = (plan.arrays[f"particle.{name}"].initial for name in ("cell", "mass"))
    assert cell is not None
    assert mass is not None
    empty = cell[:, 0] < 0
    assert empty.sum() == round(cone[Window].spare_fraction * plan.particle_count)
    np.testing.assert_array_equal(cell[empty], -1)
    np.testing.assert_array_equal(mass[empty], 0.0)
    bounds = share_bounds(len(cell), plan.share_count)
    taken = [np.count_nonzero(~empty[a:b]) for a, b in itertools.pairwise(bounds)]
    assert np.ptp(taken) <= 1
    for first, count in zip(bounds, taken, strict=False):
        assert not empty[first : first + count].any()


def test_a_scene_without_a_window_has_no_slot_to_spare(floating: Scene) -> None:
    plan = make_plan(dataclasses.replace(floating, particles_per_side=3))
    assert plan.particle_count == 9 * floating.grid.cell_count
    assert plan.arrays["particle.mass"].shape == (plan.particle_count,)
