"""Expansion of a spherical cavity in undrained clay, at large strain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.scenes.base import Verification
from mpm_warp.scenes.families.cavity import RADIUS, Cavity, verifications

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from mpm_warp.parts.boundaries import FarField, Fixed
    from mpm_warp.grid.fitted import Grid
    from mpm_warp.materials.materials import LinearElastic
    from mpm_warp.grid.polar import PolarGrid


@dataclass(frozen=True, kw_only=True)
class CavitySphere(Cavity):
    """A quarter of the half plane, from the axis to the equator, on rays; see `Cavity`.

    The grid ends, without traction, at six times the radius of the plastic zone: what is missing
    beyond lowers the pressure by 4/3 su / 6^3, a thousandth of the limit.
    """

    summary: ClassVar[str] = "pressure of an expanding spherical cavity in undrained clay"
    version: ClassVar[int] = 5
    verifications: ClassVar[tuple[Verification, ...]] = verifications(0.02, (4, 6))
    exponent: ClassVar[int] = 3
    factor: ClassVar[float] = 4.0 / 3.0
    von_mises_strength: ClassVar[float] = math.sqrt(0.75)

    def grid(self) -> PolarGrid:
        """See `Cavity`."""
        import numpy as np

        from mpm_warp.grid.polar import PolarGrid

        outer = 6.0 * self.plastic_radius
        row_count = max(2, round(0.5 * math.pi * self.cells_per_radius))
        return PolarGrid(
            columns=self.columns(outer),
            rows=np.linspace(0.0, 0.5 * math.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            outer_radius=outer,
        )

    def fixed(self, grid: Grid) -> Fixed:
        """See `Cavity`."""
        import numpy as np

        from mpm_warp.parts.boundaries import Fixed

        radial = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical = radial.copy()
        radial[0] = True
        vertical[-1] = True
        return Fixed.where(radial=radial, vertical=vertical)

    def far_field(self, grid: Grid, material: LinearElastic) -> FarField | None:
        """See `Cavity`."""
        return None

    def wall_area(self, grid: Grid, radius: float) -> float:
        """See `Cavity`: what the normal forces of the nodes act on, r^2 less 0.6 % at 4 cells."""
        return float(_wall_areas(grid).sum()) * (radius / RADIUS) ** 2

    def shape(self, grid: Grid, on_rows: np.ndarray) -> dict[str, xarray.Variable]:
        """See `Cavity`."""
        import numpy as np

        from mpm_warp.results import variable

        pressure = on_rows / _wall_areas(grid)
        return {
            "departure": variable(
                float(np.ptp(pressure) / pressure.mean()),
                unit="1",
                meaning="departure from a sphere",
                description="range of the pressure over the wall at the end, over its mean",
            )
        }


def _wall_areas(grid: Grid) -> np.ndarray:
    """Of the wall's nodes at the start, along their normals [m2 per radian], [row_count + 1]."""
    from mpm_warp.grid.polar import PolarGrid

    assert isinstance(grid, PolarGrid)
    areas: np.ndarray = (grid.wall_vectors * grid.surface_normals).sum(axis=1)
    return areas
