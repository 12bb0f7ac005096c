"""What particles take from the grid: velocity, position, and a stress that turns and yields."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.materials.tresca import Tresca
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


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
