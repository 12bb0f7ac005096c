"""The parameters of a cone penetration test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.catalogue import CatalogueScene
from mpm_warp.scenes.cone.window import approach_speed_ratio
from mpm_warp.scenes.shared_parameters import floating_point, yield_criterion


@dataclass(frozen=True, kw_only=True)
class ConeTest(CatalogueScene):
    """Clay, penetrometer and method of a cone penetration test."""

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
