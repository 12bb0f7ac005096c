"""The parameters of a cone in the ground, of a cone penetration test, and of the grid of both."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from mpm_warp.fields.declaration import Derived, parameter
from mpm_warp.scenes.clay_tower import FieldClayScene
from mpm_warp.scenes.cone.penetrometer import Penetrometer
from mpm_warp.uncertainty.laws import ErrorLaws, slope_ratio


@dataclass(frozen=True, kw_only=True)
class ConeInGround:
    """A cone penetrometer, the stress of the ground around it, its grid and the time step."""

    adhesion_factor: float = parameter(
        0.0, "adhesion factor of the cone face", minimum=0, maximum=1
    )
    shaft_adhesion_factor: float = parameter(
        None, "adhesion factor of the shaft (default: the face's)", minimum=0, maximum=1
    )
    # A standard cone has a base of 10 cm2.
    cone_radius: float = parameter(
        0.01785, "radius of the cone's base", unit="m", minimum=1e-6, maximum=1e3
    )
    stress_anisotropy: float = parameter(
        Derived(0.0),
        "stress anisotropy Delta in the ground before: vertical less horizontal stress over 2 su",
        above=-1,
        below=1,
    )
    cell_growth: float = parameter(
        0.4, "growth of the cells' width per distance from the penetrometer", minimum=0.1, maximum=2
    )
    time_step_fraction: float = parameter(
        0.85, "time step over the critical one", minimum=0.01, maximum=1.2, sane=(0.1, 1.0)
    )
    domain_radius: float = parameter(
        None,
        "radius of the grid over cone radius, to the nearest cell "
        "(default: 4 sqrt(Ir), 40 at least, Ir the greatest in the ground)",
        minimum=5,
        maximum=1000,
    )
    domain_above: float = parameter(
        None,
        "extent of the grid above the shoulder over cone radius "
        "(default: 1.3 sqrt(Ir), 13 at least)",
        minimum=2,
        maximum=500,
    )
    domain_below: float = parameter(
        None,
        "extent of the grid below the tip over cone radius (default: sqrt(Ir), 14 at least)",
        minimum=2,
        maximum=500,
    )


class FittedToCone(ConeInGround):
    """Quantities of a scene whose grid is fitted to a cone, derived from its parameters."""

    method: ClassVar[tuple[str, ...]] = (
        "cells_per_radius",
        "cell_growth",
        "time_step_fraction",
        "speed_ratio",
        "domain_radius",
        "domain_above",
        "domain_below",
        "uncertainty",
    )
    rigidity_index: float
    cells_per_radius: float
    apex_angle: float = 60.0
    rate_factor: float
    reference_strain_rate: float | None
    penetration_speed: float
    remoulded_strength_ratio: float
    ductility: float | None

    @property
    def greatest_rigidity_index(self) -> float:
        """Greatest rigidity index of the ground; it sets the default window."""
        return self.rigidity_index

    @property
    def default_extents(self) -> dict[str, float]:
        """Default extents of the window over cone radius: the resistance hardly depends on them."""
        root = math.sqrt(self.greatest_rigidity_index)
        return {
            "domain_radius": max(40.0, 4.0 * root),
            "domain_above": max(13.0, 1.3 * root),
            "domain_below": max(14.0, root),
        }

    @property
    def extent_ratio(self) -> float:
        """Default extent of the window over its actual extent, the greatest of all directions."""
        extents = self.default_extents.items()
        ratios: list[float] = [by_default / getattr(self, name) for name, by_default in extents]
        return max(ratios)

    @property
    def approach_inertia(self) -> float:
        """Inertia rho V^2 / su in a fast approach; 0 without one."""
        return 0.0

    @property
    def penetrometer(self) -> Penetrometer:
        """The penetrometer."""
        return Penetrometer(radius=self.cone_radius, apex_angle=math.radians(self.apex_angle))

    @property
    def cell_size(self) -> float:
        """Width and height of the cells at the cone [m]."""
        rows = self.penetrometer.rows_on_face(self.cone_radius / self.cells_per_radius)
        return self.penetrometer.cone_height / rows

    @property
    def relative_cell_size(self) -> float:
        """Width of the cells at the cone over its radius."""
        return self.cell_size / self.cone_radius

    def error_laws(self, **clay_and_penetration: Any) -> ErrorLaws:
        """The laws of the error in this grid, with the other fields of `ErrorLaws`."""
        strain_rate = self.penetration_speed / self.cone_radius
        fastest = strain_rate / (self.reference_strain_rate or strain_rate)
        return ErrorLaws(
            cell_size=self.relative_cell_size,
            cell_growth=self.cell_growth,
            outer=self.domain_radius,
            above=self.domain_above,
            below=self.domain_below,
            extent_ratio=self.extent_ratio,
            above_ratio=self.domain_above / self.default_extents["domain_above"],
            approach_inertia=self.approach_inertia,
            slope_ratio=slope_ratio(
                self.apex_angle,
                strengthening=self.rate_factor * math.log10(max(1.0, fastest)),
                brittleness=(1.0 - self.remoulded_strength_ratio) / (self.ductility or 1.0),
            ),
            **clay_and_penetration,
        )


@dataclass(frozen=True, kw_only=True)
class ConeTest(FittedToCone, FieldClayScene):
    """Clay, penetrometer and method of a cone penetration test."""

    method = (
        "accuracy",
        *FittedToCone.method,
        "particles_per_cell",
        "approach",
        "approach_speed_ratio",
        "penetration",
        "steady_tolerance",
        "poissons_ratio_bound",
        "energy_audit",
    )

    friction_coefficient: float = parameter(
        0.0, "Coulomb friction coefficient of the penetrometer", minimum=0, maximum=1
    )
    in_situ_stress: float = parameter(
        400e3, "vertical total stress in the ground before", unit="Pa", minimum=0
    )
    apex_angle: float = parameter(
        60.0, "apex angle of the cone", unit="degree", minimum=30, maximum=150, sane=(30.0, 120.0)
    )
    penetration: float = parameter(
        None,
        "greatest penetration over cone radius (default: approach + 10, more below Ir 100)",
        minimum=1,
        maximum=1000,
    )
    approach: float = parameter(
        None,
        "penetration of the approach, its rise and fall of speed included, over cone "
        "radius (default: domain_above + 1); ends 5.5 before the greatest at the latest, more "
        "below Ir 100; 3 or less: none",
        minimum=0,
        maximum=600,
    )
    approach_speed_ratio: float = parameter(
        None,
        "approach speed over shear wave speed (default: the lesser of 0.25 and "
        "sqrt(7 / Ir), sqrt(1.4 / Ir) where apex_angle is above 90); not above speed_ratio: no "
        "approach",
        above=0,
        maximum=0.5,
    )
    steady_tolerance: float = parameter(
        0.003,
        "change of the resistance over two radii at which it counts as steady, and the run "
        "ends; 0: never, and the run need not become steady",
        minimum=0,
        maximum=0.1,
    )
    speed_ratio: float = parameter(
        None,
        "penetration speed V over shear wave speed, rho V^2 at most 50 su (default: 0.03, 0.045 "
        "where accuracy is quick; in perfectly plastic Tresca clay quick has less above Ir 1481, "
        "fine above Ir 222, and standard 0.3 / sqrt(Ir), at most 0.05, below Ir 100)",
        minimum=1e-4,
        maximum=0.5,
        sane=(1e-4, 0.1),
    )
    accuracy: str = parameter(
        "standard",
        "what cells, window and speed are by default: fine halves the cells, has 1.3 times the "
        "window, takes some ten times as long, and has two thirds of the uncertainty; quick has "
        "0.75 times the window, takes a twentieth to a third of the time, and adds 26 to 82 % to "
        "the uncertainty",
        choices=("quick", "standard", "fine"),
    )
    cells_per_radius: float = parameter(
        None,
        "cells per cone radius at the cone, about: they are square, and a whole number of "
        "them makes up its height (default: 3; 6 where accuracy is fine, 1.75 where it is quick; "
        "where laws of the error take its effect off, below Ir 100 3.46 and, quick, 2.31, and "
        "above Ir 300 2.31 and, fine, 4.62)",
        minimum=1,
        maximum=100,
    )
    # With one per cell, cells beside the shaft become empty and the cone factor a sixth too low.
    particles_per_cell: int = parameter(4, "material points per cell", choices=(4, 9, 16, 25))
    poissons_ratio_bound: float = parameter(
        None,
        "greatest Poisson's ratio simulated: bounds the bulk modulus, and so the steps (default: "
        "0.4999; where laws of the error take its effect off, that of a bulk modulus of 5000 su, "
        "10000 su where accuracy is fine, 250 su where it is quick, but 0.45 at least; below Ir "
        "100, accuracy standard, 0.475)",
        minimum=0,
        maximum=0.4999,
    )
    uncertainty: str = parameter(
        "known",
        "how the error of the cone factor is found: known from other cases, or measured by "
        "four further runs of this one, which take some ten times as long",
        choices=("known", "measured"),
    )
    energy_audit: str = parameter(
        "transfers",
        "what is recorded of energy: what the transfers of the method dissipate, or the "
        "balance, where all work of the penetrometer goes",
        choices=("transfers", "balance"),
    )
