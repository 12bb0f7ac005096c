"""The source of soil of a travelling window: layers of soil enter at the bottom.

A layer that enters is a copy of the lowest layer as it was seeded, in all that particles carry, so
that what a part or a material adds to the particles enters with them. Where the scene says how the
ground around the window moves, the layer has its velocity and stress. Where the material varies,
the layer has the properties of its depth. Parts that depend on the travel follow.
"""

import functools
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.errors import WindowOverfull
from mpm_warp.grid.fitted import Integers
from mpm_warp.materials.material import PROPERTIES
from mpm_warp.parts.part import FollowsWindow, NodeAction, Setting
from mpm_warp.parts.records.history import note_origin
from mpm_warp.parts.window.surrounding_ground import SurroundingGround
from mpm_warp.parts.window.window import Window
from mpm_warp.plan.launch import share_bounds
from mpm_warp.plan.plan import Plan
from mpm_warp.plan.run import Run

ROUNDING = 1e-6
"""Share of a step that counts as rounding: no step beyond a distance is taken for it."""
REMEDY = "where soil piles up finer cells, more spare slots or less travel"


def add_inflow(plan: Plan, setting: Setting) -> None:
    """Add what lets a layer enter, when the plan has all arrays of its particles.

    Of every array "particle.x" the plan gets "layer.x", its values in a layer that enters, and the
    launch "enter.x" to be ordered between steps, which writes them into the slots "layer.slots".
    """
    plan.remedy += f", or {REMEDY}"
    cell = plan.arrays["particle.cell"].initial
    assert cell is not None
    slots = np.flatnonzero(cell[:, 1] == 0)
    slots = slots[: len(slots) // setting.particles_per_side]
    plan.add_zeros("layer.slots", "int", len(slots), (len(cell),))
    for name in [name for name in plan.arrays if name.startswith("particle.")]:
        field = plan.arrays[name]
        of_layer = name.replace("particle.", "layer.")
        if field.initial is None:
            plan.add_zeros(of_layer, field.kind, len(slots))
        else:
            plan.add_array(of_layer, field.kind, field.initial[slots], field.counts)
        plan.between_steps[name.replace("particle.", "enter.")] = plan.launch(
            _make_enter(field.kind, field.dtype), len(slots), layer=of_layer, field=name
        )


class Inflow:
    """Lets soil into a run whose scene has a window, layer by layer.

    Args:
        run: that has not travelled yet.
        setting: the soil.
        window: of the scene.
        ground: around the window, or none: what enters is undisturbed then.
        parts: of the scene; those that follow the window do.
    """

    def __init__(
        self,
        run: Run,
        setting: Setting,
        window: Window,
        ground: SurroundingGround | None,
        parts: Iterable[NodeAction] = (),
    ) -> None:
        plan, rows = run.plan, setting.grid.rows
        self._run = run
        self._setting = setting
        self._window = window
        self._ground = ground
        self._launches = [
            launch for name, launch in plan.between_steps.items() if name.startswith("enter.")
        ]
        self._share_bounds = share_bounds(plan.arrays["particle.mass"].shape[0], plan.share_count)
        self._position = run.array("layer.position").copy()
        self._position[:, 1] = rows[0]
        self._layers_per_row = setting.particles_per_side
        self._layer_height = float(rows[1] - rows[0]) / self._layers_per_row
        self._layer_count = 0
        self._followers = [it for it in parts if isinstance(it, FollowsWindow)]

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

    def let_in(self) -> None:
        """Let a layer in, if the window has travelled far enough for it.

        Raises:
            WindowOverfull: no slots are left for it.
        """
        above_bottom = self.travel - self._next_layer
        if above_bottom < 0.0:
            return
        free = np.flatnonzero(self._run.array("particle.cell")[:, 0] < 0)
        if len(free) < len(self._position):
            raise WindowOverfull(
                f"after {self.travel:.4g} m of travel more soil has stayed in the window than it "
                f"has slots for; {self._run.plan.remedy}"
            )
        position = self._position.copy()
        position[:, 1] += position.dtype.type(above_bottom)
        self._run.assign("layer.position", position)
        note_origin(self._run, position, self.travel)
        if self._run.plan.find(PROPERTIES):
            place = position - np.array([0.0, self.travel])
            self._run.assign("layer.properties", self._setting.material.properties_at(place))
        self._run.assign("layer.slots", self._chosen(free))
        if self._ground is not None:
            speed, travel = self._run.array("window.motion")[1:]
            flow = self._ground.source.velocity(position)
            self._run.assign("layer.velocity", speed * flow)
            self._run.assign("layer.stress", self._ground.stress(self._setting, position, travel))
        for launch in self._launches:
            self._run.launch(launch)
        self._layer_count += 1
        has_risen_by_a_row = self._layer_count % self._layers_per_row == 0
        if has_risen_by_a_row and self._run.plan.find("far_field.displacement"):
            # The springs at the side belong to the soil there.
            springs = self._run.array("far_field.displacement").copy()
            springs[1:] = springs[:-1]
            springs[0] = (
                0.0
                if self._ground is None
                else self._ground.entering_spring(self._setting, self.travel)
            )
            self._run.assign("far_field.displacement", springs)
        for part in self._followers:
            part.follow(self._run, self._setting, self.travel)

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
def _make_enter(kind: str, dtype: Any) -> Any:
    """The kernel that writes the values of a layer into its slots; over the layer's particles."""
    scalar = getattr(dtype, "_wp_scalar_type_", dtype).__name__

    @wp.kernel(module=f"mpm_warp.enter.{kind}.{scalar}", enable_backward=False)
    def enter(
        layer_slots: wp.array(dtype=int), layer: wp.array(dtype=dtype), field: wp.array(dtype=dtype)
    ):
        k = wp.tid()
        field[layer_slots[k]] = layer[k]

    return enter
