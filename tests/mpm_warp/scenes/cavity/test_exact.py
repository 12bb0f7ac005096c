"""The integral of the cavity pressure for any strength law, against what is known of it."""

import math

import numpy as np
import pytest

from mpm_warp import EinavRandolph, Tresca
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cavity.exact import cavity_pressure, strain_rate
from mpm_warp.scenes.cavity.shapes import CavityCylinder, CavitySphere
from mpm_warp.scenes.material.strain_paths import shear_stress
from tests.mpm_warp.conftest import changing_clay

CYLINDER, SPHERE = (2, 1.0), (3, 4 / 3)
ELASTIC = {"shear_modulus": 100.0, "poissons_ratio": 0.49, "density": 1.0, "strength": 1.0}
PERFECT = Tresca(**ELASTIC)


def clay(**changed: float) -> EinavRandolph:
    return changing_clay(**ELASTIC, **changed)


@pytest.mark.parametrize(
    ("body", "expansion", "pressures"),
    [
        (CYLINDER, math.inf, [4.223, 4.842, 5.293, 5.535]),
        (CYLINDER, 4.0, [4.210, 4.827, 5.263, 5.480]),
        (SPHERE, math.inf, [5.630, 6.456, 7.058, 7.3795]),
        (SPHERE, 4.0, [5.626, 6.451, 7.050, 7.363]),
    ],
)
def test_clay_that_softens_has_its_tabulated_pressures(
    body: tuple[int, float], expansion: float, pressures: list[float]
) -> None:
    """At xi_95 = 1, 3, 10, 50, delta 0.2 and Ir 100; to three decimals, one of them to four."""
    m, factor = body
    for ductility, expected in zip((1.0, 3.0, 10.0, 50.0), pressures, strict=True):
        soft = clay(remoulded_strength_ratio=0.2, ductility=ductility)
        pressure = cavity_pressure(
            lambda strain, soft=soft: shear_stress(soft, strain, 0.0 * strain),
            strain=m * math.log(expansion),
            factor=factor,
        )
        assert pressure == pytest.approx(expected, abs=5.1e-4)


@pytest.mark.parametrize(("body", "expected"), [(CYLINDER, 6.068), (SPHERE, 8.091)])
def test_a_rate_effect_has_its_tabulated_limits(body: tuple[int, float], expected: float) -> None:
    """mu 0.1, m (da/dt)/a 100 times the reference strain rate."""
    m, factor = body
    hurried = clay(rate_factor=0.1)

    def shear(strain: Floats) -> Floats:
        rate = strain_rate(strain, exponent=m, growth_rate=100.0 / m, expansion=math.inf)
        return shear_stress(hurried, strain, rate)

    pressure = cavity_pressure(shear, strain=math.inf, factor=factor)
    assert pressure == pytest.approx(expected, abs=5.1e-4)


@pytest.mark.parametrize("scene", [CavityCylinder, CavitySphere])
def test_perfect_plasticity_has_its_closed_form(scene: type[CavityCylinder | CavitySphere]) -> None:
    radii, exact = np.array([1.001, 1.01, 1.1, 2.0, 10.0]), scene(rigidity_index=100.0).exact
    pressures = [
        cavity_pressure(
            lambda strain: shear_stress(PERFECT, strain, 0.0 * strain),
            strain=scene.exponent * math.log(radius),
            factor=exact.factor,
        )
        for radius in radii
    ]
    # A panel is 1/160 of a logarithm of the strain wide; tau has a corner in one of them.
    corner = (1 / 160) ** 2 / 8
    np.testing.assert_allclose(pressures, exact.pressure(radii), atol=corner)


def test_any_law_can_be_given() -> None:
    """tau = e^gamma - 1 makes the integral the strain itself."""
    assert cavity_pressure(np.expm1, strain=3.0, factor=4 / 3) == pytest.approx(4.0, rel=1e-12)


@pytest.mark.parametrize("m", [2, 3])
def test_the_strain_rate_is_that_of_the_flow(m: int) -> None:
    """By differences of gamma = m ln(r/r0), with r^m - r0^m the same everywhere."""
    a, small, r = 1.7, 1e-6, np.array([1.7, 2.0, 5.0])

    def strain(radius: float) -> Floats:
        rest = r**m - a**m + 1.0
        return m * np.log((rest + radius**m - 1.0) ** (1 / m) / rest ** (1 / m))

    by_differences = (strain(a + small) - strain(a - small)) / (2.0 * small)
    rates = strain_rate(strain(a), exponent=m, growth_rate=1.0 / a, expansion=a)
    np.testing.assert_allclose(rates, by_differences, rtol=1e-8)
