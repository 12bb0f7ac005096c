"""Ball and T-bar pushed down until the soil flows steadily around them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError, UnfinishedRun
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.declaration import group, own_parameters_of, parameter, redefined
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.parts.window import Window
from mpm_warp.results import labelled
from mpm_warp.sampling import follow, mean_of_points, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.clay_scene import ClayScene
from mpm_warp.scenes.cone.groups import Cone
from mpm_warp.scenes.cone.soundness import energy_error, energy_limits
from mpm_warp.scenes.full_flow import failure
from mpm_warp.scenes.full_flow.groups import BallOnShaft, Body, ClayAroundBody, Flow, TBar
from mpm_warp.scenes.full_flow.limit_load import LIMIT_LOAD_SOURCE, limit_load
from mpm_warp.scenes.full_flow.round_body import ResistanceSamples
from mpm_warp.scenes.limits import Limits
from mpm_warp.scenes.run_size import RunSize, of_several, size_in_grid
from mpm_warp.scenes.strength_modes import by_mode
from mpm_warp.scenes.verification import compared
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
`failure.GREATEST_INERTIA` 10 of 12 random cases with fewer are inaccurate, and 1 of 7 others."""
RELATIVE_SPEED = 0.3
"""Speed by default over sqrt(su / rho): rho V^2 is 9 % of su."""
LAST_CYCLE = 0.5
"""Number of the passage: the soil behind the body has borne one."""
LARGEST_CHANGE = 0.02
"""Largest relative change of the mean resistance from one two radii to the next in steady flow."""


@dataclass(frozen=True, kw_only=True, init=False)
class FullFlowPenetration(ClayScene):
    """A round body pushed at constant speed through clay, to steady flow."""

    method = (*own_parameters_of(Flow), "penetration", "uncertainty")
    limits: ClassVar[Limits] = {
        **energy_limits("penetration"),
        "error": "the limit load has no inertia, which a fast bar meets beside it",
    }

    clay: ClayAroundBody = group()
    adhesion_factor: float = redefined(
        Cone, "adhesion_factor", meaning="adhesion factor of the body"
    )
    flow: Flow = group()
    penetration: float = parameter(8.0, "penetration over radius", minimum=5, maximum=50)
    uncertainty: str = parameter(
        "none",
        "whether the error of the resistance factor is measured, by four further runs, "
        "which take some twenty times as long",
        choices=("none", "measured"),
    )

    body: Body = group()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uncertainty == "measured":
            self.further_tests()  # refuses a case whose further runs are not allowed

    def derived(self) -> Mapping[str, float]:
        """The speed over that of shear waves, which rises with sqrt(Ir)."""
        speed_ratio = RELATIVE_SPEED / math.sqrt(self.clay.rigidity_index)
        return {**super().derived(), "speed_ratio": speed_ratio}

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: remoulded soil is thrown off, or the clay is brittle."""
        clay, speed_ratio, limit = self.clay, self.flow.speed_ratio, failure.GREATEST_INERTIA
        has_many_cells = self.flow.cells_per_radius >= CELLS_AT_SPEED
        if failure.inertia(clay, speed_ratio, LAST_CYCLE) <= limit or has_many_cells:
            return failure.brittle(clay)
        thrown_off = failure.thrown_off(clay, speed_ratio, LAST_CYCLE, limit)
        return f"{thrown_off}, and {CELLS_AT_SPEED} cells_per_radius or more"

    @property
    def soil(self) -> Material:
        """The clay as it is simulated, with strain rates as at the real speed."""
        return self.clay.at_speed(self.flow.speed_ratio, self.stress_at_rest)

    @property
    def window(self) -> Window:
        """The grid travels with the body, which reaches its speed after one radius."""
        return Window(
            speed=self.flow.speed(self.clay, self.soil),
            ramp_travel=self.body.shape.radius,
            spare_fraction=SPARE_FRACTION,
        )

    def build(self) -> Scene:
        """The soil around the body, in a grid that travels with it."""
        strength = self.clay.undrained_shear_strength
        adhesion = self.adhesion_factor * strength
        return self.flow.around(
            self.body.shape, self.soil, self.window, strength=strength, adhesion=adhesion
        )

    @property
    def end_time(self) -> float:
        """Time to the end of the penetration [s]."""
        return self.window.time_to(self.penetration * self.body.shape.radius)

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
        if not self.body.shape.planar or str(results.built_law.values) not in CRITERIA:
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
        flow = self.flow
        full_flow.check_measurable(flow.cells_per_radius, flow.cell_growth)
        finer = {"cells_per_radius": math.ceil(full_flow.FINER * flow.cells_per_radius)}
        slower = {"speed_ratio": full_flow.SLOWER * flow.speed_ratio}
        changes: dict[str, dict[str, Any]] = {
            "mesh": finer,
            "speed": slower,
            "mesh_and_speed": finer | slower,
            "domain": {"domain_extent": math.ceil(full_flow.WIDER * flow.domain_extent)},
        }
        return further_runs.further_tests(self._alone, changes, full_flow.DIFFERENCES)

    def error_of(self, recorded: xr.Dataset) -> full_flow.FullFlowRun:
        """What determines the error of a run of the test."""
        flow = self.flow
        few = flow.particles_per_cell == full_flow.FEWEST_POINTS
        return full_flow.FullFlowRun(
            cells_per_radius=flow.cells_per_radius,
            relative_speed=flow.speed_ratio * math.sqrt(self.clay.rigidity_index),
            extent=flow.domain_extent,
            has_few_points=self.body.shape.planar and few,
            recorded=recorded,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Push the body down, and average its resistance over the last two radii.

        Raises:
            InaccurateRun: the transfers took too much of the work of the body.
            UnfinishedRun: the resistance still changes at the end.
        """
        body = self.body.shape
        curve = ResistanceSamples(simulation, body)
        spacing = SAMPLE_SPACING * body.radius
        moments = [k * spacing for k in range(1, round(self.penetration / SAMPLE_SPACING) + 1)]
        recorded = follow(simulation, moments, simulation.travel_to, [curve], progress)
        empty = float(_empty_cells(simulation, NEAR_HEIGHT * body.radius))
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
            resistance_factor=(mean / self.clay.undrained_shear_strength, "1", of_mean, in_the_end),
        )
        change = labelled(resistance_factor_change=(1.0 - before / mean, "1", of_change, since))
        return factor | change | by_mode(self.clay, **factor)


