"""Expansion of a spherical cavity in undrained clay, at large strain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries import Fixed, RadialMotion
from mpm_warp.results import variable
from mpm_warp.scene import Part
from mpm_warp.scenes.catalogue import Verification
from mpm_warp.scenes.cavity.common import RADIUS, Cavity
from mpm_warp.scenes.cavity.verifications import HURRIED, LATE, SOON, verifications


@dataclass(frozen=True, kw_only=True)
class CavitySphere(Cavity):
    """A quarter of the half plane, from the axis to the equator, on rays.

    The grid ends, without traction, at six times the radius of the plastic zone: what is missing
    beyond lowers the pressure by 4/3 su / 6^3, a thousandth of the limit.

    Where the clay softens, soil moves along the rays alone, as the exact pressure takes it to: a
    free flow of Tresca soil parts from that and bears less.
    """

    summary: ClassVar[str] = "pressure of an expanding spherical cavity in undrained clay"
    version: ClassVar[int] = 6
    verifications: ClassVar[tuple[Verification, ...]] = verifications(
        0.02, (4, 6), HURRIED, LATE, SOON
    )
    exponent: ClassVar[int] = 3
    factor: ClassVar[float] = 4.0 / 3.0
    von_mises_strength: ClassVar[float] = math.sqrt(0.75)

    def grid(self) -> PolarGrid:
        """Rays from the axis to the equator, to six times the radius of the plastic zone."""
        outer = 6.0 * self.plastic_radius
        row_count = max(2, round(0.5 * math.pi * self.cells_per_radius))
        return PolarGrid(
            columns=self.columns(outer),
            rows=np.linspace(0.0, 0.5 * math.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves across the axis or the equator; the grid ends without traction.

        Where the clay softens it moves along rays, which keeps the flow as round as the exact one.
        """
        radial = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical = radial.copy()
        radial[0] = True
        vertical[-1] = True
        fixed = Fixed.where(radial=radial, vertical=vertical)
        return (RadialMotion(), fixed) if self.remoulded_strength_ratio < 1.0 else (fixed,)

    def wall_area(self, grid: Grid, radius: float) -> float:
        """Area of the wall per radian [m2] when the cavity has a radius [m].

        It is what the normal forces of the nodes act on: r^2 less 0.6 % at 4 cells.
        """
        return float(_wall_areas(grid).sum()) * (radius / RADIUS) ** 2

    def shape(self, grid: Grid, on_rows: Floats) -> dict[str, xr.Variable]:
        """How uneven the pressure over the wall is at the end."""
        pressure = on_rows / _wall_areas(grid)
        return {
            "departure": variable(
                float(np.ptp(pressure) / pressure.mean()),
                unit="1",
                meaning="departure from a sphere",
                description="range of the pressure over the wall at the end, over its mean",
            )
        }


def _wall_areas(grid: Grid) -> Floats:
    """Of the wall's nodes at the start, along their normals [m2 per radian], [row_count + 1]."""
    assert isinstance(grid, PolarGrid)
    areas: Floats = (grid.wall_vectors * grid.surface_normals).sum(axis=1)
    return areas
