"""The return to the cylinder of von Mises: radially."""

from collections.abc import Callable

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.materials.von_mises import VonMises

STRENGTH = 2.5
CLAY = VonMises(shear_modulus=100.0, poissons_ratio=0.3, density=1.0, strength=STRENGTH)
Function = Callable[[Material, Floats], Floats]


def deviators(stress: Floats) -> Floats:
    """(rr, zz, rz, tt), shape [n, 4]."""
    mean = stress[:, [0, 1, 3]].mean(axis=1, keepdims=True)
    return np.asarray(stress - mean * [1.0, 1.0, 0.0, 1.0])


def root_of_j2(stress: Floats) -> Floats:
    """Root of half the sum of the squares of all nine components of the deviator, [n]."""
    return np.asarray(np.sqrt(0.5 * deviators(stress) ** 2 @ [1.0, 1.0, 2.0, 1.0]))


def trials() -> Floats:
    return np.random.default_rng(1).normal(scale=20.0, size=(2000, 4))


def test_von_mises_ends_on_its_surface_radially(returned: Function) -> None:
    trial = trials()
    scale = np.minimum(1.0, STRENGTH / root_of_j2(trial))
    after = deviators(returned(CLAY, trial))
    np.testing.assert_allclose(after, deviators(trial) * scale[:, None], atol=1e-12)


def test_the_measure_of_von_mises_is_the_root_of_j2(yield_measures: Function) -> None:
    stress = trials()
    measure, strength = yield_measures(CLAY, stress).T
    np.testing.assert_allclose(measure, root_of_j2(stress), rtol=1e-13)
    np.testing.assert_array_equal(strength, STRENGTH)