def _empty_cells(simulation: Simulation, height: float) -> int:
    """Number of cells without a material point, up to a height [m] above and below the centre."""
    grid = soil_scene(simulation).grid
    is_near = (grid.rows[:-1] >= -height) & (grid.rows[1:] <= height)
    in_cells = mean_of_points(simulation, simulation.array("particle.mass"))
    is_empty = np.isnan(in_cells).reshape(grid.row_count, grid.column_count)
    return int(np.count_nonzero(is_empty[is_near]))


@dataclass(frozen=True, kw_only=True, init=False)
class BallPenetration(FullFlowPenetration):
    """A ball below a smooth shaft, pushed through uniform clay to steady flow.

    Example:
        >>> round(BallPenetration(rigidity_index=200).end_time, 2)  # simulated time [s]
        0.49
    """

    summary = "ball penetrometer pushed through undrained clay to steady flow"
    version = 7

    body: BallOnShaft = group()


@dataclass(frozen=True, kw_only=True, init=False)
class TBarPenetration(FullFlowPenetration):
    """A T-bar in plane strain, pushed through uniform clay to steady flow.

    In perfectly plastic clay its resistance is the limit load of `full_flow_cylinder`.

    Example:
        >>> round(TBarPenetration(rigidity_index=200).end_time, 2)  # simulated time [s]
        0.17
    """

    summary = "T-bar pushed through undrained clay to steady flow, plane strain"
    version = 6
    verifications = compared(
        "cells_per_radius",
        (3, 4),
        *({"adhesion_factor": factor} for factor in (0.0, 0.5, 1.0)),
        error=0.02,
    )

    body: TBar = group()
