"""From a scene to its plan: the one place that decides what a run needs, and leaves out the rest.

The functions below stand in the order of the step. Each adds the arrays that its stage is the first
to use, and its launch. What not every scene has stands in the files `planning_*.py`.
"""

from __future__ import annotations

import functools

import numpy as np

from mpm_warp.parts.even_flow import even_flow_weights
from mpm_warp.step.consistent_mass import make_consistent_mass
from mpm_warp.step.grid_to_particles import make_grid_to_particles
from mpm_warp.step.grid_update import make_cell_rates, make_cell_stress, make_node_update
from mpm_warp.step.particles_to_grid import make_particles_to_grid
from mpm_warp.precision import PRECISIONS
from mpm_warp.materials.yielding import make_yielding
from mpm_warp.materials.materials import PerfectlyPlastic
from mpm_warp.grid.seeding import PARTICLE_STATE, seed_rows
from mpm_warp.plan.plan import OFFSET, ShareRow, Plan, share_bounds
from mpm_warp.planning_energy import add_energy_audit
from mpm_warp.planning_moving_wall import add_wall_motion, add_wall_push, crossing_time
from mpm_warp.planning_nodes import add_actions_on_nodes
from mpm_warp.planning_window import add_admission, add_travel
from mpm_warp.scene import Scene
from mpm_warp.plan.time_step import TimeStepControl

SHARE_COUNT = 4
"""Shares of a launch on processors: as many threads may take part in a step."""
ABSURD_SPEED = 100.0
"""Speed over that of the pressure wave beyond which a node is left out of the step."""


@functools.singledispatch
def make_plan(scene: Scene, share_count: int = SHARE_COUNT, time_step: float | None = None) -> Plan:
    """The plan of a run of `scene`, complete.

    Args:
        scene: what to run.
        share_count: into how many shares its launches are split, >= 1.
        time_step: length of a step [s]; default: the scene's fraction of the critical one.
    """
    wave_speed = scene.material.pressure_wave_speed
    # Soil carries its waves along.
    flow_speed = 0.0 if scene.window is None else scene.window.first_speed
    critical_time_step = float(scene.grid.cell_lengths.min()) / (wave_speed + flow_speed)
    plan = Plan(
        scene=scene,
        precision=PRECISIONS[scene.precision],
        share_count=share_count,
        time_step=time_step or scene.time_step_fraction * critical_time_step,
        longest_time_step=max(1.0, scene.time_step_fraction) * critical_time_step,
        speed_limit=wave_speed,
        particle_bounds=scene.grid.particle_bounds,
    )
    if scene.moving_wall is not None:
        plan.control = TimeStepControl(
            first=plan.time_step,
            fraction=scene.time_step_fraction,
            critical=lambda array: crossing_time(scene, array),
            replan=lambda time_step: make_plan(scene, share_count, time_step),
        )
    _add_particles(plan)
    if scene.window is not None:
        add_admission(plan)
    _add_particles_to_grid(plan)
    if scene.consistent_mass:
        _add_consistent_mass(plan)
    _add_cell_stress(plan)
    _add_node_update(plan)
    add_actions_on_nodes(plan)
    if scene.moving_wall is not None:
        add_wall_push(plan)
    _add_cell_rates(plan)
    _add_grid_to_particles(plan)
    if scene.moving_wall is not None:
        add_wall_motion(plan, scene.moving_wall)
    if scene.window is not None:
        add_travel(plan, scene.window)
    if scene.energy_audit:
        add_energy_audit(plan)
    return plan


def _add_particles(plan: Plan) -> None:
    scene = plan.scene
    seed = seed_rows(scene.grid, 0, scene.grid.row_count, scene.particles_per_side)
    plan.particle_count = seed.particle_count
    spare = 0
    if scene.window is not None:
        spare = round(scene.window.spare_fraction * seed.particle_count)
    places = seed.particle_count + spare
    # Spare places are at the end of each share, so that all shares have as much to do.
    bounds = share_bounds(seed.particle_count, plan.share_count)
    shift = share_bounds(places, plan.share_count) - bounds
    taken = np.arange(seed.particle_count) + np.repeat(shift[:-1], np.diff(bounds))
    # A place without a particle has the cell (-1, -1).
    position = np.full((places, 2), scene.grid.outer_radius)
    mass = np.zeros(places)
    cell = np.full((places, 2), -1, dtype=np.int32)
    position[taken] = seed.position
    mass[taken] = scene.material.density * seed.volume
    cell[taken] = seed.cell
    plan.add_array("particle.position", "vec2", position)
    plan.add_zeros("particle.velocity", "vec2", places)
    plan.add_zeros("particle.stress", "vec4", places)
    plan.add_array("particle.mass", "real", mass)
    plan.add_array("particle.cell", "vec2i", cell)


def _add_particles_to_grid(plan: Plan) -> None:
    grid = plan.scene.grid
    width = np.append(np.diff(grid.columns), 1.0)
    height = np.append(np.diff(grid.rows), 1.0)
    lean = np.append(np.diff(grid.surface_radius), 0.0)
    columns = np.stack([grid.columns, width, 1.0 / width], axis=-1)
    rows = np.stack([grid.rows, height, 1.0 / height, grid.surface_radius, lean], axis=-1)
    plan.add_array("grid.columns", "vec3", columns)
    plan.add_array("grid.rows", "vec5", rows)
    plan.add_zeros("cell.stress_sum", "vec4", (plan.share_count, grid.cell_count))
    plan.add_zeros("cell.mass", "real", (plan.share_count, grid.cell_count))
    plan.add_zeros("node.momentum", "vec4", (plan.share_count, grid.node_count))
    plan.add_launch(
        make_particles_to_grid(grid.polar, plan.scene.window is not None, plan.precision),
        plan.arrays["particle.mass"].shape,
        OFFSET,
        *PARTICLE_STATE,
        *("grid.columns", "grid.rows", grid.outer_radius, grid.column_count),
        *(ShareRow("node.momentum"), ShareRow("cell.stress_sum"), ShareRow("cell.mass")),
    )


