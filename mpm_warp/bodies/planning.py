"""From bodies in contact to the plan of their run: the order of the stages, and nothing else.

Arrays over "field" have a row for each body and a column for each node.
"""

from __future__ import annotations

from mpm_warp.arguments import FROM_ONE, check_whole
from mpm_warp.bodies.body import add_particles
from mpm_warp.bodies.contact import add_clear_surfaces
from mpm_warp.bodies.loads import add_clock, add_loads
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.bodies.transfers import add_body_to_grid, add_grid_to_body
from mpm_warp.plan.plan import Plan
from mpm_warp.plan.time_step import TimeStepControl
from mpm_warp.planning import make_plan
from mpm_warp.precision import FLOAT64


@make_plan.register
def make_body_plan(scene: BodyScene, share_count: int = 1, time_step: float | None = None) -> Plan:
    """The plan of a run of `scene`, complete.

    Args:
        scene: what to run.
        share_count: not used: no launch over bodies is split into shares.
        time_step: length of a step [s], > 0; default: the scene's fraction of the critical one.
    """
    check_whole("share_count", share_count, FROM_ONE)
    critical_time_step = scene.critical_time_step()
    if time_step is None:
        time_step = scene.time_step_fraction * critical_time_step
    plan = Plan(
        precision=FLOAT64,
        time_step=time_step,
        longest_time_step=max(1.0, scene.time_step_fraction) * critical_time_step,
        speed_limit=max(body.material.pressure_wave_speed for body in scene.bodies),
        particle_bounds=scene.grid.particle_bounds,
        control=TimeStepControl(
            first=scene.time_step_fraction * critical_time_step,
            fraction=scene.time_step_fraction,
            critical=lambda array: scene.critical_time_step(array("particle.volume")),
        ),
        remedy="try a smaller time_step_fraction, or a wider grid where a body has left it",
    )
    add_particles(plan, scene.bodies)
    if scene.loads:
        add_loads(plan, scene.loads)
    add_body_to_grid(plan, scene)
    for index, contact in enumerate(scene.contacts):
        contact.add_to(plan, index, scene.bodies, scene.grid)
    if scene.contacts:
        add_clear_surfaces(plan)
    add_grid_to_body(plan, scene)
    if scene.loads:
        add_clock(plan)
    return plan
