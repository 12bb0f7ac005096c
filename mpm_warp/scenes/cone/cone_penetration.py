"""The cone penetration test in undrained clay, to steady state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import xarray as xr

from mpm_warp.materials import CRITERIA
from mpm_warp.parameters import parameter
from mpm_warp.parts.far_field import FarField
from mpm_warp.parts.fixed import Fixed
from mpm_warp.plan.plan import Plan
from mpm_warp.results import variable
from mpm_warp.sampling import follow, soil_scene, transferred_energy
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import CatalogueScene, Progress
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING, PenetrationCurves, steady_values
from mpm_warp.scenes.cone.penetrometer import Penetrometer, PenetrometerContact
from mpm_warp.scenes.cone.soundness import (
    check_bound,
    check_energy,
    check_levelled,
    energy_error,
)
from mpm_warp.scenes.cone.window import (
    approach_speed_ratio,
    unsteady_penetration,
    window_of_test,
)
from mpm_warp.scenes.shared_parameters import floating_point, yield_criterion
from mpm_warp.simulation import Simulation

VON_MISES_STRENGTH = 2.0 / math.sqrt(3.0)
"""Strength of soil of von Mises in compression along one axis, over that of Tresca."""


@dataclass(frozen=True, kw_only=True)
class ConePenetration(CatalogueScene):
    """A penetrometer pushed at constant speed into uniform, weightless, undrained clay.

    The penetrometer starts in place, in undisturbed ground. Excess stresses are simulated: those
    over the isotropic in-situ stress, which balances itself.
    """

    summary: ClassVar[str] = "cone penetration test in undrained clay, to steady state"
    version: ClassVar[int] = 7
    method: ClassVar[tuple[str, ...]] = (
        "cells_per_radius",
        "cell_growth",
        "particles_per_cell",
        "time_step_fraction",
        "speed_ratio",
        "approach",
        "approach_speed_ratio",
        "penetration",
        "steady_tolerance",
        "domain_radius",
        "domain_above",
        "domain_below",
        "poissons_ratio_bound",
        "precision",
    )

    rigidity_index: float = parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=2, maximum=5000
    )
    adhesion_factor: float = parameter(
        0.0, unit="1", meaning="adhesion factor of the cone face", minimum=0, maximum=1
    )
    shaft_adhesion_factor: float | None = parameter(
        None,
        unit="1",
        meaning="adhesion factor of the shaft (default: the face's)",
        minimum=0,
        maximum=1,
    )
    friction_coefficient: float = parameter(
        0.0,
        unit="1",
        meaning="Coulomb friction coefficient of the penetrometer",
        minimum=0,
        maximum=1,
    )
    undrained_shear_strength: float = parameter(
        20e3,
        unit="Pa",
        meaning="undrained shear strength su in pure shear",
        minimum=1e-3,
        maximum=1e9,
    )
    material: str = yield_criterion()
    poissons_ratio: float = parameter(
        0.49, unit="1", meaning="Poisson's ratio", minimum=0, maximum=0.4999
    )
    density: float = parameter(
        1700.0, unit="kg m-3", meaning="density of the clay", minimum=1e-3, maximum=1e9
    )
    in_situ_stress: float = parameter(
        400e3, unit="Pa", meaning="isotropic total stress in the ground before", minimum=0
    )
    cone_radius: float = parameter(
        0.01785, unit="m", meaning="radius of the cone's base", minimum=1e-6, maximum=1e3
    )
    apex_angle: float = parameter(
        60.0, unit="degree", meaning="apex angle of the cone", minimum=30, maximum=150
    )
    penetration: float = parameter(
        30.0, unit="1", meaning="greatest penetration over cone radius", minimum=1, maximum=200
    )
    approach: float = parameter(
        8.0,
        unit="1",
        meaning="penetration of the approach, its rise and fall of speed included, over cone "
        "radius; ends 5.5 before the greatest at the latest, 3 or less: none",
        minimum=0,
        maximum=200,
    )
    approach_speed_ratio: float | None = parameter(
        None,
        unit="1",
        meaning="approach speed over shear wave speed (default: the lesser of 4 speed_ratio and "
        "sqrt(7 / Ir)); not above speed_ratio: no approach",
        above=0,
        maximum=0.5,
    )
    steady_tolerance: float = parameter(
        0.003,
        unit="1",
        meaning="change of the resistance over two radii at which it counts as steady, and the run "
        "ends; 0: never, and the run need not become steady",
        minimum=0,
        maximum=0.1,
    )
    speed_ratio: float = parameter(
        0.03, unit="1", meaning="penetration speed over shear wave speed", minimum=1e-4, maximum=0.5
    )
    cells_per_radius: float = parameter(
        3.0, unit="1", meaning="cells per cone radius at the cone", minimum=1, maximum=100
    )
    cell_growth: float = parameter(
        0.8,
        unit="1",
        meaning="growth of the cells' width per distance from the penetrometer",
        minimum=0.1,
        maximum=2,
    )
    # One a cell leaves cells empty beside the shaft: the cone factor comes out a sixth too low.
    particles_per_cell: int = parameter(
        4, unit="1", meaning="material points per cell", choices=(4, 9, 16, 25)
    )
    time_step_fraction: float = parameter(
        0.85, unit="1", meaning="time step over the critical one", minimum=0.01, maximum=1.2
    )
    domain_radius: float = parameter(
        40.0, unit="1", meaning="radius of the grid over cone radius", minimum=5, maximum=1000
    )
    domain_above: float = parameter(
        14.0,
        unit="1",
        meaning="extent of the grid above the shoulder over cone radius",
        minimum=2,
        maximum=500,
    )
    domain_below: float = parameter(
        14.0,
        unit="1",
        meaning="extent of the grid below the tip over cone radius",
        minimum=2,
        maximum=500,
    )

    poissons_ratio_bound: float = parameter(
        0.4999,
        unit="1",
        meaning="greatest Poisson's ratio simulated: bounds the bulk modulus, and so the steps",
        minimum=0,
        maximum=0.4999,
    )
    precision: str = floating_point()

    def derived(self) -> Mapping[str, float]:
        """The shaft is as rough as the face; the approach is as fast as its inertia allows."""
        return {
            "shaft_adhesion_factor": self.adhesion_factor,
            "approach_speed_ratio": approach_speed_ratio(self.speed_ratio, self.rigidity_index),
        }

    def build(self) -> Scene:
        """The soil around the penetrometer; its contact is a `PenetrometerContact`."""
        strength, radius = self.undrained_shear_strength, self.cone_radius
        material = CRITERIA[self.material](
            shear_modulus=self.rigidity_index * strength,
            poissons_ratio=min(self.poissons_ratio, self.poissons_ratio_bound),
            density=self.density,
            strength=strength,
        )
        penetrometer = Penetrometer(radius=radius, apex_angle=math.radians(self.apex_angle))
        grid = penetrometer.fitted_grid(
            cell_size=radius / self.cells_per_radius,
            cell_growth=self.cell_growth,
            outer_radius=self.domain_radius * radius,
            depth_below=self.domain_below * radius,
            height_above=self.domain_above * radius,
        )
        assert self.shaft_adhesion_factor is not None
        assert self.approach_speed_ratio is not None
        return Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=self.time_step_fraction,
            bulk_viscosity=0.2,
            fixed=Fixed.axis_and_ends(grid),
            far_field=FarField.around(grid, material),
            contact=PenetrometerContact.of(
                penetrometer,
                grid,
                face_adhesion=self.adhesion_factor * strength,
                shaft_adhesion=self.shaft_adhesion_factor * strength,
                friction=self.friction_coefficient,
                in_situ_stress=self.in_situ_stress,
            ),
            window=window_of_test(
                radius=radius,
                shear_wave_speed=material.shear_wave_speed,
                speed_ratio=self.speed_ratio,
                approach_speed_ratio=self.approach_speed_ratio,
                approach=self.approach,
                penetration=self.penetration,
                rubs=self.friction_coefficient > 0.0,
            ),
            conservative_interpolation=True,
            energy_audit=True,
            precision=self.precision,
        )

    def step_count_bound(self, plan: Plan) -> int:
        """Steps to the greatest penetration."""
        window = self.build().window
        assert window is not None
        return math.ceil(window.time_to(self.penetration * self.cone_radius) / plan.time_step)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Push the penetrometer in until its resistance is steady.

        Raises:
            InaccurateRun: the transfers took too much of the penetrometer's work, or the cone
                factor is above all that soil can give.
            UnfinishedRun: a steady resistance was asked for (`steady_tolerance` > 0), and at the
                greatest penetration it still changes.
        """
        window = soil_scene(simulation).window
        assert window is not None
        curves = PenetrationCurves(
            simulation,
            radius=self.cone_radius,
            unsteady=unsteady_penetration(window, self.cone_radius),
            tolerance=self.steady_tolerance,
        )
        spacing = SAMPLE_SPACING * self.cone_radius
        sample_count = round(self.penetration / SAMPLE_SPACING)
        recorded = follow(
            simulation,
            [sample * spacing for sample in range(1, sample_count + 1)],
            simulation.travel_to,
            [curves],
            progress,
            is_over=curves.is_steady,
        )
        results = recorded.assign(steady_values(recorded, self.undrained_shear_strength)).assign(
            energy_error=energy_error(transferred_energy(simulation) / curves.work),
            step_count_bound=variable(
                self.step_count_bound(simulation.plan),
                unit="1",
                meaning="time steps to the greatest penetration",
            ),
        )
        check_energy(results)
        if self.steady_tolerance > 0.0 and not curves.is_steady():
            check_levelled(results)
        check_bound(
            results,
            rigidity_index=self.rigidity_index,
            strength_ratio=VON_MISES_STRENGTH if self.material == "von_mises" else 1.0,
            face_shear=1.0 if self.friction_coefficient > 0.0 else self.adhesion_factor,
            apex_angle=math.radians(self.apex_angle),
        )
        return results
