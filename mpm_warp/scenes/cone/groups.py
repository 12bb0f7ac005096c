"""The groups of parameters of a cone test, some of which a sounding has too."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mpm_warp.fields.checked import Group
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Grid, growing
from mpm_warp.scenes.clay import FieldClay
from mpm_warp.scenes.clay_scene import StressAtRest
from mpm_warp.scenes.cone.penetrometer import Penetrometer
from mpm_warp.uncertainty.laws import ErrorLaws, slope_ratio


@dataclass(frozen=True, kw_only=True)
class StandardCone(Group):
    """A cone penetrometer of 60 degrees without friction."""

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
    apex_angle = 60.0
    friction_coefficient = 0.0

    def derived(self) -> Mapping[str, float]:
        """The shaft is as rough as the face."""
        return {"shaft_adhesion_factor": self.adhesion_factor}

    @property
    def penetrometer(self) -> Penetrometer:
        """The penetrometer."""
        return Penetrometer(radius=self.cone_radius, apex_angle=math.radians(self.apex_angle))

    def cell_size(self, cells_per_radius: float) -> float:
        """Width and height of the cells at the cone, of which a whole number fits its face [m]."""
        rows = self.penetrometer.rows_on_face(self.cone_radius / cells_per_radius)
        return self.penetrometer.cone_height / rows


@dataclass(frozen=True, kw_only=True)
class Cone(StandardCone):
    """A cone penetrometer of any angle and surface."""

    friction_coefficient: float = parameter(
        0.0, "Coulomb friction coefficient of the penetrometer", minimum=0, maximum=1
    )
    apex_angle: float = parameter(
        60.0, "apex angle of the cone", unit="degree", minimum=30, maximum=150, sane=(30.0, 120.0)
    )


@dataclass(frozen=True, kw_only=True)
class InSituStress(StressAtRest):
    """The stress of the ground before a test, and how much of it is vertical."""

    in_situ_stress: float = parameter(
        400e3, "vertical total stress in the ground before", unit="Pa", minimum=0
    )


@dataclass(frozen=True, kw_only=True)
class Domain(Group):
    """The extents of the grid around a cone, the growth of its cells, and the time step."""

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

    def extent_ratio(self, by_default: Mapping[str, float]) -> float:
        """Extents by default over these, the greatest of all directions."""
        ratios: list[float] = [extent / getattr(self, name) for name, extent in by_default.items()]
        return max(ratios)

    def error_laws(
        self,
        clay: FieldClay,
        cone: StandardCone,
        *,
        cells_per_radius: float,
        extents: Mapping[str, float],
        **others: Any,
    ) -> ErrorLaws:
        """The laws of the error here, where the extents by default are given.

        The `others` are the other fields of `ErrorLaws`, of clay and penetration.
        """
        strain_rate = clay.penetration_speed / cone.cone_radius
        fastest = strain_rate / (clay.reference_strain_rate or strain_rate)
        return ErrorLaws(
            cell_size=cone.cell_size(cells_per_radius) / cone.cone_radius,
            cell_growth=self.cell_growth,
            outer=self.domain_radius,
            above=self.domain_above,
            below=self.domain_below,
            extent_ratio=self.extent_ratio(extents),
            above_ratio=self.domain_above / extents["domain_above"],
            slope_ratio=slope_ratio(
                cone.apex_angle,
                strengthening=clay.rate_factor * math.log10(max(1.0, fastest)),
                brittleness=(1.0 - clay.remoulded_strength_ratio) / (clay.ductility or 1.0),
            ),
            **others,
        )

    def grid(self, penetrometer: Penetrometer, cell_size: float) -> Grid:
        """The grid around a penetrometer, with cells of a size at the cone [m]."""
        radius = penetrometer.radius
        span = (self.domain_radius - 1.0) * radius
        return penetrometer.fitted_grid(
            cell_size=cell_size,
            columns=growing(cell_size, span, 1.0 + self.cell_growth * cell_size / radius),
            depth_below=self.domain_below * radius,
            height_above=self.domain_above * radius,
        )


@dataclass(frozen=True, kw_only=True)
class Push(Group):
    """How far and how fast the penetrometer is pushed, and when the test ends."""

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
        "quick; in Tresca clay faster where it is soft, and slower, unless standard, where it is "
        "very stiff)",
        minimum=1e-4,
        maximum=0.5,
        sane=(1e-4, 0.1),
    )


@dataclass(frozen=True, kw_only=True)
class Resolution(Group):
    """How fine and how stiff the simulated soil is."""

    accuracy: str = parameter(
        "standard",
        "what cells, window and speed are by default: fine halves the cells, has 1.3 times the "
        "window, takes some ten times as long, and 8 to 34 % off the uncertainty; quick has "
        "0.75 times the window, takes a twentieth to a third of the time, and adds 23 to 67 % to "
        "the uncertainty",
        choices=("quick", "standard", "fine"),
    )
    cells_per_radius: float = parameter(
        None,
        "cells per cone radius at the cone, about: they are square, and a whole number of "
        "them makes up its height (default: 3, 1.75 quick, 6 fine; in Tresca clay more where it is "
        "soft, and fewer where it is very stiff)",
        minimum=1,
        maximum=100,
    )
    # With one per cell, cells beside the shaft become empty and the cone factor a sixth too low.
    particles_per_cell: int = parameter(4, "material points per cell", choices=(4, 9, 16, 25))
    poissons_ratio_bound: float = parameter(
        None,
        "greatest Poisson's ratio simulated: bounds the bulk modulus, and so the steps (default: "
        "0.4999; in Tresca clay that of a bulk modulus of 5000 su, 250 su quick, 10000 su fine)",
        minimum=0,
        maximum=0.4999,
    )
