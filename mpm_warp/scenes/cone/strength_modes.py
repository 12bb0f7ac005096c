"""A cone factor by the test that su is from, and the rigidity index that goes with it.

The strength of a law that has its own depends on the mode of the test. A cone factor is a
resistance over one of these strengths; without its name it says nothing.
"""

from typing import Any

import xarray as xr

from mpm_warp.materials.elasticity import Isotropic
from mpm_warp.materials.other_laws import other_law
from mpm_warp.results import labelled, variable
from mpm_warp.scenes.catalogue import scene_class
from mpm_warp.scenes.clay import FieldClayScene

MODES = {
    "compression": "triaxial_compression",
    "simple_shear": "simple_shear",
    "extension": "triaxial_extension",
}
"""Element tests by the names of their modes in results."""
STEP_COUNT = 2000
"""Of an element test: G at half of the strength is within 1 % of that of 10,000 steps."""


def factors_by_mode(test: FieldClayScene, results: xr.Dataset) -> dict[str, xr.Variable]:
    """The cone factor over each su, and over the mean of the three, of a law that has its own.

    The name of `cone_factor` then says which su it is over.

    Args:
        test: a cone test.
        results: of it: `cone_factor`, over the su of the scene.
    """
    if test.own_strength is None:
        return {}
    clay = test.own_clay
    strengths = {mode: clay.undrained_strength(name) for mode, name in MODES.items()}
    known = {mode: su for mode, su in strengths.items() if su is not None}
    resistance = float(results.cone_factor) * test.undrained_shear_strength
    of_scene = clay.reference_test.removeprefix("triaxial_").replace("_", " ")
    factors = {"cone_factor": results.cone_factor.variable.copy()}
    factors["cone_factor"].attrs["long_name"] = f"cone factor, {of_scene}"
    for mode, su in known.items():
        words = mode.replace("_", " ")
        factors[f"cone_factor_by_{mode}"] = variable(
            resistance / su,
            meaning=f"cone factor, {words}",
            description=f"net cone resistance over su in {MODES[mode].replace('_', ' ')}",
        )
        factors[f"strength_by_{mode}"] = variable(su, unit="Pa", meaning=f"su in {words}")
    if len(known) < len(MODES):
        return factors
    mean = sum(known.values()) / len(known)
    return factors | labelled(
        cone_factor_by_average=(
            resistance / mean,
            "1",
            "cone factor, average",
            "net cone resistance over the mean of su in compression, simple shear and extension",
        )
    )


def rigidity_of_law(test: FieldClayScene) -> dict[str, xr.Variable]:
    """G over su in the element test of the law's su, of a law that has its own strength.

    Args:
        test: a cone test.
    """
    if test.own_strength is None:
        return {}
    clay = test.own_clay
    mode = clay.reference_test
    at_first = at_half = test.clay.ground_shear_modulus / test.own_strength
    if not isinstance(clay, Isotropic):
        own = {name: getattr(test, name) for name in other_law(test.material).parameters}
        element: Any = scene_class("element_test")
        found = element(material=test.material, test=mode, step_count=STEP_COUNT, **own).run()
        at_first = float(found.small_strain_rigidity_index)
        at_half = float(found.half_strength_rigidity_index)
    by = f"G over su in {mode.replace('_', ' ')}"
    return labelled(
        small_strain_rigidity_index=(at_first, "1", "rigidity index at small strain", by),
        half_strength_rigidity_index=(at_half, "1", "rigidity index at 50 % of su", by),
    )
