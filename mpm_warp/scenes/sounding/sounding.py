"""A sounding: a cone penetration test through ground whose properties change with depth."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from mpm_warp.errors import SimulationDiverged
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.declaration import own_parameters_of
from mpm_warp.parts.free_surface import PassingSurface
from mpm_warp.sampling import follow, soil_scene
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.failure import SANE_INERTIA
from mpm_warp.scenes.cone.groups import Domain, InSituStress, Push
from mpm_warp.scenes.cone.penetration import PenetrationCurves
from mpm_warp.scenes.cone.pore_pressure import pore_pressure_curves
from mpm_warp.scenes.cone.soundness import energy_error, energy_limits
from mpm_warp.scenes.limits import with_limits
from mpm_warp.scenes.run_size import RunSize, law_bytes, of_several
from mpm_warp.scenes.sounding.curves import last_factor, layer_values, sounding_curves
from mpm_warp.scenes.sounding.sounding_test import SoundingTest
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.built import (
    is_of_catalogue,
    why_law_not_measured,
    why_not_of_catalogue,
    why_not_tresca,
)
from mpm_warp.uncertainty.further_runs import FAILURES, one_after_the_other, with_cost
from mpm_warp.uncertainty.samples import MeasuredError, measured_by

STEADY_TOLERANCE = 0.003
"""`steady_tolerance` of the cone tests that measure the error, as by default in a cone test."""
CELLS_AT_SURFACE = 1.5
"""Cells per radius below which a sounding from the surface is likely to fail. Below it 41 of 70
random soundings did not complete, above it 8 of 46."""


@dataclass(frozen=True, kw_only=True, init=False)
class Sounding(SoundingTest):
    """A penetrometer pushed at constant speed through clay whose strength and stiffness vary.

    The strength may fall with plastic strain, and rise with the strain rate of the real speed, by
    the same law everywhere.

    The ground is a `profile`, or has a strength that is linear in depth, with one layer in it. The
    penetrometer starts in place above the first depth, or with its tip at the surface of the
    ground. Simulated stresses exclude the vertical in-situ stress, which is in equilibrium.

    Example:
        >>> ground = Profile(depth=np.array([0.0, 5.0]), strength=np.array([10e3, 30e3]))
        >>> test = Sounding(profile=ground.text)
        >>> float(test.ground.strength_at(2.5))  # [Pa]
        20000.0
    """

    summary = "cone penetration through ground that changes with depth"
    version = 33
    limits = energy_limits()
    method = ("cells_per_radius", *own_parameters_of(Domain), "speed_ratio", "uncertainty")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.uncertainty == "measured":
            _ = self.tests_by_depth  # raises where a parameter of a test is not allowed

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`; that of a cone test in the strongest soil of the ground."""
        test = self.test
        scale = self.speed_ratio / test.push.speed_ratio
        if test.inertia > SANE_INERTIA:
            return f"of the strongest soil {test.thrown_off(SANE_INERTIA, scale)}"
        if self.starts_at_surface and self.cells_per_radius < CELLS_AT_SURFACE:
            return (
                f"from the surface on fewer than {CELLS_AT_SURFACE:g} cells a radius half of the "
                f"cases are inaccurate; try cells_per_radius = {CELLS_AT_SURFACE:g} or more"
            )
        return test.failure_told(scale)

    @property
    def tests_by_depth(self) -> dict[float, ConePenetration]:
        """Cone tests whose further runs measure the error, by depth [m].

        Each is in uniform clay like that of the ground at its depth. The depths are both ends of
        the sounding, and half a sample above and below each border of layers. In a sounding from
        the surface the upper end is where the surface has left the window; there is no test if it
        never does. In uniform ground the lower end is the only depth.
        """
        begin = self.first_depth
        end = self.path.from_depth + (self.samples[-1] + 1) * self.spacing
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
        adhesion = ground.adhesion_factor_at(at, self.cone.adhesion_factor)
        anisotropy = ground.stress_anisotropy_at(at, self.stress.stress_anisotropy)
        strength, stiffness = float(ground.strength_at(at)), float(ground.shear_modulus_at(at))
        clay: dict[str, Any] = {"undrained_shear_strength": strength}
        if not self.clay.material.has_own_stiffness:
            clay["rigidity_index"] = stiffness / strength
        test = self.test
        return replace(
            test,
            clay=replace(test.clay, **clay),
            cone=self.cone_with(float(adhesion)),
            stress=InSituStress(
                stress_anisotropy=float(anisotropy),
                in_situ_stress=float(ground.vertical_stress_at(at)),
            ),
            # Approach and penetration have their defaults, as in a cone test of a user.
            push=Push(
                steady_tolerance=STEADY_TOLERANCE,
                speed_ratio=math.sqrt(self.dynamic_pressure / stiffness),
            ),
            uncertainty="measured",
        )

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; with all further runs where the uncertainty is measured."""
        tests = self.tests_by_depth.values() if self._is_measured else ()
        return of_several([self._run_size, *(test.run_size() for test in tests)])

    @property
    def _is_measured(self) -> bool:
        """Whether cone tests are run to measure the error."""
        asked = self.uncertainty == "measured" and is_of_catalogue(self)
        return asked and not why_law_not_measured(self.soil)

    @property
    def _run_size(self) -> RunSize:
        test = self.test
        size = test.run_size()
        travel_ratio = self.travel / (test.push.penetration * test.cone.cone_radius)
        varying = law_bytes(self.soil) - law_bytes(test.soil)
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
        return self.test.window.time_to(self.travel)

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
        curves = PenetrationCurves(simulation, radius=self.cone.cone_radius)
        pressures = pore_pressure_curves(simulation, self.cone.penetrometer)
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
