"""The parameters of a cone penetration test, and what follows: clay, penetrometer, window.

Until the resistance is of interest the penetrometer goes faster; at last it has the speed asked
for.
"""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.parameters import Derived, parameter
from mpm_warp.parts.window import Approach, Window
from mpm_warp.scenes.clay import FieldClayScene
from mpm_warp.scenes.cone.penetrometer import ROUNDING, Penetrometer
from mpm_warp.uncertainty import cone
from mpm_warp.uncertainty.laws import APEX_ANGLE, LARGEST_INERTIA, ErrorLaws
from mpm_warp.uncertainty.steadiness import forgetting, steady_penetration

CELLS_PER_RADIUS = {"quick": 1.75, "standard": 3.0, "fine": 6.0}
WINDOW = {"quick": 0.75, "standard": 1.0, "fine": 1.3}
SPEED_RATIO = {"quick": 0.045, "standard": 0.03, "fine": 0.03}
"""Cells per cone radius, extents of the window over those of `default_extents`, and speed over that
of shear waves in stiff clay, by accuracy."""
SOFT_CELLS_PER_RADIUS = 2.31
"""The same where accuracy is quick, below the rigidity index `STIFF`: four rows, not three."""
BULK_MODULUS = {"quick": 250.0, "standard": 5e3, "fine": 1e4}
"""Bulk modulus over su up to which clay is simulated by default, by accuracy; steps are the longer
the lower it is."""
COMPRESSIBLE, INCOMPRESSIBLE = 0.45, 0.4999
"""Poisson's ratios that the bound of it is by default at least and at most."""
DERIVED_BY_ERROR = ("cells_per_radius", "speed_ratio", "poissons_ratio_bound")
"""What follows by default from whether the error of a test is known."""
STIFF, SOFT_SPEED_RATIO = 100.0, 0.05
"""Rigidity index below which the speed follows the inertia rho V^2 / su, and up to what speed."""
SPARE = 4.5
"""Penetration that is left for a resistance that becomes steady late, in cone radii."""
RAMP = 1.0
"""Penetration in which the speed rises from rest, in cone radii."""
SLOWING = 2.0
"""Penetration in which the speed falls to the final one, in cone radii."""
PUSHED = 0.5
"""Penetration after the approach in which the soil that was slowed down still pushes, in cone
radii."""
FROM_REST = 2.0
"""Penetration without an approach before which no resistance counts as steady, in cone radii."""
SPARE_SLOTS, SPARE_SLOTS_WITH_FRICTION = 0.15, 0.4
"""Slots for material points beside those that fill the grid, over their number: the cells along a
rough shaft come to hold the many small ones from near the axis, with friction more of them."""
INERTIA_OF_APPROACH, SPEED_RATIO_OF_APPROACH = 7.0, 0.25
"""What rho V^2 / su and V over the speed of shear waves may be during the approach by default."""
SANE_INERTIA, GREATEST_INERTIA = 5.0, 10.0
"""rho V^2 / su up to which nearly all random cases complete, and beyond which few do: the soil is
thrown off, and the transfers dissipate much of the work."""


@dataclass(frozen=True, kw_only=True)
class ConeInGround:
    """A cone penetrometer and the stress of the ground around it; scenes inherit it."""

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


@dataclass(frozen=True, kw_only=True)
class ConeGrid:
    """The grid around a cone penetrometer, its time step and its numbers."""

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


class FittedToCone:
    """What follows for a scene of a cone in a grid that is fitted to it."""

    cone_radius: float
    cells_per_radius: float
    apex_angle: float = 60.0

    @property
    @abstractmethod
    def default_extents(self) -> dict[str, float]:
        """Extents of a window that the resistance hardly depends on, over cone radius."""

    @property
    def extent_ratio(self) -> float:
        """Greatest ratio of an extent of the window by default to what it is."""
        extents = self.default_extents.items()
        ratios: list[float] = [by_default / getattr(self, name) for name, by_default in extents]
        return max(ratios)

    @property
    def penetrometer(self) -> Penetrometer:
        """The penetrometer."""
        return Penetrometer(radius=self.cone_radius, apex_angle=math.radians(self.apex_angle))

    @property
    def cell_size(self) -> float:
        """Width and height of the cells at the cone [m]."""
        rows = self.penetrometer.rows_on_face(self.cone_radius / self.cells_per_radius)
        return self.penetrometer.cone_height / rows


