"""Excess pore pressure on a penetrometer, at the places where a piezocone measures it.

It is the change of mean total stress of the soil beside the surface. An elastic, perfectly plastic
undrained clay has no other part.
"""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import Quantity, curves, variable
from mpm_warp.sampling import PORE_PRESSURE_IS, excess_pore_pressure, soil_scene
from mpm_warp.scenes.cone.penetration import Slowing, penetration_axis, without_slowing
from mpm_warp.scenes.cone.penetrometer import SHAFT_FILTER, SHOULDER_FILTER, Penetrometer
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.steadiness import steady_mean

PLACES: Mapping[str, str] = {
    "face": "u1: in the middle of the cone's face",
    "shoulder": f"u2: on the shaft, {SHOULDER_FILTER:.2g} radii above the shoulder",
    "shaft": f"u3: on the shaft, {SHAFT_FILTER:.3g} radii above the shoulder, over the sleeve",
}
"""The places by their names in results."""
NOT_GIVEN = "not a number above the window, and where the penetrometer slows down"
"""Where there is no pressure."""


class PorePressureCurves:
    """Samples the excess pore pressure beside a penetrometer, where `PenetrationCurves` samples.

    A cell of the first column stands for the surface beside it; between the middles of two cells
    the pressure is linear. A sample is the mean of the pressures at its begin and at its end.

    Args:
        simulation: a run, from its start, of a scene in a grid that is fitted to the penetrometer.
        penetrometer: the penetrometer.
        slowing: penetration between which the pressure is not given; see `PenetrationCurves`.
    """

    def __init__(
        self, simulation: Simulation, *, penetrometer: Penetrometer, slowing: Slowing | None
    ) -> None:
        rows = soil_scene(simulation).grid.rows
        shoulder, radius = penetrometer.cone_height, penetrometer.radius
        self._simulation = simulation
        self._slowing = slowing
        self._middles = 0.5 * (rows[:-1] + rows[1:])
        self._heights = [
            0.5 * shoulder,
            shoulder + SHOULDER_FILTER * radius,
            shoulder + SHAFT_FILTER * radius,
        ]
        self._pressures: list[Floats] = [np.zeros(len(PLACES))]  # at the start, then by sample

    def sample(self) -> None:
        """Record the pressures at all places."""
        column_count = soil_scene(self._simulation).grid.column_count
        beside = excess_pore_pressure(self._simulation)[::column_count]
        # The window may end below the highest place.
        self._pressures.append(np.interp(self._heights, self._middles, beside, right=np.nan))

    def dataset(self) -> xr.Dataset:
        """The pressure at each place over penetration."""
        at_samples = np.array(self._pressures)
        pressures = 0.5 * (at_samples[:-1] + at_samples[1:])
        penetration = penetration_axis(len(pressures))
        by_place: dict[str, Quantity] = {
            f"excess_pore_pressure_{name}": (
                without_slowing(pressure, self._slowing),
                "Pa",
                f"excess pore pressure, {name}",
                f"{place}; {PORE_PRESSURE_IS}; {NOT_GIVEN}",
            )
            for (name, place), pressure in zip(PLACES.items(), pressures.T, strict=True)
        }
        return curves("penetration", penetration, **by_place)


def pore_pressure_factors(recorded: xr.Dataset, strength: float) -> dict[str, xr.Variable]:
    """Excess pore pressure over strength at each place, at the end.

    Args:
        recorded: the curves of `PorePressureCurves`.
        strength: undrained shear strength su [Pa].
    """
    factors = {}
    for name, place in PLACES.items():
        pressure, over = steady_mean(recorded[f"excess_pore_pressure_{name}"])
        factors[f"pore_pressure_factor_{name}"] = variable(
            pressure / strength,
            meaning=f"pore pressure factor, {name}",
            description=f"excess pore pressure over su, mean {over}; {place}",
        )
    return factors
