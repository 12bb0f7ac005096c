"""Ball and T-bar pushed down until the soil flows steadily around them."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError, UnfinishedRun
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.declaration import parameter
from mpm_warp.materials import CRITERIA
from mpm_warp.parts.window import Window
from mpm_warp.results import labelled
from mpm_warp.sampling import follow, mean_of_points, soil_scene
from mpm_warp.scenes.catalogue import CatalogueScene, Progress, compared
from mpm_warp.scenes.cone.soundness import energy_error, energy_limits
from mpm_warp.scenes.full_flow.limit_load import LIMIT_LOAD_SOURCE, limit_load
from mpm_warp.scenes.full_flow.penetrometer import (
    GREATEST_INERTIA,
    Ball,
    FullFlowPenetrometer,
    ResistanceSamples,
    TBar,
)
from mpm_warp.scenes.limits import Limits
from mpm_warp.scenes.run_size import RunSize, of_several, size_in_grid
from mpm_warp.scenes.strength_modes import by_mode
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty import full_flow, further_runs
from mpm_warp.uncertainty.built import why_law_not_measured, why_not_of_catalogue
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING, STEADY_SAMPLES, steady_mean

SPARE_FRACTION = 0.4
"""Spare slots for material points, over the number of points that fill the grid."""
NEAR_HEIGHT = 2.0
"""Height above and below the centre, in radii, within which an empty cell affects the body."""
NOT_MEASURED = "further runs: none were made; uncertainty = measured makes them"
CELLS_AT_SPEED = 4
"""Cells per radius from which on the energy error stays below its limit at any speed. Above
`GREATEST_INERTIA` 10 of 12 random cases with fewer are inaccurate, and 1 of 7 others."""
LARGEST_CHANGE = 0.02
"""Largest relative change of the mean resistance from one two radii to the next in steady flow."""


@dataclass(frozen=True, kw_only=True)
class FullFlowPenetration(FullFlowPenetrometer):
    """A round body pushed at constant speed through clay, to steady flow."""

    method = (*FullFlowPenetrometer.method, "penetration", "uncertainty")
    limits: ClassVar[Limits] = {
        **energy_limits("penetration"),
        "error": "the limit load has no inertia, which a fast bar meets beside it",
    }

    penetration: float = parameter(8.0, "penetration over radius", minimum=5, maximum=50)
    uncertainty: str = parameter(
        "none",
        "whether the error of the resistance factor is measured, by four further runs, "
        "which take some twenty times as long",
        choices=("none", "measured"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uncertainty == "measured":
            self.further_tests()  # refuses a case whose further runs are not allowed

    @property
    def last_cycle(self) -> float:
        """See `FullFlowPenetrometer`: the soil behind the body has borne one passage."""
        return 0.5

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: remoulded soil is thrown off, or the clay is brittle."""
        if self.inertia <= GREATEST_INERTIA or self.cells_per_radius >= CELLS_AT_SPEED:
            return self.brittle
        return f"{self.thrown_off(GREATEST_INERTIA)}, and {CELLS_AT_SPEED} cells_per_radius or more"

    @property
    def window(self) -> Window:
        """The grid travels with the body, which reaches its speed after one radius."""
        return Window(speed=self.speed, ramp_travel=self.body.radius, spare_fraction=SPARE_FRACTION)

    @property
    def end_time(self) -> float:
        """Time to the end of the penetration [s]."""
        return self.window.time_to(self.penetration * self.body.radius)

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; with the further runs where the uncertainty is measured."""
        tests = () if self._why_no_uncertainty() else self.further_tests().values()
        return of_several([test.own_size for test in (self, *tests)])

    @property
    def own_size(self) -> RunSize:
        """The size of a run without the further ones."""
        return size_in_grid(self.build(), self.end_time)

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """Run the test, and the further tests where the uncertainty is to be measured.

        For plane strain in perfectly plastic clay the results include the exact limit load.
        """

        def run(test: "FullFlowPenetration", report: Progress) -> xr.Dataset:
            return CatalogueScene.compute(test, report, execution)

        reasons = self._why_no_uncertainty()
        if reasons:
            results = run(self._alone, progress)
            results = results.assign(self.error_of(results).stated(0.0, {}, reasons))
        else:
            results = further_runs.with_measured_error(self._alone, run, progress)
        if not self.body.planar or str(results.built_law.values) not in CRITERIA:
            return results
        exact = limit_load(self.adhesion_factor)
        error = abs(float(results.resistance_factor) / exact - 1.0)
        of_limit = (exact, "1", "limit load over projected area and su", LIMIT_LOAD_SOURCE)
        of_error = (error, "1", "error of the resistance", "relative to the limit load")
        found = labelled(resistance_factor_exact=of_limit) | labelled(role="error", error=of_error)
        return results.assign(found)

    @property
    def _alone(self) -> Self:
        """This test without further runs."""
        return replace(self, uncertainty="none")

    def _why_no_uncertainty(self) -> list[str]:
        """Why the error is not measured, each reason as "word: sentence"; [] if it is."""
        scene = self.build()
        cannot = why_not_of_catalogue(self, scene) or why_law_not_measured(scene.material)
        if cannot or self.uncertainty == "measured":
            return cannot
        try:
            self.further_tests()
        except ParameterError as error:
            return [f"further runs: {error}"]
        return [NOT_MEASURED]

    def further_tests(self) -> dict[str, Self]:
        """The further tests, by what they change; `ParameterError` where one is not allowed."""
        full_flow.check_measurable(self.cells_per_radius, self.cell_growth)
        finer = {"cells_per_radius": math.ceil(full_flow.FINER * self.cells_per_radius)}
        slower = {"speed_ratio": full_flow.SLOWER * self.speed_ratio}
        changes: dict[str, dict[str, Any]] = {
            "mesh": finer,
            "speed": slower,
            "mesh_and_speed": finer | slower,
            "domain": {"domain_extent": math.ceil(full_flow.WIDER * self.domain_extent)},
        }
        return further_runs.further_tests(self._alone, changes, full_flow.DIFFERENCES)

    def error_of(self, recorded: xr.Dataset) -> full_flow.FullFlowRun:
        """What determines the error of a run of the test."""
        few = self.particles_per_cell == full_flow.FEWEST_POINTS
        return full_flow.FullFlowRun(
            cells_per_radius=self.cells_per_radius,
            relative_speed=self.speed_ratio * math.sqrt(self.rigidity_index),
            extent=self.domain_extent,
            has_few_points=self.body.planar and few,
            recorded=recorded,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Push the body down, and average its resistance over the last two radii.

        Raises:
            InaccurateRun: the transfers took too much of the work of the body.
            UnfinishedRun: the resistance still changes at the end.
        """
        curve = ResistanceSamples(simulation, self.body)
        spacing = SAMPLE_SPACING * self.body.radius
        moments = [k * spacing for k in range(1, round(self.penetration / SAMPLE_SPACING) + 1)]
        recorded = follow(simulation, moments, simulation.travel_to, [curve], progress)
        empty = float(_empty_cells(simulation, NEAR_HEIGHT * self.body.radius))
        near = "cells near the body without a material point"
        holes = f"within {NEAR_HEIGHT:g} radii at the end; above 0 only where soil leaves a hole"
        results = recorded.assign(
            self._steady_values(recorded.penetration_resistance)
            | labelled(empty_cells=(empty, "1", near, holes))
            | energy_error(simulation, curve.work)
        )
        results = self.checked(results)
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
        in_the_end = f"mean {over}, of the excess over the in-situ stress"
        of_mean = "resistance over projected area and su"
        of_change = "change of the mean resistance over two radii"
        since = f"mean {over} less that over the two before, over it"
        factor = labelled(
            role="headline",
            resistance_factor=(mean / self.undrained_shear_strength, "1", of_mean, in_the_end),
        )
        change = labelled(resistance_factor_change=(1.0 - before / mean, "1", of_change, since))
        return factor | change | by_mode(self, **factor)


