"""Strain paths against the closed forms of their stress."""

import math

import numpy as np
import pytest

from mpm_warp import Simulation, SimulationDiverged
from mpm_warp.scenes.material.material_point import CHANGING, MaterialPoint
from mpm_warp.scenes.material.strain_paths import PATH_COUNT, known_paths
from tests.mpm_warp.scenes.conftest import order_and_errors

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("material", ["tresca", "von_mises"])
def test_stress_on_strain_paths(material: str) -> None:
    """Some start in pure shear, where clay of von Mises bears more than in a triaxial test."""
    steps = 1000
    result = MaterialPoint(material=material, step_count=steps).run()
    # Cayley's angle of a step t is 2 atan(t/2), short by t^3/12; the circle of the stress that is
    # turned has the radius su/2 and is passed at twice the angle.
    assert float(result.error) <= (2 * math.pi) ** 3 / (12 * steps**2)
    assert float(result.yield_excess) <= 1e-9


def test_rotation_is_of_second_order() -> None:
    order, *_ = order_and_errors(MaterialPoint, "step_count", 500)
    assert order == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("rigidity_index", [2, 50, 500])
@pytest.mark.parametrize("poissons_ratio", [0.0, 0.3, 0.499])
def test_stress_whatever_the_stiffness(rigidity_index: float, poissons_ratio: float) -> None:
    result = MaterialPoint(rigidity_index=rigidity_index, poissons_ratio=poissons_ratio).run()
    assert float(result.error) <= 1e-6
    assert float(result.yield_excess) <= 1e-9


@pytest.mark.parametrize("material", ["tresca", "von_mises"])
@pytest.mark.parametrize("changed", [{}, {"ductility": 20.0}, {"rate_factor": 0.0}])
def test_stress_of_clay_that_changes_its_strength(material: str, changed: dict[str, float]) -> None:
    """The error is that of the turn, as in clay that does not: the law itself is followed."""
    steps = 1000
    result = MaterialPoint(material=material, step_count=steps, **{**CHANGING, **changed}).run()
    assert float(result.error) <= (2 * math.pi) ** 3 / (12 * steps**2)
    difference = np.abs(result.stress - result.stress_exact).max("component")
    turned = difference.path.str.contains("turn by|simple shear")
    assert float(difference.where(~turned).max()) <= 1e-9
    assert float(result.yield_excess) <= 1e-9


def test_the_number_of_paths_is_known_before_they_are() -> None:
    assert len(known_paths(MaterialPoint().soil)) == PATH_COUNT


def test_a_stress_that_is_not_finite_ends_the_run() -> None:
    simulation = Simulation(MaterialPoint(step_count=10).build())
    simulation.array("particle.stress")[3, 1] = np.nan
    simulation.advance(10)
    with pytest.raises(SimulationDiverged, match="the stress of path 3 is not finite"):
        simulation.check()
