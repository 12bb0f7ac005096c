"""Checks during a run: a run that diverges ends with an error, not with wrong numbers.

A check raises a `Fault` that says what is wrong and where. The simulation adds the time and what
may help.
"""

import functools
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpm_warp.errors import Fault
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.materials.material import PROPERTIES
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Run, check_time_step
from mpm_warp.scene import Scene

BLOCK_SIZE = 4_000
"""Particles that are checked together; arrays of more would not fit into the fast memory."""
SAMPLE_SIZE = 2_000
"""Approximate number of particles whose mean stress is compared with their volume."""
STRESS_ROUNDINGS = 64
"""Allowed error of the change of mean stress, over the rounding of the greatest stress."""
OVERFULL = 20
"""Mass in a cell over that of a full cell from which on the run is not sound."""
EMPTIED = 0.1
"""Mass in a block of cells over the initial mass, below which the run is not sound."""
LARGEST_PARTED_SHARE = 0.1
"""Allowed share of a surface without contact, due to noise, if the soil cannot part from it."""
SPEED_ROUNDING = 1e-3
"""Normal velocity at a surface, over the greatest velocity there, that counts as rounding."""


class ParticleWatch:
    """Checks of single particles and of the time step.

    Attributes:
        particle_count: particles at the last check.
    """

    def __init__(self, run: Run) -> None:
        self._run = run
        self.particle_count = run.plan.particle_count

    def prepare(self) -> None:
        """Record values before the next step; `look` compares them with those after it."""

    def look(self) -> None:
        """Raise `Fault`, which says what and where, if the run is not sound."""
        plan = self._run.plan
        check_time_step(time_step=plan.time_step, longest=plan.longest_time_step)
        present = self._present
        self.particle_count = len(present)
        if not len(present):
            raise Fault("no material point is left in the grid")
        for first in range(0, len(present), BLOCK_SIZE):
            self._look_at_particles(present[first : first + BLOCK_SIZE])
        self._look_at_all(present)

    def _look_at_particles(self, particle: Integers) -> None:
        """Check that particles are in the grid, finite and slower than pressure waves."""
        lower, upper = self._run.plan.particle_bounds
        position, velocity = self._of("position", particle), self._of("velocity", particle)
        stress, mass = self._of("stress", particle), self._of("mass", particle)
        # NaN fails every comparison. A reduction over all components is the fastest.
        looked_at = [
            ("velocity", velocity, np.abs(velocity) < self._run.plan.speed_limit),
            ("stress", stress, np.isfinite(stress)),
            ("mass", mass, (mass > 0.0) & np.isfinite(mass)),
            ("position", position, (position >= lower) & (position <= upper)),
        ]
        if "particle.state" in self._run.plan.arrays:
            state = self._of("state", particle)
            looked_at.append(("state", state, np.isfinite(state)))
        for quantity, values, sound in looked_at:
            if not sound.all():
                worst = int(np.argmin(sound)) // values[0].size
                raise Fault(
                    f"{quantity} of {self._named(particle[worst])} is {_text(values[worst])}"
                )

    def _look_at_all(self, present: Integers) -> None:
        """Further checks of a subclass."""

    @property
    def _present(self) -> Integers:
        """Slots that hold a particle."""
        if "particle.cell" not in self._run.plan.arrays:
            return np.arange(self._run.plan.particle_count, dtype=np.int32)
        slots = np.flatnonzero(self._run.array("particle.cell")[:, 0] >= 0)
        return slots.astype(np.int32)

    def _of(self, name: str, particle: Integers) -> NDArray[Any]:
        return self._run.array(f"particle.{name}").take(particle, axis=0)

    def _named(self, particle: int | np.integer[Any]) -> str:
        return f"particle {particle} at {_text(self._run.array('particle.position')[particle])} m"


class _Before(NamedTuple):
    """Values before the last step."""

    particle: Integers  # slots of a sample of the particles
    cell: Integers  # the cell of each
    trace: Floats  # sum of the normal stresses [Pa]
    state: Floats | None  # state variables, shape [sample_count, state_count]
    speed: float  # of the rigid body down through the soil [m/s]


