"""Ball and T-bar pushed down and pulled up over a stroke, time and again: clay is remoulded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.parameters import parameter, redefined
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.results import labelled
from mpm_warp.sampling import follow, transferred_energy
from mpm_warp.scenes.catalogue import Progress, Verification
from mpm_warp.scenes.cone.soundness import check_energy, energy_error
from mpm_warp.scenes.full_flow.cyclic.degradation import FITTED, Degradation, fitted_degradation
from mpm_warp.scenes.full_flow.cyclic.loops import ResistanceLoops
from mpm_warp.scenes.full_flow.penetrometer import FullFlowPenetrometer
from mpm_warp.simulation import Simulation

BEYOND = "not a number where the test ends before n_95"
"""What is said of all that is fitted."""


@dataclass(frozen=True, kw_only=True)
class CyclicPenetration(FullFlowPenetrometer):
    """A round body that goes down and up again in the same soil.

    It starts at rest at the upper end of the stroke, in intact soil: its first passage is that of
    the same body that goes on. Clay that softens resists the less from passage to passage;
    perfectly plastic clay resists each of them alike.
    """

    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cells_per_radius",
            resolutions=(2, 3),
            bounds={"error": 0.01},
            settings={
                "adhesion_factor": 0.5,
                "cycle_count": 2,
                "stroke": 6.0,
                "speed_ratio": 0.03,
            },
        ),
    )

    # Remoulded clay is weak: half the speed has a quarter of the inertia.
    relative_speed: ClassVar[float] = 0.15
    speed_ratio: float = redefined(
        FullFlowPenetrometer,
        "speed_ratio",
        meaning="penetration speed over shear wave speed (default: 0.15 / sqrt(Ir))",
    )
    cycle_count: int = parameter(
        5,
        unit="1",
        meaning="number of cycles, each a penetration and an extraction",
        minimum=1,
        maximum=100,
    )
    stroke: float = parameter(
        8.0, unit="1", meaning="way from turn to turn over radius", minimum=6, maximum=50
    )

    @property
    def window(self) -> CyclicWindow:
        """The travel of the grid: the speed is reached in a radius after each turn."""
        return CyclicWindow(
            speed=self.speed,
            ramp_travel=self.body.radius,
            stroke=self.stroke * self.body.radius,
        )

    @property
    def end_time(self) -> float:
        """Time to the end of the last cycle [s]."""
        return 2.0 * self.cycle_count * self.window.passage_time

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Move the body, and take its mean resistance in the middle of each passage.

        Raises:
            InaccurateRun: the transfers took too much of the work of the body.
        """
        loops = ResistanceLoops(
            simulation,
            self.body,
            stroke=self.stroke,
            cycle_count=self.cycle_count,
            strength=self.undrained_shear_strength,
        )
        moments = [self.window.time_to(way) for way in loops.ways]
        recorded = follow(simulation, moments, simulation.advance_to, [loops], progress)
        results = recorded.assign(self._ratio(recorded.cyclic_resistance_factor)).assign(
            energy_error=energy_error(transferred_energy(simulation) / loops.work)
        )
        check_energy(results)
        return results

    def _ratio(self, factor: xr.DataArray) -> dict[str, xr.Variable]:
        """What is left of the resistance, and what that says of the clay."""
        first, last = float(factor[0]), float(factor[-2:].mean())
        ratio = labelled(
            role="headline",
            resistance_ratio=(
                last / first,
                "1",
                "resistance left in the last cycle",
                "mean of penetration and extraction, over that of the first passage",
            ),
        )
        if not isinstance(self.clay, EinavRandolph):
            error = abs(last / first - 1.0)
            what = "of perfectly plastic clay, which does not degrade"
            return (
                ratio
                | labelled(resistance_ratio_exact=(1.0, "1", "resistance ratio", what))
                | labelled(role="error", error=(error, "1", "error of the resistance ratio", what))
            )
        if self.remoulded_strength_ratio == 1.0 or factor.size <= FITTED:
            return ratio
        return ratio | self.fitted(fitted_degradation(factor["cycle"].values, factor.values))

    def fitted(self, fit: Degradation) -> dict[str, xr.Variable]:
        """The fit of practice; what lies beyond the end of the test is not a number."""
        known = fit.cycles <= self.cycle_count
        cycles, remoulded = (fit.cycles, fit.remoulded_share) if known else (math.nan, math.nan)
        return labelled(
            fitted_cycles=(cycles, "1", "cycles n_95 to 95 % of the loss of resistance", BEYOND),
            fitted_remoulded_ratio=(
                remoulded,
                "1",
                "remoulded over intact resistance, fitted",
                f"{BEYOND}; the intact one is that before any softening, drawn on to cycle 0",
            ),
            fitted_resistance_factor=(
                fit.intact if known else np.nan,
                "1",
                "resistance factor of intact clay, fitted",
                BEYOND,
            ),
            fit_misfit=(
                fit.misfit,
                "1",
                "misfit of the fit",
                "root mean square of what it leaves, over the fitted resistance of intact clay",
            ),
        )
