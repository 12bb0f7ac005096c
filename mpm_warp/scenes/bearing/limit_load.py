"""The load that a rigid surface, pressed slowly into soil, cannot exceed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import ContactForces, soil_scene
from mpm_warp.simulation import Simulation

PLATEAU_SHARE = 0.25
"""The share of the displacement, at its end, over which the load has to stand still."""
PLATEAU_CHANGE = 0.01
"""What its linear fit may change there by, over its mean."""

LEAST_SAMPLES = 3
"""Samples that make a plateau, at least."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadCurve:
    """Load against displacement.

    Attributes:
        displacement: of the surface, over a length of it, rising, shape [sample_count].
        load: mean load since the sample before, over area and su, shape [sample_count].
    """

    displacement: Floats
    load: Floats

    @property
    def limit(self) -> float:
        """Mean load of the plateau; not a number where the curve does not end in one."""
        last = self.displacement >= (1.0 - PLATEAU_SHARE) * self.displacement[-1]
        displacement, load = self.displacement[last], self.load[last]
        if len(load) < LEAST_SAMPLES:
            return math.nan
        slope = np.polyfit(displacement, load, 1)[0]
        change = abs(slope) * (displacement[-1] - displacement[0])
        return float(load.mean()) if change <= PLATEAU_CHANGE * abs(load.mean()) else math.nan

    def dataset(self) -> xr.Dataset:
        """The curve alone."""
        axis = (self.displacement, "1", "displacement over radius")
        return curves("displacement", axis, resistance=(self.load, "1", "load over area and su"))

    def limit_beside(self, exact: float, source: str) -> dict[str, xr.Variable]:
        """The limit over area and su, and the exact one with the error where one is known.

        Args:
            exact: the exact limit over area and su; not a number where none is known.
            source: where it comes from.
        """
        plateau = (
            f"mean over the last {PLATEAU_SHARE:.0%} of the displacement, if the load changes "
            f"there by at most {PLATEAU_CHANGE:.0%}; else not a number"
        )
        computed = labelled(
            role="headline",
            bearing_capacity=(self.limit, "1", "limit load over area and su", plateau),
        )
        if math.isnan(exact):
            return computed
        error = (
            abs(self.limit / exact - 1),
            "1",
            "error of the limit load",
            "relative error of the plateau",
        )
        return (
            labelled(role="error", error=error)
            | computed
            | labelled(
                bearing_capacity_exact=(exact, "1", "limit load over area and su, exact", source),
            )
        )


class LoadSampler:
    """Samples the load of a rigid surface that is pressed into soil at the speed of its contact.

    Args:
        simulation: a run of a scene with contact and without a window.
        length: to measure the displacement by [m], > 0.
        load: the load over area and su, out of the forces of the contact nodes.
    """

    def __init__(
        self, simulation: Simulation, *, length: float, load: Callable[[Floats], float]
    ) -> None:
        self._simulation = simulation
        self._length = length
        self._load = load
        self._contact_forces = ContactForces(simulation)
        self._reached: list[float] = []  # displacement at each sample [m]
        self._loads: list[float] = []

    @property
    def travel_per_step(self) -> float:
        """How far the surface sinks in a step [m]."""
        contact = soil_scene(self._simulation)[SurfaceContact]
        return contact.speed * self._simulation.plan.time_step

    def steps(self, displacement: float, sample_count: int) -> list[int]:
        """Steps after which samples are due, evenly over a displacement [m].

        There are fewer samples where there are fewer steps.
        """
        shares = np.arange(1, sample_count + 1) / sample_count
        steps = np.rint(shares * displacement / self.travel_per_step)
        due: list[int] = np.unique(np.maximum(steps, 1.0)).astype(int).tolist()
        return due

    def sample(self) -> None:
        """Record the displacement, and the mean load since the sample before."""
        self._loads.append(self._load(self._contact_forces.take()))
        self._reached.append(self._simulation.step_count * self.travel_per_step)

    @property
    def curve(self) -> LoadCurve:
        """Load against displacement so far."""
        # A mean over the steps since the sample before stands in their middle.
        before = np.array([0.0, *self._reached])[: len(self._reached)]
        middles = 0.5 * (np.array(self._reached) + before)
        return LoadCurve(displacement=middles / self._length, load=np.array(self._loads))

    def dataset(self) -> xr.Dataset:
        """The curve alone."""
        return self.curve.dataset()
