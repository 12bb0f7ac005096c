"""The independent method: its exact solutions, on coarse meshes, and one cone."""

import sys

import numpy as np
import pytest

from mpm_warp import ConePenetration
from tests.conftest import finished
from tests.independent.clay import Array, Clay
from tests.independent.cone import Cone
from tests.independent.elements import Elements
from tests.independent.flow import Boundary, Flow
from tests.independent.verify import CHECKS


@pytest.mark.slow
@pytest.mark.parametrize("name", CHECKS)
def test_the_error_of_an_exact_solution_has_its_order(name: str) -> None:
    coarse, fine = (it - CHECKS[name].exact for it in CHECKS[name].pair())
    assert np.log2(coarse / fine) == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_normals_at_the_shoulder_bracket_the_cone_factor_of_the_simulation() -> None:
    found = [Cone(shoulder=it).factors() for it in ("face", "mean", "shaft")]
    (face, _), (mean, before), (shaft, _) = found
    result = ConePenetration(rigidity_index=100, adhesion_factor=0, poissons_ratio=0.49).run()
    factor, error = float(result.cone_factor), float(result.cone_factor_uncertainty)
    assert shaft < factor - error < factor + error < face
    # One normal of the two has an error of first order in the elements, their mean of second.
    second = Cone().element * (face - shaft) / 2.0
    assert mean == pytest.approx(factor, abs=second + error)
    assert mean == pytest.approx(before, abs=second)  # it is steady


@pytest.mark.parametrize("criterion", ["tresca", "von_mises"])
def test_tangent_is_the_derivative_of_the_stress(criterion: str) -> None:
    clay = Clay(criterion=criterion)
    trial = np.random.default_rng(0).normal(scale=3.0, size=(1000, 4))
    size = 1e-7
    steps = size * np.eye(4) @ clay.stiffness
    change = [clay.respond(trial + it)[0] - clay.respond(trial - it)[0] for it in steps]
    _, tangent = clay.respond(trial)
    # Differences of stresses of some 10 su have an error by rounding of 1e-14 over the size.
    np.testing.assert_allclose(np.stack(change, -1) / (2.0 * size), tangent, atol=1e-6)


def test_stress_turns_with_the_soil() -> None:
    def elastic(place: Array) -> Array:
        return np.tile([0.2, -0.3, 0.1, 0.4], (*place.shape[:-1], 1))

    mesh = Elements(np.stack(np.meshgrid(np.linspace(1.0, 2.0, 5), np.linspace(0.0, 1.0, 5)), -1))
    velocity = np.stack([-mesh.x[:, 1], mesh.x[:, 0]], axis=1)  # from r to z by 1 in a unit of time
    flow = Flow(mesh, Clay(), Boundary(len(mesh.x)), velocity, velocity, elastic)
    rr, zz, rz, tt = np.moveaxis(flow._carried(0.3), -1, 0)
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    expected = turn @ [[0.2, 0.1], [0.1, -0.3]] @ turn.T
    for component, place in ((rr, (0, 0)), (zz, (1, 1)), (rz, (0, 1))):
        np.testing.assert_allclose(component, expected[place], rtol=1e-12)
    np.testing.assert_allclose(tt, 0.4, rtol=1e-12)


def test_it_shares_no_code_with_the_simulator() -> None:
    code = "import sys, tests.independent.cone, tests.independent.verify; print(*sys.modules)"
    loaded = finished([sys.executable, "-c", code]).stdout.split()
    assert "tests.independent.flow" in loaded
    assert not [it for it in loaded if it.partition(".")[0] in {"mpm_warp", "harness", "warp"}]
