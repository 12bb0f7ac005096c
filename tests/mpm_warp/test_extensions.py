"""A law is one file: one that only this file knows, on strain paths and around a cone.

It is von Mises soil with linear isotropic hardening by accumulated plastic shear strain.
"""

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.materials.elasticity import Isotropic, make_elastic_increment
from mpm_warp.materials.material import Material
from mpm_warp.materials.von_mises import make_j2
from mpm_warp.precision import Precision
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.simulation import Simulation

pytestmark = pytest.mark.slow

SHEAR_MODULUS, STRENGTH, HARDENING = 2e6, 20e3, 3e5


@dataclass(frozen=True, kw_only=True)
class HardeningVonMises(Isotropic):
    """Yields where sqrt(J2) = su + H x, with x the accumulated plastic shear strain."""

    strength: float
    hardening: float

    @property
    def state(self) -> tuple[str, ...]:
        return ("plastic_shear_strain",)

    @property
    def properties(self) -> tuple[float, ...]:
        return (*super().properties, self.strength, self.hardening)

    def update(self, precision: Precision) -> Any:
        return _make_update(precision)

    def yield_function(self, precision: Precision) -> Any:
        return _make_yield_function(precision)


@functools.cache
def _make_yield_function(precision: Precision) -> Any:
    vec1, vec2, vec4 = (precision.vector(length) for length in (1, 2, 4))
    j2 = make_j2(precision)

    @wp.func
    def hardened(stress: vec4, properties: vec4, state: vec1) -> vec2:
        return vec2(wp.sqrt(j2(stress)), properties[2] + properties[3] * state[0])

    return hardened


@functools.cache
def _make_update(precision: Precision) -> Any:
    real = precision.real
    vec1, vec4 = precision.vector(1), precision.vec4
    j2, elastic_increment = make_j2(precision), make_elastic_increment(precision)

    @wp.func
    def return_and_harden(
        stress: vec4, strain: vec4, time_step: real, properties: vec4, state: vec1
    ):
        shear_modulus, hardening = properties[0], properties[3]
        trial = stress + elastic_increment(strain, shear_modulus, properties[1])
        strength = properties[2] + hardening * state[0]
        shear = wp.sqrt(j2(trial))
        if shear <= strength:
            return trial, state
        # The return takes G x off the shear stress while the strength rises by H x.
        plastic = (shear - strength) / (shear_modulus + hardening)
        scale = real(1.0) - shear_modulus * plastic / shear
        mean = (trial[0] + trial[1] + trial[3]) / real(3.0)
        centre = vec4(mean, mean, real(0.0), mean)
        return centre + scale * (trial - centre), vec1(state[0] + plastic)

    return return_and_harden


SOIL = HardeningVonMises(
    shear_modulus=SHEAR_MODULUS,
    poissons_ratio=0.49,
    density=1700.0,
    strength=STRENGTH,
    hardening=HARDENING,
)


def exact_shear(strain: float) -> float:
    """Shear stress after a monotonic engineering shear strain: elastic, then hardening."""
    elastic = SHEAR_MODULUS * strain
    if elastic <= STRENGTH:
        return elastic
    return (STRENGTH + HARDENING * strain) / (1.0 + HARDENING / SHEAR_MODULUS)


@pytest.mark.parametrize("strain", [0.5e-2, 1.5e-2, 0.2])
def test_the_material_is_exact_on_strain_paths(strain: float) -> None:
    """Pure shear in the plane, sheared along z, and against the hoop: one law, three directions.

    The paths are proportional, so the return is exact whatever the number of steps: rounding is
    left, the sum of one for each step.
    """
    half = 0.5 * strain
    gradient = np.array(
        [[half, 0, 0, -half, 0], [0, half, half, 0, 0], [half, 0, 0, 0, -half]], dtype=float
    )
    rest = np.zeros((3, 4))
    simulation = Simulation(
        StrainPaths(material=SOIL, gradient=gradient, stress=rest, step_count=1000)
    )
    simulation.advance(1000)
    shear = exact_shear(strain)
    exact = shear * np.array([[1, -1, 0, 0], [0, 0, 1, 0], [1, 0, 0, -1]], dtype=float)
    np.testing.assert_allclose(simulation.array("particle.stress"), exact, atol=1e-6 * STRENGTH)
    plastic = strain - shear / SHEAR_MODULUS
    remembered = simulation.array("particle.state")[:, 0]
    np.testing.assert_allclose(remembered, plastic, atol=1e-6 * strain)


def test_the_material_remembers_when_the_strain_turns_back() -> None:
    """After hardening to the strength k, it yields the other way at -k, not at -su."""
    strain = 0.1
    hardened = exact_shear(strain)
    half = 0.5 * strain
    # Forth and back: two paths, the second from where the first ends.
    forth = Simulation(
        StrainPaths(
            material=SOIL,
            gradient=np.array([[half, 0, 0, -half, 0]]),
            stress=np.zeros((1, 4)),
            step_count=500,
        )
    )
    forth.advance(500)
    back = Simulation(
        StrainPaths(
            material=SOIL,
            gradient=np.array([[-half, 0, 0, half, 0]]),
            stress=forth.array("particle.stress").copy(),
            step_count=500,
        )
    )
    back.assign("particle.state", forth.array("particle.state"))
    back.advance(500)
    beyond = strain - 2.0 * hardened / SHEAR_MODULUS  # what is left of it after yield
    expected = -(hardened + HARDENING * beyond / (1.0 + HARDENING / SHEAR_MODULUS))
    stress = back.array("particle.stress")[0]
    np.testing.assert_allclose(stress, [expected, -expected, 0, 0], atol=1e-6 * STRENGTH)


def cone_of(test: ConePenetration, material: Material) -> Simulation:
    """A short penetration of a cone through a window."""
    simulation = Simulation(replace(test.build(), material=material))
    simulation.travel_to(1.5 * test.cone_radius)
    simulation.check()
    return simulation


def test_the_material_goes_through_a_cone_and_a_window(short_test: ConePenetration) -> None:
    """Points remember; of what has entered through the window some has not yielded as yet."""
    simulation = cone_of(short_test, SOIL)
    present = simulation.array("particle.cell")[:, 0] >= 0
    remembered = simulation.array("particle.state")[present, 0]
    row = simulation.array("particle.cell")[present, 1]
    assert remembered.max() > 0.1
    assert remembered[row == 0].min() == 0.0
    # No point is beyond its own strength.
    stress = simulation.array("particle.stress")[present]
    normal = stress[:, [0, 1, 3]] - stress[:, [0, 1, 3]].mean(axis=1, keepdims=True)
    shear = np.sqrt(0.5 * np.sum(normal**2, axis=1) + stress[:, 2] ** 2)
    assert np.all(shear <= (STRENGTH + HARDENING * remembered) * (1.0 + 1e-12))


def test_the_watch_knows_the_strength_of_the_material(short_test: ConePenetration) -> None:
    simulation = cone_of(short_test, SOIL)
    slot = int(np.flatnonzero(simulation.array("particle.cell")[:, 0] >= 0)[5])
    simulation.array("particle.stress")[slot] = [0.0, 0.0, 5.0 * STRENGTH, 0.0]
    with pytest.raises(Exception, match=f"stress of particle {slot} .* outside the yield surface"):
        simulation.check()
