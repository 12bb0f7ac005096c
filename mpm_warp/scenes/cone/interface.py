"""The surface of a penetrometer as it is built, and as rough as friction makes it in a run."""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr

from mpm_warp.materials.einav_randolph import LARGEST_RATE
from mpm_warp.results import labelled
from mpm_warp.scenes.clay import Clay
from mpm_warp.scenes.cone.groups import InSituStress, StandardCone
from mpm_warp.uncertainty.shoulder import RADIAL_FACTOR


class Interface(NamedTuple):
    """Adhesion and friction of the surface of a penetrometer."""

    face: float  # adhesion factor of the face
    shaft: float  # adhesion factor of the shaft
    friction: float  # Coulomb friction coefficient

    @property
    def as_built(self) -> dict[str, xr.Variable]:
        """The interface as variables of a result."""
        return labelled(
            adhesion_factor_built=(self.face, "1", "adhesion factor of the face as built"),
            shaft_adhesion_factor_built=(self.shaft, "1", "adhesion factor of the shaft as built"),
            friction_coefficient_built=(self.friction, "1", "friction coefficient as built"),
        )


def interface_of(cone: StandardCone, clay: Clay, stress: InSituStress) -> Interface:
    """Adhesion and friction of face and shaft as they are built.

    Where the in-situ stress is so high that friction alone reaches the strength of the soil, the
    soil shears before it slides. Face and shaft are then built rough, without friction. The
    strength is that at the highest strain rate.
    """
    strength = clay.undrained_shear_strength
    pressure = stress.in_situ_stress - 2.0 * max(stress.stress_anisotropy, 0.0) * strength
    strongest = strength * (1.0 + clay.rate_factor * math.log10(LARGEST_RATE))
    if cone.friction_coefficient * pressure >= strongest:
        return Interface(1.0, 1.0, 0.0)
    return Interface(cone.adhesion_factor, cone.shaft_adhesion_factor, cone.friction_coefficient)


def interface_in(
    recorded: xr.Dataset, built: Interface, clay: Clay, stress: InSituStress
) -> Interface:
    """The interface as adhesive as friction makes it, under the normal stress of a run."""
    face, shaft, friction = built
    if friction == 0.0:
        return built
    at_rest = stress.in_situ_stress / clay.undrained_shear_strength
    on_face = float(recorded.cone_factor_simulated) - float(recorded.cone_factor_shear)
    on_shaft = np.nan_to_num(float(recorded[RADIAL_FACTOR])) - 2.0 * stress.stress_anisotropy
    face, shaft = (
        min(1.0, adhesion + friction * max(0.0, at_rest + of_soil))
        for adhesion, of_soil in ((face, on_face), (shaft, on_shaft))
    )
    return Interface(face, shaft, friction)
