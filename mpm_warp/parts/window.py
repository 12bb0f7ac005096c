"""The window: the grid travels with the penetrometer down through the soil.

Its motion is (time [s], speed of the soil past the grid [m/s], travel [m]). It is kept on the
device so that a recorded step can be replayed as it is. Soil enters below and leaves above.

Soil enters by layers. One that enters is a copy of the lowest layer as it was seeded, in all that
particles carry, so that what a part or a material adds to the particles enters with them. Where the
material varies, the layer has the properties of its depth. A part may give it more (`Part.enter`),
and what depends on the travel follows (`Part.follow`). At last the law takes a step without strain:
ground around the window, which stays elastic, may give a stress outside the yield surface.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import POSITIVE, Checked, Range, check_kind, check_number, checked
from mpm_warp.errors import WindowOverfull
from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.kernel_types import kernel, one, real, vec4, zero
from mpm_warp.materials.material import ADHESION_RATIO, PROPERTIES, Law
from mpm_warp.parts.velocity_bound import VELOCITY_BOUND, add_velocity_bound
from mpm_warp.plan.launch import share_bounds
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import BetweenSteps, Part, Scene, refuse_together

ROUNDING = 1e-6
"""Share of a step that counts as rounding: no step beyond a distance is taken for it."""
REMEDY = "where soil piles up finer cells, more spare slots or less travel"


@dataclass(frozen=True, kw_only=True)
class MovingGrid(Part):
    """A grid that moves through the soil; velocities stay those relative to undisturbed soil.

    The array "window.motion" has (time [s], speed of the soil past the grid [m/s], travel [m]).

    Attributes:
        speed: of the grid when it neither rises nor falls [m/s], > 0.
        ramp_travel: travel over which the speed rises from rest, linearly in time [m], > 0.
    """

    speed: float = checked(POSITIVE, unit="m/s")
    ramp_travel: float = checked(POSITIVE, unit="m")

    @property
    def first_speed(self) -> float:
        """The greatest speed: that after the first ramp [m/s]."""
        return self.speed

    @property
    def ramp_time(self) -> float:
        """Time of the first ramp [s]."""
        return 2.0 * self.ramp_travel / self.first_speed

    def spare_fraction_in(self, grid: Grid) -> float:
        """Empty slots at the start, over the number of particles that fill a grid; none here."""
        return 0.0

    def fill_spare_slots(self, plan: Plan, scene: Scene) -> None:
        """Put points into the empty slots, before parts add what points carry; none by default."""

    def top(self, scene: Scene) -> float:
        """Height above which particles leave the grid [m].

        Half a layer stays above the top, else the mass of the nodes there could vanish.
        """
        rows = scene.grid.rows
        return float(rows[-1] + 0.5 * (rows[-1] - rows[-2]) / scene.particles_per_side)

    def check(self, scene: Scene) -> None:
        """Check that the grid has rows that soil can rise through."""
        refuse_together(type(self).__name__, scene.grid.polar, "a grid of rays")

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add the array of the motion, which stages and parts read."""
        plan.add_zeros("window.motion", "real", 3)


@dataclass(frozen=True, kw_only=True)
class Approach(Checked):
    """The window hurries to where it matters, then falls to its final speed.

    What the soil remembers of it is its stress, which hardly depends on the speed; what it owes to
    inertia is gone when the soil around has been replaced.

    Attributes:
        speed: of the grid before it falls [m/s], above the final one.
        travel: where it has fallen to the final speed [m], > `slowing_travel`.
        slowing_travel: travel over which it falls, linearly [m], > 0.
    """

    speed: float = checked(POSITIVE, unit="m/s")
    travel: float
    slowing_travel: float = checked(POSITIVE, unit="m")

    def __post_init__(self) -> None:
        super().__post_init__()
        beyond = Range(above=self.slowing_travel)
        check_number("Approach: travel", self.travel, beyond, unit="m")


@dataclass(frozen=True, kw_only=True)
class Window(MovingGrid):
    """The grid moves down through the soil.

    Whenever the grid has travelled by the height of a layer of particles, a layer of undisturbed
    soil enters the lowest row, into the slots of particles that left above the highest. `speed` is
    that after the approach.

    Attributes:
        approach: a hurried start, or none.
        spare_fraction: slots for particles beyond those of the full grid, over their number,
            dimensionless, > 0.
    """

    spare_fraction: float = checked(POSITIVE)
    approach: Approach | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_kind("Window: approach", self.approach, (Approach, type(None)))
        if self.approach is not None:
            faster = Range(above=self.speed)
            check_number("Window: approach.speed", self.approach.speed, faster, unit="m/s")

    @property
    def first_speed(self) -> float:
        """The speed after the ramp [m/s]."""
        return self.speed if self.approach is None else self.approach.speed

    def time_to(self, travel: float) -> float:
        """Time to a travel [m], >= 0, where the approach is longer than ramp and slowing [s]."""
        if travel <= self.ramp_travel:
            return self.ramp_time * math.sqrt(travel / self.ramp_travel)
        if self.approach is None:
            return self.ramp_time + (travel - self.ramp_travel) / self.speed
        fast, slow, falling = self.approach.speed, self.speed, self.approach.slowing_travel
        begin = self.approach.travel - falling
        time = self.ramp_time + (min(travel, begin) - self.ramp_travel) / fast
        fallen = min(1.0, max(0.0, travel - begin) / falling) * (fast - slow)
        time += falling / (fast - slow) * math.log(fast / (fast - fallen))
        return time + max(0.0, travel - self.approach.travel) / slow

    def highest_speed_from(self, travel: float) -> float:
        """The highest speed that the grid has beyond a travel [m], after the ramp [m/s]."""
        if self.approach is None:
            return self.speed
        left = (self.approach.travel - travel) / self.approach.slowing_travel
        return self.speed + min(1.0, max(0.0, left)) * (self.approach.speed - self.speed)

    def spare_fraction_in(self, grid: Grid) -> float:
        """See `MovingGrid`."""
        return self.spare_fraction

    def add_after_motion(self, plan: Plan, scene: Scene) -> None:
        """Add the launch that moves it on, and what lets soil enter."""
        approach = self.approach
        plan.add_launch(
            _make_advance_window(approach is not None),
            1,
            speed=self.first_speed,
            ramp_time=self.ramp_time,
            final_speed=self.speed,
            approach_travel=0.0 if approach is None else approach.travel,
            slowing_travel=0.0 if approach is None else approach.slowing_travel,
        )
        add_velocity_bound(plan, scene, window_speed=self.first_speed)
        add_inflow(plan, scene)

    def between_steps(self, run: Run, scene: Scene) -> BetweenSteps:
        """What lets soil enter."""
        return Inflow(run, scene, self)


