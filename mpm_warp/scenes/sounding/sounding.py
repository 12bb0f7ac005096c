"""A sounding: a cone penetration test through ground whose properties change with depth."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError, SceneError, SimulationDiverged
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.declaration import Derived, own_parameters_of
from mpm_warp.materials.material import Material
from mpm_warp.parts.free_surface import PassingSurface
from mpm_warp.parts.surrounding_ground import SurroundingGround
from mpm_warp.parts.window import Window
from mpm_warp.sampling import follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cone.cone_penetration import SANE_INERTIA, ConePenetration
from mpm_warp.scenes.cone.defaults import INCOMPRESSIBLE
from mpm_warp.scenes.cone.penetration import PenetrationCurves
from mpm_warp.scenes.cone.pore_pressure import pore_pressure_curves
from mpm_warp.scenes.cone.soundness import energy_error, energy_limits
from mpm_warp.scenes.limits import with_limits
from mpm_warp.scenes.run_size import RunSize, law_bytes, of_several
from mpm_warp.scenes.sounding.curves import last_factor, layer_values, sounding_curves
from mpm_warp.scenes.sounding.parameters import LAYER, SoundingTest, check_sounding
from mpm_warp.simulation import Simulation
from mpm_warp.step.points import seed_rows
from mpm_warp.uncertainty.built import (
    is_of_catalogue,
    why_law_not_measured,
    why_not_of_catalogue,
    why_not_tresca,
)
from mpm_warp.uncertainty.further_runs import FAILURES, one_after_the_other, with_cost
from mpm_warp.uncertainty.samples import MeasuredError, measured_by

PIC_FRACTION = 0.02
"""PIC fraction of the material points near the surface of the ground; see `PassingSurface`. Without
it soil is thrown off the surface. At 3 cells per radius, the resistances with 0.01 and with 0.03
differ by 10 % two radii below the surface, and by 1 % from three radii on."""
STEADY_TOLERANCE = 0.003
"""`steady_tolerance` of the cone tests that measure the error, as by default in a cone test."""
TIME_STEP_FRACTION = 0.7
"""Largest time step over the critical one, in a sounding from the surface. Cells near the surface
have no mass-matrix correction; without it 0.76 is stable."""
CELLS_AT_SURFACE = 1.5
"""Cells per radius below which a sounding from the surface is likely to fail. Below it 41 of 70
random soundings did not complete, above it 8 of 46."""


@dataclass(frozen=True, kw_only=True)
class Sounding(SoundingTest):
    """A penetrometer pushed at constant speed through clay whose strength and stiffness vary.

    The strength may fall with plastic strain, and rise with the strain rate of the real speed, by
    the same law everywhere.

    The ground is a `profile`, or has a strength that is linear in depth, with one layer in it. The
    penetrometer starts in place above the first depth, or with its tip at the surface of the
    ground. Simulated stresses exclude the vertical in-situ stress, which is in equilibrium.
    """

    summary = "cone penetration through ground that changes with depth"
    version = 33
    limits = energy_limits()

    def check_clay(self) -> None:
        """Check the clay as `ClayScene` does, in a profile that of each row."""
        if self.profile is None:
            self._follow_law()
        check_sounding(self)
        try:
            _ = self.clay
        except (ParameterError, SceneError) as refusal:
            key = refusal.key if isinstance(refusal, ParameterError) else "ductility"
            raise ParameterError(key, f"in the ground that the cone passes: {refusal}") from None
        if self.uncertainty == "measured":
            _ = self.tests_by_depth  # raises where a parameter of a test is not allowed

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`; that of a cone test in the strongest soil of the ground."""
        test = self._test
        scale = self.speed_ratio / test.speed_ratio
        if test.inertia > SANE_INERTIA:
            return f"of the strongest soil {test.thrown_off(SANE_INERTIA, scale)}"
        if self.starts_at_surface and self.cells_per_radius < CELLS_AT_SURFACE:
            return (
                f"from the surface on fewer than {CELLS_AT_SURFACE:g} cells a radius half of the "
                f"cases are inaccurate; try cells_per_radius = {CELLS_AT_SURFACE:g} or more"
            )
        return test.failure_told(scale)

    @property
    def _test(self) -> ConePenetration:
        """The cone test in uniform clay with the greatest strength and stiffness passed.

        If parameters of the material law vary, it is the test in the clay of the stiffest row.
        """
        ground = self.ground_passed
        row = int(ground.shear_modulus.argmax()) if ground.of_law else None
        # In ground that varies, the variation of the material holds the in-situ anisotropy.
        of_ground = ground.stress_anisotropy_at(ground.depth[:1], self.stress_anisotropy)
        return self._test_in(row, float(of_ground[0]) if ground.is_uniform else 0.0)

    def _test_in(self, row: int | None, stress_anisotropy: float) -> ConePenetration:
        """The cone test in the clay of a row of the ground passed; None: see `_test`."""
        ground = self.ground_passed
        chosen = slice(None) if row is None else slice(row, row + 1)
        shear_modulus = ground.shear_modulus[chosen].max()
        of_ground = self._in_ground(
            ground.strength[chosen].max(),
            shear_modulus,
            ground.greatest_adhesion_factor(self.adhesion_factor),
            stress_anisotropy,
            ground.vertical_stress_at(np.array(max(0.0, self.start_depth))),
        )
        of_start = {
            "approach": 0.0,
            "steady_tolerance": 0.0,
            "uncertainty": "known",
            # No law corrects a sample for the bound of Poisson's ratio.
            "poissons_ratio_bound": INCOMPRESSIBLE,
            "speed_ratio": self.speed_ratio * math.sqrt(ground.shear_modulus.min() / shear_modulus),
        }
        if self.starts_at_surface:
            of_start["time_step_fraction"] = min(self.time_step_fraction, TIME_STEP_FRACTION)
        of_law = {name: float(values[row]) for name, values in ground.of_law.items()}
        common = own_parameters_of(type(self)).keys() & own_parameters_of(ConePenetration).keys()
        values = {name: getattr(self, name) for name in common}
        # The test would derive another default window than that of the sounding.
        kept = {
            name: float(value) if isinstance(value, Derived) else value
            for name, value in values.items()
        }
        law = self.material.changed(of_law)
        given: dict[str, Any] = kept | of_ground | of_start | {"material": law}
        return ConePenetration(**given)

    def _in_ground(
        self, strength: Any, shear_modulus: Any, adhesion: Any, anisotropy: Any, vertical: Any
    ) -> dict[str, Any]:
        """Parameters of a cone test in this clay, under this vertical stress [Pa]."""
        index = float(shear_modulus) / float(strength)
        return {
            # The stiffness that a law derives from its parameters is not linear between rows.
            "rigidity_index": Derived(index) if self.material.has_own_stiffness else index,
            "undrained_shear_strength": float(strength),
            "adhesion_factor": float(adhesion),
            "shaft_adhesion_factor": self.shaft_adhesion(float(adhesion)),
            "stress_anisotropy": float(anisotropy),
            "in_situ_stress": float(vertical),
        }

    @property
    def clay(self) -> Material:
        """The clay of `_test`, varied with depth like the ground."""
        test, ground = self._test, self.ground_passed
        anisotropy = ground.stress_anisotropy_at(ground.depth, self.stress_anisotropy)
        rows = None
        if ground.of_law:
            rows = tuple(self._test_in(*row).clay for row in enumerate(anisotropy.tolist()))
        else:  # raise where the in-situ stress is outside the yield surface
            _ = [self._test_in(None, extreme) for extreme in {anisotropy.min(), anisotropy.max()}]
        variation = ground.variation(
            self.start_depth,
            self.stress_anisotropy,
            strength=test.undrained_shear_strength,
            rows=rows,
        )
        return replace(test.clay, variation=variation)

    @property
    def tests_by_depth(self) -> dict[float, ConePenetration]:
        """Cone tests whose further runs measure the error, by depth [m].

        Each is in uniform clay like that of the ground at its depth. The depths are both ends of
        the sounding, and half a sample above and below each border of layers. In a sounding from
        the surface the upper end is where the surface has left the window; there is no test if it
        never does. In uniform ground the lower end is the only depth.
        """
        begin = self._first_depth
        end = self.from_depth + (self.samples[-1] + 1) * self.spacing
        if self.starts_at_surface:
            begin = max(begin, self.start_depth + self.surface_passed)
        if begin >= end:
            return {}
        depths, half = self.ground.depth, 0.5 * self.spacing
        borders = depths[1:][np.diff(depths) == 0.0]
        sides = np.add.outer(borders, [-half, half]).ravel().tolist()
        others = [begin, *(side for side in sides if begin < side < end)]
        chosen = [end] if self.ground_passed.is_uniform else [*others, end]
        return {depth: self._test_at(depth) for depth in chosen}

    def _test_at(self, depth: float) -> ConePenetration:
        """The cone test of `tests_by_depth` at a depth [m]; its error is measured."""
        ground, at = self.ground, np.array(depth)
        changes = self._in_ground(
            ground.strength_at(at),
            ground.shear_modulus_at(at),
            ground.adhesion_factor_at(at, self.adhesion_factor),
            ground.stress_anisotropy_at(at, self.stress_anisotropy),
            ground.vertical_stress_at(at),
        )
        # Approach and penetration have their defaults, as in a cone test of a user.
        method = {"steady_tolerance": STEADY_TOLERANCE, "approach": None, "penetration": None}
        speed_ratio = math.sqrt(self.dynamic_pressure / ground.shear_modulus_at(at))
        changes |= {"uncertainty": "measured", "speed_ratio": speed_ratio, **method}
        return replace(self._test, **changes)

    def build(self) -> Scene:
        """The scene of a cone test in clay that varies, in place or from the surface."""
        scene = replace(self._test.build(), material=self.clay)
        return self._from_surface(scene) if self.starts_at_surface else scene

    def _from_surface(self, scene: Scene) -> Scene:
        """The scene of a cone test that starts with its tip at the surface of the ground.

        As the cone penetrates, soil heaves beside it. The surface moves up through the window and
        leaves it at the top; from then on the scene is that of a deep cone. The simulated soil is
        weightless: its weight is in the in-situ stress, and acts on the cone as sigma_v0. The
        weight of the heave is left out; it is some gamma R / su, about 0.01, of the strength.
        """
        level = self.start_depth
        grid, window = replace(scene.grid, ground_level=level), scene[Window]
        seeded = len(seed_rows(grid, grid.row_count, scene.particles_per_side).volume)
        slots = (1.0 + window.spare_fraction) * grid.cell_count * scene.particles_per_side**2
        surface = PassingSurface(
            level=level, layer=LAYER * self.cone_radius, pic_fraction=PIC_FRACTION
        )
        return replace(scene, grid=grid).with_parts(
            replace(window, spare_fraction=slots / seeded - 1.0),
            replace(scene[SurroundingGround], from_afar=False),
            surface,
        )

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; with all further runs where the uncertainty is measured."""
        tests = self.tests_by_depth.values() if self._is_measured else ()
        return of_several([self._run_size, *(test.run_size() for test in tests)])

    @property
    def _is_measured(self) -> bool:
        """Whether cone tests are run to measure the error."""
        asked = self.uncertainty == "measured" and is_of_catalogue(self)
        return asked and not why_law_not_measured(self.clay)

    @property
    def _run_size(self) -> RunSize:
        test = self._test
        size = test.run_size()
        travel_ratio = self.travel / (test.penetration * test.cone_radius)
        varying = law_bytes(self.clay) - law_bytes(test.clay)
        surface = PassingSurface.cell_bytes if self.starts_at_surface else 0.0
        return replace(
            size,
            step_count=travel_ratio * size.step_count,
            bytes_per_cell=size.bytes_per_cell + surface,
            bytes_per_particle=size.bytes_per_particle + varying,
            curve_bytes=travel_ratio * size.curve_bytes,
        )

    @property
    def end_time(self) -> float:
        """Time to the last depth [s]."""
        return self._test.window.time_to(self.travel)

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """The results of a run; to measure the uncertainty, cone tests are run first."""
        tests = self.tests_by_depth if self._is_measured else {}
        if not tests:
            return super().compute(progress, execution)
        sizes = [*(further.run_size() for further in tests.values()), self._run_size]
        *parts, own = one_after_the_other(sizes, progress)
        outcomes: list[xr.Dataset | str] = []
        for part, test in zip(parts, tests.values(), strict=True):
            try:
                outcomes.append(test.compute(part, execution))
            except FAILURES as error:
                outcomes.append(f"further runs: {error}")
        simulation = Simulation(self.build(), execution)
        results = self.record(simulation, own, measured_by(list(tests), outcomes))
        return with_cost(results, [it for it in outcomes if isinstance(it, xr.Dataset)])

    def checked(self, results: xr.Dataset) -> xr.Dataset:
        """See `CatalogueScene`; no accuracy is stated where the surface stays in the window."""
        if not self.starts_at_surface or self.travel >= self.surface_passed:
            return super().checked(results)
        return with_limits(self.limits, results)

    def record(
        self, simulation: Simulation, progress: Progress, measured: MeasuredError | None = None
    ) -> xr.Dataset:
        """Push the penetrometer through the ground; `measured` replaces the laws of the error."""
        curves = PenetrationCurves(simulation, radius=self.cone_radius)
        pressures = pore_pressure_curves(simulation, self.penetrometer)
        built = soil_scene(simulation)
        of_others = why_not_of_catalogue(self, built)
        why_none = of_others or why_law_not_measured(built.material)
        if measured is None:
            why_none = why_none or why_not_tresca(built.material)
        count = self.lead_count + len(self.samples)
        moments = [number * self.spacing for number in range(1, count + 1)]
        try:
            recorded = follow(
                simulation, moments, simulation.travel_to, [curves, pressures], progress
            )
        except SimulationDiverged as error:
            sampled = error.curves
            if sampled is not None:  # None: before the first sample
                begun = sampled.sizes["penetration"] > self.lead_count
                error.curves = sounding_curves(self, sampled, why_none, measured) if begun else None
            raise
        over_depth = sounding_curves(self, recorded, why_none, measured)
        layer = layer_values(self, over_depth, is_known=measured is None and not why_none)
        is_thin = "layer_share" in layer  # the share of the layer is then the main result
        values = layer if is_thin else last_factor(over_depth) | layer
        return over_depth.assign(values | energy_error(simulation, curves.work))
