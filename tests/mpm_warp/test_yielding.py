"""Returns to the yield surface, through a kernel that does nothing but call them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import warp as wp
from mpm_warp.materials.materials import LinearElastic, Tresca, VonMises
from mpm_warp.materials.yielding import make_yielding

from mpm_warp.grid.fitted import Floats
from mpm_warp.precision import FLOAT64

STRENGTH = 2.5
ELASTIC = {"shear_modulus": 100.0, "poissons_ratio": 0.3, "density": 1.0}


def make_returned(material: LinearElastic) -> Callable[[Floats], Floats]:
    """A function from trial stresses [n, 4] to returned stresses."""
    yielding = make_yielding(material, FLOAT64)

    @wp.kernel(enable_backward=False, module="unique")
    def apply(stress: wp.array(dtype=wp.vec4d), strength: wp.float64):
        k = wp.tid()
        stress[k] = yielding(stress[k], strength)

    def returned(trial: Floats) -> Floats:
        stress = wp.array(trial, dtype=wp.vec4d, device="cpu")
        wp.launch(apply, len(trial), [stress, STRENGTH], device="cpu")
        values: Floats = stress.numpy()
        return values

    return returned


returned_to_tresca = make_returned(Tresca(strength=STRENGTH, **ELASTIC))
returned_to_von_mises = make_returned(VonMises(strength=STRENGTH, **ELASTIC))


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


def test_tresca_returns_to_the_nearest_point() -> None:
    trial = trials(300)
    outside = np.ptp(principal(trial), axis=1) > 2.0 * STRENGTH
    after = principal(returned_to_tresca(trial[outside]))
    # The brute force has 20000 points on a side of length 2 sqrt(2) su.
    np.testing.assert_allclose(after, nearest_on_hexagon(principal(trial[outside])), atol=1e-3)


@pytest.mark.parametrize("spread", [2.0, 20.0, 2e6])
def test_tresca_ends_on_or_inside_its_surface(spread: float) -> None:
    after = returned_to_tresca(trials(spread=spread))
    rounding = 1e-15 * spread
    assert np.ptp(principal(after), axis=1).max() <= 2.0 * STRENGTH * (1 + 1e-14) + 10 * rounding


def test_von_mises_ends_on_its_surface_radially() -> None:
    trial = trials()
    after = returned_to_von_mises(trial)
    before_dev = principal(trial) - principal(trial).mean(axis=1, keepdims=True)
    after_dev = principal(after) - principal(after).mean(axis=1, keepdims=True)
    j2 = 0.5 * np.sum(before_dev**2, axis=1)
    scale = np.minimum(1.0, STRENGTH / np.sqrt(j2))
    np.testing.assert_allclose(after_dev, before_dev * scale[:, None], atol=1e-12)


@pytest.mark.parametrize("returned", [returned_to_tresca, returned_to_von_mises])
def test_returns_keep_pressure_directions_and_what_is_inside(
    returned: Callable[[Floats], Floats],
) -> None:
    trial = trials()
    after = returned(trial)
    pressure = trial[:, [0, 1, 3]].sum(axis=1)
    np.testing.assert_allclose(after[:, [0, 1, 3]].sum(axis=1), pressure, atol=1e-12)
    # Same principal directions: the deviators in the plane are parallel.
    cross = (trial[:, 0] - trial[:, 1]) * after[:, 2] - (after[:, 0] - after[:, 1]) * trial[:, 2]
    np.testing.assert_allclose(cross, 0.0, atol=1e-11)
    inside = trials(spread=0.3)
    np.testing.assert_array_equal(returned(inside), inside)


@pytest.mark.parametrize("hoop", [50.0, -50.0])
def test_tresca_with_equal_stresses_in_the_plane_returns_to_the_corner(hoop: float) -> None:
    after = returned_to_tresca(np.array([[0.0, 0.0, 0.0, hoop]]))
    mean, sign = hoop / 3.0, np.sign(hoop)
    plane, tt = mean - sign * 2.0 / 3.0 * STRENGTH, mean + sign * 4.0 / 3.0 * STRENGTH
    np.testing.assert_allclose(after, [[plane, plane, 0.0, tt]], rtol=1e-14)


def test_a_material_that_never_yields_has_no_return() -> None:
    assert make_yielding(LinearElastic(**ELASTIC), FLOAT64) is None
