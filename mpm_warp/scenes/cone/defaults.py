"""What the method of a cone test is by default, and the laws of its error, on which that depends.

Laws that take the error of a method off allow a method of less cost.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from mpm_warp.materials.einav_randolph import LARGEST_RATE
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.uncertainty.built import is_of_catalogue
from mpm_warp.uncertainty.laws import LARGEST_INERTIA, ErrorLaws
from mpm_warp.uncertainty.shoulder import RADIAL_FACTOR
from mpm_warp.uncertainty.steadiness import steady_penetration

CELLS_PER_RADIUS = {
    "quick": (2.31, 1.75, 1.75),
    "standard": (3.46, 3.0, 2.31),
    "fine": (6.0, 6.0, 4.62),
}
"""Cells per cone radius by accuracy in soft, ordinary and very stiff clay: 3 to 10 rows beside the
face. Clay for which no law of the error holds counts as ordinary. In soft clay the cone factor is
small and tests are short; in very stiff clay the factor is large and tests are long."""
WINDOW = {"quick": 0.75, "standard": 1.0, "fine": 1.3}
SPEED_RATIO = {"quick": 0.045, "standard": 0.03, "fine": 0.03}
"""Extents of the window over those of `default_extents`, and speed over that of shear waves in
stiff clay, by accuracy."""
INERTIA_BY_ACCURACY = {"quick": LARGEST_INERTIA, "fine": 0.2}
"""Largest rho V^2 / su at that speed, by accuracy. quick: the largest whose effect is known. fine:
one whose effect has a half width of 0.01."""
ROUNDING = 1e-9
"""Relative margin below these limits, so that rounding never exceeds them."""
BULK_MODULUS = {"quick": 250.0, "standard": 5e3, "fine": 1e4}
"""Largest bulk modulus over su that is simulated by default, by accuracy. A lower one allows longer
time steps."""
COMPRESSIBLE, INCOMPRESSIBLE = 0.45, 0.4999
"""Smallest and largest default of the bound of Poisson's ratio."""
SOFT_BOUND = 0.475
"""Largest default of this bound in soft clay, accuracy standard."""
DERIVED_BY_ERROR = ("cells_per_radius", "speed_ratio", "poissons_ratio_bound")
"""Parameters whose default depends on whether the error of the test is known by laws."""
STIFF, VERY_STIFF = 100.0, 300.0
"""Rigidity indices below which clay is soft, and above which it is very stiff."""
SOFT_SPEED_RATIO = 0.05
"""Largest default speed in soft clay, over the speed of shear waves."""
SPARE = 4.5
"""Penetration kept in reserve for a resistance that becomes steady late, in cone radii."""
INERTIA_OF_APPROACH, SPEED_RATIO_OF_APPROACH = 7.0, 0.25
"""Largest rho V^2 / su and largest V over the speed of shear waves of the default approach."""
RAMP, SLOWING = 1.0, 2.0
"""Penetration over which the speed rises from rest, and over which it falls to the final speed
after the approach, in cone radii."""
BLUNTEST_WITH_FEW_ROWS = 75.0
"""Apex angle [degree] up to which a cone has three rows beside its face, 2.31 cells per radius."""
BLUNT, INERTIA_OF_BLUNT_APPROACH = 90.0, 1.4
"""Apex angle [degree] above which the default approach is slower, and its largest rho V^2 / su
then. At 6, soil is thrown off the tip of a rough cone of 120 degrees on four rows of cells beside
its face."""


class Interface(NamedTuple):
    """Adhesion and friction of the surface of a penetrometer."""

    face: float  # adhesion factor of the face
    shaft: float  # adhesion factor of the shaft
    friction: float  # Coulomb friction coefficient