class SoilWatch(ParticleWatch):
    """Checks yield, cells, contact and the change of mean stress in the last step too."""

    def __init__(self, scene: Scene, run: Run) -> None:
        super().__init__(run)
        self._scene = scene
        present = self._present
        self._initial_soil = self._soil_in_blocks(self._mass_in(self._cell_of(present), present))
        contact, window = scene.find(SurfaceContact), scene.find(MovingGrid)
        speed = window.first_speed if window else contact.speed if contact else 0.0
        self._can_part = contact is not None and contact.can_part(scene.material, speed)
        self._before: _Before | None = None

    def prepare(self) -> None:
        """See `ParticleWatch`."""
        contact = self._scene.find(SurfaceContact)
        speed = 0.0 if contact is None else contact.speed
        if "window.motion" in self._run.plan.arrays:
            speed = float(self._run.array("window.motion")[1])
        present = self._present
        sample = present[:: 1 + len(present) // SAMPLE_SIZE]
        self._before = _Before(
            particle=sample,
            cell=self._cell_of(sample),
            trace=self._trace_of(sample),
            state=self._state_of(sample),
            speed=speed,
        )

    def _look_at_all(self, present: Integers) -> None:
        self._look_at_yield()
        cell = self._cell_of(present)
        mass = self._mass_in(cell, present)
        self._look_at_cells(cell, mass)
        # Below a free surface, and beside a surface that parts, cells may lose their soil.
        if not (self._scene.find(FreeSurface) or self._can_part):
            self._look_at_blocks(self._soil_in_blocks(mass))
        if self._before is not None:
            if (contact := self._scene.find(SurfaceContact)) is not None and not self._can_part:
                velocity = self._run.array("node.velocities")[contact.nodes, :2]
                on_axis = self._scene.grid.node_positions[contact.nodes, 0] == 0.0
                check_contact(contact, velocity, speed=self._before.speed, on_axis=on_axis)
            self._look_at_mean_stress(self._before)
            self._before = None

    def _look_at_yield(self) -> None:
        """No stress is outside the yield surface by more than rounding."""
        launch = self._run.plan.between_steps.get("yield_check")
        if launch is None:
            return
        self._run.launch(launch)
        margin = self._run.array("yield.margin")
        block = int(np.argmax(margin))
        if not margin[block] <= 0.0:  # NaN if the law's measure or strength is NaN
            worst = int(self._run.array("yield.particle")[block])
            stress = self._run.array("particle.stress")[worst]
            raise Fault(
                f"stress of {self._named(worst)} is {_text(stress)}, outside the yield surface by "
                f"{margin[block]:.2g} of the strength"
            )

    def _look_at_cells(self, cell: Integers, mass: Floats) -> None:
        """Check that no cell is overfull, by mass and by number of particles.

        Mass alone is not enough: a single particle may overfill a cell that a surface cuts.
        """
        volume = self._run.array("cell.volume")
        count = np.bincount(cell, minlength=len(volume))
        filling = np.minimum(
            mass / (self._scene.material.density * volume),
            count / self._scene.particles_per_side**2,
        )
        worst = int(np.argmax(filling))
        if not filling[worst] < OVERFULL:
            raise Fault(f"soil in cell {worst} is {filling[worst]:.3g} times that of a full one")

    def _look_at_blocks(self, soil: Floats) -> None:
        """Check that no block of cells has lost its initial soil."""
        emptied = soil < EMPTIED * self._initial_soil
        if emptied.any():
            row, column = np.argwhere(emptied)[0]
            left = soil[row, column] / self._initial_soil[row, column]
            raise Fault(
                f"soil in 3 x 3 cells from row {row}, column {column} is {left:.2g} times that at "
                "the start"
            )

    def _look_at_mean_stress(self, before: _Before) -> None:
        """Check the change of mean stress against that of the law for the change of volume."""
        material, particle = self._scene.material, before.particle
        # The strain of the step in the cell of each particle.
        strain = self._run.array("cell.motion").take(before.cell, axis=0)[:, :4]
        after = self._state_of(particle)
        own = np.tile(material.properties, (len(particle), 1))
        if PROPERTIES in self._run.plan.arrays:
            own = self._of("properties", particle)
        expected = material.mean_stress_change(
            strain[:, 0] + strain[:, 1] + strain[:, 3],
            own,
            None if before.state is None or after is None else (before.state, after),
        )
        if expected is None:
            return
        stress = self._of("stress", particle)
        change = (self._trace_of(particle) - before.trace) / 3.0
        # The trial stress before the return to the yield surface has rounding errors too.
        trial = 2.0 * material.ground_shear_modulus * np.abs(strain).max(axis=1)
        # Rows of a transposed copy are fast to reduce.
        greatest = np.abs(stress.T.copy()).max(axis=0) + np.abs(expected) + trial
        drift = np.abs(change - expected) - STRESS_ROUNDINGS * np.finfo(stress.dtype).eps * greatest
        worst = int(np.argmax(drift))
        if not drift[worst] <= 0.0:
            raise Fault(
                f"mean stress of {self._named(particle[worst])} has changed in a step by "
                f"{change[worst]:.4g} Pa, its volume by what makes {expected[worst]:.4g} Pa"
            )

    def _trace_of(self, particle: Integers) -> Floats:
        rr, zz, _, tt = self._of("stress", particle).T
        trace: Floats = rr + zz + tt
        return trace

    def _state_of(self, particle: Integers) -> Floats | None:
        return self._of("state", particle) if "particle.state" in self._run.plan.arrays else None

    def _cell_of(self, particle: Integers) -> Integers:
        column, row = self._of("cell", particle).T
        cell: Integers = row * self._scene.grid.column_count + column
        return cell

    def _mass_in(self, cell: Integers, particle: Integers) -> Floats:
        count = self._scene.grid.cell_count
        mass = np.bincount(cell, self._of("mass", particle), minlength=count)
        return mass.astype(np.float64, copy=False)

    def _soil_in_blocks(self, mass: Floats) -> Floats:
        """Sums over all blocks of 3 x 3 cells, by their first row and column."""
        mass = mass.reshape(self._scene.grid.row_count, self._scene.grid.column_count)
        in_rows = mass[:-2] + mass[1:-1] + mass[2:]
        return in_rows[:, :-2] + in_rows[:, 1:-1] + in_rows[:, 2:]


def check_contact(
    contact: SurfaceContact, velocity: Floats, *, speed: float, on_axis: NDArray[np.bool_]
) -> None:
    """Check that soil, if it cannot part from a surface, moves with it along the normal.

    `velocity` is that of the soil at the nodes in the last step [m/s], shape [node_count, 2],
    `speed` that of the body down through the soil [m/s]. Nodes `on_axis`, shape [node_count], are
    left out: the axis holds the soil there too, and the check of blocks of cells finds a gap.

    Raises:
        Fault: on too large a share of the surface the normal velocities differ.
    """
    past = velocity + np.array([0.0, speed])
    normal_speed = np.sum(past * contact.normals, axis=1)
    rounding = SPEED_ROUNDING * (abs(speed) + np.abs(velocity).max())
    lost = ~(np.abs(normal_speed) <= rounding)
    # A node on the axis may have no soil for a moment.
    lost[on_axis] = False
    share = contact.normal_areas[lost].sum() / contact.normal_areas.sum()
    if share > LARGEST_PARTED_SHARE:
        worst = int(np.argmax(np.abs(normal_speed)))
        raise Fault(
            f"contact is lost on {share:.0%} of the surface: node {contact.nodes[worst]} goes "
            f"into it at {normal_speed[worst]:.4g} m/s"
        )


def _text(values: Floats) -> str:
    return np.array2string(np.asarray(values), precision=4, separator=", ")


@functools.singledispatch
def make_watch(scene: object, run: Run) -> ParticleWatch:
    """The watch on a run; kinds of scenes may register their own."""
    return ParticleWatch(run)


make_watch.register(Scene, SoilWatch)
