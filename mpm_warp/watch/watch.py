"""The watch on a run: one that diverges ends with a named error, not with wrong numbers."""

import functools
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.materials.material import PROPERTIES
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Run
from mpm_warp.plan.time_step import check_time_step
from mpm_warp.scene import Scene
from mpm_warp.watch.checks import (
    block_sums,
    check_blocks,
    check_cells,
    check_contact,
    check_mean_stress,
    check_particles,
    check_yield,
)

LOOKED_AT_ONCE = 4_000
"""Particles that the watch looks at together; the memory of more would be fetched each time."""
SAMPLED = 2_000
"""Particles, about, whose mean stress is compared with their volume."""


class Watch(Protocol):
    """A watch on a run."""

    @property
    def particle_count(self) -> int:
        """Particles at the last look."""

    def prepare(self) -> None:
        """Record what the next step, the last one before a look, is compared with."""

    def look(self) -> None:
        """Look at the run.

        Raises:
            Fault: it is not sound; the message names what and where.
        """


class ParticleWatch:
    """Looks at each particle by itself, and at the time step.

    Attributes:
        particle_count: particles at the last look.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self.particle_count = run.plan.particle_count

    def prepare(self) -> None:
        """Record what the next step, the last one before a look, is compared with."""

    def look(self) -> None:
        """Look at the run.

        Raises:
            Fault: it is not sound; the message names what and where.
        """
        plan = self._run.plan
        check_time_step(time_step=plan.time_step, longest=plan.longest_time_step)
        present = self._present
        self.particle_count = len(present)
        names = ("position", "velocity", "stress", "mass")
        for first in range(0, len(present), LOOKED_AT_ONCE):
            part = present[first : first + LOOKED_AT_ONCE]
            check_particles(
                number=part,
                **{name: self._of(name, part) for name in names},
                speed_limit=plan.speed_limit,
                bounds=plan.particle_bounds,
            )
        self._look_at_all(present)

    def _look_at_all(self, present: Integers) -> None:
        """Look at what is more than each particle by itself."""

    @property
    def _present(self) -> Integers:
        """The slots that hold a particle."""
        if self._run.plan.find("particle.cell") is None:
            return np.arange(self._run.plan.particle_count, dtype=np.int32)
        slots = np.flatnonzero(self._run.array("particle.cell")[:, 0] >= 0)
        return slots.astype(np.int32)

    def _of(self, name: str, particle: Integers) -> NDArray[Any]:
        return self._run.array(f"particle.{name}").take(particle, axis=0)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Before:
    """What is recorded before the last step that a look is at.

    Attributes:
        particle: slots of a sample of the particles, shape [sample_count].
        cell: the cells that these are in.
        trace: sum of their normal stresses [Pa].
        state: what they remember, shape [sample_count, state_count]; None where nothing.
        speed: of the rigid body down through the soil [m/s].
    """

    particle: Integers
    cell: Integers
    trace: Floats
    state: Floats | None
    speed: float


class SoilWatch(ParticleWatch):
    """Looks at yield, cells, contact and what the last step did to the mean stress, besides."""

    def __init__(self, scene: Scene, run: Run) -> None:
        super().__init__(run)
        self._scene = scene
        present = self._present
        self._first_blocks = self._blocks(self._mass_in(self._cell_of(present), present))
        contact, window = scene.find(SurfaceContact), scene.find(MovingGrid)
        speed = window.first_speed if window else contact.speed if contact else 0.0
        self._parts = contact is not None and contact.can_part(scene.material, speed)
        self._before: _Before | None = None

    def prepare(self) -> None:
        """Record what the next step, the last one before a look, is compared with."""
        present = self._present
        sample = present[:: 1 + len(present) // SAMPLED]
        self._before = _Before(
            particle=sample,
            cell=self._cell_of(sample),
            trace=self._trace_of(sample),
            state=self._state_of(sample),
            speed=self._speed,
        )

    def _look_at_all(self, present: Integers) -> None:
        self._look_at_yield()
        self._look_at_cells(present)
        if self._before is not None:
            self._look_at_contact(self._before)
            self._look_at_mean_stress(self._before)
            self._before = None

    def _look_at_yield(self) -> None:
        launch = self._run.plan.between_steps.get("yield_check")
        if launch is not None:
            self._run.launch(launch)
            check_yield(
                margin=self._run.array("yield.margin"),
                particle=self._run.array("yield.particle"),
                position=self._run.array("particle.position"),
                stress=self._run.array("particle.stress"),
            )

    def _look_at_cells(self, present: Integers) -> None:
        scene, volume = self._scene, self._run.array("cell.volume")
        cell = self._cell_of(present)
        mass = self._mass_in(cell, present)
        check_cells(
            mass=mass,
            count=np.bincount(cell, minlength=len(volume)),
            full_mass=scene.material.density * volume,
            particles_per_cell=scene.particles_per_side**2,
        )
        # Elsewhere soil may leave a cell by right: below a free surface, beside one that parts.
        if not (scene.find(FreeSurface) or self._parts):
            check_blocks(self._blocks(mass), self._first_blocks)

    def _look_at_contact(self, before: _Before) -> None:
        contact = self._scene.find(SurfaceContact)
        if contact is not None and not self._parts:
            velocity = self._run.array("node.velocities")[contact.nodes, :2]
            check_contact(contact, velocity, speed=before.speed)

    def _look_at_mean_stress(self, before: _Before) -> None:
        material, particle = self._scene.material, before.particle
        # The strain of the step in the cell that each was in.
        motion = self._run.array("cell.motion").take(before.cell, axis=0)
        strain = motion[:, :4].astype(np.float64)
        after = self._state_of(particle)
        told = material.mean_stress_change(
            strain[:, 0] + strain[:, 1] + strain[:, 3],
            self._properties_of(particle),
            None if before.state is None or after is None else (before.state, after),
        )
        if told is None:
            return
        check_mean_stress(
            number=particle,
            position=self._of("position", particle),
            stress=self._of("stress", particle),
            change=(self._trace_of(particle) - before.trace) / 3.0,
            told=told,
            # The deviator has rounded too, before the return took it away.
            trial=2.0 * material.ground_shear_modulus * np.abs(strain).max(axis=1),
        )

    @property
    def _speed(self) -> float:
        """Of the rigid body down into the soil in the next step [m/s]."""
        if self._run.plan.find("window.motion"):
            return float(self._run.array("window.motion")[1])
        contact = self._scene.find(SurfaceContact)
        return 0.0 if contact is None else contact.speed

    def _trace_of(self, particle: Integers) -> Floats:
        rr, zz, _, tt = self._of("stress", particle).T
        trace: Floats = rr + zz + tt
        return trace

    def _state_of(self, particle: Integers) -> Floats | None:
        return self._of("state", particle) if self._run.plan.find("particle.state") else None

    def _properties_of(self, particle: Integers) -> Floats:
        if self._run.plan.find(PROPERTIES):
            return self._of("properties", particle)
        return np.tile(self._scene.material.properties, (len(particle), 1))

    def _cell_of(self, particle: Integers) -> Integers:
        column, row = self._of("cell", particle).T
        cell: Integers = row * self._scene.grid.column_count + column
        return cell

    def _mass_in(self, cell: Integers, particle: Integers) -> Floats:
        count = self._scene.grid.cell_count
        mass = np.bincount(cell, self._of("mass", particle), minlength=count)
        return mass.astype(np.float64, copy=False)

    def _blocks(self, mass: Floats) -> Floats:
        grid = self._scene.grid
        return block_sums(mass.reshape(grid.row_count, grid.column_count))


@functools.singledispatch
def make_watch(scene: object, run: Run) -> Watch:
    """The watch on a run of a scene: of each particle, where its kind has registered no other."""
    return ParticleWatch(run)


make_watch.register(Scene, SoilWatch)
