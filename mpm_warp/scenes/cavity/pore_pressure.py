"""Excess pore pressure around a cavity, at the end of its expansion, beside the exact one."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, variable
from mpm_warp.sampling import PORE_PRESSURE_IS, excess_pore_pressure, soil_scene
from mpm_warp.simulation import Simulation


class ExactPorePressure(Protocol):
    """A closed form of the excess pore pressure."""

    def __call__(self, distance: Floats, *, expansion: float) -> Floats:
        """Excess pore pressure at distances from the middle [Pa], shape [n].

        Args:
            distance: over the radius of the cavity, >= 1, shape [n].
            expansion: radius of the cavity over that at the start, > 1.
        """


def pore_pressure_profile(
    simulation: Simulation, *, radius_at_start: float, exact: ExactPorePressure
) -> xr.Dataset:
    """Excess pore pressure over the distance from the middle, computed and exact, and its error.

    Args:
        simulation: of a scene with a moving wall, at its end.
        radius_at_start: of the cavity [m].
        exact: the closed form.
    """
    grid = soil_scene(simulation).grid
    radius = float(simulation.array("wall.motion")[0, 2])
    middles = 0.5 * (grid.columns[:-1] + grid.columns[1:])
    distance = 1.0 + (grid.outer_radius / radius - 1.0) * middles
    by_rows = excess_pore_pressure(simulation).reshape(grid.row_count, grid.column_count)
    volumes = simulation.array("cell.volume").reshape(by_rows.shape)
    pressure = np.average(by_rows, axis=0, weights=volumes)
    expected = exact(distance, expansion=radius / radius_at_start)
    profile = curves(
        "distance",
        (distance, "1", "distance from the middle over the radius of the cavity"),
        excess_pore_pressure=(
            pressure,
            "Pa",
            "excess pore pressure",
            f"mean over each column of cells at the end; {PORE_PRESSURE_IS}",
        ),
        excess_pore_pressure_exact=(expected, "Pa", "excess pore pressure, exact"),
    )
    error = variable(
        np.abs(pressure - expected).max() / expected.max(),
        unit="1",
        meaning="error of the excess pore pressure",
        description="greatest difference over the whole profile, over the exact one in the "
        "innermost cell",
        role="error",
    )
    return profile.assign(pore_pressure_error=error)
