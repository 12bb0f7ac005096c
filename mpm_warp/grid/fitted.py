"""The background grid: horizontal rows, columns that follow a surface on the left.

A node sits at

    r(i, j) = s + (fitted_radius - s) * columns[i]      s = surface_radius[j] where columns[i] < 1,
    z(i, j) = rows[j]                                       0 beyond

so the first column of nodes lies on a surface, such as that of a penetrometer. Columns follow the
surface less and less up to the fitted radius and are upright beyond it. With a surface radius of
zero the grid is rectilinear. Inside a cell the map from natural coordinates (xi, eta), both 0 to 1,
to (r, z) is bilinear and its inverse has a closed form.

Arrays over cells and nodes are flat, column fastest: cell (i, j) is ``j * column_count + i``,
node (i, j) is ``j * (column_count + 1) + i``. All volumes and areas are per radian, or in
plane strain per unit thickness.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.checks import (
    FROM_ONE,
    POSITIVE,
    Range,
    check_array,
    check_number,
    check_rising,
    check_whole,
)
from mpm_warp.fields.declaration import parameter

Floats = NDArray[np.float64]
Integers = NDArray[np.integer[Any]]

LARGEST_EXPONENT = 700.0
"""Largest exponent of e, rounded down; double precision overflows beyond 709."""

# Two Gauss points on [0, 1], equal weights: exact for cubics.
GAUSS_POINTS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid(Checked):
    """A structured grid of bilinear cells, axisymmetric or in plane strain of unit thickness.

    Attributes:
        surface_radius: radius of the inner surface on each row of nodes [m], shape
            [row_count + 1]; 0 on the axis.
        planar: whether strain is plane; r is then a Cartesian coordinate.
        ground_level: height of the initial surface of the soil, above the lowest row [m];
            default: the grid is full.
        soil_radius: radius of its initial side [m], > 0; default: as wide as the grid. Material
            points are there where their middle is below the level and within the radius: both on
            lines of nodes give the exact mass.

    Raises:
        SceneError: a value is not allowed.

    Example:
        >>> grid = Grid(
        ...     columns=np.array([0.0, 1.0]),
        ...     rows=np.linspace(0.0, 1.0, 5),
        ...     surface_radius=np.zeros(5),  # the axis
        ...     fitted_radius=0.5,
        ... )
        >>> grid.cell_count, grid.outer_radius
        (4, 0.5)
        >>> grid.cell_volumes  # per radian [m3]
        array([0.03125, 0.03125, 0.03125, 0.03125])
    """

    # 1, the fitted radius, is one of them; beyond it they are radius over fitted radius
    columns: Floats = parameter(
        meaning="coordinates of the columns of nodes, rising from 0 on the surface", shape=(None,)
    )
    rows: Floats = parameter(
        meaning="heights z of the rows of nodes, rising", unit="m", shape=(None,)
    )
    surface_radius: Floats
    fitted_radius: float = parameter(
        meaning="radius from which on columns of nodes are upright", unit="m", above=0
    )
    planar: bool = False
    ground_level: float = math.inf
    soil_radius: float = math.inf
    polar = False
    """Whether cells are in distance and angle, see `mpm_warp.grid.polar`."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("columns", "rows"):
            values = getattr(self, name)
            check_whole(f"Grid: length of {name}, less 1,", len(values) - 1, FROM_ONE)
            check_rising(f"Grid: {name}", values)
        if self.columns[0] != 0.0 or 1.0 not in self.columns:
            ends = f"{self.columns[0]:g} to {self.columns[-1]:g}"
            raise SceneError(f"Grid: columns are from {ends}, must be from 0 and one of them 1")
        within = Range(minimum=0.0, below=self.fitted_radius)
        check_array("Grid: surface_radius", self.surface_radius, self.rows.shape, within)
        if self.ground_level != math.inf:
            above_bottom = Range(above=float(self.rows[0]))
            check_number("Grid: ground_level", self.ground_level, above_bottom, unit="m")
        if self.soil_radius != math.inf:
            check_number("Grid: soil_radius", self.soil_radius, POSITIVE, unit="m")

    def weight(self, radius: Floats) -> Floats:
        """Volume per area of the half plane (r, z) at radii [m]: r, or 1 in plane strain, [...]."""
        return np.ones_like(radius) if self.planar else radius

    @property
    def outer_radius(self) -> float:
        """Radius of the last column of nodes [m]."""
        return self.fitted_radius * float(self.columns[-1])

    @property
    def column_count(self) -> int:
        """Number of cells in a row."""
        return len(self.columns) - 1

    @property
    def row_count(self) -> int:
        """Number of rows of cells."""
        return len(self.rows) - 1

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return self.column_count * self.row_count

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return (self.column_count + 1) * (self.row_count + 1)

    def node(self, column: int | Integers, row: int | Integers) -> Integers:
        """Flat index of the node at a column and a row, or of several."""
        return np.asarray(row * (self.column_count + 1) + column, dtype=np.int32)

    def place(self, column: Integers, row: Integers, xi: Floats, eta: Floats) -> Floats:
        """Position (r, z) [m] of natural coordinates in cells, shape [..., 2]."""
        fraction = self.columns[column] + xi * np.diff(self.columns)[column]
        surface = self._followed(column, row, eta)
        radius = surface + (self.fitted_radius - surface) * fraction
        height = self.rows[row] + eta * np.diff(self.rows)[row]
        return np.stack(np.broadcast_arrays(radius, height), axis=-1)

    @property
    def particle_bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest (r, z) of points [m], a cell beyond the sides of the grid.

        A point may move out a little; it then has the velocity of the side.
        """
        below, above = np.diff(self.rows)[[0, -1]]
        beside = np.diff(self.columns)[-1] * self.fitted_radius
        lower = np.array([0.0, self.rows[0] - below])
        return lower, np.array([self.outer_radius + beside, self.rows[-1] + above])

    @property
    def kernel_arguments(self) -> dict[str, Any]:
        """Arguments of kernels that describe the grid, by name."""
        return {
            "column_count": self.column_count,
            "row_count": self.row_count,
            "cell_counts": wp.vec2i(self.column_count, self.row_count),
            "fitted_radius": self.fitted_radius,
        }

    @property
    def surface_normals(self) -> Floats:
        """Unit normals of a cylindrical inner surface into the soil, [row_count + 1, 2]."""
        return np.tile([1.0, 0.0], (self.row_count + 1, 1))

    @property
    def wall_vectors(self) -> Floats:
        """Integrals of N n over the inner surface, n into the soil, shape [row_count + 1, 2].

        They are in m2 per radian, or in m in plane strain.
        """
        weight = self.weight(self.surface_radius)
        along = np.diff(self.rows), -np.diff(self.surface_radius)
        return np.stack([nodal_areas(weight, length) for length in along], axis=-1)

    def width(self, column: Integers, row: Integers, eta: Floats) -> Floats:
        """Widths of cells at natural heights [m], shape [...]."""
        span = self.fitted_radius - self._followed(column, row, eta)
        return span * np.diff(self.columns)[column]

    def _followed(self, column: Integers, row: Integers, eta: Floats) -> Floats:
        """Radius of the surface that cells follow at natural heights [m], 0 for upright cells."""
        surface = self.surface_radius[row] + eta * np.diff(self.surface_radius)[row]
        return np.where(self.columns[column] < 1.0, surface, 0.0)

    def jacobian(self, column: Integers, row: Integers, xi: Floats, eta: Floats) -> Floats:
        """Volume per area of natural coordinates in cells [m3], shape [...]."""
        width = self.width(column, row, eta)
        weight = self.weight(self.place(column, row, xi, eta)[..., 0])
        return weight * width * np.diff(self.rows)[row]

    @cached_property
    def node_positions(self) -> Floats:
        """Positions (r, z) of the nodes [m], shape [node_count, 2]."""
        surface = np.where(self.columns < 1.0, self.surface_radius[:, None], 0.0)
        radius = surface + (self.fitted_radius - surface) * self.columns
        height = np.broadcast_to(self.rows[:, None], radius.shape)
        return np.stack([radius, height], axis=-1).reshape(-1, 2)

    @property
    def cell_nodes(self) -> Integers:
        """The nodes of each cell at (xi, eta) = 00, 10, 01, 11, shape [cell_count, 4]."""
        row, column = np.divmod(np.arange(self.cell_count), self.column_count)
        first = self.node(column, row)
        stride = self.column_count + 1
        return np.stack([first, first + 1, first + stride, first + stride + 1], axis=-1)

    @property
    def gradient_integrals(self) -> Floats:
        """Integrals over each cell of (dN/dr r, dN/dz r, N), N the shape function of each node.

        They give the radial, vertical and hoop parts of the internal force of a uniform stress and
        of the mean strain rate. They are exact, in m2, shape [cell_count, 4, 3].
        """
        xi, eta = (g.ravel() for g in np.meshgrid(GAUSS_POINTS, GAUSS_POINTS))
        shape, d_xi, d_eta = bilinear(xi, eta)  # each [4 nodes, 4 points]
        radius, height = np.moveaxis(self.node_positions[self.cell_nodes], -1, 0)
        r, r_xi, r_eta = (radius @ function for function in (shape, d_xi, d_eta))
        z_eta = height @ d_eta
        area = 0.25 * r_xi * z_eta
        volume = self.weight(r) * area
        # Rows are horizontal, so z does not depend on xi.
        d_r = d_xi / r_xi[:, None, :]
        integrals = np.zeros((self.cell_count, 4, 3))
        integrals[..., 0] = np.einsum("cnp,cp->cn", d_r, volume)
        d_z = (d_eta - d_r * r_eta[:, None, :]) / z_eta[:, None, :]
        integrals[..., 1] = np.einsum("cnp,cp->cn", d_z, volume)
        if not self.planar:
            integrals[..., 2] = area @ shape.T
        return integrals

    @cached_property
    def cell_volumes(self) -> Floats:
        """Volume of each cell per radian [m3], shape [cell_count]."""
        radius = self.node_positions[self.cell_nodes, 0]
        if self.planar:
            radius_difference = radius[:, 1] - radius[:, 0] + radius[:, 3] - radius[:, 2]
            heights = np.repeat(np.diff(self.rows), self.column_count)
            planar_volumes: Floats = 0.5 * radius_difference * heights
            return planar_volumes
        # r is the sum of N r_i over the nodes, so the integral of r is that of the integrals of N.
        volumes: Floats = np.sum(self.gradient_integrals[..., 2] * radius, axis=-1)
        return volumes

    @cached_property
    def node_volumes(self) -> Floats:
        """Volume of each node per radian [m3], a quarter of each cell around, [node_count]."""
        volumes = np.zeros(self.node_count)
        np.add.at(volumes, self.cell_nodes, 0.25 * self.cell_volumes[:, None])
        return volumes

    @cached_property
    def cell_lengths(self) -> Floats:
        """See the function `cell_lengths`."""
        return cell_lengths(self.gradient_integrals, self.cell_volumes)


def cell_lengths(gradient_integrals: Floats, cell_volumes: Floats) -> Floats:
    """Length that a wave crosses in the critical time step of a cell [m], shape [cell_count].

    It is 1 / |mean grad N|, for a square of side h h / sqrt(2), by the bound on the highest
    frequency of a uniform-strain cell (Flanagan & Belytschko 1984, J. Appl. Mech. 51:35-40). It is
    infinite for a cell without volume. Integrals and volumes are those of `Grid`.
    """
    gradients = gradient_integrals[..., :2] / cell_volumes[:, None, None]
    with np.errstate(divide="ignore"):
        lengths: Floats = 1.0 / np.sqrt(np.sum(gradients**2, axis=(1, 2)))
    return lengths


def nodal_areas(weight: Floats, length: Floats) -> Floats:
    """Integrals of N w over a line of nodes, from the lengths between them [m]; [node_count].

    The weight w is linear between nodes: r for areas per radian [m], 1 in plane strain.
    """
    to_lower = length * (weight[:-1] / 3.0 + weight[1:] / 6.0)
    to_upper = length * (weight[:-1] / 6.0 + weight[1:] / 3.0)
    return np.append(to_lower, 0.0) + np.insert(to_upper, 0, 0.0)


def bilinear(xi: Floats, eta: Floats) -> tuple[Floats, Floats, Floats]:
    """Shape functions and their derivatives along xi and eta, 0 to 1; each [4 nodes, points]."""
    shape = np.array([(1 - xi) * (1 - eta), xi * (1 - eta), (1 - xi) * eta, xi * eta])
    d_xi = np.array([eta - 1, 1 - eta, -eta, eta])
    d_eta = np.array([xi - 1, -xi, 1 - xi, xi])
    return shape, d_xi, d_eta


def graded(first: float, length: float, growth: float) -> Floats:
    """Edges from 0 to `length` whose spacing starts near `first` and grows by about `growth`.

    The number of cells is the nearest whole one; `first` is then kept and the growth adjusted.

    Args:
        first: width of the first cell [m].
        length: sum of all widths [m], more than `first`.
        growth: ratio of a cell's width to the one before, more than 1.

    Raises:
        SceneError: a value is not allowed.
    """
    count = max(1, _cell_count("graded", first, length, growth))
    low, high = 1.0 + 1e-12, 10.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        # A sum that overflows exceeds the length.
        is_huge = count * math.log(middle) > LARGEST_EXPONENT
        reached = math.inf if is_huge else first * (middle**count - 1.0) / (middle - 1.0)
        low, high = (middle, high) if reached < length else (low, middle)
    edges: Floats = first * (low ** np.arange(count + 1.0) - 1.0) / (low - 1.0)
    edges[-1] = length
    return edges


def _cell_count(name: str, first: float, length: float, growth: float) -> int:
    check_number(f"{name}: first", first, POSITIVE, unit="m")
    check_number(f"{name}: length", length, Range(above=first), unit="m")
    check_number(f"{name}: growth", growth, Range(above=1.0))
    count: int = round(np.log1p(length / first * (growth - 1.0)) / np.log(growth))
    return count


def growing(first: float, length: float, growth: float) -> Floats:
    """Edges as of `graded`, but with `first` and `growth` kept and the length adjusted."""
    count = _cell_count("growing", first, length, growth)
    return first * (growth ** np.arange(count + 1.0) - 1.0) / (growth - 1.0)
