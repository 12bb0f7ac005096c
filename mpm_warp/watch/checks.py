"""What is looked at in a run that may have become unsound: one function a check.

Each raises a `Fault` that names what, and where; when, and what may help, is added by who calls.
"""

from typing import Any

import numpy as np

from mpm_warp.errors import Fault
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.parts.contact import SurfaceContact

STRESS_ROUNDINGS = 64
"""Roundings of the greatest stress by which a step may change the mean stress by itself."""
OVERFULL = 20
"""Soil in a cell, over that of a full one, that no compression of soil could explain."""
EMPTIED = 0.1
"""Soil in a block of cells, over that at the start, that no passing of particles could explain."""
LARGEST_PARTED_SHARE = 0.1
"""Share of a surface that noise may part where the soil cannot pull as the ground presses."""
ROUNDED = 1e-3
"""Normal velocity at a surface, over the greatest there, that is rounding."""


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
    # NaN is not within any limit either. A reduction over all components is the fastest.
    sound = {
        "velocity": (velocity, np.abs(velocity) < speed_limit),
        "stress": (stress, np.isfinite(stress)),
        "mass": (mass, (mass > 0.0) & np.isfinite(mass)),
        "position": (position, (position >= bounds[0]) & (position <= bounds[1])),
    }
    for quantity, (values, healthy) in sound.items():
        if not healthy.all():
            worst = int(np.argmin(healthy)) // values[0].size
            raise Fault(
                f"{quantity} of {_particle(number[worst], position[worst])} is "
                f"{_text(values[worst])}"
            )


def check_yield(*, margin: Floats, particle: Integers, position: Floats, stress: Floats) -> None:
    """Check that stresses are on or inside the yield surface.

    Args:
        margin: by how much the worst of some particles is outside beyond rounding, over the
            strength; shape [block_count].
        particle: number of the worst of each, shape [block_count].
        position: coordinates of all particles [m], shape [particle_count, 2].
        stress: of all (rr, zz, rz, tt) [Pa], shape [particle_count, 4].

    Raises:
        Fault: one is outside.
    """
    block = int(np.argmax(margin))
    if margin[block] > 0.0:
        worst = int(particle[block])
        raise Fault(
            f"stress of {_particle(worst, position[worst])} is {_text(stress[worst])}, outside "
            f"the yield surface by {margin[block]:.2g} of the strength"
        )


def check_cells(
    *, mass: Floats, count: Integers, full_mass: Floats, particles_per_cell: int
) -> None:
    """Check that no cell holds more soil than could be pressed into it, by mass and by number.

    Of a cell that a surface cuts, little may be open, which one particle then fills many times.

    Args:
        mass: of the soil in each cell [kg], shape [cell_count].
        count: of the particles in each cell, shape [cell_count].
        full_mass: of each cell when it is full [kg], shape [cell_count].
        particles_per_cell: particles that fill a cell.

    Raises:
        Fault: one does.
    """
    filling = np.minimum(mass / full_mass, count / particles_per_cell)
    worst = int(np.argmax(filling))
    if not filling[worst] < OVERFULL:
        raise Fault(f"soil in cell {worst} is {filling[worst]:.3g} times that of a full one")


def block_sums(mass: Floats) -> Floats:
    """Sums over all blocks of 3 x 3 cells, by the row and column in which they begin.

    Args:
        mass: of the soil in each cell [kg], shape [row_count, column_count].
    """
    in_rows = mass[:-2] + mass[1:-1] + mass[2:]
    sums: Floats = in_rows[:, :-2] + in_rows[:, 1:-1] + in_rows[:, 2:]
    return sums


def check_blocks(soil: Floats, first_soil: Floats) -> None:
    """Check that no block of cells has lost its soil.

    Args:
        soil: in each block, see `block_sums` [kg].
        first_soil: the same at the start; a block may have had none.

    Raises:
        Fault: one has.
    """
    emptied = soil < EMPTIED * first_soil
    if emptied.any():
        row, column = np.argwhere(emptied)[0]
        left = soil[row, column] / first_soil[row, column]
        raise Fault(
            f"soil in 3 x 3 cells from row {row}, column {column} is {left:.2g} times that at the "
            "start"
        )


def check_contact(contact: SurfaceContact, velocity: Floats, *, speed: float) -> None:
    """Check that soil and surface move together along their normal, on nearly all of it.

    Nodes on the axis are left out; should soil come apart there, blocks of cells lose theirs.

    Args:
        contact: one of a surface from which the soil cannot part.
        velocity: of the soil at its nodes in the last step [m/s], shape [node_count, 2].
        speed: of the body down through the soil in that step [m/s].

    Raises:
        Fault: they have come apart, or go through each other.
    """
    past = velocity + np.array([0.0, speed])
    normal_speed = np.sum(past * contact.normals, axis=1)
    rounding = ROUNDED * (abs(speed) + np.abs(velocity).max())
    lost = ~(np.abs(normal_speed) <= rounding)
    # Where the axis holds the soil too, the flow may leave a node none for a moment.
    lost[contact.on_axis] = False
    share = contact.normal_areas[lost].sum() / contact.normal_areas.sum()
    if share > LARGEST_PARTED_SHARE:
        worst = int(np.argmax(np.abs(normal_speed)))
        raise Fault(
            f"contact is lost on {share:.0%} of the surface: node {contact.nodes[worst]} goes "
            f"into it at {normal_speed[worst]:.4g} m/s"
        )


def check_mean_stress(
    *,
    number: Integers,
    position: Floats,
    stress: Floats,
    change: Floats,
    told: Floats,
    trial: Floats,
) -> None:
    """Check that the mean stress has changed in a step by what the law tells of its volume.

    Args:
        number: by which a particle is named, shape [particle_count].
        position: coordinates [m], shape [particle_count, 2].
        stress: after the step [Pa], shape [particle_count, 4].
        change: of the mean stress [Pa], shape [particle_count].
        told: by the law of the material, see `Material.mean_stress_change`, likewise.
        trial: greatest change of a component in the trial stress [Pa], likewise.

    Raises:
        Fault: one has not; the mean stress drifts.
    """
    greatest = _greatest(stress) + np.abs(told) + trial
    drift = np.abs(change - told) - STRESS_ROUNDINGS * np.finfo(stress.dtype).eps * greatest
    worst = int(np.argmax(drift))
    if not drift[worst] <= 0.0:
        raise Fault(
            f"mean stress of {_particle(number[worst], position[worst])} has changed in a step by "
            f"{change[worst]:.4g} Pa, its volume by what makes {told[worst]:.4g} Pa"
        )


def _greatest(stress: Floats) -> Floats:
    """Greatest component, by size, of each stress: rows of a transposed copy are fast to reduce."""
    greatest: Floats = np.abs(stress.T.copy()).max(axis=0)
    return greatest


def _particle(number: int | np.integer[Any], position: Floats) -> str:
    return f"particle {number} at {_text(position)} m"


def _text(values: Floats) -> str:
    return np.array2string(np.asarray(values), precision=4, separator=", ")
