"""Elastic stress of a step, through a kernel that does nothing but work it out."""

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import (
    make_elastic_trial,
    make_strain_increment,
    make_stress_increment,
)
from mpm_warp.precision import FLOAT64

TIME_STEP, SHEAR, BULK = 1e-3, 2.0, 70.0
vec5 = FLOAT64.vec5
stress_increment = make_stress_increment(FLOAT64)
elastic_trial = make_elastic_trial(FLOAT64)
strain_increment = make_strain_increment(FLOAT64)


@wp.kernel(enable_backward=False)
def deform(
    gradient: wp.array(dtype=vec5),
    time_step: wp.float64,
    shear_modulus: wp.float64,
    bulk_modulus: wp.float64,
    stress: wp.array(dtype=wp.vec4d),
    strain: wp.array(dtype=wp.vec4d),
):
    k = wp.tid()
    increment = stress_increment(gradient[k], time_step, shear_modulus, bulk_modulus)
    stress[k] = elastic_trial(stress[k], increment)
    strain[k] = strain_increment(increment, shear_modulus, bulk_modulus)


def deformed(gradient: Floats, stress: Floats) -> tuple[Floats, Floats]:
    """Stress after a step and strain in it, at velocity gradients (rr, rz, zr, zz, tt)."""
    after = wp.array(stress, dtype=wp.vec4d, device="cpu")
    strain = wp.zeros(len(stress), dtype=wp.vec4d, device="cpu")
    gradients = wp.array(gradient, dtype=vec5, device="cpu")
    arguments = [gradients, TIME_STEP, SHEAR, BULK, after, strain]
    wp.launch(deform, len(stress), arguments, device="cpu")
    return after.numpy(), strain.numpy()


@pytest.fixture
def gradients() -> Floats:
    """Any velocity gradients."""
    return np.random.default_rng(4).normal(size=(100, 5))


def test_stress_of_a_step_from_rest_is_hookes(gradients: Floats) -> None:
    """dt (K tr D + 2 G dev D)."""
    stress, _ = deformed(gradients, np.zeros((100, 4)))
    rr, rz, zr, zz, tt = gradients.T
    strain = TIME_STEP * np.stack([rr, zz, 0.5 * (rz + zr), tt], axis=-1)
    volume = strain[:, [0, 1, 3]].sum(axis=1)
    expected = 2.0 * SHEAR * strain
    expected[:, [0, 1, 3]] += ((BULK - 2.0 / 3.0 * SHEAR) * volume)[:, None]
    np.testing.assert_allclose(stress, expected, rtol=1e-12, atol=1e-15)


def test_the_strain_that_a_law_is_told_is_that_of_the_step(gradients: Floats) -> None:
    _, strain = deformed(gradients, np.zeros((100, 4)))
    rr, rz, zr, zz, tt = gradients.T
    expected = TIME_STEP * np.stack([rr, zz, 0.5 * (rz + zr), tt], axis=-1)
    np.testing.assert_allclose(strain, expected, rtol=1e-12, atol=1e-16)


def test_spin_turns_the_stress_and_nothing_else() -> None:
    """However far: its invariants stay, and a quarter turn exchanges r and z."""
    stress = np.tile([3.0, -1.0, 0.5, 2.0], (2, 1))
    quarter = 2.0 * np.tan(0.25 * np.pi) / TIME_STEP  # Cayley: tan of half the angle
    after, strain = deformed(
        np.array([[0.0, -quarter, quarter, 0.0, 0.0], [0.0, 300.0, -300.0, 0.0, 0.0]]), stress
    )
    np.testing.assert_allclose(after[0], [-1.0, 3.0, -0.5, 2.0], atol=1e-12)
    rr, zz, rz, tt = after[1]
    assert rr + zz == pytest.approx(2.0)
    assert (rr - zz) ** 2 + 4.0 * rz**2 == pytest.approx(17.0)
    assert tt == 2.0
    np.testing.assert_array_equal(strain, 0.0)