def _empty_cells(simulation: Simulation, height: float) -> int:
    """Number of cells without a material point, up to a height [m] above and below the centre."""
    grid = soil_scene(simulation).grid
    is_near = (grid.rows[:-1] >= -height) & (grid.rows[1:] <= height)
    in_cells = mean_of_points(simulation, simulation.array("particle.mass"))
    is_empty = np.isnan(in_cells).reshape(grid.row_count, grid.column_count)
    return int(np.count_nonzero(is_empty[is_near]))


@dataclass(frozen=True, kw_only=True)
class BallPenetration(Ball, FullFlowPenetration):
    """A ball below a smooth shaft, pushed through uniform clay to steady flow."""

    summary = "ball penetrometer pushed through undrained clay to steady flow"
    version = 7

    shaft_radius_ratio: float = parameter(
        0.316,
        "radius of the shaft over that of the ball: 10 cm2 below 100 cm2; 0: no shaft",
        minimum=0,
        maximum=0.8,
    )


@dataclass(frozen=True, kw_only=True)
class TBarPenetration(TBar, FullFlowPenetration):
    """A T-bar in plane strain, pushed through uniform clay to steady flow.

    In perfectly plastic clay its resistance is the limit load of `full_flow_cylinder`.
    """

    summary = "T-bar pushed through undrained clay to steady flow, plane strain"
    version = 6
    verifications = compared(
        "cells_per_radius",
        (3, 4),
        *({"adhesion_factor": factor} for factor in (0.0, 0.5, 1.0)),
        error=0.02,
    )