def add_inflow(plan: Plan, scene: Scene) -> None:
    """Add what lets a layer enter, when the plan has all arrays of its particles.

    Of every array "particle.x" the plan gets "layer.x", its values in a layer that enters, and the
    launch "enter.x" to be ordered between steps, which writes them into the slots "layer.slots".
    """
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
        plan.between_steps["enter.by_law"] = plan.launch(
            _make_enter_by_law(law),
            len(slots),
            **scene.material.on_points(plan, law),
        )


class Inflow:
    """Lets soil into a run that has not travelled yet, layer by layer."""

    def __init__(self, run: Run, scene: Scene, window: Window) -> None:
        plan, rows = run.plan, scene.grid.rows
        self._run = run
        self._scene = scene
        self._window = window
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
        """How far the window has moved down through the soil [m]."""
        return float(self._run.array("window.motion")[2])

    def steps_to(self, travel: float) -> int:
        """Steps to a travel [m], at least 1; fewer than needed where the speed rises or falls."""
        now = self.travel
        per_step = self._window.highest_speed_from(now) * self._run.plan.time_step
        return max(1, math.ceil((travel - now) / per_step - ROUNDING))

    @property
    def steps_ahead(self) -> int:
        """Steps that can be taken before a layer may have to enter, at least 1."""
        return self.steps_to(self._next_layer)

    def act(self) -> None:
        """Let a layer in, if the window has travelled far enough for it.

        Raises:
            WindowOverfull: no slots are left for it.
        """
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
        position[:, 1] += position.dtype.type(above_bottom)
        run.assign("layer.position", position)
        run.assign("layer.slots", self._chosen(free))
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
        """Give a layer what the material says of its place in the ground [m], [point_count, 2]."""
        run, material = self._run, self._scene.material
        if run.plan.find(PROPERTIES):
            run.assign("layer.properties", material.properties_at(place))
        if material.variation is not None and run.plan.find(ADHESION_RATIO):
            run.assign("layer.adhesion_ratio", material.variation.adhesion_ratio_at(place))
        if material.state:
            run.assign("layer.state", material.state_at(run.array("layer.stress"), place))

    @property
    def _next_layer(self) -> float:
        """Travel at which the next layer enters [m]."""
        return (self._layer_count + 0.5) * self._layer_height

    def _chosen(self, free: Integers) -> Integers:
        """As many of the free slots as a layer needs: those of the shares that have most."""
        bounds = self._share_bounds
        end_of_share = np.searchsorted(free, bounds)[np.searchsorted(bounds, free, side="right")]
        left_in_share = end_of_share - np.arange(len(free))
        return free[np.argsort(-left_in_share, kind="stable")[: len(self._position)]]


@functools.cache
def _make_advance_window(hurried: bool) -> Any:
    """One step of the motion, the speed rising linearly in time; launched once.

    `hurried`: the speed falls again at the end of an approach, linearly in travel.
    """

    @kernel
    def advance_window(
        time_step: real,
        speed: real,
        ramp_time: real,
        final_speed: real,
        approach_travel: real,
        slowing_travel: real,
        window_motion: wp.array(dtype=real),
    ):
        window_motion[2] += time_step * window_motion[1]
        window_motion[0] += time_step
        risen = speed * wp.min(window_motion[0] / ramp_time, one)
        if wp.static(hurried):
            left = wp.clamp((approach_travel - window_motion[2]) / slowing_travel, zero, one)
            window_motion[1] = wp.min(risen, final_speed + left * (speed - final_speed))
        else:
            window_motion[1] = risen

    return advance_window


@functools.cache
def _make_enter(dtype: Any) -> Any:
    """The kernel that writes the values of a layer into its slots; over the layer's particles."""

    @kernel
    def enter(
        layer_slots: wp.array(dtype=int), layer: wp.array(dtype=dtype), field: wp.array(dtype=dtype)
    ):
        k = wp.tid()
        field[layer_slots[k]] = layer[k]

    return enter


@functools.cache
def _make_enter_by_law(law: Law) -> Any:
    """The kernel that brings what has entered within its yield surface; over the layer's particles.

    What is within stays as it is, and nothing is remembered of it.
    """

    @kernel
    def enter_by_law(
        time_step: real,
        properties: law.properties_argument,
        layer_slots: wp.array(dtype=int),
        particle_stress: wp.array(dtype=vec4),
        particle_state: wp.array(dtype=law.state_type),
    ):
        p = layer_slots[wp.tid()]
        own, remembered = law.properties_of(properties, p), law.state_of(particle_state, p)
        sigma, _ = law.update(particle_stress[p], vec4(), time_step, own, remembered)
        particle_stress[p] = sigma

    return enter_by_law
