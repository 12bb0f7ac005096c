"""Element tests: strength and stiffness by mode, as the law has them."""

import math

import numpy as np
import pytest

from mpm_warp import ElementTest
from mpm_warp.scenes.material.element_test import TESTS

SU = 20e3
modes = pytest.mark.parametrize("mode", TESTS)


@modes
@pytest.mark.parametrize("anisotropy", [0.0, 0.5, -0.5])
def test_tresca_has_one_strength_and_its_stiffness(mode: str, anisotropy: float) -> None:
    """t = G gamma up to su, from the stress at the start on; so G and su are read exactly."""
    result = ElementTest(test=mode, stress_anisotropy=anisotropy, step_count=1000).run()
    assert float(result.strength) == pytest.approx(SU, rel=1e-12)
    assert float(result.strength_exact) == SU
    assert float(result.small_strain_rigidity_index) == pytest.approx(100.0, rel=1e-9)
    assert float(result.half_strength_rigidity_index) == pytest.approx(100.0, rel=1e-9)
    assert "effective_mean_stress" not in result


@modes
def test_von_mises_is_weaker_in_triaxial_modes(mode: str) -> None:
    """sqrt(J2) = su: q = sqrt(3) su, of which the half is sqrt(3)/2 su, and 1 in plane strain."""
    result = ElementTest(test=mode, material="von_mises", step_count=1000).run()
    share = math.sqrt(0.75) if mode.startswith("triaxial") else 1.0
    assert float(result.strength) == pytest.approx(share * SU, rel=1e-12)
    assert float(result.error) < 1e-12


def test_clay_that_softens_has_a_peak_and_an_end() -> None:
    """At the end xi = gamma - t / G, and t = su (delta + (1 - delta) exp(-3 xi / xi_95))."""
    result = ElementTest(remoulded_strength_ratio=0.5, ductility=0.5).run()
    end = float(result.strength) / SU
    xi = 1.0 - 0.01 * end
    assert end == pytest.approx(0.5 + 0.5 * math.exp(-3.0 * xi / 0.5), rel=1e-6)
    # The peak lies within a sample of yield, at gamma = 0.01.
    assert 0.995 < float(result.peak_strength) / SU <= 1.0
    assert "strength_exact" not in result


def test_strain_rates_count_as_in_the_laboratory() -> None:
    """One log cycle above the reference adds mu."""
    result = ElementTest(rate_factor=0.1, reference_strain_rate=3e-7).run()
    assert float(result.strength) == pytest.approx(1.1 * SU, rel=1e-9)


def test_extension_begins_by_taking_the_shear_stress_of_the_ground_off() -> None:
    result = ElementTest(test="triaxial_extension", stress_anisotropy=0.5).run()
    along = result.mobilised_stress.values
    np.testing.assert_allclose(result.shear_stress.values, np.abs(0.5 * SU - along), atol=1e-9 * SU)
    assert along[-1] == pytest.approx(1.5 * SU)
