"""From a scene to its plan: the one place that decides what a run needs, and leaves out the rest.

The functions below stand in the order of the step. Each adds the arrays that its stage is the first
to use, and its launch.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpm_warp.boundaries import FarField, Fixed
from mpm_warp.contact import SurfaceContact
from mpm_warp.even_flow import even_flow_weights
from mpm_warp.grids import cell_lengths
from mpm_warp.kernels.boundaries import make_far_field, make_fixed
from mpm_warp.kernels.contact import make_surface_contact
from mpm_warp.kernels.energy import make_kinetic_energy
from mpm_warp.kernels.grid_to_particles import make_grid_to_particles
from mpm_warp.kernels.grid_update import make_cell_rates, make_cell_stress, make_node_update
from mpm_warp.kernels.loads import make_damping, make_gravity, make_nodal_load
from mpm_warp.kernels.moving_wall import (
    make_move_wall,
    make_push,
    make_refit_cells,
    make_refit_sectors,
)
from mpm_warp.kernels.particles_to_grid import make_particles_to_grid
from mpm_warp.kernels.precision import PRECISIONS
from mpm_warp.kernels.window import make_admit, make_advance_window
from mpm_warp.kernels.yielding import make_yielding
from mpm_warp.loads import NodalLoad
from mpm_warp.materials import PerfectlyPlastic
from mpm_warp.moving_wall import MovingWall
from mpm_warp.particles import seed_rows
from mpm_warp.plan import FIRST, Launch, Own, Plan, share_bounds
from mpm_warp.polar import PolarGrid
from mpm_warp.scene import Scene
from mpm_warp.time_step import TimeStepControl
from mpm_warp.window import Window

PARTICLE_STATE = (
    "particle.position",
    "particle.velocity",
    "particle.stress",
    "particle.mass",
    "particle.cell",
)

SHARE_COUNT = 4
"""Shares of a launch on processors: as many threads may take part in a step."""
ABSURD_SPEED = 100.0
"""Speed over that of the pressure wave beyond which a node is left out of the step."""


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
            critical=lambda array: _critical_time_step(scene, array),
            replan=lambda time_step: make_plan(scene, share_count, time_step),
        )
    _add_particles(plan)
    if scene.window is not None:
        _add_admission(plan, scene.window)
    _add_particles_to_grid(plan)
    _add_cell_stress(plan)
    _add_node_update(plan)
    if scene.load is not None:
        _add_load(plan, scene.load)
    if scene.gravity is not None:
        _add_gravity(plan, scene.gravity)
    if scene.damping is not None:
        _add_damping(plan, scene.damping)
    if scene.fixed is not None:
        _add_fixed(plan, scene.fixed)
    if scene.far_field is not None:
        _add_far_field(plan, scene.far_field)
    if scene.contact is not None:
        _add_contact(plan, scene.contact)
    if scene.moving_wall is not None:
        _add_push(plan)
    _add_cell_rates(plan)
    _add_grid_to_particles(plan)
    if scene.moving_wall is not None:
        _move_wall(plan, scene.moving_wall)
    if scene.window is not None:
        _advance_window(plan, scene.window)
    if scene.energy_audit:
        _add_energy_audit(plan)
    return plan


def _critical_time_step(scene: Scene, array: Callable[[str], NDArray[Any]]) -> float:
    """In which a wave crosses the shortest cell, as the wall has left them."""
    lengths = cell_lengths(array("cell.integrals"), array("cell.volume"))
    return float(lengths.min()) / scene.material.pressure_wave_speed


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
    # A place without a particle has the cell (-1, -1); its position only has to be finite.
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


def _add_admission(plan: Plan, window: Window) -> None:
    scene = plan.scene
    lowest = seed_rows(scene.grid, 0, 1, scene.particles_per_side)
    count = lowest.particle_count // scene.particles_per_side
    # A layer enters through the bottom of the grid, when it gets there.
    position = lowest.position[:count].copy()
    position[:, 1] = scene.grid.rows[0]
    plan.add_array("layer.position", "vec2", position)
    plan.add_array("layer.mass", "real", scene.material.density * lowest.volume[:count])
    plan.add_array("layer.cell", "vec2i", lowest.cell[:count])
    plan.add_zeros("window.motion", "real", 3)
    plan.add_zeros("layer.lift", "real", 1)
    plan.add_zeros("layer.places", "int", count)
    plan.admission = Launch(
        kernel=make_admit(plan.precision),
        dim=(count,),
        arguments=(
            *("layer.position", "layer.mass", "layer.cell", "layer.lift", "layer.places"),
            *PARTICLE_STATE,
        ),
    )


def _add_particles_to_grid(plan: Plan) -> None:
    grid = plan.scene.grid
    width = np.append(np.diff(grid.columns), 1.0)
    height = np.append(np.diff(grid.rows), 1.0)
    lean = np.append(np.diff(grid.surface_radius), 0.0)
    columns = np.stack([grid.columns, width, 1.0 / width], axis=-1)
    rows = np.stack([grid.rows, height, 1.0 / height, grid.surface_radius, lean], axis=-1)
    plan.add_array("grid.columns", "vec3", columns)
    plan.add_array("grid.rows", "vec5", rows)
    plan.add_zeros("cell.gradient", "mat22", grid.cell_count)
    plan.add_zeros("cell.stress_sum", "vec4", (plan.share_count, grid.cell_count))
    plan.add_zeros("cell.mass", "real", (plan.share_count, grid.cell_count))
    plan.add_zeros("node.momentum", "vec4", (plan.share_count, grid.node_count))
    plan.add_launch(
        make_particles_to_grid(grid.polar, plan.scene.window is not None, plan.precision),
        plan.arrays["particle.mass"].shape,
        FIRST,
        *PARTICLE_STATE,
        *("grid.columns", "grid.rows", grid.outer_radius, grid.column_count),
        *("cell.gradient", Own("node.momentum"), Own("cell.stress_sum"), Own("cell.mass")),
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
        FIRST,
        *("cell.stress_sum", "cell.mass", dilation_rate, viscosity, full_mass, "cell.stress"),
    )


def _add_node_update(plan: Plan) -> None:
    grid = plan.scene.grid
    plan.add_array("cell.integrals", "vec3", grid.gradient_integrals)
    half_full = 0.5 * plan.scene.material.density * grid.node_volumes
    plan.add_array("node.least_mass", "real", half_full)
    plan.add_zeros("node.mass", "real", grid.node_count)
    plan.add_zeros("node.motion", "vec4", grid.node_count)
    plan.add_launch(
        make_node_update(plan.share_count, plan.precision),
        (grid.row_count + 1, grid.column_count + 1),
        FIRST,
        *("node.momentum", "cell.stress", "cell.integrals"),
        *(grid.column_count, grid.row_count, plan.time_step, "node.least_mass"),
        ABSURD_SPEED * plan.speed_limit,
        *("node.mass", "node.motion"),
    )


def _add_load(plan: Plan, load: NodalLoad) -> None:
    plan.add_array("load.nodes", "int", load.nodes)
    plan.add_array("load.forces", "vec2", load.forces)
    plan.add_launch(
        make_nodal_load(plan.precision),
        len(load.nodes),
        *("load.nodes", "load.forces", "node.mass", plan.time_step, "node.motion"),
    )


def _add_gravity(plan: Plan, gravity: float) -> None:
    kernel = make_gravity(plan.precision)
    count = plan.scene.grid.node_count
    plan.add_launch(kernel, count, FIRST, gravity * plan.time_step, "node.mass", "node.motion")


def _add_damping(plan: Plan, damping: float) -> None:
    kernel = make_damping(plan.precision)
    count = plan.scene.grid.node_count
    plan.add_launch(kernel, count, FIRST, damping * plan.time_step, "node.motion")


def _add_fixed(plan: Plan, fixed: Fixed) -> None:
    plan.add_array("fixed.nodes", "int", fixed.nodes)
    plan.add_array("fixed.free", "vec2", fixed.free)
    kernel = make_fixed(plan.precision)
    plan.add_launch(kernel, len(fixed.nodes), FIRST, "fixed.nodes", "fixed.free", "node.motion")


def _add_far_field(plan: Plan, far_field: FarField) -> None:
    count = len(far_field.nodes)
    plan.add_array("far_field.nodes", "int", far_field.nodes)
    plan.add_array("far_field.spring", "real", far_field.spring)
    plan.add_array("far_field.dashpot", "vec2", far_field.dashpot)
    plan.add_zeros("far_field.displacement", "real", count)
    plan.add_launch(
        make_far_field(plan.precision),
        count,
        FIRST,
        *("far_field.nodes", "far_field.spring", "far_field.dashpot"),
        *("node.mass", plan.time_step, "far_field.displacement", "node.motion"),
    )


def _add_contact(plan: Plan, contact: SurfaceContact) -> None:
    pressure_forces = contact.in_situ_stress * contact.normal_areas
    plan.add_array("contact.nodes", "int", contact.nodes)
    plan.add_array("contact.normals", "vec2", contact.normals)
    plan.add_array("contact.adhesion", "real", contact.adhesion_forces)
    plan.add_array("contact.pressure", "real", pressure_forces)
    plan.add_zeros("contact.impulse", "vec2", len(contact.nodes))
    window = None if plan.scene.window is None else "window.motion"
    plan.add_launch(
        make_surface_contact(window is not None, plan.precision),
        len(contact.nodes),
        FIRST,
        *("contact.nodes", "contact.normals", contact.friction),
        *("contact.adhesion", "contact.pressure", "node.mass", plan.time_step),
        *(contact.speed, window),
        *("node.motion", "contact.impulse"),
    )


def _add_push(plan: Plan) -> None:
    grid = plan.scene.grid
    motion = np.zeros((grid.row_count + 1, 3))
    motion[:, 2] = grid.surface_radius
    plan.add_array("wall.motion", "vec3", motion)
    plan.add_array("wall.outward", "vec2", grid.surface_normals)
    plan.add_zeros("wall.impulse", "real", grid.row_count + 1)
    plan.add_launch(
        make_push(plan.precision),
        grid.row_count + 1,
        *(
            grid.column_count,
            "wall.motion",
            "wall.outward",
            "node.mass",
            "node.motion",
            "wall.impulse",
        ),
    )


def _add_cell_rates(plan: Plan) -> None:
    grid, material = plan.scene.grid, plan.scene.material
    viscous = plan.scene.bulk_viscosity is not None
    plan.add_array("cell.volume", "real", grid.cell_volumes)
    evening = None
    if plan.scene.even_flow:
        evening = plan.add_array("cell.evening", "vec10", even_flow_weights(grid))
    plan.add_zeros("cell.step", "vec11" if plan.scene.even_flow else "vec7", grid.cell_count)
    plan.add_launch(
        make_cell_rates(viscous, plan.scene.even_flow, plan.precision),
        grid.cell_count,
        FIRST,
        *("node.motion", "cell.integrals", "cell.volume", grid.column_count, plan.time_step),
        *(material.shear_modulus, material.bulk_modulus),
        *("cell.gradient", "cell.dilation_rate" if viscous else None, "cell.step"),
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
        FIRST,
        *("node.motion", "cell.step", "grid.columns", "grid.rows", grid.outer_radius),
        *((grid.column_count, grid.row_count), plan.time_step),
        *(plan.time_step / scene.velocity_memory, strength),
        *("particle.position", "particle.velocity", "particle.stress", "particle.cell"),
        *travelling,
    )


def _advance_window(plan: Plan, window: Window) -> None:
    approach = window.approach
    falling = (0.0, 0.0) if approach is None else (approach.travel, approach.slowing_travel)
    plan.add_launch(
        make_advance_window(approach is not None, plan.precision),
        1,
        *(plan.time_step, window.first_speed, window.ramp_time, window.speed, *falling),
        "window.motion",
    )


def _move_wall(plan: Plan, wall: MovingWall) -> None:
    grid = plan.scene.grid
    plan.add_launch(
        make_move_wall(plan.precision),
        grid.row_count + 1,
        *(plan.time_step, wall.speed, wall.ramp_time, "wall.motion", "grid.rows"),
    )
    geometry = ("grid.columns", "grid.rows", grid.outer_radius, grid.column_count)
    if isinstance(grid, PolarGrid):
        angular, caps = grid.angular_integrals
        plan.add_launch(
            make_refit_sectors(plan.precision),
            grid.cell_count,
            FIRST,
            *geometry,
            plan.add_array("wall.angular", "vec5", angular),
            plan.add_array("wall.caps", "real", caps),
            *("cell.integrals", "cell.volume"),
        )
    else:
        kernel = make_refit_cells(plan.precision)
        plan.add_launch(kernel, grid.cell_count, FIRST, *geometry, "cell.integrals", "cell.volume")


def _add_energy_audit(plan: Plan) -> None:
    grid = plan.scene.grid
    energy = plan.add_zeros("transfer.energy", "real", grid.row_count + 1)
    before, after = (
        Launch(
            kernel=make_kinetic_energy(when, plan.precision),
            dim=(grid.row_count + 1,),
            arguments=(grid.column_count, "node.mass", "node.motion", energy),
        )
        for when in ("before", "after")
    )
    update = next(i for i, it in enumerate(plan.step) if "node.least_mass" in it.arrays) + 1
    plan.audited_step = [after, *plan.step[:update], before, *plan.step[update:]]
