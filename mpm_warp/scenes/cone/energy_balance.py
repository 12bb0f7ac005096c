"""Where the work of the penetrometer goes, as shares of it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from mpm_warp.errors import InaccurateRun
from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.energy_balance import OF_CELLS, OF_NODES, OF_POINTS
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.results import variable
from mpm_warp.sampling import transferred_energy
from mpm_warp.scenes.cone.penetration import STEADY_SAMPLES
from mpm_warp.simulation import Simulation

LARGEST_RESIDUAL = 0.01
"""What may be left of the balance, over the work of the penetrometer."""
MEANING = {
    "plastic": "plastic work in the soil, over the penetrometer's",
    "sliding": "work of sliding along face and shaft, over the penetrometer's",
    "elastic": "energy stored in the soil or carried off with it, over the penetrometer's work",
    "ground": "work on the ground around the window, over the penetrometer's",
    "kinetic": "kinetic energy kept by the soil or carried off with it, over the penetrometer's "
    "work",
    "transfers": "kinetic energy that the transfers dissipate, over the penetrometer's work",
    "viscous": "work of the method's viscous pressure, over the penetrometer's",
    "least_mass": "work that the least mass of nodes keeps from the stress, over the "
    "penetrometer's",
}
"""Where the work goes."""
RESIDUAL = "work of the penetrometer that is not found again, over all of it"


class EnergyBalanceCurves:
    """Samples the works of a scene with an energy balance, and gives their shares.

    The work is that on face and shaft within the window, of the excess over the in-situ stress.

    Args:
        simulation: of the scene.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._works = [self._works_so_far()]

    def sample(self) -> None:
        """Record the works so far."""
        self._works.append(self._works_so_far())

    def dataset(self) -> xr.Dataset:
        """The shares over the last two radii, or the last half of the way."""
        count = min(STEADY_SAMPLES, len(self._works) // 2)
        works = self._works[-1] - self._works[-1 - count]
        body, to_soil, by_ground, kinetic, least_mass, viscous, plastic, elastic, created = works
        goes_to = {
            "plastic": plastic,
            "sliding": body - to_soil,
            "elastic": elastic,
            "ground": -by_ground,
            "kinetic": kinetic + created,
            "transfers": -created,
            "viscous": viscous,
            "least_mass": -least_mass,
        }
        residual = body - sum(goes_to.values())
        with np.errstate(invalid="ignore"):  # without an audited step no share is a number
            shares = {
                f"work_share_{name}": variable(work / body, unit="1", meaning=MEANING[name])
                for name, work in goes_to.items()
            }
            shares["energy_residual"] = variable(residual / body, unit="1", meaning=RESIDUAL)
        return xr.Dataset(shares)

    def _works_so_far(self) -> Floats:
        """The sums of the audited steps, taken for all steps [J]."""
        array = self._simulation.array
        sums = [*array(OF_NODES).sum(axis=0), array(OF_CELLS).sum(), *array(OF_POINTS).sum(axis=0)]
        return np.array(
            [*(AUDIT_INTERVAL * float(it) for it in sums), transferred_energy(self._simulation)]
        )


def check_balance(results: xr.Dataset) -> None:
    """Refuse results whose energy balance does not close.

    Raises:
        InaccurateRun: more than `LARGEST_RESIDUAL` of the penetrometer's work is left.
    """
    residual = float(results.energy_residual)
    if not abs(residual) <= LARGEST_RESIDUAL:
        raise InaccurateRun(
            f"{residual:.1%} of the penetrometer's work is not found again, more than "
            f"{LARGEST_RESIDUAL:.0%}: try a lower speed_ratio, or more cells_per_radius",
            results,
        )
