"""The cone penetration test in undrained clay, to steady state."""

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr

from mpm_warp.execution.execution import Execution
from mpm_warp.grid.fitted import Grid, growing
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.energy import EnergyAudit, EnergyBalance
from mpm_warp.parts.history import History
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.parts.window import Approach, Window
from mpm_warp.results import labelled
from mpm_warp.sampling import Sampler, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cone import penetration, pore_pressure, soundness
from mpm_warp.scenes.cone.defaults import DERIVED_BY_ERROR, RAMP, SLOWING, ConeTestByDefault
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from mpm_warp.scenes.run_size import RunSize, of_several, size_in_grid
from mpm_warp.scenes.strength_modes import cone_factors_by_mode, rigidity_of_law
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots
from mpm_warp.uncertainty import cone, further_runs
from mpm_warp.uncertainty.built import LAWS_OF_CONES, goes_on, is_of_catalogue, why_law_not_measured
from mpm_warp.uncertainty.laws import APEX_ANGLE
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING, transient_penetration

SOURCE_HEIGHT = 2.0 / 3.0
"""Height above the tip, over that of the cone, of the point source that the cone resembles from
afar: the centroid of the volume that it displaces."""
SPARE_SLOTS, SPARE_SLOTS_WITH_FRICTION = 0.15, 0.4
"""Additional slots for material points, over the number of points that fill the grid. Many small
points from near the axis gather in the cells along a rough shaft, with friction even more."""
SANE_INERTIA, GREATEST_INERTIA, REFUSED_INERTIA = 5.0, 10.0, 50.0
"""Limits of rho V^2 / su. Up to the first nearly all random cases complete. Beyond the second few
do on coarse cells: soil is thrown off, and the transfers dissipate much of the work. Beyond the
third none of 98 did."""
CELLS_AT_SPEED = 1.8
"""Cells per radius below which cells are coarse in this sense: with fewer 23 of 85 cases complete,
with more 46 of 63."""
MANY_ROWS, SPEED_OF_MANY_ROWS, STEP_OF_MANY_ROWS = 550, 0.08, 0.125
"""Number of rows above which waves grow from row to row (`mpm_warp.step.momentum`), and what
prevents it: a speed over that of shear waves, or a path of shear waves in one step over the height
of a row. Two of 5 cases in 663 rows lost over a fifth of their work, as did all of 6 in more rows;
none did in 465."""


