"""The cyclic window: the grid travels with a body down and up again, over a stroke.

Its motion is (time, speed, travel) as in a `Window`, but the grid turns at the end of each passage
of the stroke. With t the time since the last turn, t_p the time of a passage, t_r the time of a
ramp, and V the greatest speed, the speed is

    +-V min(1, t / t_r, (t_p - t) / t_r)        + on the way down

At a turn the body and the soil are set to rest. Otherwise the parts of particle velocities that no
node represents would grow from passage to passage and throw soil about.

No soil enters, and none is lost. The soil of the whole stroke exists from the start, in the grid
and below it. A point that the grid has left rests at its place in the ground and keeps its stress
and state. Relative to the grid, which moves down by V, it moves up:

    x <- x + dt V e_z,      v = 0           outside: cell (-1, -1)

It returns in the column in which it left, because it does not move sideways.
"""

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from mpm_warp.fields.checks import Range, check_number
from mpm_warp.grid.fitted import Grid
from mpm_warp.kernel_types import half, kernel, one, real, two, vec2, zero
from mpm_warp.parts.boundaries import FarField
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene, refuse_together
from mpm_warp.step.points import seed_rows

RESTING_COLUMN = "particle.resting_column"
"""Column of cells in which a particle left the grid, -1 inside the grid; shape [slot_count]."""


@dataclass(frozen=True, kw_only=True)
class CyclicWindow(MovingGrid):
    """The grid moves down and up through the soil over a stroke, with a ramp at each turn.

    Attributes:
        stroke: travel of a passage, from turn to turn [m], at least that of two ramps.

    Example:
        >>> window = CyclicWindow(speed=1.0, ramp_travel=0.1, stroke=1.0)
        >>> round(window.passage_time, 3)  # [s]
        1.2
    """

    not_beside = ((FarField, "hold the nodes around the grid"),)
    stroke: float

    def __post_init__(self) -> None:
        super().__post_init__()
        two_ramps = Range(minimum=2.0 * self.ramp_travel)
        check_number("CyclicWindow: stroke", self.stroke, two_ramps, unit="m")

    @property
    def passage_time(self) -> float:
        """Time from turn to turn [s]."""
        return self.ramp_time + self.stroke / self.speed

    def time_to(self, distance: float) -> float:
        """Time [s] to a distance, the sum of the travels down and up [m], >= 0."""
        passages, since = divmod(distance, self.stroke)
        to_turn = self.stroke - since
        if since < self.ramp_travel:
            time = self.ramp_time * math.sqrt(since / self.ramp_travel)
        elif to_turn < self.ramp_travel:
            time = self.passage_time - self.ramp_time * math.sqrt(to_turn / self.ramp_travel)
        else:
            time = self.ramp_time + (since - self.ramp_travel) / self.speed
        return passages * self.passage_time + time

    def spare_fraction_in(self, grid: Grid) -> float:
        """See `MovingGrid`; over a stroke below the grid, rows are as high as the lowest."""
        return math.ceil(self.stroke / float(grid.rows[1] - grid.rows[0])) / grid.row_count

    def top(self, scene: Scene) -> float:
        """Infinite: `leave_and_return` takes particles out of the grid at the top."""
        return math.inf

    def check(self, scene: Scene) -> None:
        """Check grid and material."""
        super().check(scene)
        varies = scene.material.variation is not None
        refuse_together("CyclicWindow", varies, "a material that varies")

    def fill_spare_slots(self, plan: Plan, scene: Scene) -> None:
        """Put the soil below the grid into the empty slots; it fills all of them."""
        grid = scene.grid
        position, mass, cell, stress = (
            plan.initial(f"particle.{name}") for name in ("position", "mass", "cell", "stress")
        )
        state = plan.initial("particle.state") if scene.material.state else None
        row = seed_rows(grid, 1, scene.particles_per_side)
        height = grid.rows[1] - grid.rows[0]
        column = np.full(len(cell), -1, dtype=np.int32)
        in_rows = np.flatnonzero(cell[:, 0] < 0).reshape(-1, len(row.volume))
        for depth, slots in enumerate(in_rows, start=1):
            position[slots] = row.position - np.array([0.0, depth * height])
            mass[slots] = scene.material.density * row.volume
            column[slots] = row.cell[:, 0]
            if state is not None:
                state[slots] = scene.material.state_at(stress[slots], position[slots])
        plan.add_array(RESTING_COLUMN, "int", column, (grid.column_count,), may_be_none=True)

    def add_after_motion(self, plan: Plan, scene: Scene) -> None:
        """Add the launches by which points leave, return and come to rest, and the grid moves."""
        grid = scene.grid
        plan.add_launch(
            leave_and_return,
            plan.arrays["particle.mass"].shape,
            bottom=float(grid.rows[0]),
            top=super().top(scene),
            highest_row=grid.row_count - 1,
            passage_time=self.passage_time,
        )
        plan.add_launch(
            advance_cyclic_window,
            1,
            speed=self.speed,
            ramp_time=self.ramp_time,
            passage_time=self.passage_time,
        )


@kernel
def advance_cyclic_window(
    time_step: real, speed: real, ramp_time: real, passage_time: real, window_motion: wp.array[real]
):
    """One step of the motion; launched once."""
    window_motion[2] += time_step * window_motion[1]
    window_motion[0] += time_step
    passages = wp.floor(window_motion[0] / passage_time)
    since_turn = window_motion[0] - passages * passage_time
    to_turn = passage_time - since_turn
    share = wp.min(one, wp.min(since_turn, to_turn) / ramp_time)
    upward = passages - two * wp.floor(passages / two)  # 0 or 1
    window_motion[1] = (one - two * upward) * share * speed


@kernel
def leave_and_return(
    offset: int,
    time_step: real,
    bottom: real,
    top: real,
    highest_row: int,
    passage_time: real,
    window_motion: wp.array[real],
    particle_position: wp.array[vec2],
    particle_velocity: wp.array[vec2],
    particle_cell: wp.array[wp.vec2i],
    particle_resting_column: wp.array[int],
):
    """Launched over slots of particles."""
    p = offset + wp.tid()
    x = particle_position[p]
    column = particle_resting_column[p]
    if column >= 0:
        x += vec2(zero, time_step * window_motion[1])
        particle_position[p] = x
        if x[1] >= bottom and x[1] < top:
            row = 0
            if x[1] > half * (bottom + top):
                row = highest_row
            particle_cell[p] = wp.vec2i(column, row)
            particle_resting_column[p] = -1
    elif x[1] < bottom or x[1] >= top:
        particle_velocity[p] = vec2(zero)
        particle_resting_column[p] = particle_cell[p][0]
        particle_cell[p] = wp.vec2i(-1, -1)
    now = window_motion[0]
    if wp.floor((now + time_step) / passage_time) > wp.floor(now / passage_time):
        particle_velocity[p] = vec2(zero)  # the step of a turn
