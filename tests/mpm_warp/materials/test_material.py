"""What all materials have in common: elastic constants, and laws that keep their promises."""

from collections.abc import Callable

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic

STRENGTH = 2.5
ELASTIC = {"shear_modulus": 100.0, "poissons_ratio": 0.3, "density": 4.0}
Function = Callable[[Material, Floats], Floats]


def trials(spread: float) -> Floats:
    return np.random.default_rng(1).normal(scale=spread, size=(2000, 4))


@pytest.mark.parametrize("criterion", CRITERIA.values())
def test_returns_keep_pressure_directions_and_what_is_inside(
    returned: Function, criterion: type[PerfectlyPlastic]
) -> None:
    clay = criterion(strength=STRENGTH, **ELASTIC)
    trial = trials(spread=20.0)
    after = returned(clay, trial)
    pressure = trial[:, [0, 1, 3]].sum(axis=1)
    np.testing.assert_allclose(after[:, [0, 1, 3]].sum(axis=1), pressure, atol=1e-12)
    # Same principal directions: the deviators in the plane are parallel.
    cross = (trial[:, 0] - trial[:, 1]) * after[:, 2] - (after[:, 0] - after[:, 1]) * trial[:, 2]
    np.testing.assert_allclose(cross, 0.0, atol=1e-11)
    inside = trials(spread=0.3)
    np.testing.assert_array_equal(returned(clay, inside), inside)


@pytest.mark.parametrize("criterion", CRITERIA.values())
def test_what_is_returned_is_on_the_surface_that_the_law_itself_measures(
    returned: Function, yield_measures: Function, criterion: type[PerfectlyPlastic]
) -> None:
    clay = criterion(strength=STRENGTH, **ELASTIC)
    trial = trials(spread=20.0)
    before, strength = yield_measures(clay, trial).T
    after = yield_measures(clay, returned(clay, trial))[:, 0]
    np.testing.assert_allclose(after, np.minimum(before, strength), rtol=1e-13)


@pytest.mark.parametrize("criterion", CRITERIA.values())
def test_both_criteria_yield_at_the_strength_in_pure_shear(
    yield_measures: Function, criterion: type[PerfectlyPlastic]
) -> None:
    """Under any pressure; at equal normal stresses nothing is borne."""
    clay = criterion(strength=2.0, **ELASTIC)
    stress = np.array([[5.0, 5.0, 2.0, 5.0], [5.0, 5.0, 3.0, 5.0], [1.0, 1.0, 0.0, 1.0]])
    measures = yield_measures(clay, stress)
    np.testing.assert_allclose(measures, [[2.0, 2.0], [3.0, 2.0], [0.0, 2.0]], atol=1e-12)


def test_a_material_that_never_yields_has_no_return(returned: Function) -> None:
    material = LinearElastic(**ELASTIC)
    assert material.law().yield_function is None
    trial = trials(spread=1e6)
    np.testing.assert_array_equal(returned(material, trial), trial)


def test_every_material_has_one_law_of_its_own() -> None:
    materials = [
        LinearElastic(**ELASTIC),
        *(criterion(strength=STRENGTH, **ELASTIC) for criterion in CRITERIA.values()),
    ]
    laws = [it.law() for it in materials]
    assert len(set(laws)) == len(laws)
    assert laws == [it.law() for it in materials]  # no kernel is built twice
    assert not any(law.remembers for law in laws)


def test_wave_speeds_are_those_of_the_elastic_moduli() -> None:
    """E = 2 G (1 + nu); the constrained modulus E (1 - nu) / ((1 + nu) (1 - 2 nu)) is rho cp^2."""
    material = LinearElastic(**ELASTIC)
    youngs = 2.0 * 100.0 * 1.3
    constrained = youngs * 0.7 / (1.3 * 0.4)
    assert material.pressure_wave_speed == pytest.approx((constrained / 4.0) ** 0.5)
    assert material.shear_wave_speed == pytest.approx(5.0)
    assert material.bulk_modulus == pytest.approx(youngs / (3.0 * 0.4))
