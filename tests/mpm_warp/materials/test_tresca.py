"""The return to the hexagon of Tresca: to its nearest point, a side or a corner."""

from collections.abc import Callable

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.materials.tresca import Tresca

STRENGTH = 2.5
CLAY = Tresca(shear_modulus=100.0, poissons_ratio=0.3, density=1.0, strength=STRENGTH)
Function = Callable[[Material, Floats], Floats]


def principal(stress: Floats) -> Floats:
    """Principal stresses in rising order, shape [n, 3]."""
    centre = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    return np.sort(np.stack([centre - radius, centre + radius, stress[:, 3]], axis=1), axis=1)


def trials(count: int = 2000, spread: float = 20.0) -> Floats:
    return np.random.default_rng(1).normal(scale=spread, size=(count, 4))


def nearest_on_hexagon(values: Floats) -> Floats:
    """Brute force: the nearest point of the Tresca hexagon to principal deviators, [n, 3]."""
    corners = np.array([[-2.0, -2.0, 4.0], [-4.0, 2.0, 2.0]]) * STRENGTH / 3.0
    share = np.linspace(0.0, 1.0, 20001)[:, None]
    # With the principal stresses in order only one side can be the nearest.
    side = (1.0 - share) * corners[0] + share * corners[1]
    mean = values.mean(axis=1, keepdims=True)
    distances = np.sum(((values - mean)[:, None, :] - side) ** 2, axis=2)
    nearest: Floats = side[np.argmin(distances, axis=1)] + mean
    return nearest


def test_tresca_returns_to_the_nearest_point(returned: Function) -> None:
    trial = trials(300)
    outside = np.ptp(principal(trial), axis=1) > 2.0 * STRENGTH
    after = principal(returned(CLAY, trial[outside]))
    # The brute force has 20000 points on a side of length 2 sqrt(2) su.
    np.testing.assert_allclose(after, nearest_on_hexagon(principal(trial[outside])), atol=1e-3)


@pytest.mark.parametrize("spread", [2.0, 20.0, 2e6])
def test_tresca_ends_on_or_inside_its_surface(returned: Function, spread: float) -> None:
    after = returned(CLAY, trials(spread=spread))
    rounding = 1e-15 * spread
    assert np.ptp(principal(after), axis=1).max() <= 2.0 * STRENGTH * (1 + 1e-14) + 10 * rounding


@pytest.mark.parametrize("hoop", [50.0, -50.0])
def test_tresca_with_equal_stresses_in_the_plane_returns_to_the_corner(
    returned: Function, hoop: float
) -> None:
    after = returned(CLAY, np.array([[0.0, 0.0, 0.0, hoop]]))
    mean, sign = hoop / 3.0, np.sign(hoop)
    plane, tt = mean - sign * 2.0 / 3.0 * STRENGTH, mean + sign * 4.0 / 3.0 * STRENGTH
    np.testing.assert_allclose(after, [[plane, plane, 0.0, tt]], rtol=1e-14)


def test_the_measure_of_tresca_is_half_the_difference_of_the_extreme_principal_stresses(
    yield_measures: Function,
) -> None:
    stress = trials()
    measure, strength = yield_measures(CLAY, stress).T
    np.testing.assert_allclose(measure, 0.5 * np.ptp(principal(stress), axis=1), rtol=1e-13)
    np.testing.assert_array_equal(strength, STRENGTH)
