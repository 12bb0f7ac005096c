"""From bodies in contact to the plan of their run; what a scene does not need is not in it.

The functions below stand in the order of the step. Each adds the arrays that its stage is the first
to use, and its launches. Arrays over "field" have a row for each body and a column for each node.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.bodies.scene import Body, BodyContact, BodyScene, UniformGrid
from mpm_warp.grid.fitted import Integers
from mpm_warp.bodies.contact import (
    make_body_contact,
    make_clear_surfaces,
    make_extents,
    make_interface,
    make_pressing,
    make_shared_pressure,
)
from mpm_warp.bodies.loads import make_body_loads, make_clock
from mpm_warp.bodies.body_to_grid import make_body_prediction, make_body_to_grid
from mpm_warp.bodies.grid_to_body import make_grid_to_body
from mpm_warp.precision import FLOAT64, Precision
from mpm_warp.plan.plan import StepPlan
from mpm_warp.plan.time_step import TimeStepControl

CLOSED_GAP = 0.05
"""Gap below which bodies touch, over cell size: a block at rest must not chatter on its base."""


@dataclass(kw_only=True, eq=False)
class BodyPlan(StepPlan):
    """All that a run of bodies in contact consists of.

    Attributes:
        scene: what is run.
    """

    scene: BodyScene


def make_body_plan(
    scene: BodyScene, precision: Precision = FLOAT64, time_step: float | None = None
) -> BodyPlan:
    """The plan of a run of `scene`, complete.

    Args:
        scene: what to run.
        precision: floating point types.
        time_step: length of a step [s]; default: the scene's fraction of the critical one.
    """
    critical_time_step = min(body.critical_time_step(scene.grid.cell_size) for body in scene.bodies)
    plan = BodyPlan(
        scene=scene,
        precision=precision,
        time_step=time_step or scene.time_step_fraction * critical_time_step,
        longest_time_step=max(1.0, scene.time_step_fraction) * critical_time_step,
        speed_limit=max(body.material.pressure_wave_speed for body in scene.bodies),
        particle_count=sum(body.particle_count for body in scene.bodies),
        particle_bounds=scene.grid.particle_bounds,
        control=TimeStepControl(
            first=scene.time_step_fraction * critical_time_step,
            fraction=scene.time_step_fraction,
            critical=lambda array: _critical_time_step(scene, array),
            replan=lambda time_step: make_body_plan(scene, precision, time_step),
        ),
        remedy="try a smaller time_step_fraction, or a wider grid where a body has left it",
    )
    _add_particles(plan)
    damped = any(body.retardation_time is not None for body in scene.bodies)
    if damped:
        _add_damping(plan)
    loaded = any(body.loads for body in scene.bodies)
    if loaded:
        _add_loads(plan)
    _add_prediction(plan, damped=damped, loaded=loaded)
    for index, contact in enumerate(scene.contacts):
        _add_contact(plan, index, contact)
    if scene.contacts:
        kernel = make_clear_surfaces(precision)
        plan.add_launch(kernel, _fields(plan), "field.surface")
    _add_grid_to_body(plan, damped=damped)
    if loaded:
        plan.add_launch(make_clock(precision), 1, plan.time_step, "load.time")
    return plan


def _critical_time_step(scene: BodyScene, array: Callable[[str], NDArray[Any]]) -> float:
    """The least of all bodies', as they are drawn out by now."""
    volume, first = array("particle.volume"), 0
    longest = math.inf
    for body in scene.bodies:
        now = volume[first : first + body.particle_count]
        thinning = float(np.max(now / body.volume))
        longest = min(longest, body.critical_time_step(scene.grid.cell_size, thinning))
        first += body.particle_count
    return longest


def _fields(plan: BodyPlan) -> tuple[int, int]:
    return len(plan.scene.bodies), plan.scene.grid.node_count


def _geometry(plan: BodyPlan) -> tuple[object, ...]:
    """The grid as kernels take it: lowest corner, cell size, nodes along both axes."""
    grid = plan.scene.grid
    return plan.precision.vec2(*grid.lower), grid.cell_size, wp.vec2i(*grid.node_counts)


def _add_particles(plan: BodyPlan) -> None:
    bodies = plan.scene.bodies
    numbers = np.repeat(np.arange(len(bodies)), [body.particle_count for body in bodies])
    plan.add_array("particle.body", "int", numbers.astype(np.int32))
    plan.add_array("particle.position", "vec2", np.concatenate([b.position for b in bodies]))
    plan.add_array("particle.mass", "real", np.concatenate([b.mass for b in bodies]))
    plan.add_array("particle.volume", "real", np.concatenate([b.volume for b in bodies]))
    plan.add_zeros("particle.velocity", "vec2", plan.particle_count)
    plan.add_zeros("particle.affine", "mat22", plan.particle_count)
    plan.add_zeros("particle.stress", "vec4", plan.particle_count)


def _add_damping(plan: BodyPlan) -> None:
    times = [body.retardation_time or 0.0 for body in plan.scene.bodies]
    plan.add_array("body.retardation_time", "real", np.array(times))
    plan.add_zeros("particle.viscous_stress", "vec4", plan.particle_count)
    plan.add_zeros("particle.dissipated", "real", plan.particle_count)


