"""The pressure in a cavity against its radius, sampled as its wall moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves
from mpm_warp.sampling import soil_scene
from mpm_warp.simulation import Simulation


class PressureCurve:
    """Samples the pressure in a cavity: means over the time since the sample before.

    Args:
        simulation: a run of a scene with a moving wall.
        radius: of the cavity at the start [m].
        strength: by which pressures are divided [Pa].
        wall_area: area of the wall per radian [m2] when the cavity has a radius [m].
        exact: exact pressures over strength at radii over the initial one, both of shape [n].

    Attributes:
        on_rows: normal forces on the wall by row of nodes in the last sample [N].
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        radius: float,
        strength: float,
        wall_area: Callable[[float], float],
        exact: Callable[[Floats], Floats],
    ) -> None:
        self._simulation = simulation
        self._radius_at_start = self._radius = radius
        self._strength = strength
        self._wall_area = wall_area
        self._exact = exact
        self._sampled_at = simulation.time
        self._expansion: list[float] = []
        self._pressure: list[float] = []
        self.on_rows = np.zeros(soil_scene(simulation).grid.row_count + 1)

    def sample(self) -> None:
        """Record the radius and the mean pressure since the sample before."""
        simulation = self._simulation
        if simulation.time == self._sampled_at:
            return  # one step may go past several samples
        radius = float(simulation.array("wall.motion")[0, 2])
        self.on_rows = simulation.array("wall.impulse") / (simulation.time - self._sampled_at)
        simulation.assign("wall.impulse", 0.0)
        middle = 0.5 * (self._radius + radius)
        self._expansion.append(middle / self._radius_at_start)
        self._pressure.append(self.on_rows.sum() / self._wall_area(middle) / self._strength)
        self._radius, self._sampled_at = radius, simulation.time

    def dataset(self) -> xr.Dataset:
        """Pressure over su against radius over that at the start, computed and exact."""
        expansion = np.array(self._expansion)
        return curves(
            "expansion",
            (expansion, "1", "radius of the cavity over that at the start"),
            cavity_pressure=(np.array(self._pressure), "1", "excess cavity pressure over su"),
            cavity_pressure_exact=(
                self._exact(expansion),
                "1",
                "excess cavity pressure over su, exact",
            ),
        )
