"""From a scene to its plan: the order of the stages of a step, and which parts add to each.

Nothing else is decided here. A part that a scene does not have has no array and no launch.
"""

from __future__ import annotations

import functools

from mpm_warp.materials.yield_check import add_yield_check
from mpm_warp.materials.yield_share import add_yield_share
from mpm_warp.parts.boundaries.moving_wall import crossing_time
from mpm_warp.parts.contact.strength_beside import add_strength_beside
from mpm_warp.parts.records.energy_audit import add_energy_audit
from mpm_warp.parts.records.energy_balance import add_energy_balance
from mpm_warp.parts.records.history import add_origin
from mpm_warp.parts.records.plastic_strain import add_plastic_strain, add_plastic_strain_audit
from mpm_warp.parts.velocity_interpolation import add_velocity_interpolation
from mpm_warp.parts.window.cyclic_window import CyclicWindow
from mpm_warp.parts.window.inflow import add_inflow
from mpm_warp.parts.window.resting_ground import add_ground_below, add_resting_ground
from mpm_warp.parts.window.window import Window, add_window_motion
from mpm_warp.plan.plan import Plan
from mpm_warp.plan.time_step import TimeStepControl
from mpm_warp.precision import PRECISIONS
from mpm_warp.scene import Scene
from mpm_warp.step.cell_rates import add_cell_rates
from mpm_warp.step.cell_stress import add_cell_stress
from mpm_warp.step.grid_to_particles import add_grid_to_particles
from mpm_warp.step.momentum import add_momentum
from mpm_warp.step.particles_to_grid import add_particles_to_grid
from mpm_warp.step.points import add_points

SHARE_COUNT = 4
"""Shares of a launch on processors: as many threads may take part in a step."""


@functools.singledispatch
def make_plan(
    scene: object, share_count: int = SHARE_COUNT, time_step: float | None = None
) -> Plan:
    """The plan of a run, complete. Other kinds of scenes than soil in a grid register their own.

    Args:
        scene: what to run.
        share_count: into how many shares its launches are split, >= 1.
        time_step: length of a step [s], > 0; default: the scene's fraction of the critical one.

    Raises:
        SceneError: a value is not allowed.
        TypeError: nobody has said how such a scene is planned.
    """
    raise TypeError(f"a {type(scene).__name__} cannot be planned")


@make_plan.register
def make_soil_plan(
    scene: Scene, share_count: int = SHARE_COUNT, time_step: float | None = None
) -> Plan:
    """The plan of a run of soil in a grid; the arguments are those of `make_plan`."""
    grid, material, window = scene.grid, scene.material, scene.window
    plan = _empty_plan(scene, share_count, time_step)
    add_points(
        plan,
        grid,
        material,
        particles_per_side=scene.particles_per_side,
        spare_fraction=0.0 if window is None else window.spare_fraction_in(grid),
        stress_at=scene.stress_at_rest_at,
    )
    if isinstance(window, CyclicWindow):
        add_ground_below(plan, scene)
    if scene.history:
        add_origin(plan)
        add_plastic_strain(plan)
    if window is not None:
        add_window_motion(plan)
    interpolation = (
        add_velocity_interpolation(plan, grid) if scene.conservative_interpolation else None
    )
    add_particles_to_grid(plan, grid, has_empty_slots=window is not None)
    add_cell_stress(
        plan, grid, material, bulk_viscosity=scene.bulk_viscosity, free_surface=scene.free_surface
    )
    add_momentum(plan, grid, material, corrected=scene.has_mass_matrix_correction)
    for part in scene.node_actions:
        part.add_to(plan, scene)
    if scene.moving_wall is not None:
        scene.moving_wall.add_push(plan, scene)
    add_cell_rates(
        plan,
        grid,
        material,
        particles_per_side=scene.particles_per_side,
        internal_flow=None if interpolation is None else interpolation.of_cell,
    )
    add_grid_to_particles(
        plan,
        grid,
        material,
        flow_displacement=None if interpolation is None else interpolation.displacement,
        window_top=None if window is None else window.top(scene),
    )
    if scene.moving_wall is not None:
        scene.moving_wall.add_motion(plan, scene)
    if window is not None:
        _add_travel(plan, scene, window)
    if scene.energy_audit:
        add_energy_audit(plan, grid)
    if scene.energy_balance:
        add_energy_balance(plan, grid, material)
    if scene.contact is not None:
        add_strength_beside(plan, scene, scene.contact)
    add_yield_check(plan, material)
    if scene.history:
        add_plastic_strain_audit(plan, grid, material)
        add_yield_share(plan, material)
    return plan


def _add_travel(plan: Plan, scene: Scene, window: Window | CyclicWindow) -> None:
    """Add what moves the grid through the soil, and how soil comes in and goes."""
    if isinstance(window, CyclicWindow):
        add_resting_ground(plan, scene)
        window.add_to(plan)
    else:
        window.add_to(plan)
        add_inflow(plan, scene)


def _empty_plan(scene: Scene, share_count: int, time_step: float | None) -> Plan:
    """The plan without arrays and launches: its time step and limits."""
    wave_speed = scene.material.pressure_wave_speed
    # Soil carries its waves along.
    flow_speed = 0.0 if scene.window is None else scene.window.first_speed
    critical_time_step = float(scene.grid.cell_lengths.min()) / (wave_speed + flow_speed)
    if time_step is None:
        time_step = scene.time_step_fraction * critical_time_step
    plan = Plan(
        precision=PRECISIONS[scene.precision],
        share_count=share_count,
        time_step=time_step,
        longest_time_step=max(1.0, scene.time_step_fraction) * critical_time_step,
        speed_limit=wave_speed,
        particle_bounds=scene.grid.particle_bounds,
    )
    if scene.moving_wall is not None:
        plan.control = TimeStepControl(
            first=plan.time_step,
            fraction=scene.time_step_fraction,
            critical=lambda array: crossing_time(array, scene.material),
            replan=lambda time_step: make_soil_plan(scene, share_count, time_step),
        )
    return plan
