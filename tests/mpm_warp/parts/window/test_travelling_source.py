"""The travelling source: its flow, and the stress that the flow leaves."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.surrounding_ground import TravellingSource

SOURCE = TravellingSource(radius=0.5, height=0.2, shear_modulus=3.0)
PLACES = np.array([[4.0, -6.0], [5.0, 0.2], [3.0, 7.0], [0.0, -5.0]])
"""(r, z): below the source, beside it, above it, and on the axis below it."""
STEP = 1e-4


def gradients(place: Floats) -> Floats:
    """(dv_r/dr, dv_z/dz, (dv_r/dz + dv_z/dr) / 2, v_r / r), by central differences."""
    along_r, along_z = (
        (SOURCE.velocity(place + step) - SOURCE.velocity(place - step)) / (2.0 * STEP)
        for step in (np.array([STEP, 0.0]), np.array([0.0, STEP]))
    )
    hoop = along_r[0] if place[0] == 0.0 else SOURCE.velocity(place)[0] / place[0]
    return np.array([along_r[0], along_z[1], 0.5 * (along_z[0] + along_r[1]), hoop])


def test_the_volume_of_the_body_flows_through_any_sphere() -> None:
    """pi R^2 V, whatever the sphere; per radian R^2 / 2."""
    points, weights = np.polynomial.legendre.leggauss(4)
    for distance in (2.0, 9.0):
        sine = np.sqrt(1.0 - points**2)
        place = np.stack([distance * sine, SOURCE.height + distance * points], axis=-1)
        outward = (SOURCE.velocity(place) * np.stack([sine, points], axis=-1)).sum(axis=-1)
        flow = distance**2 * weights @ outward
        assert flow == pytest.approx(0.5 * SOURCE.radius**2, rel=1e-12)


@pytest.mark.parametrize("place", PLACES)
def test_the_flow_keeps_volume(place: Floats) -> None:
    strain = gradients(place)
    # Central differences are exact to the square of their step.
    assert abs(strain[[0, 1, 3]].sum()) < 10.0 * STEP**2 * np.abs(strain).max()


@pytest.mark.parametrize("place", PLACES)
def test_the_stress_is_that_of_the_flow_along_the_way_of_the_soil(place: Floats) -> None:
    """2 G grad v, integrated while the soil rises past the source, by Gauss's rule."""
    travel = 6.0
    points, weights = np.polynomial.legendre.leggauss(40)
    heights = place[1] - 0.5 * travel * (1.0 - points)
    rates = np.array([gradients(np.array([place[0], height])) for height in heights])
    expected = 0.5 * travel * weights @ (2.0 * SOURCE.shear_modulus * rates)
    stress = SOURCE.stress_since(place[None], travel)[0]
    np.testing.assert_allclose(stress, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("place", PLACES)
def test_the_traction_grows_as_the_stress_does(place: Floats) -> None:
    expected = 2.0 * SOURCE.shear_modulus * gradients(place)[[0, 2]]
    rate = SOURCE.traction_rate(place)
    np.testing.assert_allclose(rate, expected, atol=1e-6 * np.abs(expected).max())


def test_soil_that_nothing_has_passed_has_no_stress() -> None:
    np.testing.assert_array_equal(SOURCE.stress_since(PLACES, 0.0), 0.0)


@pytest.mark.parametrize("name", ["radius", "shear_modulus"])
def test_what_must_be_positive(name: str) -> None:
    values = {"radius": 1.0, "height": 0.0, "shear_modulus": 1.0} | {name: -1.0}
    with pytest.raises(SceneError, match=f"source: {name} = -1"):
        TravellingSource(**values)
