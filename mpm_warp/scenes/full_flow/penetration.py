"""Ball and T-bar that are pushed down until soil flows round them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np
import xarray as xr

from mpm_warp.errors import UnfinishedRun
from mpm_warp.execution.execution import Execution
from mpm_warp.parameters import parameter
from mpm_warp.parts.window import Window
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import follow, soil_scene, transferred_energy
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cone.penetration import (
    SAMPLE_SPACING,
    STEADY_SAMPLES,
    penetration_axis,
    steady_mean,
)
from mpm_warp.scenes.cone.soundness import check_energy, energy_error
from mpm_warp.scenes.full_flow.measured_error import further_tests, with_measured_error
from mpm_warp.scenes.full_flow.penetrometer import FullFlowPenetrometer, ResistanceSamples
from mpm_warp.scenes.full_flow.round_body import RoundBody
from mpm_warp.scenes.run_size import RunSize, of_several
from mpm_warp.simulation import Simulation

SPARE_FRACTION = 0.4
"""Slots for material points beside those that fill the grid, over their number."""
NEAR = 2.0
"""Radii above and below the centre up to which an empty cell is a hole that the body feels."""
LARGEST_CHANGE = 0.02
"""What the mean resistance over two radii may differ from that over the two before, over it."""


@dataclass(frozen=True, kw_only=True)
class FullFlowPenetration(FullFlowPenetrometer):
    """A round body pushed at constant speed through clay, to steady flow."""

    method: ClassVar[tuple[str, ...]] = (
        *FullFlowPenetrometer.method,
        "penetration",
        "uncertainty",
    )

    penetration: float = parameter(
        8.0, unit="1", meaning="penetration over radius", minimum=5, maximum=50
    )
    uncertainty: str = parameter(
        "none",
        unit="1",
        meaning="whether the error of the resistance factor is measured, by four further runs, "
        "which take some twenty times as long",
        choices=("none", "measured"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uncertainty == "measured":
            further_tests(self._alone)  # all are allowed

    @property
    def _alone(self) -> Self:
        """The test without its further runs."""
        return replace(self, uncertainty="none")

    @property
    def window(self) -> Window:
        """The travel of the grid: the speed is reached after a radius."""
        return Window(
            speed=self.speed,
            ramp_travel=self.body.radius,
            spare_fraction=SPARE_FRACTION,
        )

    @property
    def end_time(self) -> float:
        """Time to the end of the penetration [s]."""
        return self.window.time_to(self.penetration * self.body.radius)

    def run_size(self) -> RunSize:
        """See `FullFlowPenetrometer`; that of several runs where the uncertainty is measured."""
        if self.uncertainty == "none":
            return super().run_size()
        alone = self._alone
        return of_several([it.run_size() for it in (alone, *further_tests(alone).values())])

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """What a run gives; with its uncertainty to be measured, the further runs are made too."""

        def run(test: FullFlowPenetration, report: Progress) -> xr.Dataset:
            simulation = Simulation(test.build(), execution)
            report(0.0)
            return test.record(simulation, report)

        if self.uncertainty == "none":
            return self.with_exact_value(run(self, progress))
        return self.with_exact_value(with_measured_error(self._alone, run, progress))

    def with_exact_value(self, results: xr.Dataset) -> xr.Dataset:
        """The results beside the exact resistance factor, where there is one."""
        return results

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Push the body down, and take the mean of its resistance over the last two radii.

        Raises:
            InaccurateRun: the transfers took too much of the work of the body.
            UnfinishedRun: the resistance still changes at the end.
        """
        curve = _ResistanceCurve(simulation, self.body)
        spacing = SAMPLE_SPACING * self.body.radius
        moments = [k * spacing for k in range(1, round(self.penetration / SAMPLE_SPACING) + 1)]
        recorded = follow(simulation, moments, simulation.travel_to, [curve], progress)
        empty_cells = labelled(
            empty_cells=(
                float(_empty_cells(simulation, NEAR * self.body.radius)),
                "1",
                "cells near the body that no material point is in",
                f"within {NEAR:g} radii at the end; none, but where soil leaves a hole behind",
            )
        )
        results = recorded.assign(
            self._steady_values(recorded.penetration_resistance) | empty_cells
        ).assign(energy_error=energy_error(transferred_energy(simulation) / curve.work))
        check_energy(results)
        change = float(results.resistance_factor_change)
        if not abs(change) <= LARGEST_CHANGE:
            raise UnfinishedRun(
                f"the mean resistance over two radii still changes by {change:.0%}; try more "
                "penetration",
                results,
            )
        return results

    def _steady_values(self, resistance: xr.DataArray) -> dict[str, xr.Variable]:
        mean, over = steady_mean(resistance)
        before, _ = steady_mean(resistance[:-STEADY_SAMPLES])
        return labelled(
            role="headline",
            resistance_factor=(
                mean / self.undrained_shear_strength,
                "1",
                "resistance over projected area and su",
                f"mean {over}, of the excess over the in-situ stress",
            ),
        ) | labelled(
            resistance_factor_change=(
                1.0 - before / mean,
                "1",
                "change of the mean resistance over two radii",
                f"mean {over} less that over the two before, over it",
            )
        )


def _empty_cells(simulation: Simulation, height: float) -> int:
    """How many cells no material point is in, up to a height [m] above and below the body."""
    grid = soil_scene(simulation).grid
    is_near = (grid.rows[:-1] >= -height) & (grid.rows[1:] <= height)
    cell = simulation.array("particle.cell")
    is_filled = np.zeros((grid.row_count, grid.column_count), dtype=bool)
    column, row = cell[cell[:, 0] >= 0].T
    is_filled[row, column] = True
    return int(np.count_nonzero(~is_filled[is_near]))


class _ResistanceCurve:
    """Samples the resistance, at every `SAMPLE_SPACING` radii of penetration."""

    def __init__(self, simulation: Simulation, body: RoundBody) -> None:
        self._radius = body.radius
        self._samples = ResistanceSamples(simulation, body)

    def sample(self) -> None:
        """Record the mean force since the sample before."""
        self._samples.take()

    @property
    def work(self) -> float:
        """Of the body so far [J], per radian or per unit length of half of it."""
        return math.fsum(self._samples.forces) * SAMPLE_SPACING * self._radius

    def dataset(self) -> xr.Dataset:
        """The curve."""
        return curves(
            "penetration",
            penetration_axis(len(self._samples.forces), over="radius of the body"),
            penetration_resistance=(
                self._samples.resistance,
                "Pa",
                "resistance over projected area",
                "excess over the in-situ stress",
            ),
        )
