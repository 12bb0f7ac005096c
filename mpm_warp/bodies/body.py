"""Bodies: square lattices of particles, the loads on them, and the uniform grid around them.

Loads rise linearly in time, then stay:

    f_p = sum over loads min(max((t + dt / 2 - t_0) / T, 0), 1) F_p        then t <- t + dt

Loads are evaluated at the middle of the step. So their impulse is exact in every step but those in
which the rise begins or ends.

Shape functions are quadratic B-splines, nine nodes for each particle. Symbols: h cell size, X_0
lowest of the three nodes along an axis, f = (x - X_0) / h, between 0.5 and 1.5.

    N = (3/2 - f)^2 / 2,    3/4 - (f - 1)^2,    (f - 1/2)^2 / 2
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.checks import (
    FINITE,
    FROM_ONE,
    NOT_NEGATIVE,
    Range,
    check_array,
    check_number,
    check_whole,
)
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import half, kernel, one, real, two, vec2, vec3, zero
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.plan.plan import Plan


@dataclass(frozen=True, kw_only=True, eq=False)
class Load(Checked):
    """Forces of constant direction on the particles of a body; they rise linearly, then stay.

    Example:
        >>> pressing = Load(forces=np.array([[0.0, -5.0]]), start=1.0, rise_time=2.0)
        >>> float(pressing.impulse_time(4.0))  # [s]
        2.0
    """

    forces: Floats = parameter(meaning="final force on each particle", unit="N", shape=(None, 2))
    start: float = parameter(meaning="time t_0 at which the rise begins", unit="s", minimum=0)
    rise_time: float = parameter(meaning="duration T of the rise", unit="s", above=0)

    def impulse_time(self, time: Floats) -> Floats:
        """Impulse until each time since the start of the run [s], over the final force [s]."""
        rising = np.clip(time - self.start, 0.0, self.rise_time)
        steady = np.maximum(time - self.start - self.rise_time, 0.0)
        return 0.5 * rising**2 / self.rise_time + steady


def add_loads(plan: Plan, loads: Sequence[tuple[slice, Load]]) -> None:
    """Add the forces of loads, each with the slice of the particles of its body."""
    forces = np.zeros((len(loads), plan.particle_count, 2))
    for index, (particles, load) in enumerate(loads):
        forces[index, particles] = load.forces
    schedule = np.array([(load.start, load.rise_time) for _, load in loads])
    plan.add_array("load.schedule", "vec2", schedule)
    plan.add_array("load.forces", "vec2", forces)
    plan.add_zeros("load.time", "real", 1)
    plan.add_zeros("particle.load", "vec2", plan.particle_count)
    plan.add_launch(body_loads, plan.particle_count, half_step=0.5 * plan.time_step)


@kernel
def body_loads(
    load_schedule: wp.array[vec2],
    load_forces: wp.array2d[vec2],
    load_time: wp.array[real],
    half_step: real,
    particle_load: wp.array[vec2],
):
    """Forces of all loads; launched over particles. `load_schedule` is (t_0, T) of each load."""
    p = wp.tid()
    middle = load_time[0] + half_step
    total = vec2()
    for k in range(load_schedule.shape[0]):
        start, rise_time = load_schedule[k][0], load_schedule[k][1]
        total += wp.clamp((middle - start) / rise_time, zero, one) * load_forces[k, p]
    particle_load[p] = total


@kernel
def clock(time_step: real, load_time: wp.array[real]):
    """Advance the time of the loads; launched once, at the end of a step."""
    load_time[0] += time_step


@dataclass(frozen=True, kw_only=True, eq=False)
class Body(Checked):
    """A linear elastic body, or a rigid one, as a square lattice of particles.

    Attributes:
        position: positions of the particles [m], shape [particle_count, 2].
        material: elastic constants and density.
        held: whether each particle is at rest, shape [particle_count]; the body is fixed at every
            node that one of them reaches. None: no particle is.
        loads: forces on the particles.

    Raises:
        SceneError: a value is not allowed.

    Example:
        >>> soil = LinearElastic(shear_modulus=4e6, poissons_ratio=0.3, density=2000.0)
        >>> frame = InterfaceFrame(angle=0.0)
        >>> block = frame.body((0.0, 1.0), (0.0, 0.3), spacing=0.05, material=soil)  # [m]
        >>> block.position.shape, round(block.mass.sum())
        ((120, 2), 600)
    """

    position: Floats
    volume: Floats = parameter(
        meaning="volumes of the particles per radian or thickness", shape=(None,), above=0
    )
    spacing: float = parameter(meaning="side of a particle's square", unit="m", above=0)
    material: LinearElastic
    held: NDArray[np.bool_] | None = None
    # the stress is that of the strain plus tau times its rate, which damps a frequency omega by
    # omega tau / 2 of the critical damping
    retardation_time: float | None = parameter(
        None, "tau of a Kelvin-Voigt solid; None: no damping", unit="s", above=0
    )
    loads: tuple[Load, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        self.material.check_complete("Body: material")
        count = np.size(self.volume)
        check_whole("Body: length of volume", count, FROM_ONE)
        check_array("Body: position", self.position, (count, 2))
        if self.held is not None:
            check_array("Body: held", self.held, (count,), kinds="b")
        for load in self.loads:
            check_array("Body: loads: forces", load.forces, (count, 2))

    @property
    def particle_count(self) -> int:
        """Number of particles."""
        return len(self.volume)

    @property
    def mass(self) -> Floats:
        """Masses of the particles [kg], shape [particle_count]."""
        return self.material.density * self.volume


def critical_time_step(
    cell_size: float, material: LinearElastic, retardation_time: float | None, thinning: float = 1.0
) -> float:
    """Time in which a wave crosses a cell, reduced by damping [s].

    `thinning` is the volume over that at rest: a body that is stretched keeps its moduli, but its
    density falls, so its waves become faster.
    """
    crossing = cell_size / (material.pressure_wave_speed * math.sqrt(thinning))
    damping_ratio = (retardation_time or 0.0) / crossing
    return crossing * (math.hypot(1.0, damping_ratio) - damping_ratio)


low, high = wp.constant(real(0.75)), wp.constant(real(1.5))


@dataclass(frozen=True, kw_only=True)
class UniformGrid(Checked):
    """A grid of square cells.

    Attributes:
        lower: corner of the lowest coordinates, (x, y) or (r, z) [m]; r >= 0.
        cell_counts: cells along both axes, >= 3 each.
        axisymmetric: whether the axes are (r, z); else (x, y) in plane strain.

    Raises:
        SceneError: a value is not allowed.

    Example:
        >>> UniformGrid(lower=(0.0, 0.0), cell_size=0.1, cell_counts=(10, 5)).node_count
        66
    """

    lower: tuple[float, float]
    cell_size: float = parameter(meaning="side of a cell", unit="m", above=0)
    cell_counts: tuple[int, int]
    axisymmetric: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("lower", "cell_counts"):
            if np.shape(getattr(self, name)) != (2,):
                raise SceneError(
                    f"UniformGrid: {name} = {getattr(self, name)!r} must be two numbers"
                )
        for count in self.cell_counts:
            check_whole("UniformGrid: cell_counts: one", count, Range(minimum=3))
        r, z = self.lower
        least = NOT_NEGATIVE if self.axisymmetric else FINITE
        check_number("UniformGrid: lower r", r, least, unit="m")
        check_number("UniformGrid: lower z", z, unit="m")

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

    @property
    def kernel_arguments(self) -> dict[str, Any]:
        """Arguments of kernels: lowest corner, cell size h, nodes along both axes."""
        return {
            "lower": vec2(*self.lower),
            "h": self.cell_size,
            "node_counts": wp.vec2i(*self.node_counts),
        }


@wp.func
def first_node(where: real, node_count: int) -> int:
    """Number of the lowest of the three nodes around a place, which is over h; all three exist."""
    return wp.clamp(int(wp.floor(where - half)), 0, node_count - 3)


@wp.func
def spline(where: real, h: real, node_count: int):
    """`first_node` of a place; N, dN/dx [1/m] and X - x [m] of the three nodes.

    f is limited to its range, so a particle outside the grid stays finite until the watch finds it.
    """
    first = first_node(where, node_count)
    f = wp.clamp(where - real(first), half, high)
    weights = vec3(
        half * (high - f) * (high - f),
        low - (f - one) * (f - one),
        half * (f - half) * (f - half),
    )
    slopes = vec3(f - high, two * (one - f), f - half)
    offsets = vec3(-f, one - f, two - f)
    return first, weights, slopes / h, h * offsets


MARGIN = 2
"""Least number of empty cells around the bodies."""


@dataclass(frozen=True, kw_only=True)
class InterfaceFrame:
    """Coordinates along an interface and normal to it.

    Attributes:
        angle: from the first axis of the grid to the interface in plane strain [rad].
        interface_radius: radius of a cylindrical interface around the axis [m], > 0; it runs along
            z, its outward side is the inner one. None: plane strain.

    Example:
        >>> soil = LinearElastic(shear_modulus=4e6, poissons_ratio=0.3, density=2000.0)
        >>> frame = InterfaceFrame(angle=0.0)
        >>> block = frame.body((0.0, 1.0), (0.0, 0.3), spacing=0.05, material=soil)  # [m]
        >>> block.particle_count
        120
    """

    angle: float
    interface_radius: float | None = None

    @property
    def along(self) -> Floats:
        """Unit vector along the interface."""
        if self.interface_radius is not None:
            return np.array([0.0, 1.0])
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def outward(self) -> Floats:
        """Unit vector normal to the interface."""
        return np.array([-self.along[1], self.along[0]])

    def height(self, position: Floats) -> Floats:
        """Distance of points from the interface, outward positive [m], shape [point_count]."""
        return (position - self._origin) @ self.outward

    def body(
        self,
        extent: tuple[float, float],
        heights: tuple[float, float],
        spacing: float,
        material: LinearElastic,
    ) -> Body:
        """A rectangle of particles at a spacing [m].

        `extent` are its ends along the interface, `heights` its distances from it, outward positive
        [m]; the sides are rounded to whole numbers of particles.
        """
        across, up = (
            low + spacing * (np.arange(round((high - low) / spacing)) + 0.5)
            for low, high in (extent, heights)
        )
        x, y = (axis.ravel() for axis in np.meshgrid(across, up))
        position = self._origin + np.outer(x, self.along) + np.outer(y, self.outward)
        radius = position[:, 0] if self.interface_radius is not None else np.ones(len(position))
        return Body(
            position=position, volume=spacing**2 * radius, spacing=spacing, material=material
        )

    def grid_around(
        self, bodies: Sequence[Body], *, travel: float, cell_size: float, offset: float
    ) -> UniformGrid:
        """A grid that holds the bodies, also after a travel of the first along the interface [m].

        The offset is the distance of the nodes from the origin over the cell size, 0 to 1.
        """
        travelled = bodies[0].position + travel * self.along
        occupied = np.concatenate([travelled, *(body.position for body in bodies)]) / cell_size
        first = np.floor(occupied.min(axis=0)) - MARGIN - offset
        counts = np.ceil(occupied.max(axis=0) - first).astype(int) + MARGIN
        lower = cell_size * first
        return UniformGrid(
            lower=(float(lower[0]), float(lower[1])),
            cell_size=cell_size,
            cell_counts=(int(counts[0]), int(counts[1])),
            axisymmetric=self.interface_radius is not None,
        )

    @property
    def _origin(self) -> Floats:
        return np.array([self.interface_radius or 0.0, 0.0])


def add_particles(plan: Plan, bodies: Sequence[Body]) -> None:
    """Add the arrays of all particles, body after body, at rest and without stress."""
    counts = [body.particle_count for body in bodies]
    plan.particle_count = sum(counts)
    numbers = np.repeat(np.arange(len(bodies)), counts)
    plan.add_array("particle.body", "int", numbers.astype(np.int32), (len(bodies),))
    plan.add_array("particle.position", "vec2", np.concatenate([b.position for b in bodies]))
    for name in ("mass", "volume"):
        values = np.concatenate([getattr(body, name) for body in bodies])
        plan.add_array(f"particle.{name}", "real", values, least=0.0)
    plan.add_zeros("particle.velocity", "vec2", plan.particle_count)
    plan.add_zeros("particle.affine", "mat22", plan.particle_count)
    plan.add_zeros("particle.stress", "vec4", plan.particle_count)
