"""Soil enters a travelling window layer by layer; the velocities of all points are then bounded.

A layer that enters is a copy of the lowest layer as it was seeded, in all arrays of the particles,
also those that parts and materials have added. Where the material varies, the layer has the
properties of its depth. A part may set further values (`Part.enter`) and follow the travel
(`Part.follow`). Last, the material law takes a step without strain, because the stress of the
elastic ground around the window may be outside the yield surface.

The bound limits w, the velocity of a point relative to the interpolated velocity of the grid.
Symbols: v_p velocity of the point, v velocity of the nodes, N shape functions at the point.

    w = v_p - N v,      v_p <- N v + w W / |w| where |w| > W

A scene may give a lower bound s. Then |w| is at most s, or OVER_CELL times the difference of v at
opposite corners of the cell if that is more: in a coarse cell sound soil may have as much.

A point does not move with its w, but passes it to the nodes in the next step. The w of a point that
stays near a tip, a shoulder or a pole grows, because each step changes it as much as that of points
that pass quickly. In the end the point would be faster than waves. This takes many steps, so the
bound is applied only when a layer enters, at almost no cost. A point that is already faster than
waves is a fault; the watch reports it.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.errors import WindowOverfull
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.grid.location import between_nodes, make_location
from mpm_warp.kernel_types import kernel, maybe, real, vec2, vec3, vec4, vec5
from mpm_warp.materials.material import ADHESION_RATIO, PROPERTIES, Law
from mpm_warp.plan.launch import share_bounds
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import Scene

ROUNDING = 1e-6
"""Share of a step that counts as rounding and needs no further step."""
REMEDY = "where soil piles up finer cells, more spare slots or less travel"
VELOCITY_BOUND = "velocity.bound"
"""Name of the launch between steps."""
SHARE_OF_WAVE, OVER_WINDOW = 0.5, 4.0
"""W over the speed of pressure waves, and over the largest speed of the grid; the smaller W holds.
In sound runs points reach 0.12 and 2.7 of these speeds."""
OVER_CELL = 2.0
"""Bound of |w| over the difference of the velocities at opposite corners of a cell, if above s."""


def add_inflow(plan: Plan, scene: Scene, *, window_speed: float, stray_speed: float) -> None:
    """Add the arrays and launches by which a layer enters, after all particle arrays.

    `window_speed` is the greatest speed of the window, `stray_speed` the bound s [m/s]. For every
    array "particle.x" the plan gets "layer.x", the values of an entering layer, and the launch
    "enter.x" between steps, which writes them into the slots "layer.slots".
    """
    W = min(SHARE_OF_WAVE * scene.material.pressure_wave_speed, OVER_WINDOW * window_speed)
    plan.between_steps[VELOCITY_BOUND] = plan.launch(
        bound_velocity,
        len(plan.initial("particle.cell")),
        stride=scene.grid.column_count + 1,
        W=W,
        s=min(W, stray_speed),
        over_cell=OVER_CELL,
        speed_limit=plan.speed_limit,
    )
    plan.remedy += f", or {REMEDY}"
    cell = plan.initial("particle.cell")
    slots = np.flatnonzero(cell[:, 1] == 0)
    slots = slots[: len(slots) // scene.particles_per_side]
    plan.add_zeros("layer.slots", "int", len(slots), (len(cell),))
    for name in [name for name in plan.arrays if name.startswith("particle.")]:
        field = plan.arrays[name]
        of_layer = name.replace("particle.", "layer.")
        if field.initial is None:
            plan.add_zeros(of_layer, field.kind, len(slots))
        else:
            plan.add_array(of_layer, field.kind, field.initial[slots], field.counts)
        plan.between_steps[name.replace("particle.", "enter.")] = plan.launch(
            _make_enter(field.dtype), len(slots), layer=of_layer, field=name
        )
    law = scene.material.law()
    if law.yield_function is not None:
        plan.between_steps["enter.by_law"] = plan.launch(_make_enter_by_law(law), len(slots))


class Inflow:
    """Lets soil into a run, layer by layer.

    `highest_speed_from` gives the highest speed [m/s] of the window beyond a travel [m].
    """

    def __init__(
        self, run: Run, scene: Scene, highest_speed_from: Callable[[float], float]
    ) -> None:
        plan, rows = run.plan, scene.grid.rows
        self._run = run
        self._scene = scene
        self._highest_speed_from = highest_speed_from
        self._launches = [
            launch for name, launch in plan.between_steps.items() if name.startswith("enter.")
        ]
        self._share_bounds = share_bounds(plan.arrays["particle.mass"].shape[0], plan.share_count)
        self._position = run.array("layer.position").copy()
        self._position[:, 1] = rows[0]
        self._layers_per_row = scene.particles_per_side
        self._layer_height = float(rows[1] - rows[0]) / self._layers_per_row
        self._layer_count = 0

    @property
    def travel(self) -> float:
        """Distance that the window has moved down through the soil [m]."""
        return float(self._run.array("window.motion")[2])

    def steps_to(self, travel: float) -> int:
        """Steps to a travel [m], at least 1; a lower bound while the speed rises or falls."""
        now = self.travel
        per_step = self._highest_speed_from(now) * self._run.plan.time_step
        return max(1, math.ceil((travel - now) / per_step - ROUNDING))

    @property
    def steps_ahead(self) -> int:
        """Steps that can be taken before a layer may have to enter, at least 1."""
        return self.steps_to(self._next_layer)

    def act(self) -> None:
        """Add a layer if it is due; raise `WindowOverfull` if too few slots are free."""
        travel = self.travel
        above_bottom = travel - self._next_layer
        if above_bottom < 0.0:
            return
        run, scene = self._run, self._scene
        run.launch(run.plan.between_steps[VELOCITY_BOUND])
        free = np.flatnonzero(run.array("particle.cell")[:, 0] < 0)
        if len(free) < len(self._position):
            raise WindowOverfull(
                f"after {travel:.4g} m of travel more soil has stayed in the window than it "
                f"has slots for; {run.plan.remedy}"
            )
        position = self._position.copy()
        position[:, 1] += above_bottom
        run.assign("layer.position", position)
        run.assign("layer.slots", self._slots_for_layer(free))
        for part in scene.parts:
            part.enter(run, scene, position, travel)
        self._enter_by_law(position - np.array([0.0, travel]))
        for launch in self._launches:
            run.launch(launch)
        self._layer_count += 1
        by_a_row = self._layer_count % self._layers_per_row == 0
        for part in scene.parts:
            part.follow(run, scene, travel, by_a_row=by_a_row)

    def _enter_by_law(self, place: Floats) -> None:
        """Give a layer properties and state by its place in the ground [m], [point_count, 2]."""
        run, material = self._run, self._scene.material
        if PROPERTIES in run.plan.arrays:
            run.assign("layer.properties", material.properties_at(place))
        if ADHESION_RATIO in run.plan.arrays:
            run.assign("layer.adhesion_ratio", material.ratio_at(place, "adhesion_ratio"))
        if material.state:
            run.assign("layer.state", material.state_at(run.array("layer.stress"), place))

    @property
    def _next_layer(self) -> float:
        """Travel at which the next layer enters [m]."""
        return (self._layer_count + 0.5) * self._layer_height

    def _slots_for_layer(self, free: Integers) -> Integers:
        """Free slots for a layer, from the shares with the most free slots."""
        bounds = self._share_bounds
        end_of_share = np.searchsorted(free, bounds)[np.searchsorted(bounds, free, side="right")]
        left_in_share = end_of_share - np.arange(len(free))
        return free[np.argsort(-left_in_share, kind="stable")[: len(self._position)]]


@functools.cache
def _make_enter(dtype: Any) -> Any:
    @kernel
    def enter(layer_slots: wp.array[int], layer: wp.array[dtype], field: wp.array[dtype]):
        k = wp.tid()
        field[layer_slots[k]] = layer[k]

    return enter


@functools.cache
def _make_enter_by_law(law: Law) -> Any:
    """The kernel that returns stress to the yield surface, over the particles of a layer.

    Stress within the surface does not change, nor does any state.
    """

    @kernel
    def enter_by_law(
        time_step: real,
        properties: law.properties_argument,
        layer_slots: wp.array[int],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
    ):
        p = layer_slots[wp.tid()]
        own, remembered = law.of_point(properties, particle_state, p)
        sigma, _ = law.update(particle_stress[p], vec4(), time_step, own, remembered)
        particle_stress[p] = sigma

    return enter_by_law


natural = make_location(polar=False).natural


@kernel
def bound_velocity(
    node_velocities: wp.array[vec4],
    grid_columns: wp.array[vec3],
    grid_rows: wp.array[vec5],
    stride: int,
    fitted_radius: real,
    particle_cell: wp.array[wp.vec2i],
    particle_position: wp.array[vec2],
    W: real,
    s: real,
    over_cell: real,
    speed_limit: real,
    particle_velocity: wp.array[vec2],
):
    """Launched over slots."""
    p = wp.tid()
    i, j = particle_cell[p][0], particle_cell[p][1]
    if i < 0:
        return
    where = natural(particle_position[p], grid_columns[i], grid_rows[j], fitted_radius)
    node = j * stride + i
    here = between_nodes(node_velocities, node, stride, where[0], where[1])
    v = vec2(here[0], here[1])
    w = particle_velocity[p] - v
    rising = node_velocities[node + stride + 1] - node_velocities[node]
    falling = node_velocities[node + 1] - node_velocities[node + stride]
    differ = wp.max(wp.length(vec2(rising[0], rising[1])), wp.length(vec2(falling[0], falling[1])))
    most = wp.min(W, wp.max(s, over_cell * differ))
    if wp.length(w) > most and wp.length(w) < speed_limit:
        particle_velocity[p] = v + (most / wp.length(w)) * w
