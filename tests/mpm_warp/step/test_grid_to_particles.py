"""What particles take from the grid: velocity, position, and a stress that turns and yields."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.materials.tresca import Tresca
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation
from mpm_warp.step.grid_to_particles import EXCESS_OVER_WINDOW


def test_a_rigid_motion_along_the_axis_leaves_no_stress_and_keeps_momentum(floating: Scene) -> None:
    simulation = Simulation(floating)
    simulation.array("particle.velocity")[:, 1] = 0.7
    start = simulation.array("particle.position").copy()
    simulation.advance(20)
    np.testing.assert_allclose(simulation.array("particle.velocity")[:, 1], 0.7, rtol=1e-12)
    risen = simulation.array("particle.position") - start
    np.testing.assert_allclose(risen[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(risen[:, 1], 0.7 * simulation.time, rtol=1e-9)
    np.testing.assert_allclose(simulation.array("particle.stress"), 0.0, atol=1e-7)


def test_spin_turns_the_stress_by_its_angle(floating: Scene) -> None:
    """A rotation of the grid's velocity in the (r, z) plane, far from the axis: no hoop strain."""
    far = dataclasses.replace(
        floating.grid,
        columns=np.linspace(0.0, 1.0, 7),
        rows=np.linspace(0.0, 1.4, 7),
        surface_radius=np.full(7, 1e6),
        fitted_radius=1e6 + 1.0,
    )
    # A step so short that the stress does not accelerate the soil by much beside its spin.
    simulation = Simulation(dataclasses.replace(floating, grid=far, time_step_fraction=1e-4))
    simulation.array("particle.stress")[:] = [3e4, -1e4, 5e3, 2e3]
    spin = 1e-3 / simulation.plan.time_step
    centre = np.array([1e6 + 0.5, 0.7])
    velocity = (simulation.array("particle.position") - centre) @ np.array([[0, -spin], [spin, 0]])
    simulation.assign("particle.velocity", velocity)
    simulation.advance(1)
    cell = simulation.array("particle.cell")
    amid = ((cell > 0) & (cell < 5)).all(axis=1)  # a linear field arrives where soil is all around
    after = simulation.array("particle.stress")[amid].mean(axis=0)
    # d sigma_rr = 2 W_rz sigma_rz dt, d sigma_rz = W_rz (sigma_zz - sigma_rr) dt
    angle = 1e-3
    assert after[0] - 3e4 == pytest.approx(2.0 * angle * 5e3, rel=1e-2)
    assert after[1] + 1e4 == pytest.approx(-2.0 * angle * 5e3, rel=1e-2)
    assert after[2] - 5e3 == pytest.approx(angle * (-1e4 - 3e4), rel=1e-2)


def test_strength_bounds_the_stress_of_every_particle(cone: Scene) -> None:
    assert isinstance(cone.material, Tresca)
    simulation = Simulation(cone)
    simulation.travel_to(1.0)
    stress = simulation.array("particle.stress")
    centre = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    principal = np.stack([centre - radius, centre + radius, stress[:, 3]])
    assert np.ptp(principal, axis=0).max() <= 2.0 * cone.material.strength * (1.0 + 1e-9)
    assert np.ptp(principal, axis=0).max() >= 2.0 * cone.material.strength * (1.0 - 1e-9)


@pytest.mark.parametrize("share", [0.5, 3.0])
def test_a_point_is_not_faster_than_the_soil_at_it_by_more_than_the_bound(
    cone: Scene, share: float
) -> None:
    """One point has a velocity of its own, at the bound times `share`; it moves with the soil."""
    parts = tuple(part for part in cone.parts if not isinstance(part, ConservativeInterpolation))
    simulation = Simulation(dataclasses.replace(cone, parts=parts))
    simulation.travel_to(0.2)
    bound = EXCESS_OVER_WINDOW * cone[Window].first_speed
    point = np.flatnonzero(simulation.array("particle.cell")[:, 0] == 2)[20]
    velocity = simulation.array("particle.velocity")
    velocity[point] = [0.0, share * bound]
    before = simulation.array("particle.position")[point].copy()
    rise = simulation.array("window.motion")[1]
    simulation.advance(1)
    moved = simulation.array("particle.position")[point] - before
    of_soil = moved / simulation.plan.time_step - [0.0, rise]
    excess = np.linalg.norm(simulation.array("particle.velocity")[point] - of_soil)
    if share > 1.0:
        assert excess == pytest.approx(bound, rel=1e-9)
    else:
        assert 0.3 * bound < excess < bound


def test_no_point_at_the_tip_outruns_waves_where_a_cone_is_fast_in_soft_soil() -> None:
    """Ir 7.7 at 0.42 of the shear wave's speed: without the bound a point reaches the wave's."""
    test = ConePenetration(
        rigidity_index=7.7,
        poissons_ratio=0.04,
        adhesion_factor=0.4,
        friction_coefficient=0.67,
        in_situ_stress=0.0,
        speed_ratio=0.42,
        time_step_fraction=0.26,
        particles_per_cell=16,
        cells_per_radius=1.38,
        domain_radius=20,
        domain_above=10.9,
        domain_below=8.9,
        penetration=12,
        steady_tolerance=0,
    )
    assert float(test.run().cone_factor) > 0.0
