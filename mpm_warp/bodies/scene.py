"""What a user declares for bodies in contact: particles of several bodies on one uniform grid.

Each body has a velocity field of its own. Where two bodies meet, and along which normal, is found
from their particles in every step; nothing of it is declared. A part that is None, or empty, costs
nothing in the run. SI units; plane strain per unit thickness, axisymmetric per radian.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.materials import LinearElastic
from mpm_warp.scene import SceneError

TOUCHING = 0.9
"""Bodies overlap where particles are nearer to each other than this, over their mean spacing."""


@dataclass(frozen=True, kw_only=True)
class UniformGrid:
    """A grid of square cells.

    Attributes:
        lower: corner of the lowest coordinates, (x, y) or (r, z) [m]; r >= 0.
        cell_size: side of a cell [m], > 0.
        cell_counts: cells along both axes, >= 3 each.
        axisymmetric: whether the axes are (r, z), else plane strain in (x, y).
    """

    lower: tuple[float, float]
    cell_size: float
    cell_counts: tuple[int, int]
    axisymmetric: bool = False

    def __post_init__(self) -> None:
        if self.cell_size <= 0.0:
            raise SceneError(f"grid: cell_size = {self.cell_size:g} m must be > 0")
        if min(self.cell_counts) < 3:
            raise SceneError(f"grid: cell_counts = {self.cell_counts} must be 3 or more each")
        if self.axisymmetric and self.lower[0] < 0.0:
            raise SceneError(f"grid: lower r = {self.lower[0]:g} m must be >= 0")

    @property
    def node_counts(self) -> tuple[int, int]:
        """Nodes along both axes."""
        return self.cell_counts[0] + 1, self.cell_counts[1] + 1

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return self.node_counts[0] * self.node_counts[1]

    @property
    def particle_bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest coordinates at which all nodes of a quadratic B-spline exist [m]."""
        lower = np.asarray(self.lower) + 0.5 * self.cell_size
        return lower, lower + self.cell_size * (np.asarray(self.cell_counts) - 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Load:
    """Dead forces on the particles of a body, which rise linearly from zero and then stay.

    Attributes:
        forces: final force on each particle [N], shape [particle_count, 2].
        start: time at which they begin to rise [s], >= 0.
        rise_time: time that they take to rise [s], > 0.
    """

    forces: Floats
    start: float
    rise_time: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Body:
    """A linear elastic body, or a rigid one, as a square lattice of particles.

    Attributes:
        position: places of the particles [m], shape [particle_count, 2].
        volume: volumes of the particles per radian or thickness, shape [particle_count].
        spacing: side of the square that a particle stands for [m], > 0.
        material: elastic constants and density.
        held: particles at rest for ever, shape [particle_count]; the body is rigid and immovable
            at every node that one of them reaches. None where none is.
        retardation_time: tau of a Kelvin-Voigt solid, whose stress is that of the strain plus tau
            times the rate of strain [s], > 0; None where the body has no damping. It damps a
            frequency omega by omega tau / 2 of the critical damping.
        loads: forces on the particles.
    """

    position: Floats
    volume: Floats
    spacing: float
    material: LinearElastic
    held: NDArray[np.bool_] | None = None
    retardation_time: float | None = None
    loads: tuple[Load, ...] = ()

    @property
    def particle_count(self) -> int:
        """Number of particles."""
        return len(self.volume)

    @property
    def mass(self) -> Floats:
        """Masses of the particles [kg], shape [particle_count]."""
        return self.material.density * self.volume

    def critical_time_step(self, cell_size: float, thinning: float = 1.0) -> float:
        """Time in which a wave crosses a cell, shorter where damping makes it so [s].

        Args:
            cell_size: side of a cell [m].
            thinning: volume over that at rest: a body that is drawn out has the same moduli and a
                lower density, and so faster waves.
        """
        crossing = cell_size / (self.material.pressure_wave_speed * math.sqrt(thinning))
        damping_ratio = (self.retardation_time or 0.0) / crossing
        return crossing * (math.hypot(1.0, damping_ratio) - damping_ratio)


@dataclass(frozen=True, kw_only=True)
class BodyContact:
    """Contact between two bodies.

    The normal is that of the base, whose surface should go on where the body's ends: at its edges
    a body's own normal turns away. The area is the body's own along that normal.

    Attributes:
        body: index of one body in the scene.
        base: index of the other.
        friction: Coulomb coefficient, dimensionless, >= 0.
        adhesion: shear stress transmitted without normal stress [Pa], >= 0.
    """

    body: int
    base: int
    friction: float = 0.0
    adhesion: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyScene:
    """Bodies on a grid, and contact between them.

    Attributes:
        grid: the background grid.
        bodies: one or more.
        time_step_fraction: time step over the critical one, see `Body.critical_time_step`, > 0.
        contacts: pairs of bodies that feel each other; other pairs pass through each other.

    Raises:
        SceneError: a value is not allowed, a body is not within the grid, or two overlap.
    """

    grid: UniformGrid
    bodies: tuple[Body, ...]
    time_step_fraction: float = 0.6
    contacts: tuple[BodyContact, ...] = ()

    def __post_init__(self) -> None:
        if not self.bodies:
            raise SceneError("bodies: there is none; give one or more")
        if self.time_step_fraction <= 0.0:
            raise SceneError(f"time_step_fraction = {self.time_step_fraction:g} must be > 0")
        for index, body in enumerate(self.bodies):
            self._check_body(index, body)
        for index, contact in enumerate(self.contacts):
            self._check_contact(index, contact)
        for first, body in enumerate(self.bodies):
            for second in range(first + 1, len(self.bodies)):
                _check_overlap(first, body, second, self.bodies[second])

    def _check_body(self, index: int, body: Body) -> None:
        lower, upper = self.grid.particle_bounds
        outside = ~np.all((body.position >= lower) & (body.position <= upper), axis=1)
        if outside.any():
            place = np.array2string(body.position[outside][0], precision=4)
            raise SceneError(
                f"body {index}: {outside.sum()} particles, one at {place} m, are outside the grid "
                f"or within half a cell of its edge, which allows {lower} to {upper} m; widen it"
            )
        if body.retardation_time is not None and not body.retardation_time > 0.0:
            raise SceneError(
                f"body {index}: retardation_time = {body.retardation_time:g} s must be > 0"
            )
        for load in body.loads:
            if load.start < 0.0 or load.rise_time <= 0.0:
                raise SceneError(
                    f"body {index}: load with start = {load.start:g} s, rise_time = "
                    f"{load.rise_time:g} s: must be >= 0 and > 0"
                )

    def _check_contact(self, index: int, contact: BodyContact) -> None:
        for name in ("body", "base"):
            value = getattr(contact, name)
            if not 0 <= value < len(self.bodies):
                raise SceneError(
                    f"contact {index}: {name} = {value}, but the scene has {len(self.bodies)} "
                    "bodies, counted from 0; contact needs two"
                )
        if contact.body == contact.base:
            raise SceneError(f"contact {index}: body {contact.body} cannot touch itself")
        for name in ("friction", "adhesion"):
            value = getattr(contact, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise SceneError(f"contact {index}: {name} = {value:g} must be >= 0")


def _check_overlap(first: int, one: Body, second: int, other: Body) -> None:
    nearest = TOUCHING * 0.5 * (one.spacing + other.spacing)
    lower, upper = other.position.min(axis=0) - nearest, other.position.max(axis=0) + nearest
    near = np.all((one.position > lower) & (one.position < upper), axis=1)
    for place in one.position[near]:
        if np.min(np.hypot(*(other.position - place).T)) < nearest:
            raise SceneError(
                f"bodies {first} and {second} overlap at {np.array2string(place, precision=4)} m; "
                "move them apart"
            )
