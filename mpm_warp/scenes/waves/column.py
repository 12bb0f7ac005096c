"""A column of soil that can move along its height alone, on the axisymmetric grid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.forces import NodalLoad


@dataclass(frozen=True, kw_only=True, eq=False)
class Column:
    """A column of square cells on a fixed base, from z = 0 up.

    Attributes:
        height: height [m], > 0.
        cell_count: cells along the height, >= 1.
    """

    height: float
    cell_count: int

    @cached_property
    def grid(self) -> Grid:
        """One cell from the axis outward."""
        return Grid(
            columns=np.array([0.0, 1.0]),
            rows=np.linspace(0.0, self.height, self.cell_count + 1),
            surface_radius=np.zeros(self.cell_count + 1),
            fitted_radius=self.height / self.cell_count,
        )

    @property
    def fixed(self) -> Fixed:
        """No radial velocity anywhere, none at all at the base."""
        vertical = np.zeros((self.cell_count + 1, 2), dtype=bool)
        vertical[0] = True
        return Fixed.where(radial=np.ones_like(vertical), vertical=vertical)

    def pressure_on_top(self, pressure: float) -> NodalLoad:
        """A uniform pressure [Pa] on the top, downward."""
        top = self.grid.outer_radius
        # Integrals of N r over the radius, for the node on the axis and the one outside.
        areas = top**2 * np.array([1.0 / 6.0, 1.0 / 3.0])
        return NodalLoad(
            nodes=self.grid.node(np.arange(2), np.array([self.cell_count] * 2)),
            forces=np.outer(areas, [0.0, -pressure]),
        )

    def mean_over_sections(self, values: Floats, mass: Floats) -> Floats:
        """Means over the particles at each height, weighted by mass, from the base up.

        Args:
            values: of the particles as they were seeded, shape [particle_count].
            mass: their masses [kg], shape [particle_count].
        """
        across = round((len(mass) / self.cell_count) ** 0.5)
        weights = mass.reshape(-1, across)
        means: Floats = (values.reshape(weights.shape) * weights).sum(axis=1) / weights.sum(axis=1)
        return means