@dataclass(frozen=True, kw_only=True)
class ConeTestByDefault(ConeTest):
    """A cone test that derives the parameters of the method from its clay where none are given."""

    def derived(self) -> Mapping[str, float]:
        """The shaft is as rough as the face; window and approach follow the rigidity index."""
        extents = {
            name: WINDOW[self.accuracy] * by_law for name, by_law in self.default_extents.items()
        }
        above = extents["domain_above"] if self.domain_above is None else self.domain_above
        # By then all soil that the cone has never passed has left the window.
        approach = above + 1.0 if self.approach is None else self.approach
        is_blunt = self.apex_angle > BLUNT
        inertia = INERTIA_OF_BLUNT_APPROACH if is_blunt else INERTIA_OF_APPROACH
        method = {
            "cells_per_radius": self._cells_per_radius,
            "speed_ratio": self._speed_ratio,
            "poissons_ratio_bound": self._bound,
            "shaft_adhesion_factor": self.adhesion_factor,
            "approach_speed_ratio": min(
                SPEED_RATIO_OF_APPROACH, math.sqrt(inertia / self.rigidity_index)
            ),
            "approach": approach,
            "penetration": approach + steady_penetration(self.rigidity_index) + SPARE,
        }
        return extents | method

    @property
    def _bound(self) -> float:
        """Default bound of Poisson's ratio, from `BULK_MODULUS`.

        There is a bound only where laws correct its effect. It is lower in soft clay, which is
        simulated with smaller cells.
        """
        if not self._is_corrected:
            return INCOMPRESSIBLE
        over_shear = BULK_MODULUS[self.accuracy] / self.rigidity_index
        of_bulk_modulus = (3.0 * over_shear - 2.0) / (6.0 * over_shear + 2.0)
        has_more_cells = self._is_soft and self.accuracy == "standard"
        greatest = SOFT_BOUND if has_more_cells else INCOMPRESSIBLE
        return min(greatest, max(COMPRESSIBLE, of_bulk_modulus))

    def laws(self, penetration: float) -> ErrorLaws:
        """The laws of the error after a penetration, over the radius of the cone."""
        return self.error_laws(
            rigidity_index=self.rigidity_index,
            adhesion_factor=self.interface.face,
            stress_anisotropy=self.stress_anisotropy,
            poissons_ratio=self.poissons_ratio - self.poissons_ratio_reduction,
            poissons_ratio_reduction=self.poissons_ratio_reduction,
            inertia=self.inertia,
            penetration=penetration,
        )

    @property
    def interface(self) -> Interface:
        """Adhesion and friction of face and shaft as they are built.

        Where the in-situ stress is so high that friction alone reaches the strength of the soil,
        the soil shears before it slides. Face and shaft are then built rough, without friction. The
        strength is that at the highest strain rate.
        """
        strength = self.undrained_shear_strength
        pressure = self.in_situ_stress - 2.0 * max(self.stress_anisotropy, 0.0) * strength
        strongest = strength * (1.0 + self.rate_factor * math.log10(LARGEST_RATE))
        if self.friction_coefficient * pressure >= strongest:
            return Interface(1.0, 1.0, 0.0)
        adhesion = self.adhesion_factor, self.shaft_adhesion_factor
        return Interface(*adhesion, self.friction_coefficient)

    def interface_in(self, recorded: xr.Dataset) -> Interface:
        """The interface as adhesive as friction makes it, under the normal stress of a run."""
        face, shaft, friction = self.interface
        if friction == 0.0:
            return self.interface
        at_rest = self.in_situ_stress / self.undrained_shear_strength
        on_face = float(recorded.cone_factor_simulated) - float(recorded.cone_factor_shear)
        on_shaft = np.nan_to_num(float(recorded[RADIAL_FACTOR])) - 2.0 * self.stress_anisotropy
        face, shaft = (
            min(1.0, adhesion + friction * max(0.0, at_rest + stress))
            for adhesion, stress in ((face, on_face), (shaft, on_shaft))
        )
        return Interface(face, shaft, friction)

    @property
    def inertia(self) -> float:
        """Inertia of the soil over its strength, rho V^2 / su."""
        return self.rigidity_index * self.speed_ratio * self.speed_ratio

    @property
    def approach_travel(self) -> float:
        """Penetration of the approach over the radius; 0 if it would be no faster, or too short.

        The last part of the penetration, in which the resistance becomes steady, has the final
        speed.
        """
        travel = min(self.approach, self.penetration - steady_penetration(self.rigidity_index))
        is_made = travel > RAMP + SLOWING and self.approach_speed_ratio > self.speed_ratio
        return travel if is_made else 0.0

    @property
    def approach_inertia(self) -> float:
        """See `FittedToCone`."""
        is_made = self.approach_travel > 0.0
        return self.rigidity_index * self.approach_speed_ratio**2 if is_made else 0.0

    @property
    def poissons_ratio_reduction(self) -> float:
        """Poisson's ratio of the clay less that simulated under the bound; 0 without effect."""
        return max(0.0, self.poissons_ratio - self.poissons_ratio_bound)

    @property
    def _cells_per_radius(self) -> float:
        """Cells per cone radius by default."""
        soft, ordinary, very_stiff = CELLS_PER_RADIUS[self.accuracy]
        if self._is_soft:
            return soft
        is_very_stiff = self.rigidity_index > VERY_STIFF and self._is_corrected
        return very_stiff if is_very_stiff else ordinary

    @property
    def _is_soft(self) -> bool:
        return self.rigidity_index < STIFF and self._is_corrected

    @property
    def _is_corrected(self) -> bool:
        """Whether laws take off the error of a cheaper method, so that no further runs do.

        They go on where friction, a rate effect or softening begins, and so does the method. Blunt
        cones need more rows beside the face.
        """
        is_blunt = self.apex_angle > BLUNTEST_WITH_FEW_ROWS
        return self._is_tresca and not is_blunt and self.uncertainty == "known"

    @property
    def _is_tresca(self) -> bool:
        """Whether the laws of the error are of this criterion; see `is_of_catalogue`."""
        return is_of_catalogue(self) and self.material.name == "tresca"

    @property
    def _speed_ratio(self) -> float:
        """Default speed over that of shear waves.

        In soft clay the standard speed is higher, so that the inertia rho V^2 / su is the same as
        in stiff clay. This holds only where a law corrects the effect of inertia, in Tresca clay.
        quick tests would gain little by it; fine tests have a small uncertainty to keep. In
        stiff clay both are slower where `INERTIA_BY_ACCURACY` demands it.
        """
        ratio = SPEED_RATIO[self.accuracy]
        if not self._is_tresca:
            return ratio
        if self.accuracy != "standard":
            greatest = (1.0 - ROUNDING) * INERTIA_BY_ACCURACY[self.accuracy]
            return min(ratio, math.sqrt(greatest / self.rigidity_index))
        of_same_inertia = ratio * math.sqrt(STIFF / self.rigidity_index)
        return max(ratio, min(of_same_inertia, SOFT_SPEED_RATIO))
