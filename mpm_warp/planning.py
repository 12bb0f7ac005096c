"""From a scene to its plan: the stages of a step, and the places between them at which parts act.

`mpm_warp.scene` lists these places. A stage recognises a part that it depends on by its class, or
by an array that the part adds.
"""

import functools

from mpm_warp.errors import SceneError
from mpm_warp.materials.yield_check import add_yield_check
from mpm_warp.parts.free_surface import FreeSurface, PassingSurface
from mpm_warp.parts.interpolation import (
    ConservativeInterpolation,
    conservative_flow,
    flow_displacement,
)
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene
from mpm_warp.step.cells import add_cell_rates, add_cell_stress
from mpm_warp.step.grid_to_particles import add_grid_to_particles
from mpm_warp.step.momentum import add_momentum
from mpm_warp.step.points import add_particles_to_grid, add_points

SHARE_COUNT = 4
"""Shares of a launch on processors, the greatest number of threads of a step."""


@functools.singledispatch
def make_plan(
    scene: object, share_count: int = SHARE_COUNT, time_step: float | None = None
) -> Plan:
    """The complete plan of a run. Kinds of scenes other than `Scene` register a function.

    Args:
        scene: the scene to run.
        share_count: number of shares of each launch, >= 1.
        time_step: length of a step [s], > 0; default: the scene's fraction of the critical one.

    Raises:
        SceneError: a value is not allowed.
        TypeError: there is no function for this kind of scene.
    """
    raise TypeError(f"a {type(scene).__name__} cannot be planned")


@make_plan.register
def make_soil_plan(
    scene: Scene, share_count: int = SHARE_COUNT, time_step: float | None = None
) -> Plan:
    """The plan of soil in a grid, see `make_plan`."""
    scene.material.law()  # refuses a wrong law before its wave speed is used
    grid, window = scene.grid, scene.find(MovingGrid)
    wave_speed = scene.material.pressure_wave_speed
    # Soil carries its waves along.
    flow_speed = 0.0 if window is None else window.first_speed
    critical_time_step = float(grid.cell_lengths.min()) / (wave_speed + flow_speed)
    if time_step is None:
        time_step = scene.time_step_fraction * critical_time_step
    plan = Plan(
        share_count=share_count,
        time_step=time_step,
        longest_time_step=max(1.0, scene.time_step_fraction) * critical_time_step,
        speed_limit=wave_speed,
        particle_bounds=grid.particle_bounds,
        given=grid.kernel_arguments,
    )
    interpolated = scene.find(ConservativeInterpolation) is not None
    spare_fraction = 0.0 if window is None else window.spare_fraction_in(grid)
    add_points(plan, scene, spare_fraction=spare_fraction)
    if window is not None:
        window.fill_spare_slots(plan, scene)
    for part in scene.parts:
        part.add_to_points(plan, scene)
    _check_points(plan)

    add_particles_to_grid(plan, grid, has_empty_slots=window is not None)
    add_cell_stress(plan, scene)
    add_momentum(plan, scene, corrected=has_mass_matrix_correction(scene))
    for part in scene.parts:
        part.add_forces(plan, scene)
    for part in scene.parts:
        part.add_boundary(plan, scene)
    for part in scene.parts:
        part.add_contact(plan, scene)
    add_cell_rates(plan, scene, internal_flow=conservative_flow if interpolated else None)
    add_grid_to_particles(
        plan,
        scene,
        flow_displacement=flow_displacement if interpolated else None,
        window_top=None if window is None else window.top(scene),
    )
    for part in scene.parts:
        part.add_after_motion(plan, scene)

    add_yield_check(plan, scene.material)
    for part in scene.parts:
        part.add_records(plan, scene)
    return plan


def _check_points(plan: Plan) -> None:
    """Check that arrays of particles have an entry for each slot: kernels run over all slots."""
    (slots,) = plan.arrays["particle.mass"].shape
    for name, array in plan.arrays.items():
        if name.startswith("particle.") and array.shape != (slots,):
            raise SceneError(
                f"array {name!r} has shape {array.shape}, must have ({slots},): that of "
                "'particle.mass', which counts empty slots too"
            )


def has_mass_matrix_correction(scene: Scene) -> bool:
    """Whether a scene has the mass-matrix correction, see `mpm_warp.step.momentum`.

    It is derived for full cells. It is 0 with a single particle in the middle of a cell.
    """
    surface = scene.find(FreeSurface)
    has_full_cells = surface is None or isinstance(surface, PassingSurface)
    return scene.particles_per_side > 1 and has_full_cells
