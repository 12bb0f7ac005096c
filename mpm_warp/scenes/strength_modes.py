"""Factors of penetrometers by the mode of the test that gives su, and rigidity indices of laws.

The strength of a law with its own strength depends on the mode of the test. A factor is a
resistance or pressure over one of these strengths, and has a meaning only together with its mode.
"""

import math
from typing import Any

import numpy as np
import xarray as xr

from mpm_warp.materials.elasticity import Isotropic
from mpm_warp.materials.material import EFFECTIVE_STRESS, Material
from mpm_warp.results import labelled, variable
from mpm_warp.scenes.catalogue import scene_class
from mpm_warp.scenes.clay import Clay
from mpm_warp.scenes.clay_scene import ClayScene

MODES = {
    "compression": "triaxial_compression",
    "simple_shear": "simple_shear",
    "extension": "triaxial_extension",
}
"""Modes in the names of results, and their element tests."""
BY_GIVEN = "by the su given"
"""End of the long name of a factor over an su that is not the law's own."""
STEP_COUNT = 2000
"""Steps of an element test; G at half of the strength is within 1 % of that with 10,000 steps."""


def by_mode(clay: Clay, **factors: xr.Variable) -> dict[str, xr.Variable]:
    """Factors N_by_compression and so on, and N_by_average, of a law with its own strength.

    The given factors N are over su of the clay; results are {} for other laws.
    """
    own = clay.own_strength
    if own is None:
        return {}
    law = clay.by_law
    strengths = ((mode, law.undrained_strength(name)) for mode, name in MODES.items())
    known = {mode: su for mode, su in strengths if su is not None}
    found = {
        f"strength_by_{mode}": variable(su, unit="Pa", meaning=f"su in {mode.replace('_', ' ')}")
        for mode, su in known.items()
    }
    tests = {mode: MODES[mode].replace("_", " ") for mode in known}
    if len(known) == len(MODES):
        known["average"] = sum(known.values()) / len(known)
        tests["average"] = "the mean of compression, simple shear and extension"
    of_scene = law.reference_test.removeprefix("triaxial_").replace("_", " ")
    if not math.isclose(clay.undrained_shear_strength, own):
        of_scene = BY_GIVEN
    for name, factor in factors.items():
        meaning = factor.attrs["long_name"]
        found[name] = factor.copy()
        found[name].attrs["long_name"] = f"{meaning}, {of_scene}"
        for mode, su in known.items():
            found[f"{name}_by_{mode}"] = variable(
                float(factor) * clay.undrained_shear_strength / su,
                meaning=f"{meaning}, {mode.replace('_', ' ')}",
                description=f"over su in {tests[mode]}",
            )
    return found


def cone_factors_by_mode(test: ClayScene, results: xr.Dataset) -> dict[str, xr.Variable]:
    """Nkt, N_du = (u2 - u0) / su and N_ke = (qt - u2) / su by mode, and Bq = N_du / Nkt.

    N_ke needs the effective stress of the ground, which a law of total stress does not have.
    """
    net, excess = float(results.cone_factor), float(results.pore_pressure_factor_shoulder)
    of_excess = (excess, "1", "pore pressure factor N_du", "(u2 - u0) / su")
    factors = {"cone_factor": results.cone_factor.variable} | labelled(N_du=of_excess)
    soil, stress = test.soil, test.stress_at_rest
    if EFFECTIVE_STRESS in soil.state:
        mean = soil.state_at(stress, np.zeros(2))[soil.state.index(EFFECTIVE_STRESS)]
        vertical = float(mean + 2.0 / 3.0 * (stress[0] - stress[1]))
        factor = net + vertical / test.clay.undrained_shear_strength - excess
        factors |= labelled(N_ke=(factor, "1", "effective cone factor N_ke", "(qt - u2) / su"))
    found = by_mode(test.clay, **factors)
    ratio = (excess / net, "1", "pore pressure ratio Bq", "(u2 - u0) / (qt - sigma_v0)")
    return found | labelled(Bq=ratio) if found else {}


def rigidity_of_law(clay: Clay, soil: Material) -> dict[str, xr.Variable]:
    """Rigidity indices of a law with its own strength, in the element test that gives its su.

    `soil` is the clay as it is simulated.
    """
    if clay.own_strength is None:
        return {}
    law, mode = clay.by_law, clay.by_law.reference_test
    at_first = at_half = soil.ground_shear_modulus / clay.own_strength
    if not isinstance(law, Isotropic):
        element: Any = scene_class("element_test")
        found = element(material=clay.material, test=mode, step_count=STEP_COUNT).run()
        at_first = float(found.small_strain_rigidity_index)
        at_half = float(found.half_strength_rigidity_index)
    by = f"G over su in {mode.replace('_', ' ')}"
    return labelled(
        small_strain_rigidity_index=(at_first, "1", "rigidity index at small strain", by),
        half_strength_rigidity_index=(at_half, "1", "rigidity index at 50 % of su", by),
    )
