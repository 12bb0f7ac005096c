"""Softening and rate: the strength that a point is returned to, and what it remembers."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mpm_warp import EinavRandolph, LinearElastic, Simulation, Tresca
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic, UndrainedClay
from tests.mpm_warp.conftest import changing_clay, layers
from tests.mpm_warp.materials.conftest import points_on

ELASTIC = {"shear_modulus": 200.0, "poissons_ratio": 0.3, "density": 4.0, "strength": 2.0}
SLOW_AND_DUCTILE = {"reference_strain_rate": 0.01, "ductility": 2.0}
SOFT = {"remoulded_strength_ratio": 0.25}
HURRIED = {"rate_factor": 0.1}
criteria = pytest.mark.parametrize("criterion", CRITERIA.values())


def clay(criterion: type[PerfectlyPlastic] = Tresca, **changed: float) -> EinavRandolph:
    return changing_clay(criterion, **ELASTIC, **{**SLOW_AND_DUCTILE, **changed})


def pulled(material: UndrainedClay, *rates: float, steps: int = 50) -> Simulation:
    """A point in pure shear at rates gamma [1/s], one after the other, for a second each."""
    simulation = points_on(np.zeros((1, 5)), material, steps)
    for rate in rates:
        gradient = [[0.5 * rate, 0.0, 0.0, -0.5 * rate, 0.0]]
        simulation.assign("particle.velocity_gradient", np.array(gradient))
        simulation.advance(steps)
    return simulation


def shear(simulation: Simulation) -> float:
    stress: Floats = simulation.array("particle.stress")[0]
    return float(0.5 * (stress[0] - stress[1]))


def strength(material: EinavRandolph, plastic: float, rate: float) -> float:
    hurry = 1.0 + material.rate_factor * math.log10(rate / material.reference_strain_rate)
    delta = material.remoulded_strength_ratio
    softened = delta + (1.0 - delta) * math.exp(-3.0 * plastic / material.ductility)
    return material.strength * hurry * softened


@criteria
@pytest.mark.parametrize("changed", [SOFT, HURRIED, SOFT | HURRIED])
def test_strength_is_that_of_the_plastic_strain_and_the_rate(
    criterion: type[PerfectlyPlastic], changed: dict[str, float]
) -> None:
    """In steps of 2 % of strain, of which Newton's second error is 1e-8 of the strain at most."""
    material = clay(criterion, **changed)
    tau = shear(pulled(material, 1.0))
    plastic = 1.0 - tau / material.shear_modulus
    assert tau == pytest.approx(strength(material, plastic, 1.0), rel=1e-8)


@criteria
def test_plastic_strain_adds_up_forth_and_back(criterion: type[PerfectlyPlastic]) -> None:
    material = clay(criterion, **SOFT)
    simulation = pulled(material, 1.0, -0.5)
    tau = -shear(simulation)
    # The way back is 2 tau / G of elastic strain shorter, from the shear stress before.
    before = shear(pulled(material, 1.0))
    plastic = 1.0 - before / 200.0 + 0.5 - (before + tau) / 200.0
    assert tau == pytest.approx(strength(material, plastic, 1.0), rel=1e-7)
    lost = 1.0 - math.exp(-3.0 * plastic / material.ductility)
    assert simulation.array("particle.state")[0, 0] == pytest.approx(lost, rel=1e-7)


def test_strength_follows_the_rate_at_once_and_not_below_that_of_reference() -> None:
    material = clay(**HURRIED)
    for rates, expected in (((1.0,), 1.2), ((0.1, 10.0), 1.3), ((10.0, 0.1), 1.1), ((0.008,), 0.8)):
        # At 0.008 / s the point has not yielded: its shear stress is G times the strain.
        assert shear(pulled(material, *rates)) == pytest.approx(2.0 * expected, rel=1e-12)
    assert shear(pulled(material, 1.0, 0.001)) == pytest.approx(2.0, rel=1e-12)


def test_a_point_is_never_beyond_the_surface_that_the_watch_looks_at() -> None:
    simulation = pulled(clay(**SOFT, **HURRIED), 1.0, -3.0, 0.2, 40.0)
    assert float(simulation.array("particle.yield_excess")[0]) < 1e-13


@criteria
def test_without_softening_and_rate_the_stress_is_that_of_perfect_plasticity(
    criterion: type[PerfectlyPlastic],
) -> None:
    changing = pulled(clay(criterion), 1.0, -0.3).array("particle.stress")
    perfect = pulled(criterion(**ELASTIC), 1.0, -0.3).array("particle.stress")
    np.testing.assert_array_equal(changing, perfect)


def test_each_material_has_one_law_and_points_remember_only_what_changes_their_strength() -> None:
    kinds = {(): {}, ("lost_share",): SOFT, ("rate_effect",): HURRIED}
    kinds["lost_share", "rate_effect"] = SOFT | HURRIED
    laws = [LinearElastic(shear_modulus=200.0, poissons_ratio=0.3, density=4.0).law()]
    for criterion in CRITERIA.values():
        laws.append(criterion(**ELASTIC).law())
        assert not laws[-1].remembers
        for state, kind in kinds.items():
            material = clay(criterion, **kind)
            assert material.state == state
            laws.append(material.law())
            assert material.law() == laws[-1]  # no kernel is built twice
    assert len(set(laws)) == len(laws) == 11


def test_where_clay_varies_it_is_clay_of_that_strength_and_stiffness() -> None:
    """It has the properties that uniform clay of the place has."""
    strong = clay(**SOFT | HURRIED)
    material = replace(strong, variation=layers((0, 1, 1), (1, 0.5, 0.25)))
    own = material.properties_at(np.array([[1.0, -1.0]]))[0]
    weak = replace(strong, strength=0.5 * strong.strength, shear_modulus=0.25 * 200.0)
    np.testing.assert_array_equal(own, weak.properties)
    assert material.slope == weak.slope


def test_the_limit_pressure_is_that_of_hurried_intact_clay() -> None:
    greatest = 2.0 * (1.0 + 0.1 * 6.0)
    expected = 4.0 / 3.0 * greatest * (1.0 + math.log(200.0 / greatest))
    assert clay(**SOFT, **HURRIED).limit_pressure == pytest.approx(expected)
