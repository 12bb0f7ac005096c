"""What a point carries beside the velocity of the soil is bounded where the grid travels."""

import numpy as np

from mpm_warp.parts.velocity_bound import OVER_WINDOW, VELOCITY_BOUND
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation


def test_a_point_is_at_most_as_much_faster_than_the_soil_as_the_bound(cone: Scene) -> None:
    """The soil moves as a whole; points have velocities of their own, below and above the bound."""
    simulation = Simulation(cone)
    of_soil = np.array([0.3, -0.7])
    simulation.array("node.velocities")[:, :2] = of_soil
    present = simulation.array("particle.cell")[:, 0] >= 0
    bound = OVER_WINDOW * cone[Window].first_speed
    angle = np.linspace(0.0, 6.0, present.sum())
    excess = np.linspace(0.0, 2.0 * bound, present.sum())
    of_points = of_soil + excess[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    velocity = simulation.array("particle.velocity")
    velocity[present] = of_points
    velocity[~present] = 1e3 * bound
    simulation.launch(simulation.plan.between_steps[VELOCITY_BOUND])
    within = excess < 0.999 * bound
    np.testing.assert_array_equal(velocity[present][within], of_points[within])
    direction = (of_points - of_soil)[~within] / excess[~within, None]
    beyond = velocity[present][excess > bound] - of_soil
    np.testing.assert_allclose(beyond, bound * direction[-len(beyond) :], atol=1e-12 * bound)
    assert (velocity[~present] == 1e3 * bound).all()


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