def _add_loads(plan: BodyPlan) -> None:
    schedule, forces, first = [], [], 0
    for body in plan.scene.bodies:
        for load in body.loads:
            schedule.append((load.start, load.rise_time))
            on_all = np.zeros((plan.particle_count, 2))
            on_all[first : first + body.particle_count] = load.forces
            forces.append(on_all)
        first += body.particle_count
    plan.add_array("load.schedule", "vec2", np.array(schedule))
    plan.add_array("load.forces", "vec2", np.array(forces))
    plan.add_zeros("load.time", "real", 1)
    plan.add_zeros("particle.load", "vec2", plan.particle_count)
    plan.add_launch(
        make_body_loads(plan.precision),
        plan.particle_count,
        *("load.schedule", "load.forces", "load.time", 0.5 * plan.time_step, "particle.load"),
    )


def _add_prediction(plan: BodyPlan, *, damped: bool, loaded: bool) -> None:
    scene = plan.scene
    plan.add_zeros("field.momentum", "vec3", _fields(plan))
    surface = None
    if scene.contacts:
        surface = plan.add_zeros("field.surface", "vec2", _fields(plan))
    plan.add_launch(
        make_body_to_grid(
            scene.grid.axisymmetric, damped, loaded, surface is not None, plan.precision
        ),
        plan.particle_count,
        *("particle.body", "particle.position", "particle.velocity", "particle.affine"),
        *("particle.stress", "particle.mass", "particle.volume"),
        "particle.viscous_stress" if damped else None,
        "particle.load" if loaded else None,
        *_geometry(plan),
        *(plan.time_step, "field.momentum", surface),
    )
    held = np.stack([_held_nodes(body, scene.grid) for body in scene.bodies])
    plan.add_array("field.held", "int", held)
    plan.add_zeros("field.inverse_mass", "real", _fields(plan))
    plan.add_zeros("field.velocity", "vec2", _fields(plan))
    plan.add_launch(
        make_body_prediction(plan.precision),
        _fields(plan),
        *("field.held", "field.momentum", "field.inverse_mass", "field.velocity"),
    )


def _held_nodes(body: Body, grid: UniformGrid) -> Integers:
    """1 at the nodes that a held particle reaches, else 0; shape [node_count]."""
    held = np.zeros(grid.node_counts[::-1], dtype=np.int32)
    if body.held is not None:
        where = (body.position[body.held] - np.asarray(grid.lower)) / grid.cell_size
        for column, row in np.floor(where - 0.5).astype(int):
            held[row : row + 3, column : column + 3] = 1
    return held.ravel()


def _add_contact(plan: BodyPlan, index: int, contact: BodyContact) -> None:
    bodies, grid = plan.scene.bodies, plan.scene.grid
    pair = (contact.body, contact.base)
    over_nodes = grid.node_counts[::-1]
    node_counts = wp.vec2i(*grid.node_counts)
    spacing = np.array([0.5 * body.spacing for body in bodies])
    plan.add_array("body.half_spacing", "real", spacing)
    normal, extent, pressing = (
        plan.add_zeros(f"contact{index}.{name}", "vec2", grid.node_count)
        for name in ("normal", "extent", "pressing")
    )
    area, pressure = (
        plan.add_zeros(f"contact{index}.{name}", "real", grid.node_count)
        for name in ("area", "pressure")
    )
    plan.add_launch(
        make_interface(plan.precision),
        over_nodes,
        *(*pair, node_counts, "field.surface", "field.inverse_mass", normal, area, extent),
    )
    plan.add_launch(
        make_extents(plan.precision),
        plan.particle_count,
        *(*pair, "particle.body", "particle.position", "body.half_spacing"),
        *(*_geometry(plan), normal, area, extent),
    )
    plan.add_launch(
        make_pressing(plan.precision),
        grid.node_count,
        *(*pair, CLOSED_GAP * grid.cell_size, normal, area, extent),
        *("field.inverse_mass", "field.velocity", pressing),
    )
    plan.add_launch(
        make_shared_pressure(plan.precision), over_nodes, node_counts, pressing, pressure
    )
    plan.add_launch(
        make_body_contact(plan.precision),
        over_nodes,
        *(*pair, contact.friction, contact.adhesion, plan.time_step, node_counts),
        *(normal, pressing, pressure, "field.inverse_mass", "field.velocity"),
        plan.add_zeros(f"contact{index}.total", "vec3", 1),
    )


def _add_grid_to_body(plan: BodyPlan, *, damped: bool) -> None:
    materials = [body.material for body in plan.scene.bodies]
    moduli = np.array([(it.shear_modulus, it.bulk_modulus) for it in materials])
    plan.add_array("body.moduli", "vec2", moduli)
    plan.add_launch(
        make_grid_to_body(plan.scene.grid.axisymmetric, damped, plan.precision),
        plan.particle_count,
        *("particle.body", "body.moduli", "body.retardation_time" if damped else None),
        *("field.velocity", *_geometry(plan), plan.time_step),
        *("particle.position", "particle.velocity", "particle.affine", "particle.stress"),
        "particle.volume",
        *(("particle.viscous_stress", "particle.dissipated") if damped else (None, None)),
    )
