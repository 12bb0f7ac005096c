"""The watch on a run: one that diverges ends with a named error, not with wrong numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grids import Floats, Integers
from mpm_warp.materials import PerfectlyPlastic, Tresca

if TYPE_CHECKING:
    import xarray

YIELD_ROUNDINGS = 64
"""Roundings of the greatest stress by which a stress may be beyond the yield surface."""
OVERFULL = 20
"""Soil in a cell, over that of a full one, that no compression of soil could explain."""


class SimulationDiverged(RuntimeError):
    """The run became unstable; the message is one line and names what, where and when.

    Attributes:
        status: how a harness files the case.
        history: curves up to there, or none.
    """

    status = "diverged"
    history: xarray.Dataset | None = None


class InaccurateRun(RuntimeError):
    """The run came to its end, but not to a result to be relied on; the message is one line.

    Attributes:
        status: how a harness files the case.
        history: its curves.
    """

    status = "inaccurate"

    def __init__(self, message: str, history: xarray.Dataset) -> None:
        super().__init__(message)
        self.history = history


class WindowOverfull(SimulationDiverged):
    """More soil stays in the travelling window than it has places for: it piles up on the shaft."""


class Fault(Exception):
    """What the watch has found: the begin of a message, without when and what to do."""


def check_particles(
    *,
    number: Integers,
    position: Floats,
    velocity: Floats,
    stress: Floats,
    mass: Floats,
    speed_limit: float,
    bounds: tuple[Floats, Floats],
) -> None:
    """Check that particles are within the grid, finite and slower than the waves that they carry.

    Args:
        number: by which a particle is named, shape [particle_count].
        position: coordinates [m], shape [particle_count, 2].
        velocity: [m/s], shape [particle_count, 2].
        stress: four components [Pa], shape [particle_count, 4].
        mass: [kg], shape [particle_count].
        speed_limit: pressure wave speed [m/s].
        bounds: lowest and highest coordinates of the grid [m].

    Raises:
        Fault: a particle is not.
    """
    # NaN is not within any limit either.
    sound = {
        "velocity": (velocity, np.abs(velocity).max(axis=1) < speed_limit),
        "stress": (stress, np.isfinite(stress).all(axis=1)),
        "mass": (mass, (mass > 0.0) & np.isfinite(mass)),
        "position": (position, _within(position, bounds)),
    }
    for quantity, (values, healthy) in sound.items():
        if not healthy.all():
            worst = int(np.argmin(healthy))
            raise Fault(
                f"{quantity} of {_particle(number, position, worst)} is {_text(values[worst])}"
            )


def check_yield(
    *, number: Integers, position: Floats, stress: Floats, material: PerfectlyPlastic
) -> None:
    """Check that stresses (rr, zz, rz, tt) are on or inside the yield surface.

    Raises:
        Fault: one is not.
    """
    excess = yield_excess(stress, material)
    greatest = np.abs(stress).max(axis=1) / material.strength
    rounding = YIELD_ROUNDINGS * np.finfo(stress.dtype).eps * (1.0 + greatest)
    worst = int(np.argmax(excess - rounding))
    if excess[worst] > rounding[worst]:
        raise Fault(
            f"stress of {_particle(number, position, worst)} is {_text(stress[worst])}, outside "
            f"the yield surface by {excess[worst]:.2g} of the strength"
        )


def yield_excess(stress: Floats, material: PerfectlyPlastic) -> Floats:
    """How far stresses are outside the yield surface over the strength; < 0 inside."""
    rr, zz, rz, tt = stress.astype(np.float64).T
    if isinstance(material, Tresca):
        centre, radius = 0.5 * (rr + zz), np.hypot(0.5 * (rr - zz), rz)
        extreme = np.maximum(centre + radius, tt) - np.minimum(centre - radius, tt)
        beyond: Floats = 0.5 * extreme / material.strength - 1.0
        return beyond
    mean = (rr + zz + tt) / 3.0
    j2 = 0.5 * ((rr - mean) ** 2 + (zz - mean) ** 2 + (tt - mean) ** 2) + rz**2
    excess: Floats = np.sqrt(j2) / material.strength - 1.0
    return excess


def check_cells(
    *, cell: Integers, mass: Floats, full_mass: Floats, particles_per_cell: int
) -> None:
    """Check that no cell holds more soil than could be pressed into it, by mass and by number.

    Of a cell that a surface cuts, little may be open, which one particle then fills many times.

    Args:
        cell: flat index of each particle's cell, shape [particle_count].
        mass: of the particles [kg], shape [particle_count].
        full_mass: of each cell when it is full [kg], shape [cell_count].
        particles_per_cell: particles that fill a cell.

    Raises:
        Fault: one does.
    """
    by_mass = np.bincount(cell, weights=mass, minlength=len(full_mass)) / full_mass
    by_number = np.bincount(cell, minlength=len(full_mass)) / particles_per_cell
    filling = np.minimum(by_mass, by_number)
    worst = int(np.argmax(filling))
    if not filling[worst] < OVERFULL:
        raise Fault(f"soil in cell {worst} is {filling[worst]:.3g} times that of a full one")


def check_time_step(*, time_step: float, longest: float) -> None:
    """Check that the time step is at most the longest that is stable [s].

    Raises:
        Fault: it is not.
    """
    if not time_step <= longest:
        raise Fault(f"time step of {time_step:.4g} s is beyond the stable {longest:.4g} s")


def _within(position: Floats, bounds: tuple[Floats, Floats]) -> NDArray[np.bool_]:
    within: NDArray[np.bool_] = np.all((position >= bounds[0]) & (position <= bounds[1]), axis=1)
    return within


def _particle(number: Integers, position: Floats, index: int) -> str:
    return f"particle {number[index]} at {_text(position[index])} m"


def _text(values: Floats) -> str:
    return np.array2string(np.asarray(values), precision=4, separator=", ")