def _add_consistent_mass(plan: Plan) -> None:
    grid = plan.scene.grid
    plan.add_launch(
        make_consistent_mass(plan.precision),
        plan.arrays["particle.mass"].shape,
        OFFSET,
        *("particle.position", "particle.mass", "particle.cell"),
        *("grid.columns", "grid.rows", grid.outer_radius, grid.column_count),
        *("node.motion", ShareRow("node.momentum")),
    )


def _add_cell_stress(plan: Plan) -> None:
    grid, material = plan.scene.grid, plan.scene.material
    plan.add_zeros("cell.stress", "vec4", grid.cell_count)
    viscosity, dilation_rate = None, None
    if plan.scene.bulk_viscosity is not None:
        impedance = material.density * material.pressure_wave_speed
        values = plan.scene.bulk_viscosity * impedance * grid.cell_lengths
        viscosity = plan.add_array("cell.viscosity", "real", values)
        dilation_rate = plan.add_zeros("cell.dilation_rate", "real", grid.cell_count)
    full_mass = None
    if plan.scene.free_surface:
        full_mass = plan.add_array("cell.full_mass", "real", material.density * grid.cell_volumes)
    plan.add_launch(
        make_cell_stress(
            plan.share_count, viscosity is not None, full_mass is not None, plan.precision
        ),
        grid.cell_count,
        OFFSET,
        *("cell.stress_sum", "cell.mass", dilation_rate, viscosity, full_mass, "cell.stress"),
    )


def _add_node_update(plan: Plan) -> None:
    grid = plan.scene.grid
    plan.add_array("cell.integrals", "vec3", grid.gradient_integrals)
    # Where a wall moves it stays that of the start.
    half_full = 0.5 * plan.scene.material.density * grid.node_volumes
    plan.add_array("node.least_mass", "real", half_full)
    plan.add_zeros("node.mass", "real", grid.node_count)
    plan.add_zeros("node.motion", "vec4", grid.node_count)
    sharpening = None
    if plan.scene.sharpened:
        sharpening = plan.add_zeros("cell.sharpening", "vec4", grid.cell_count)
    plan.add_launch(
        make_node_update(plan.share_count, sharpening is not None, plan.precision),
        (grid.row_count + 1, grid.column_count + 1),
        OFFSET,
        *("node.momentum", "cell.stress", "cell.integrals"),
        *(grid.column_count, grid.row_count, plan.time_step, "node.least_mass"),
        ABSURD_SPEED * plan.speed_limit,
        *(sharpening, "node.mass", "node.motion"),
    )


def _add_cell_rates(plan: Plan) -> None:
    grid, material = plan.scene.grid, plan.scene.material
    viscous, sharpened = plan.scene.bulk_viscosity is not None, plan.scene.sharpened
    # What smoothing takes, at the least, of second differences; per quarter of a cell's mass.
    sharpness = material.density * (1.0 - plan.scene.particles_per_side**-2.0) / 24.0
    plan.add_array("cell.volume", "real", grid.cell_volumes)
    evening = None
    if plan.scene.even_flow:
        evening = plan.add_array("cell.evening", "vec10", even_flow_weights(grid))
    plan.add_zeros("cell.step", "vec11" if plan.scene.even_flow else "vec7", grid.cell_count)
    plan.add_launch(
        make_cell_rates(viscous, sharpened, plan.scene.even_flow, plan.precision),
        grid.cell_count,
        OFFSET,
        *("node.motion", "cell.integrals", "cell.volume", grid.column_count, plan.time_step),
        *(material.shear_modulus, material.bulk_modulus),
        "cell.dilation_rate" if viscous else None,
        *(sharpness, "cell.sharpening" if sharpened else None, "cell.step"),
        evening,
    )


def _add_grid_to_particles(plan: Plan) -> None:
    scene, grid = plan.scene, plan.scene.grid
    material = scene.material
    strength = material.strength if isinstance(material, PerfectlyPlastic) else 0.0
    travelling: tuple[object, ...] = (None, 0.0)
    if scene.window is not None:
        # Half a layer stays above the top, else the mass of the nodes there could vanish.
        top = grid.rows[-1] + 0.5 * (grid.rows[-1] - grid.rows[-2]) / scene.particles_per_side
        travelling = ("window.motion", float(top))
    plan.add_launch(
        make_grid_to_particles(
            grid.polar,
            make_yielding(material, plan.precision),
            scene.even_flow,
            scene.window is not None,
            plan.precision,
        ),
        plan.arrays["particle.mass"].shape,
        OFFSET,
        *("node.motion", "cell.step", "grid.columns", "grid.rows", grid.outer_radius),
        *((grid.column_count, grid.row_count), plan.time_step),
        strength,
        *("particle.position", "particle.velocity", "particle.stress", "particle.cell"),
        *travelling,
    )