@dataclass(frozen=True, kw_only=True)
class ConePenetration(ConeTestByDefault):
    """A penetrometer pushed at constant speed into uniform, weightless, undrained clay.

    The strength of the clay may fall with plastic strain, and rise with the strain rate of the real
    speed.

    The penetrometer starts in place, in ground stressed as if it had come from far above. The
    simulated stresses are in excess of the vertical in-situ stress, which is in equilibrium.
    """

    summary = "cone penetration test in undrained clay, to steady state"
    version = 42
    comparable = "cone_factor"
    snapshots_over = penetration.AXIS
    limits = soundness.energy_limits("penetration")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inertia > REFUSED_INERTIA:
            beside = f"rigidity_index = {self.rigidity_index:g}"
            self.refuse("speed_ratio", f" with {beside}: {self.thrown_off(REFUSED_INERTIA)}")
        if self.uncertainty == "measured":
            self.further_tests()  # raises where one of them is not allowed

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: soil is thrown off, or waves grow from row to row."""
        return self.failure_told(1.0)

    def failure_told(self, scale: float) -> str:
        """The likely failure; the speeds in its remedy are multiplied by `scale`.

        A scene whose speed is over that of other waves has another scale than 1.
        """
        if self.inertia > GREATEST_INERTIA and self.cells_per_radius < CELLS_AT_SPEED:
            remedy = f"or {CELLS_AT_SPEED:g} cells_per_radius or more"
            return f"{self.thrown_off(GREATEST_INERTIA, scale)}, {remedy}"
        rows, clay = self._grid.row_count, self.clay
        of_approach = math.sqrt(self.approach_inertia / self.rigidity_index)
        fastest = max(self.speed_ratio, of_approach)
        small_step = STEP_OF_MANY_ROWS * clay.pressure_wave_speed / clay.shear_wave_speed
        if (
            rows <= MANY_ROWS
            or fastest <= SPEED_OF_MANY_ROWS
            or self.time_step_fraction <= small_step
        ):
            return ""
        speeds = "speed_ratio and approach_speed_ratio" if of_approach > 0.0 else "speed_ratio"
        return (
            f"soil crosses {rows} rows of cells at {fastest:.2g} of the speed of shear waves, and "
            f"waves grow from row to row; try {speeds} = {scale * SPEED_OF_MANY_ROWS:.2g} or less, "
            f"or time_step_fraction = {math.floor(10.0 * small_step) / 10.0:g}"
        )

    def thrown_off(self, limit: float, scale: float = 1.0) -> str:
        """Message that the cone is above a limit of rho V^2 / su, with a speed to try."""
        speed_ratio = scale * math.sqrt(SANE_INERTIA / self.rigidity_index)
        return (
            f"rho V^2 is {self.inertia:.3g} su, and above {limit:g} su soil is thrown off; "
            f"try speed_ratio = {speed_ratio:.2g} or less"
        )

    @property
    def clay(self) -> Material:
        """The clay as simulated: Poisson's ratio bounded, strain rates those of the real speed."""
        shear_modulus = self.rigidity_index * self.undrained_shear_strength
        speed = self.speed_ratio * math.sqrt(shear_modulus / self.density)
        return self.clay_with(
            density=self.density,
            speed_up=speed / self.penetration_speed,
            greatest_poissons_ratio=float(self.poissons_ratio_bound),
        )

    @property
    def window(self) -> Window:
        """The travel of the grid."""
        speed = self.speed_ratio * self.clay.shear_wave_speed
        travel, faster = self.approach_travel, None
        if travel > 0.0:
            faster = Approach(
                speed=speed * self.approach_speed_ratio / self.speed_ratio,
                travel=travel * self.cone_radius,
                slowing_travel=SLOWING * self.cone_radius,
            )
        rubs = self.interface.friction > 0.0
        # Beside a face blunter than the standard one points stay for long, and their velocities
        # drift from that of the grid. Bounding the difference w by rho w^2 <= su keeps the stress
        # that they exert below the strength.
        is_blunt = self.apex_angle > APEX_ANGLE
        strength = self.undrained_shear_strength
        return Window(
            speed=speed,
            ramp_travel=RAMP * self.cone_radius,
            approach=faster,
            spare_fraction=SPARE_SLOTS_WITH_FRICTION if rubs else SPARE_SLOTS,
            stray_speed=math.sqrt(strength / self.density) if is_blunt else None,
        )

    def build(self) -> Scene:
        """The soil around the penetrometer; its contact is a `PenetrometerContact`."""
        return self.build_in(self._grid)

    def build_in(self, grid: Grid) -> Scene:
        """The scene in a grid with other rows and columns around the penetrometer."""
        strength, material = self.undrained_shear_strength, self.clay
        interface = self.interface
        source = TravellingSource(
            radius=self.cone_radius,
            height=SOURCE_HEIGHT * self.penetrometer.cone_height,
            shear_modulus=material.ground_shear_modulus,
        )
        return Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=self.time_step_fraction,
            bulk_viscosity=0.2,
            stress_at_rest=self.stress_at_rest,
            parts=(
                Fixed.on(grid, radial=["axis"]),
                SurroundingGround(grid=grid, material=material, source=source, strength=strength),
                PenetrometerContact.of(
                    self.penetrometer,
                    grid,
                    face_adhesion=interface.face * strength,
                    shaft_adhesion=interface.shaft * strength,
                    friction=interface.friction,
                    strength=strength,
                    in_situ_stress=self.in_situ_stress,
                ),
                self.window,
                ConservativeInterpolation(),
                EnergyAudit(),
                *([EnergyBalance()] if self.energy_audit == "balance" else []),
            ),
        )

    @property
    def _grid(self) -> Grid:
        radius, size = self.cone_radius, self.cell_size
        span = (self.domain_radius - 1.0) * radius
        return self.penetrometer.fitted_grid(
            cell_size=size,
            columns=growing(size, span, 1.0 + self.cell_growth * size / radius),
            depth_below=self.domain_below * radius,
            height_above=self.domain_above * radius,
        )

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; that of several runs where the uncertainty is measured."""
        further = self.further_tests() if self._is_measured else {}
        return of_several([test.own_size for test in (self, *further.values())])

    @property
    def _is_measured(self) -> bool:
        """Whether further runs are made."""
        asked = self.uncertainty == "measured" and is_of_catalogue(self)
        return asked and not why_law_not_measured(self.clay, LAWS_OF_CONES)

    @property
    def own_size(self) -> RunSize:
        """The size of a run without the further ones."""
        grid, size = self._grid, self.cell_size
        columns = grid.columns * (grid.outer_radius - self.cone_radius)
        # The time step follows the smallest cells, those at the cone; a small grid has them all.
        around_cone = self.penetrometer.fitted_grid(
            cell_size=size,
            columns=np.unique(columns[[0, 1, -1]]),
            depth_below=size,
            height_above=size,
        )
        slots = grid.cell_count * self.particles_per_cell * (1.0 + self.window.spare_fraction)
        return replace(
            size_in_grid(self.build_in(around_cone), self.end_time),
            cell_count=grid.cell_count,
            particle_count=round(slots),
            # A sample keeps two forces on each node beside the penetrometer, and its own results.
            curve_bytes=self.penetration / SAMPLE_SPACING * (16.0 * grid.row_count + 1000.0),
        )

    @property
    def end_time(self) -> float:
        """Time to the greatest penetration [s]."""
        return self.window.time_to(self.penetration * self.cone_radius)

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
        rows = self.penetrometer.rows_on_face(self.cell_size)
        cone.check_measurable(self.laws(penetration=self.penetration), rows)
        wider = {name: cone.WIDER * getattr(self, name) for name in self.default_extents}
        # In a taller window the cone has more soil to pass, and the resistance settles later.
        settling = cone.SETTLING * wider["domain_above"]
        further = wider["domain_above"] - self.domain_above + settling
        wider |= {"approach": self.approach + further, "penetration": self.penetration + further}
        # Rounding to whole rows must not leave the few of a blunt face as they are.
        one_row_more = (rows + 1) * self.cone_radius / self.penetrometer.cone_height
        finer = max(cone.FINER * self.cells_per_radius, one_row_more)
        changes = {
            "mesh": {"cells_per_radius": finer},
            "growth": {"cell_growth": cone.GROWING * self.cell_growth},
            "speed": {"speed_ratio": cone.SLOWER * self.speed_ratio},
            "domain": wider,
        }
        return further_runs.further_tests(self._alone, changes, cone.DIFFERENCES)

    def error_of(self, recorded: xr.Dataset) -> cone.ConeRun:
        """What the error of a run of this test depends on."""
        return cone.ConeRun(
            laws=self.laws(penetration=float(recorded.penetration_reached)),
            strength=self.undrained_shear_strength,
            roughness=self.interface_in(recorded).face,
            goes_on=goes_on(self, self.clay),
            recorded=recorded,
        )

    @property
    def _alone(self) -> Self:
        """The test without further runs; it keeps the defaults that the test with them derives."""
        kept: dict[str, Any] = {name: float(getattr(self, name)) for name in DERIVED_BY_ERROR}
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
        built, strength = soil_scene(simulation), self.undrained_shear_strength
        pressures = pore_pressure.pore_pressure_curves(simulation, self.penetrometer)
        curves = penetration.PenetrationCurves(
            simulation,
            radius=self.cone_radius,
            transient=transient_penetration(self.rigidity_index),
            tolerance=self.steady_tolerance,
        )
        balances, views = [], []
        if self.energy_audit == "balance":
            balances = [soundness.energy_balance_curves(simulation)]
        if snapshots is not None:
            views = [penetration.PenetrationSnapshots(self, curves, snapshots)]
        samplers: list[Sampler] = [curves, pressures, *balances, *views]
        spacing = SAMPLE_SPACING * self.cone_radius
        moments = [k * spacing for k in range(1, round(self.penetration / SAMPLE_SPACING) + 1)]
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
        results = results.assign(pore_pressure.stated_beside_shaft(self, results, built))
        results = results.assign(cone_factors_by_mode(self, results) | rigidity_of_law(self))
        if self.friction_coefficient > 0.0:
            face, shaft, friction = self.interface
            built_interface = labelled(
                adhesion_factor_built=(face, "1", "adhesion factor of the face as built"),
                shaft_adhesion_factor_built=(shaft, "1", "adhesion factor of the shaft as built"),
                friction_coefficient_built=(friction, "1", "friction coefficient as built"),
            )
            results = results.assign(built_interface)
        results = self.checked(results)
        if self.steady_tolerance > 0.0 and not curves.is_steady():
            soundness.check_levelled(results)
        soundness.check_bound(results, built, strength)
        return results
