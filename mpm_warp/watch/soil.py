"""What the watch looks at in soil that fills its grid, beside each particle by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.watch.health import (
    block_sums,
    check_blocks,
    check_cells,
    check_contact,
    check_mean_stress,
)
from mpm_warp.execution.host_arrays import HostArrays
from mpm_warp.plan.plan import Plan

SAMPLED = 2_000
"""Particles, about, whose mean stress is held against their volume."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Before:
    """What is noted before the last step that a look is at.

    Attributes:
        particle: places of a sample of the particles, shape [sample_count].
        cell: the cells that these are in.
        trace: sum of their normal stresses [Pa].
        speed: of the rigid body into the soil [m/s].
    """

    particle: Integers
    cell: Integers
    trace: Floats
    speed: float


class SoilWatch:
    """Looks at the cells of a run, its contact, and what its last step did to the mean stress.

    Args:
        plan: of the run.
        array: gives arrays of the run by name.
        present: places of the particles that are in the grid at the start.
    """

    def __init__(self, plan: Plan, array: HostArrays, present: Integers) -> None:
        self._plan = plan
        self._array = array
        self._first_blocks = self._blocks(self._mass_in(self._cell_of(present), present))
        contact, window = plan.scene.contact, plan.scene.window
        speed = window.first_speed if window else contact.speed if contact else 0.0
        self._parts = contact is not None and contact.can_part(plan.scene.material, speed)
        self._before: _Before | None = None

    def prepare(self, present: Integers) -> None:
        """Note what the next step, the last one before a look, is held against."""
        sample = present[:: 1 + len(present) // SAMPLED]
        self._before = _Before(
            particle=sample,
            cell=self._cell_of(sample),
            trace=self._trace_of(sample),
            speed=self._speed,
        )

    def look(self, present: Integers) -> None:
        """Look at the soil.

        Args:
            present: places of the particles that are in the grid.

        Raises:
            Fault: it is not sound.
        """
        self._look_at_cells(present)
        if self._before is not None:
            self._look_at_contact(self._before)
            self._look_at_mean_stress(self._before)
            self._before = None

    def _look_at_cells(self, present: Integers) -> None:
        scene, volume = self._plan.scene, self._array("cell.volume")
        cell = self._cell_of(present)
        mass = self._mass_in(cell, present)
        check_cells(
            mass=mass,
            count=np.bincount(cell, minlength=len(volume)),
            full_mass=scene.material.density * volume,
            particles_per_cell=scene.particles_per_side**2,
        )
        # Elsewhere soil may leave a cell by right: below a free surface, beside one that parts.
        if not (scene.free_surface or self._parts):
            check_blocks(self._blocks(mass), self._first_blocks)

    def _look_at_contact(self, before: _Before) -> None:
        contact = self._plan.scene.contact
        if contact is not None and not self._parts:
            velocity = self._array("node.motion")[contact.nodes, :2]
            check_contact(contact, velocity, speed=before.speed)

    def _look_at_mean_stress(self, before: _Before) -> None:
        # What the step did to the stress in the cell that each was in; without the rotation.
        step = self._array("cell.step").take(before.cell, axis=0)[:, :4]
        check_mean_stress(
            number=before.particle,
            position=self._of("position", before.particle),
            stress=self._of("stress", before.particle),
            change=self._trace_of(before.particle) - before.trace,
            step=step,
        )

    @property
    def _speed(self) -> float:
        """Of the rigid body into the soil in the next step [m/s]."""
        scene = self._plan.scene
        if scene.window is not None:
            return float(self._array("window.motion")[1])
        return 0.0 if scene.contact is None else scene.contact.speed

    def _trace_of(self, particle: Integers) -> Floats:
        rr, zz, _, tt = self._of("stress", particle).T
        trace: Floats = rr + zz + tt
        return trace

    def _cell_of(self, particle: Integers) -> Integers:
        column, row = self._of("cell", particle).T
        cell: Integers = row * self._plan.scene.grid.column_count + column
        return cell

    def _mass_in(self, cell: Integers, particle: Integers) -> Floats:
        count = self._plan.scene.grid.cell_count
        mass = np.bincount(cell, self._of("mass", particle), minlength=count)
        return mass.astype(np.float64, copy=False)

    def _blocks(self, mass: Floats) -> Floats:
        grid = self._plan.scene.grid
        return block_sums(mass.reshape(grid.row_count, grid.column_count))

    def _of(self, name: str, particle: Integers) -> NDArray[Any]:
        return self._array(f"particle.{name}").take(particle, axis=0)
