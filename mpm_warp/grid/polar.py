"""A background grid of rings and rays, around a cylinder in plane strain or around a sphere."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mpm_warp.errors import SceneError
from mpm_warp.fields.checks import Range, check_array
from mpm_warp.grid.fitted import Floats, Grid, Integers, bilinear

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(6)
"""Gauss points along each side of a cell; they integrate sines and cosines to rounding."""
ETA = 0.5 + 0.5 * POINTS
"""Natural coordinates of the Gauss points."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PolarGrid(Grid):
    """A grid whose rows are rays from the origin; attributes are those of `Grid`.

    Distance from the origin replaces r, and the angle from the z axis, `rows` [rad], replaces z.
    Shape functions are bilinear in the two; cells are sectors of rings. Positions and velocities
    have components along r and z.

    Raises:
        SceneError: a value is not allowed, or the surface is not round.

    Example:
        >>> grid = PolarGrid(
        ...     columns=np.array([0.0, 0.5, 1.0]),
        ...     rows=np.linspace(0.0, np.pi / 2, 4),  # angles from the z axis [rad]
        ...     surface_radius=np.ones(4),
        ...     fitted_radius=3.0,
        ... )
        >>> grid.cell_count, grid.outer_radius, grid.node_positions.shape
        (6, 3.0, (12, 2))
    """

    polar = True

    def __post_init__(self) -> None:
        super().__post_init__()
        check_array("PolarGrid: rows", self.rows, (None,), Range(minimum=0.0, maximum=np.pi))
        if np.ptp(self.surface_radius) > 0.0:
            radii = f"{self.surface_radius.min():g} to {self.surface_radius.max():g} m"
            raise SceneError(f"PolarGrid: surface_radius is {radii}, must be the same on all rays")

    def place(self, column: Integers, row: Integers, xi: Floats, eta: Floats) -> Floats:
        """See `Grid`."""
        distance, angle = np.moveaxis(super().place(column, row, xi, eta), -1, 0)
        return np.stack([distance * np.sin(angle), distance * np.cos(angle)], axis=-1)

    def jacobian(self, column: Integers, row: Integers, xi: Floats, eta: Floats) -> Floats:
        """See `Grid`."""
        distance = super().place(column, row, xi, eta)[..., 0]
        return distance * super().jacobian(column, row, xi, eta)

    @property
    def particle_bounds(self) -> tuple[Floats, Floats]:
        """See `Grid`."""
        farthest = self.outer_radius * (1.0 + np.diff(self.columns)[-1])
        return np.full(2, -farthest), np.full(2, farthest)

    @cached_property
    def node_positions(self) -> Floats:
        """See `Grid`."""
        distance, angle = super().node_positions.T
        return np.stack([distance * np.sin(angle), distance * np.cos(angle)], axis=-1)

    @property
    def surface_normals(self) -> Floats:
        """See `Grid`: of a sphere, or of a circle in plane strain."""
        return np.stack([np.sin(self.rows), np.cos(self.rows)], axis=-1)

    @cached_property
    def angular_integrals(self) -> tuple[Floats, Floats]:
        """Integrals over the angle of each row; they do not change when the surface moves.

        With g the linear function of a ray: (g sin^2, g' sin cos, g sin cos, g' sin^2, g) for the
        row's two rays, shape [row_count, 2, 5], and sin, shape [row_count].
        """
        turn = np.diff(self.rows)[:, None]
        angle = self.rows[:-1, None] + ETA * turn
        sine, cosine, weight = np.sin(angle), np.cos(angle), 0.5 * WEIGHTS * turn
        rays = []
        for g, slope in ((1.0 - ETA, -1.0 / turn), (ETA, 1.0 / turn)):
            parts = (g * sine**2, slope * sine * cosine, g * sine * cosine, slope * sine**2)
            whole = np.broadcast_to(g, sine.shape)
            rays.append(np.stack([(p * weight).sum(axis=1) for p in (*parts, whole)], axis=-1))
        return np.stack(rays, axis=1), np.sum(sine * weight, axis=1)

    @cached_property
    def wall_vectors(self) -> Floats:
        """See `Grid`."""
        angle = self.rows[:-1, None] + ETA * np.diff(self.rows)[:, None]
        normals = np.stack([np.sin(angle), np.cos(angle)], axis=-1)
        radius = self.surface_radius[:-1, None]
        length = radius * 0.5 * WEIGHTS * np.diff(self.rows)[:, None]
        vectors = normals * (self.weight(radius * np.sin(angle)) * length)[..., None]
        walls = np.zeros((len(self.rows), 2))
        walls[:-1] += np.sum((1.0 - ETA)[:, None] * vectors, axis=1)
        walls[1:] += np.sum(ETA[:, None] * vectors, axis=1)
        return walls

    def along_rays(self, stress: Floats) -> Floats:
        """Normal stresses of cells along their middle ray, across it and out of the plane [Pa].

        `stress` is (rr, zz, rz, tt), [cell_count, 4]; the result [row_count, column_count, 3].
        """
        middle = 0.5 * (self.rows[1:] + self.rows[:-1])[:, None]
        sine, cosine = np.sin(middle), np.cos(middle)
        rr, zz, rz, tt = np.moveaxis(stress.reshape(self.row_count, self.column_count, 4), -1, 0)
        turned = 2.0 * sine * cosine * rz
        along = sine**2 * rr + cosine**2 * zz + turned
        across = cosine**2 * rr + sine**2 * zz - turned
        return np.stack([along, across, tt], axis=-1)

    @cached_property
    def gradient_integrals(self) -> Floats:
        """See `Grid`."""
        return self._integrals[0]

    @cached_property
    def cell_volumes(self) -> Floats:
        """See `Grid`."""
        return self._integrals[1]

    @cached_property
    def _integrals(self) -> tuple[Floats, Floats]:
        # Row by row, because their Gauss points take ten times the memory of a run.
        rows = [self._integrals_of_row(row) for row in range(self.row_count)]
        gradients, volumes = zip(*rows, strict=True)
        return np.concatenate(gradients), np.concatenate(volumes)

    def _integrals_of_row(self, number: int) -> tuple[Floats, Floats]:
        xi, eta = (g.ravel() for g in np.meshgrid(ETA, ETA))
        weight = 0.25 * np.outer(WEIGHTS, WEIGHTS).ravel()
        shape, d_xi, d_eta = bilinear(xi, eta)  # each [4 nodes, points]
        column = np.arange(self.column_count)[:, None]
        row = np.full_like(column, number)
        distance, angle = np.moveaxis(super().place(column, row, xi, eta), -1, 0)
        sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
        volume = self.jacobian(column, row, xi, eta) * weight
        area = volume / self.weight(distance * np.sin(angle))
        width = self.width(column, row, eta)[:, None]
        turn = np.diff(self.rows)[row][..., None]
        along, across = d_xi / width, d_eta / (turn * distance[:, None])
        out_of_plane = 0.0 * shape if self.planar else shape
        hoop = np.broadcast_to(out_of_plane, (self.column_count, *shape.shape))
        parts = (
            (along * sine + across * cosine) * volume[:, None],
            (along * cosine - across * sine) * volume[:, None],
            hoop * area[:, None],
        )
        integrals = np.stack([part.sum(axis=-1) for part in parts], axis=-1)
        return integrals, volume.sum(axis=-1)