@dataclass(frozen=True, kw_only=True)
class ConeTest(ConeGrid, ConeInGround, FittedToCone, FieldClayScene):
    """Clay, penetrometer and method of a cone penetration test."""

    method = (
        "accuracy",
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
        "uncertainty",
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
        maximum=700,
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
        "sqrt(7 / Ir)); not above speed_ratio: no approach",
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
        "penetration speed over shear wave speed (default: 0.03, 0.045 where accuracy is quick, "
        "less above Ir 1481; in perfectly plastic Tresca clay, accuracy standard, 0.3 / sqrt(Ir) "
        "below Ir 100, at most 0.05)",
        minimum=1e-4,
        maximum=0.5,
        sane=(1e-4, 0.1),
    )
    accuracy: str = parameter(
        "standard",
        "what cells, window and speed are by default: fine halves the cells and widens the "
        "window by 1.3, takes some ten times as long, and has half of the uncertainty; quick "
        "takes a fifth to a tenth of the time, and has up to twice the uncertainty",
        choices=tuple(CELLS_PER_RADIUS),
    )
    cells_per_radius: float = parameter(
        None,
        "cells per cone radius at the cone, about: they are square, and a whole number of "
        "them makes up its height (default: 3; 6 where accuracy is fine, 1.75 where it is quick, "
        "2.31 below Ir 100 in clay as above)",
        minimum=1,
        maximum=100,
    )
    # One a cell leaves cells empty beside the shaft: the cone factor comes out a sixth too low.
    particles_per_cell: int = parameter(4, "material points per cell", choices=(4, 9, 16, 25))
    poissons_ratio_bound: float = parameter(
        None,
        "greatest Poisson's ratio simulated: bounds the bulk modulus, and so the steps (default: "
        "0.4999; where laws of the error take its effect off, that of a bulk modulus of 5000 su, "
        "10000 su where accuracy is fine, 250 su where it is quick, but 0.45 at least)",
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

    @property
    def default_extents(self) -> dict[str, float]:
        """Extents of a window that the resistance hardly depends on, over cone radius."""
        root = math.sqrt(self.rigidity_index)
        return {
            "domain_radius": max(40.0, 4.0 * root),
            "domain_above": max(13.0, 1.3 * root),
            "domain_below": max(14.0, root),
        }

    def derived(self) -> Mapping[str, float]:
        """The shaft is as rough as the face; window and approach follow the rigidity index."""
        extents = {
            name: WINDOW[self.accuracy] * by_law for name, by_law in self.default_extents.items()
        }
        above = extents["domain_above"] if self.domain_above is None else self.domain_above
        # Soil that the cone has never passed has then left the window.
        approach = above + 1.0 if self.approach is None else self.approach
        by_inertia = math.sqrt(INERTIA_OF_APPROACH / self.rigidity_index)
        return extents | {
            "cells_per_radius": self._cells_per_radius,
            "speed_ratio": self._speed_ratio,
            "poissons_ratio_bound": self._bound if self._laws_hold else INCOMPRESSIBLE,
            "shaft_adhesion_factor": self.adhesion_factor,
            "approach_speed_ratio": min(SPEED_RATIO_OF_APPROACH, by_inertia),
            "approach": approach,
            "penetration": approach + steady_penetration(self.rigidity_index) + SPARE,
        }

    @property
    def _bound(self) -> float:
        """Poisson's ratio of the greatest bulk modulus over su that is simulated by default."""
        over_shear = BULK_MODULUS[self.accuracy] / self.rigidity_index
        of_bulk_modulus = (3.0 * over_shear - 2.0) / (6.0 * over_shear + 2.0)
        return min(INCOMPRESSIBLE, max(COMPRESSIBLE, of_bulk_modulus))

    @property
    def _laws_hold(self) -> bool:
        """Whether laws take the error of the test off, that of a bound of Poisson's ratio too."""
        if self.poissons_ratio_bound is not None or not self._error_is_known:
            return False
        unbounded = replace(self, poissons_ratio_bound=INCOMPRESSIBLE)
        laws = unbounded.laws(way=unbounded.penetration)
        return not cone.why_laws_do_not_hold(laws)

    def laws(self, way: float) -> ErrorLaws:
        """The laws of the error after a way, over the cone's radius."""
        return ErrorLaws(
            rigidity_index=self.rigidity_index,
            adhesion_factor=self.adhesion_factor,
            stress_anisotropy=self.stress_anisotropy,
            poissons_ratio=self.poissons_ratio - self.bounded,
            bounded=self.bounded,
            inertia=self.rigidity_index * self.speed_ratio * self.speed_ratio,
            cell_size=self.relative_cell_size,
            cell_growth=self.cell_growth,
            outer=self.domain_radius,
            above=self.domain_above,
            below=self.domain_below,
            extent_ratio=self.extent_ratio,
            way=way,
        )

    @property
    def bounded(self) -> float:
        """What the bound takes off Poisson's ratio."""
        return max(0.0, self.poissons_ratio - self.poissons_ratio_bound)

    @property
    def _cells_per_radius(self) -> float:
        """Cells per radius by default: more in quick tests in soft clay, whose factor is small."""
        if self.accuracy == "quick" and self.rigidity_index < STIFF and self._error_is_known:
            return SOFT_CELLS_PER_RADIUS
        return CELLS_PER_RADIUS[self.accuracy]

    @property
    def _error_is_known(self) -> bool:
        """Whether laws take the error off, and not further runs of the same method."""
        is_as_measured = self.apex_angle == APEX_ANGLE and self.friction_coefficient == 0.0
        return self._is_plain_tresca and is_as_measured and self.uncertainty == "known"

    @property
    def _is_plain_tresca(self) -> bool:
        """Whether the clay is one whose error is known: perfectly plastic, Tresca.

        A scene of another package may build any other clay of the same parameters.
        """
        is_ours = type(self).__module__.partition(".")[0] == __package__.partition(".")[0]
        return is_ours and self.material == "tresca" and not self.strength_changes

    @property
    def _speed_ratio(self) -> float:
        """Speed over that of shear waves by default: in soft clay of the inertia in stiff clay.

        In other clay no law of the error takes the effect of inertia off, so it is slower. So are
        quick tests, which would gain little, and fine ones, whose uncertainty is small. In very
        stiff clay quick tests have the greatest inertia whose effect is known.
        """
        ratio = SPEED_RATIO[self.accuracy]
        if not self._is_plain_tresca:
            return ratio
        if self.accuracy != "standard":
            return min(ratio, math.sqrt((1.0 - ROUNDING) * LARGEST_INERTIA / self.rigidity_index))
        of_same_inertia = ratio * math.sqrt(STIFF / self.rigidity_index)
        return max(ratio, min(of_same_inertia, SOFT_SPEED_RATIO))

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: soil is thrown off where the cone is fast for its strength."""
        inertia = self.rigidity_index * self.speed_ratio**2
        if inertia <= GREATEST_INERTIA:
            return ""
        return (
            f"rho V^2 is {inertia:.3g} su, and above {GREATEST_INERTIA:g} su soil is thrown off; "
            f"try speed_ratio = {math.sqrt(SANE_INERTIA / self.rigidity_index):.2g} or less"
        )

    @property
    def relative_cell_size(self) -> float:
        """Width of the cells at the cone over its radius."""
        return self.cell_size / self.cone_radius

    @property
    def stress_at_rest(self) -> Floats:
        """Stress of the ground before, over the vertical in-situ stress [Pa]."""
        horizontal = 2.0 * self.stress_anisotropy * self.undrained_shear_strength
        return np.array([horizontal, 0.0, 0.0, horizontal])

    @property
    def clay(self) -> Material:
        """The clay, as stiff as it is simulated, its strain rates those of the real speed."""
        shear_modulus = self.rigidity_index * self.undrained_shear_strength
        speed = self.speed_ratio * math.sqrt(shear_modulus / self.density)
        return self.clay_with(
            strength=self.undrained_shear_strength,
            density=self.density,
            speed_up=speed / self.penetration_speed,
            greatest_poissons_ratio=float(self.poissons_ratio_bound),
        )

    @property
    def window(self) -> Window:
        """The travel of the grid; without an approach where that would be no faster, or too short.

        The last of the way, in which the resistance may become steady, is at the final speed.
        """
        speed = self.speed_ratio * self.clay.shear_wave_speed
        travel = min(self.approach, self.penetration - steady_penetration(self.rigidity_index))
        faster = None
        if travel > RAMP + SLOWING and self.approach_speed_ratio > self.speed_ratio:
            faster = Approach(
                speed=speed * self.approach_speed_ratio / self.speed_ratio,
                travel=travel * self.cone_radius,
                slowing_travel=SLOWING * self.cone_radius,
            )
        rubs = self.friction_coefficient > 0.0
        # Beside a blunter face than the standard one points stay for long and gather velocities of
        # their own, which must not push as the soil's strength does: rho w^2 is at most su.
        is_blunt = self.apex_angle > APEX_ANGLE
        strength = self.undrained_shear_strength
        return Window(
            speed=speed,
            ramp_travel=RAMP * self.cone_radius,
            approach=faster,
            spare_fraction=SPARE_SLOTS_WITH_FRICTION if rubs else SPARE_SLOTS,
            stray_speed=math.sqrt(strength / self.density) if is_blunt else None,
        )


def unsteady_penetration(window: Window, radius: float, rigidity_index: float) -> float:
    """Penetration before which no mean of the resistance is taken, over the radius [m]."""
    if window.approach is None:
        return FROM_REST
    return window.approach.travel / radius + forgetting(rigidity_index)


def slowing_penetration(window: Window, radius: float) -> tuple[float, float] | None:
    """Penetrations between which the soil is slowed down, over the radius [m]; or none.

    Its inertia then takes from the resistance up to 1.3 su.
    """
    approach = window.approach
    if approach is None:
        return None
    return (approach.travel - approach.slowing_travel) / radius, approach.travel / radius + PUSHED
