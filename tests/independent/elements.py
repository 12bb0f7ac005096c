"""Elements with 8 nodes and 2 x 2 points of integration, axisymmetric, in rows and columns."""

import numpy as np
import numpy.typing as npt

from tests.independent.clay import Array

Nodes = npt.NDArray[np.int64]
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]])
"""Places of the nodes in their element, (across, along)."""
POINTS = np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]]) / np.sqrt(3.0)


def _monomials(place: Array) -> tuple[Array, Array]:
    """The functions that 8 nodes can have, (n, 8), and their slopes, (n, 2, 8)."""
    x, y = place.T.astype(float)
    one, zero = np.ones_like(x), np.zeros_like(x)
    values = [one, x, y, x * x, x * y, y * y, x * x * y, x * y * y]
    across = [zero, one, zero, 2.0 * x, y, zero, 2.0 * x * y, y * y]
    along = [zero, zero, one, zero, x, 2.0 * y, x * x, 2.0 * x * y]
    return np.stack(values, axis=1), np.stack([np.stack(it, 1) for it in (across, along)], 1)


COEFFICIENTS = np.linalg.inv(_monomials(CORNERS)[0])
SHAPE, SLOPE = (it @ COEFFICIENTS for it in _monomials(POINTS))
"""Shape functions at the points, (4, 8), and their slopes in the element, (4, 2, 8)."""


def graded(length: float, first: float, growth: float) -> Array:
    """Borders of elements from 0 to a length, each `growth` times as long as the one before."""
    count = max(round(np.log1p(length * (growth - 1.0) / first) / np.log(growth)), 1)
    return length * np.expm1(np.arange(count + 1) * np.log(growth)) / (growth**count - 1.0)


def halved(borders: Array, axis: int = 0) -> Array:
    """Borders with the middles between them."""
    moved = np.moveaxis(borders, axis, 0)
    filled = np.repeat(moved, 2, axis=0)[:-1]
    filled[1::2] = (moved[1:] + moved[:-1]) / 2.0
    return np.moveaxis(filled, 0, axis)


def areas(x: Array, chain: Nodes) -> Array:
    """Area per radian of a chain of edges that falls to each node, by Simpson's rule, (n, 2).

    Its direction is to the right of the chain. A chain has the nodes corner, middle, corner, ...
    """
    slope = np.array([[-1.5, 2.0, -0.5], [-0.5, 0.0, 0.5], [0.5, -2.0, 1.5]])
    edges = np.stack([chain[:-2:2], chain[1::2], chain[2::2]], axis=1)
    along = slope @ x[edges] * x[edges][:, :, :1] * np.array([[1.0], [4.0], [1.0]]) / 3.0
    found = np.zeros_like(x)
    np.add.at(found, edges, along[:, :, ::-1] * np.array([1.0, -1.0]))
    return found


def force_of(stress: Array, area: Array) -> Array:
    """Forces of stresses (n, 4) on areas (n, 2)."""
    on_r = stress[:, 0] * area[:, 0] + stress[:, 2] * area[:, 1]
    on_z = stress[:, 2] * area[:, 0] + stress[:, 1] * area[:, 1]
    return np.stack([on_r, on_z], axis=1)


class Elements:
    """Elements by the places of their corners, middles and centres, (2 rows + 1, 2 columns + 1, 2).

    Rows follow one another along the flow, columns stand from its left to its right.
    """

    def __init__(self, grid: Array) -> None:
        kept = np.ones(grid.shape[:2], dtype=bool)
        kept[1::2, 1::2] = False  # no node in the centre
        self.nodes: Nodes = np.where(kept, kept.cumsum().reshape(kept.shape) - 1, -1)
        self.x = grid[kept]
        self.rows, self.columns = kept.shape[0] // 2, kept.shape[1] // 2
        row, column = 2 * np.indices((self.rows, self.columns)).reshape(2, -1, 1) + 1
        self.members = self.nodes[row + CORNERS[:, 1], column + CORNERS[:, 0]]

        corners = self.x[self.members]
        jacobian = np.einsum("gda,eac->egdc", SLOPE, corners)
        self.to_element = np.linalg.inv(jacobian)  # (e, g, c, d): of a place x_c
        self.place = SHAPE @ corners
        self.volume = np.linalg.det(jacobian) * self.place[:, :, 0]  # per radian
        if self.volume.min() <= 0.0:
            raise ValueError("an element is turned inside out")
        gradient = self.to_element @ SLOPE
        zero = np.zeros_like(gradient[:, :, 0])
        hoop = SHAPE / self.place[:, :, :1]
        by_r = [gradient[:, :, 0], zero, gradient[:, :, 1], hoop, -gradient[:, :, 1] / 2.0]
        by_z = [zero, gradient[:, :, 1], gradient[:, :, 0], zero, gradient[:, :, 0] / 2.0]
        self.rates = np.stack([np.stack(by_r, axis=2), np.stack(by_z, axis=2)], axis=-1)
        """Strain rates rr, zz, 2 rz, tt and spin by velocities of the nodes, (e, 4, 5, 8, 2)."""

    def in_rows(self, values: Array) -> Array:
        """Values of the points, (e, 4, ...), in their rows and columns."""
        rest = values.shape[2:]
        split = values.reshape(self.rows, self.columns, 2, 2, *rest)
        return np.moveaxis(split, 2, 1).reshape(2 * self.rows, 2 * self.columns, *rest)

    def of_elements(self, values: Array) -> Array:
        """Values of the points row by row, (n, 4), by their elements, (e, 4, 4)."""
        split = values.reshape(self.rows, 2, self.columns, 2, 4)
        return np.moveaxis(split, 1, 2).reshape(-1, 4, 4)

    def lines(self) -> tuple[Array, Array]:
        """Where the rows and columns of points stand, an element being 1 wide."""
        own = (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0)) / 2.0
        rows, columns = (np.arange(n)[:, None] + own for n in (self.rows, self.columns))
        return rows.ravel(), columns.ravel()


def interpolated(
    values: Array, lines: tuple[Array, Array], at: Array, points: tuple[int, int]
) -> Array:
    """Values (rows, columns, c) at places (n, 2) between their lines, by Lagrange's polynomials."""
    stencils, weights = zip(*map(_lagrange, lines, at.T, points), strict=True)
    near = values[stencils[0][:, :, None], stencils[1][:, None, :]]
    return np.einsum("nj,ni,njic->nc", *weights, near)


def _lagrange(line: Array, at: Array, count: int) -> tuple[Nodes, Array]:
    """The nearest points of a line, (n, count), and their weights."""
    start = np.clip(np.searchsorted(line, at) - count // 2, 0, len(line) - count)
    stencil = start[:, None] + np.arange(count)
    own = line[stencil]
    ratio = (at[:, None, None] - own[:, None, :]) / (
        own[:, :, None] - own[:, None, :] + np.eye(count)
    )
    ratio[:, np.arange(count), np.arange(count)] = 1.0
    return stencil, ratio.prod(axis=2)
