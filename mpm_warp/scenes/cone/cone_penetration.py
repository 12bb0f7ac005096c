"""The cone penetration test in undrained clay, to steady state: its runs and results."""

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr

from mpm_warp.execution.execution import Execution
from mpm_warp.fields.declaration import own_parameters_of
from mpm_warp.parts.history import History
from mpm_warp.results import labelled
from mpm_warp.sampling import Sampler, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.cone import penetration, pore_pressure, soundness
from mpm_warp.scenes.cone.cone_test import ConeTest
from mpm_warp.scenes.cone.groups import Domain, Push, Resolution
from mpm_warp.scenes.cone.interface import interface_in
from mpm_warp.scenes.run_size import RunSize, of_several, size_in_grid
from mpm_warp.scenes.strength_modes import cone_factors_by_mode, rigidity_of_law
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots
from mpm_warp.uncertainty import cone, further_runs
from mpm_warp.uncertainty.built import LAWS_OF_CONES, goes_on, is_of_catalogue, why_law_not_measured
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING, transient_penetration


@dataclass(frozen=True, kw_only=True, init=False)
class ConePenetration(ConeTest):
    """A cone test whose resistance becomes steady, with its error known or measured.

    The strength of the clay may fall with plastic strain, and rise with the strain rate of the real
    speed.

    Example:
        >>> test = ConePenetration(rigidity_index=150, adhesion_factor=0.5)
        >>> test.soil.shear_modulus, test.run_size().cell_count  # [Pa], cells
        (3000000.0, 2093)
        >>> test
        ConePenetration(rigidity_index=150.0, adhesion_factor=0.5)
    """

    summary = "cone penetration test in undrained clay, to steady state"
    version = 42
    comparable = "cone_factor"
    snapshots_over = penetration.AXIS
    limits = soundness.energy_limits("penetration")
    method = (
        *own_parameters_of(Resolution),
        *own_parameters_of(Domain),
        *own_parameters_of(Push),
        "uncertainty",
        "energy_audit",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uncertainty == "measured":
            self.further_tests()  # raises where one of them is not allowed

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; that of several runs where the uncertainty is measured."""
        further = self.further_tests() if self._is_measured else {}
        return of_several([test.own_size for test in (self, *further.values())])

    @property
    def _is_measured(self) -> bool:
        """Whether further runs are made."""
        asked = self.uncertainty == "measured" and is_of_catalogue(self)
        return asked and not why_law_not_measured(self.soil, LAWS_OF_CONES)

    @property
    def own_size(self) -> RunSize:
        """The size of a run without further ones."""
        grid, size, radius = self._grid, self.cell_size, self.cone.cone_radius
        columns = grid.columns * (grid.outer_radius - radius)
        # The time step follows the smallest cells, those at the cone; a small grid has them all.
        around_cone = self.cone.penetrometer.fitted_grid(
            cell_size=size,
            columns=np.unique(columns[[0, 1, -1]]),
            depth_below=size,
            height_above=size,
        )
        per_cell = self.resolution.particles_per_cell
        slots = grid.cell_count * per_cell * (1.0 + self.window.spare_fraction)
        return replace(
            size_in_grid(self.build_in(around_cone), self.end_time),
            cell_count=grid.cell_count,
            particle_count=round(slots),
            # A sample keeps two forces on each node beside the penetrometer, and its own results.
            curve_bytes=self.push.penetration / SAMPLE_SPACING * (16.0 * grid.row_count + 1000.0),
        )

    def compute(
        self, progress: Progress, execution: Execution | None, snapshots: Snapshots | None = None
    ) -> xr.Dataset:
        """The results of a run, and of its further runs where they measure the uncertainty."""

        def run(test: "ConePenetration", report: Progress) -> xr.Dataset:
            shown = snapshots if test is self else None
            scene = test.build() if shown is None else test.build().with_parts(History())
            simulation = Simulation(scene, execution)
            report(0.0)
            return test.record(simulation, report, shown)

        if not self._is_measured:
            return run(self, progress)
        measured = further_runs.with_measured_error(self, run, progress)
        return measured.assign(cone_factors_by_mode(self, measured))

    compute_with_snapshots = compute

    def further_tests(self) -> dict[str, Self]:
        """The tests that measure the error of this one, by the effect that each measures.

        Raises:
            ParameterError: one of them is outside the allowed range, or no law of the error holds.
        """
        push, penetrometer = self.push, self.cone.penetrometer
        rows = penetrometer.rows_on_face(self.cell_size)
        cone.check_measurable(self.laws(penetration=push.penetration), rows)
        wider = {name: cone.WIDER * getattr(self.domain, name) for name in self.default_extents}
        # In a taller window the cone has more soil to pass, and the resistance settles later.
        settling = cone.SETTLING * wider["domain_above"]
        further = wider["domain_above"] - self.domain.domain_above + settling
        wider |= {"approach": push.approach + further, "penetration": push.penetration + further}
        # Rounding to whole rows must not leave the few of a blunt face as they are.
        one_row_more = (rows + 1) * penetrometer.radius / penetrometer.cone_height
        finer = max(cone.FINER * self.resolution.cells_per_radius, one_row_more)
        changes = {
            "mesh": {"cells_per_radius": finer},
            "growth": {"cell_growth": cone.GROWING * self.domain.cell_growth},
            "speed": {"speed_ratio": cone.SLOWER * push.speed_ratio},
            "domain": wider,
        }
        return further_runs.further_tests(self._alone, changes, cone.DIFFERENCES)

    def error_of(self, recorded: xr.Dataset) -> cone.ConeRun:
        """What the error of a run of this test depends on."""
        return cone.ConeRun(
            laws=self.laws(penetration=float(recorded.penetration_reached)),
            strength=self.clay.undrained_shear_strength,
            roughness=interface_in(recorded, self.interface, self.clay, self.stress).face,
            goes_on=goes_on(self, self.soil),
            recorded=recorded,
        )

    def beside_shaft(self, recorded: xr.Dataset, built: Scene) -> dict[str, xr.Variable]:
        """See `pore_pressure.stated_beside_shaft`."""
        return pore_pressure.stated_beside_shaft(
            recorded,
            built,
            laws=self.laws(penetration=self.push.penetration),
            strength=self.clay.undrained_shear_strength,
            interface=self.interface,
            rough=interface_in(recorded, self.interface, self.clay, self.stress),
            is_corrected=goes_on(self, built.material),
        )

    @property
    def _alone(self) -> Self:
        """The test without further runs; it keeps the method that the test with them derives."""
        kept: dict[str, Any] = {"push": self.push.kept, "resolution": self.resolution.kept}
        return replace(self, uncertainty="known", **kept)

    def record(
        self, simulation: Simulation, progress: Progress, snapshots: Snapshots | None = None
    ) -> xr.Dataset:
        """Push the penetrometer in until its resistance is steady, and take snapshots on the way.

        Raises:
            InaccurateRun: the transfers took too much of the penetrometer's work, or the cone
                factor is above any that soil can have.
            UnfinishedRun: a steady resistance is required (`steady_tolerance` > 0), but at the
                greatest penetration the resistance still changes.
        """
        built, strength = soil_scene(simulation), self.clay.undrained_shear_strength
        radius, push = self.cone.cone_radius, self.push
        pressures = pore_pressure.pore_pressure_curves(simulation, self.cone.penetrometer)
        curves = penetration.PenetrationCurves(
            simulation,
            radius=radius,
            transient=transient_penetration(self.clay.rigidity_index),
            tolerance=push.steady_tolerance,
        )
        balances, views = [], []
        if self.energy_audit == "balance":
            balances = [soundness.energy_balance_curves(simulation)]
        if snapshots is not None:
            views = [penetration.PenetrationSnapshots(self, curves, snapshots)]
        samplers: list[Sampler] = [curves, pressures, *balances, *views]
        spacing = SAMPLE_SPACING * radius
        moments = [k * spacing for k in range(1, round(push.penetration / SAMPLE_SPACING) + 1)]
        recorded = follow(
            simulation, moments, simulation.travel_to, samplers, progress, is_over=curves.is_steady
        )
        for view in views:
            view.sample(is_last=True)
        most_steps = math.ceil(self.end_time / simulation.plan.time_step)
        results = recorded.assign(
            penetration.steady_values(recorded, strength)
            | pore_pressure.pore_pressure_factors(recorded, strength)
            | labelled(step_count_bound=(most_steps, "1", "time steps to the greatest penetration"))
            | soundness.energy_error(simulation, curves.work)
        )
        results = results.assign(cone.known_error(self.error_of(results), self, built))
        results = results.assign(self.beside_shaft(results, built))
        of_law = cone_factors_by_mode(self, results) | rigidity_of_law(self.clay, self.soil)
        results = results.assign(of_law)
        if self.cone.friction_coefficient > 0.0:
            results = results.assign(self.interface.as_built)
        results = self.checked(results)
        if push.steady_tolerance > 0.0 and not curves.is_steady():
            soundness.check_levelled(results)
        soundness.check_bound(results, built, strength)
        return results
