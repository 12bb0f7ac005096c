"""The stress of a step along strain paths."""

from typing import Any

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats
from tests.mpm_warp.conftest import Recording
from tests.mpm_warp.materials.conftest import points_on

TIME_STEP = 1e-3


SOIL = Recording(shear_modulus=2.0, poissons_ratio=0.48, density=1.0)


def deformed(gradients: Any, start: Any = (0, 0, 0, 0)) -> tuple[Floats, Floats]:
    """Stress after a step at velocity gradients (rr, rz, zr, zz, tt), and what the law was told."""
    simulation = points_on(gradients, SOIL, round(1.0 / TIME_STEP), start)
    simulation.advance(1)
    return simulation.array("particle.stress"), simulation.array("particle.state")


def test_stress_of_a_step_from_rest_is_hookes_of_the_strain_that_the_law_is_told() -> None:
    """dt (K tr D + 2 G dev D), and the law is told the length of the step."""
    gradients = np.random.default_rng(4).normal(size=(100, 5))
    rr, rz, zr, zz, tt = gradients.T
    strain = TIME_STEP * np.stack([rr, zz, 0.5 * (rz + zr), tt], axis=-1)
    stress, told = deformed(gradients)
    np.testing.assert_allclose(told[:, :4], strain, rtol=1e-12)
    np.testing.assert_array_equal(told[:, 4:], [[1.0, TIME_STEP]] * 100)
    volume = strain[:, [0, 1, 3]].sum(axis=1)
    expected = 2.0 * SOIL.shear_modulus * strain
    mean = SOIL.bulk_modulus - 2.0 / 3.0 * SOIL.shear_modulus
    expected[:, [0, 1, 3]] += (mean * volume)[:, None]
    np.testing.assert_allclose(stress, expected, rtol=1e-12, atol=1e-15)


def test_spin_turns_the_stress_and_nothing_else() -> None:
    """However far: its invariants stay, and a quarter turn exchanges r and z."""
    quarter = 2.0 * np.tan(0.25 * np.pi) / TIME_STEP  # Cayley: tan of half the angle
    turns = [(0.0, -quarter, quarter, 0.0, 0.0), (0.0, 300.0, -300.0, 0.0, 0.0)]
    after, told = deformed(turns, (3.0, -1.0, 0.5, 2.0))
    np.testing.assert_allclose(after[0], [-1.0, 3.0, -0.5, 2.0], atol=1e-12)
    rr, zz, rz, tt = after[1]
    assert rr + zz == pytest.approx(2.0)
    assert (rr - zz) ** 2 + 4.0 * rz**2 == pytest.approx(17.0)
    assert tt == 2.0
    np.testing.assert_array_equal(told[:, :4], 0.0)
