"""Whether U was measured for a scene, as it was built, and for its material law.

U belongs to the scenes of the catalogue as they are. A class of one's own may build another soil,
contact or grid under the same parameters; so may whoever runs a scene with other parts. Of these
nothing is known.
"""

from typing import Protocol

from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import Material, built_name
from mpm_warp.materials.modified_cam_clay import ModifiedCamClay
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.parts.energy import EnergyAudit, EnergyBalance
from mpm_warp.parts.history import History
from mpm_warp.scene import Scene

MEASURED_LAWS = (Tresca, VonMises, EinavRandolph)
"""Material laws with which further runs were tested: errors depend on the width of cells and on the
speed as further runs assume. In a law of a user the strength may depend on the speed, or softening
may localise in one cell; further runs cannot distinguish such an effect from an error."""
LAWS_OF_CONES = (*MEASURED_LAWS, ModifiedCamClay, Anisotropic)
"""Material laws with which further runs of cones were tested."""
LARGEST_BRITTLENESS = 0.1
"""(1 - delta) / xi_95 up to which further runs measure the error of clay that softens. At 0.02 to
0.08 the cone factor follows the law of the mesh, within 0.008 on 5 to 14 rows of cells. At 0.18 it
falls below the limit that further runs give, by 1.7 of their half widths."""
RECORDS = (EnergyAudit, EnergyBalance, History)
"""Parts that only record and do not change a result."""
MEASURABLE = ", but further runs may measure it (uncertainty = measured)"
"""Remedy in the reason why a factor has no uncertainty; it does not hold for pore pressures."""


class Test(Protocol):
    """A test of the catalogue, or one derived from it."""

    def build(self) -> Scene:
        """The scene that is simulated."""


def is_of_catalogue(test: object) -> bool:
    """Whether a test is one of this package, not one derived from it elsewhere."""
    return type(test).__module__.partition(".")[0] == __package__.partition(".")[0]


def goes_on(test: object, material: Material) -> bool:
    """Whether the correction of Tresca clay goes on in this clay, where no law knows the error.

    Not in a scene of one's own, nor where the strength has a direction: there finer cells lower
    the factor, where they raise it in Tresca clay.
    """
    kinds = type(material), getattr(material, "criterion", None)
    return is_of_catalogue(test) and Anisotropic not in kinds


def why_not_of_catalogue(test: Test, built: Scene) -> list[str]:
    """Why the `built` scene is none of the catalogue, as "word: sentence"; empty if it is one."""
    if not is_of_catalogue(test):
        name = f"{type(test).__module__}.{type(test).__qualname__}"
        return [f"scene: the error is known for scenes of the catalogue, not for {name}"]
    own, usual = (_names(scene) for scene in (built, test.build()))
    return [] if own == usual else [f"scene: the error is not known with {', '.join(own)}"]


def _names(scene: Scene) -> list[str]:
    """The material and the parts that change a result."""
    return sorted(map(built_name, (scene.material, *scene.without(*RECORDS).parts)))


def why_not_tresca(material: Material) -> list[str]:
    """Why the laws of the error do not hold in this soil of the catalogue; empty in Tresca soil."""
    if type(material) is Tresca:
        return []
    changing = isinstance(material, EinavRandolph)
    name = "clay that softens or has a rate effect" if changing else built_name(material)
    return [f"law: the error is known in tresca, not in {name}{MEASURABLE}"]


def why_law_not_measured(
    material: Material, laws: tuple[type[Material], ...] = MEASURED_LAWS
) -> list[str]:
    """Why neither laws nor further runs give the error in this material; empty where they do."""
    if type(material) not in laws:
        return [f"law: the error is not known in {built_name(material)}"]
    if not isinstance(material, EinavRandolph):
        return []
    if material.criterion not in MEASURED_LAWS:
        criterion = material.criterion.__name__
        return [f"law: the error is not known in {criterion} clay whose strength changes"]
    lost = 1.0 - material.remoulded_strength_ratio
    if lost > LARGEST_BRITTLENESS * material.ductility:
        above = f"(1 - delta) / xi_95 above {LARGEST_BRITTLENESS:g}"
        return [f"law: no limit of fine cells is known in clay so brittle, {above}"]
    return []
