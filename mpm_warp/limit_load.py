"""The load that a rigid surface, pressed slowly into soil, cannot exceed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves_kept, variable
from mpm_warp.simulation import Simulation

PLATEAU_SHARE = 0.25
"""The share of the displacement, at its end, over which the load has to stand still."""
PLATEAU_CHANGE = 0.01
"""What its linear fit may change there by, over its mean."""

LEAST_SAMPLES = 3
"""Samples that tell a plateau, at least."""


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

    def curves(self) -> xr.Dataset:
        """The curve alone."""
        dims = ("displacement",)
        axis = variable(self.displacement, unit="1", meaning="displacement over radius", dims=dims)
        resistance = variable(self.load, unit="1", meaning="load over area and su", dims=dims)
        return xr.Dataset({"resistance": resistance}, coords={"displacement": axis})

    def beside(self, exact: float, source: str) -> xr.Dataset:
        """The curve and its limit, beside the exact one, over area and su, and its source."""
        variables = {
            "error": variable(
                abs(self.limit / exact - 1),
                unit="1",
                meaning="error of the limit load",
                description="relative error of the plateau; not a number where there is none",
            ),
            "bearing_capacity": variable(
                self.limit,
                unit="1",
                meaning="limit load over area and su",
                description=f"mean over the last {PLATEAU_SHARE:.0%} of the displacement, if the "
                f"load changes there by at most {PLATEAU_CHANGE:.0%}; else not a number",
            ),
            "bearing_capacity_exact": variable(
                exact,
                unit="1",
                meaning="limit load over area and su, exact",
                description=source,
            ),
        }
        return self.curves().assign(variables)


def press(
    simulation: Simulation,
    *,
    displacement: float,
    length: float,
    sample_count: int,
    load: Callable[[Floats], float],
    progress: Callable[[float], None] | None = None,
) -> LoadCurve:
    """Press the surface of the simulation's contact into the soil, at the speed it has.

    Args:
        simulation: a simulation of a scene with contact and without a window.
        displacement: how far [m], > 0.
        length: to measure the displacement by [m], > 0.
        sample_count: samples of the curve, > 0; fewer where there are fewer steps.
        load: the load over area and su, out of the forces of the contact nodes.
        progress: called with the fraction done.

    Raises:
        SimulationDiverged: the run became unstable; its `history` is the curve up to there.
    """
    contact = simulation.scene.contact
    assert contact is not None, "nothing is pressed into the soil"
    travel_per_step = contact.speed * simulation.plan.time_step
    reached: list[float] = []
    loads: list[float] = []

    def curve() -> LoadCurve:
        # A mean over the steps since the sample before stands in their middle.
        middles = 0.5 * (np.array(reached) + np.array([0.0, *reached])[: len(reached)])
        return LoadCurve(displacement=middles / length, load=np.array(loads))

    with curves_kept(lambda: curve().curves()):
        for sample in range(1, sample_count + 1):
            step = max(1, round(sample / sample_count * displacement / travel_per_step))
            if step == simulation.step_count:
                continue
            simulation.advance(step - simulation.step_count)
            loads.append(load(simulation.take_contact_forces()))
            reached.append(step * travel_per_step)
            if progress is not None:
                progress(sample / sample_count)
        simulation.check()
    return curve()
