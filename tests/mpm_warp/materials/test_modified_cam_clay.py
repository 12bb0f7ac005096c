"""Modified Cam clay: closed forms, an independent integrator, and clays at random."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
import scipy

from mpm_warp import ElementTest, ModifiedCamClay, ParameterError, SceneError, Simulation
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.clay_law import own_parameters
from mpm_warp.materials.modified_cam_clay import FLOOR, MATSUOKA_NAKAI
from mpm_warp.materials.yield_check import YIELD_ROUNDINGS
from mpm_warp.scenes.material.element_test import TESTS
from mpm_warp.scenes.material.strain_paths import StrainPaths
from tests.mpm_warp.conftest import greatest_shear, refused
from tests.mpm_warp.materials.conftest import KAPPA, LAMBDA, SHARE, STRESS, V, cam_clay, points_on
from tests.mpm_warp.materials.rates import integrated

OWN = own_parameters(ModifiedCamClay).keys()


def element(test: str, ratio: float = 1.0, **changed: Any) -> Any:
    own = {it: changed.pop(it) for it in OWN & changed.keys()}
    law = ModifiedCamClay(**{"isotropic_overconsolidation_ratio": ratio} | own)
    return ElementTest(material=law, test=test, **changed).run()


def ends(material: ModifiedCamClay, gradient: Floats, steps: int) -> tuple[Floats, Floats, Floats]:
    """Stress, state and excess over the yield surface at the ends of paths, [path_count, ...]."""
    simulation = points_on(gradient, material, steps)
    simulation.advance(steps)
    names = ("stress", "state", "yield_excess")
    stress, state, excess = (simulation.array(f"particle.{it}").copy() for it in names)
    return stress, state, excess


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("ratio", [1.0, 1.5, 4.0, 20.0])
def test_the_undrained_path_is_that_of_the_closed_form(ratio: float, test: str) -> None:
    """Of p', of the pore pressure that shear makes, and of su where it ends."""
    M = 1.2
    result = element(test, ratio, critical_state_ratio=M)
    p, q = result.effective_mean_stress.values, result.deviator_stress.values
    eta_y = M * math.sqrt(ratio - 1.0)
    expected = STRESS * ((M**2 + eta_y**2) / (M**2 + (q / p) ** 2)) ** SHARE
    expected = np.where(q > eta_y * STRESS * (1.0 + 1e-9), expected, STRESS)
    np.testing.assert_allclose(p, expected, rtol=1e-6)
    np.testing.assert_allclose(
        result.excess_pore_pressure.values, STRESS - expected, atol=1e-6 * STRESS * ratio
    )
    su = 0.5 * M * STRESS * (0.5 * ratio) ** SHARE
    by_mode = 1.0 if test.startswith("triaxial") else 2.0 / math.sqrt(3.0)
    assert float(result.strength) == pytest.approx(by_mode * su, rel=1e-5)
    assert float(result.strength_exact) == pytest.approx(by_mode * su, rel=1e-12)


@pytest.mark.parametrize("start", [0.0, 0.35])
def test_the_strain_along_a_path_is_of_first_order(start: float) -> None:
    """Against rate equations integrated by scipy, at a shear strain of 1 % or 2 %.

    Plane strain from a K0 start is no proportional path: the deviator turns.
    """
    material = cam_clay(1.3)
    q = 2.0 * start * material.undrained_strength("simple_shear")
    direction, deviator = np.array([-0.5, 0.0, 0.5]), np.array([-q / 3, -q / 3, 2.0 * q / 3.0])
    strain = 0.02
    exact = integrated(material, direction, strain, deviator=deviator)(strain)
    errors = []
    for steps in (100, 200, 400, 800):
        given = {"greatest_shear_strain": strain, "stress_anisotropy": start, "step_count": steps}
        result = element("plane_strain", 1.3, **given)
        p = float(result.effective_mean_stress[-1])
        s = float(result.deviator_stress[-1])
        expected = math.sqrt(1.5 * float(exact[:3] @ exact[:3]))
        errors.append([p / exact[3] - 1.0, s / expected - 1.0])
    orders = np.log2(np.abs(np.array(errors[:-1])) / np.abs(np.array(errors[1:])))
    np.testing.assert_allclose(orders, 1.0, atol=0.1)
    assert np.abs(errors[-1]).max() < 1e-3


def test_the_shear_modulus_at_half_of_the_strength_is_that_of_the_rates() -> None:
    """Half of su over the strain at which it is reached; samples are 6 % of the strain apart."""
    material = cam_clay()
    path = integrated(material, np.array([-0.5, 0.0, 0.5]), 0.1, deviator=np.zeros(3))
    half = 0.5 * material.undrained_strength("plane_strain")
    strain = scipy.optimize.brentq(lambda it: 0.5 * (path(it)[2] - path(it)[0]) - half, 1e-4, 0.1)
    result = element("plane_strain")
    assert float(result.half_strength_shear_modulus) == pytest.approx(half / strain, rel=2e-3)
    first = float(result.small_strain_shear_modulus)
    assert first == pytest.approx(material.ground_shear_modulus, rel=1e-3)
    given = element("simple_shear", 4.0, effective_shear_modulus=2e6)
    assert float(given.small_strain_shear_modulus) == pytest.approx(2e6, rel=1e-9)
    assert float(given.error) < 1e-6


def test_a_long_step_is_taken_in_parts() -> None:
    """Two steps to a shear strain of 5 %: q within 1 %, of which one part a step misses 3.4 %."""
    for ratio in (1.0, 1.5, 4.0):
        coarse, fine = (
            float(element("simple_shear", ratio, greatest_shear_strain=0.05, step_count=n).strength)
            for n in (2, 10_000)
        )
        assert coarse == pytest.approx(fine, rel=0.01)


@pytest.mark.parametrize("test", TESTS)
def test_at_critical_state_from_the_start_it_is_von_mises(test: str) -> None:
    """R = 2: with the same su and G the curves are the same."""
    result = element(test, 2.0)
    su = STRESS / math.sqrt(3.0)
    index = 0.6 * V * STRESS / KAPPA / su
    same = ElementTest(
        material="von_mises", test=test, undrained_shear_strength=su, rigidity_index=index
    ).run()
    np.testing.assert_allclose(result.shear_stress, same.shear_stress, rtol=1e-9)


def test_drained_compression_follows_the_kappa_and_the_lambda_line() -> None:
    """ln p' over volume strain: v / kappa below p_c, v / lambda beyond it, v / kappa back."""
    R, swell, compress = 4.0, V / KAPPA, V / LAMBDA
    until = math.log(R) / swell
    for e_v, expected, size in (
        (0.5 * until, math.exp(swell * 0.5 * until), R),
        (until + 0.1, R * math.exp(compress * 0.1), R * math.exp(compress * 0.1)),
        (-0.05, math.exp(-swell * 0.05), R),
    ):
        gradient = np.array([[-e_v / 3.0, 0.0, 0.0, -e_v / 3.0, -e_v / 3.0]])
        _, state, _ = ends(cam_clay(R), gradient, 100)
        np.testing.assert_allclose(state[0, :2], [STRESS * expected, STRESS * size], rtol=1e-9)


def test_the_pore_water_bears_what_the_skeleton_does_not() -> None:
    """Total mean stress = p' + u, du = K_w / n de_v; K at the stiffest end has the given nu."""
    for ratio in (1.0, 8.0):
        material = cam_clay(ratio, poissons_ratio=0.495)
        e_v = 1e-4
        gradient = np.array([[-e_v, 0.0, 0.0, 0.0, 0.0]])
        stress, state, _ = ends(material, gradient, 10)
        mean = -stress[0, [0, 1, 3]].mean()
        assert state[0, 2] == pytest.approx(material.water_modulus * e_v, rel=1e-12)
        assert mean == pytest.approx(state[0, 0] - STRESS + state[0, 2], rel=1e-9)
        end = max(STRESS, STRESS * (0.5 * ratio) ** SHARE)
        G, K = 0.6 * V * end / KAPPA, V * end / KAPPA + material.water_modulus
        nu = (3 * K - 2 * G) / (2 * (3 * K + G))
        assert nu == pytest.approx(0.495, rel=1e-12)
        assert material.pressure_wave_speed > math.sqrt((K + 4.0 / 3.0 * G) / 1700.0)


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("M", [0.4, 1.0, 1.6])
def test_by_the_lode_angle_every_direction_has_one_friction_angle(M: float, test: str) -> None:
    """Matsuoka & Nakai: I1 I2 / I3 = 9 + 8 tan^2 phi, sin phi = 3 M / (6 + M), at the end."""
    shape: dict[str, Any] = {"critical_state_ratio": M, "critical_state_shape": MATSUOKA_NAKAI}
    scene = ElementTest(material={"law": "modified_cam_clay", **shape}, test=test)
    simulation = Simulation(scene.build())
    simulation.advance(scene.step_count)
    rr, zz, rz, tt = simulation.array("particle.stress")[0]
    mean, p = (rr + zz + tt) / 3.0, float(simulation.array("particle.state")[0, 0])
    tensor = np.array([[rr, rz, 0.0], [rz, zz, 0.0], [0.0, 0.0, tt]]) - mean * np.eye(3)
    s = np.linalg.eigvalsh(p * np.eye(3) - tensor)
    invariants = s.sum(), s[0] * s[1] + s[1] * s[2] + s[2] * s[0], s.prod()
    sine = 3.0 * M / (6.0 + M)
    expected = 9.0 + 8.0 * sine**2 / (1.0 - sine**2)
    assert invariants[0] * invariants[1] / invariants[2] == pytest.approx(expected, rel=1e-6)
    half = 0.5 * (s[2] - s[0])
    assert scene.soil.undrained_strength(test) == pytest.approx(half, rel=1e-5)
    if test == "triaxial_extension":
        assert 2.0 * half / p == pytest.approx(6.0 * sine / (3.0 + sine), rel=1e-6)


def test_random_clays_end_at_their_critical_states() -> None:
    """OCR 1 to 50, M 0.4 to 1.6, p0' 1 Pa to 10 MPa: no stress leaves the yield surface."""
    random = np.random.default_rng(7)
    gradients = np.array(list(TESTS.values()))
    for _ in range(100):
        kappa = random.uniform(0.005, 0.1)
        material = cam_clay(
            ratio=float(np.exp(random.uniform(0.0, math.log(50.0)))),
            critical_state_ratio=random.uniform(0.4, 1.6),
            swelling_slope=kappa,
            compression_slope=kappa * random.uniform(1.2, 10.0),
            specific_volume=random.uniform(1.3, 4.0),
            mean_effective_stress=float(10.0 ** random.uniform(0.0, 7.0)),
            effective_poissons_ratio=random.uniform(0.0, 0.4),
            critical_state_shape=str(random.choice(["circle", MATSUOKA_NAKAI])),
        )
        strain = 60.0 * material.strength / material.ground_shear_modulus + 3.0
        stress, state, excess = ends(material, strain * gradients, 2000)
        greatest = np.array([material.undrained_strength(test) for test in TESTS])
        np.testing.assert_allclose(greatest_shear(stress), greatest, rtol=1e-3)
        np.testing.assert_allclose(state[:, 1], 2.0 * state[:, 0], rtol=1e-2)
        assert excess.max() < 1e-9


def test_brittle_clay_keeps_the_direction_of_its_deviator() -> None:
    """In two steps to 1 to 12 times the strain of its strength: what is compressed stays so."""
    slopes = {"swelling_slope": 0.01, "compression_slope": 0.014, "specific_volume": 1.5}
    material = cam_clay(8.0, critical_state_ratio=1.5, **slopes)
    strain = material.strength / material.ground_shear_modulus * np.linspace(1.0, 12.0, 400)
    compression = np.array([TESTS["triaxial_compression"]])
    stress, state, _ = ends(material, strain[:, None] * compression, 2)
    assert (stress[:, 1] < stress[:, 0]).all()
    expected = STRESS * (8.0 * state[:, 0] / state[:, 1]) ** (1.0 - 0.01 / 0.014)
    np.testing.assert_allclose(state[:, 0], expected, rtol=1e-6)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 50.0])
def test_no_strain_takes_it_out_of_its_yield_surface(ratio: float) -> None:
    """Random strains, with volume: dry, wet, at the tip, and where p' comes to its floor."""
    gradient = np.random.default_rng(1).uniform(-0.3, 0.3, (300, 5))
    gradient[:100] *= 10.0
    tip = np.array([[-0.2, 0.0, 0.0, -0.2, -0.2], [1.0, 0.0, 0.0, 1.0, 1.0]])
    for M in (0.4, 1.6):
        material = cam_clay(ratio, critical_state_ratio=M)
        stress, state, excess = ends(material, np.concatenate([gradient, tip]), 200)
        assert np.isfinite(stress).all()
        assert (state[:, 0] >= FLOOR * STRESS).all()
        assert state[-1, 0] == FLOOR * STRESS
        # Total stress with its pore pressure has roundings that count where p_c is small.
        rounding = 64.0 * np.finfo(float).eps * np.abs(stress).max(axis=1) / state[:, 1]
        assert (excess < 1e-9 + rounding).all()


def test_strain_of_rounding_size_leaves_it_within_what_the_watch_allows() -> None:
    """At the tip of the ellipse, where all of normally consolidated soil is at the start."""
    random = np.random.default_rng(1)
    gradient = 10.0 ** random.uniform(-17.0, -9.0, (300, 1)) * random.uniform(-1.0, 1.0, (300, 5))
    _, _, excess = ends(cam_clay(), gradient, 50)
    assert (excess <= YIELD_ROUNDINGS * np.finfo(float).eps).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"critical_state_ratio": 0.0}, "critical_state_ratio = 0"),
        ({"compression_slope": 0.04}, "compression_slope = 0.04 must be > swelling_slope = 0.04"),
        ({"isotropic_overconsolidation_ratio": 0.9}, "isotropic_overconsolidation_ratio = 0.9"),
        ({"poissons_ratio": 0.2}, "poissons_ratio = 0.2 of the undrained clay is too small"),
        ({"rate_factor": 0.1}, "has a strength, update or state of its own"),
        ({"stress_anisotropy": 0.6}, "the stress of the ground is outside the yield"),
        ({"stress_anisotropy": -0.6}, "the stress of the ground is outside the yield"),
    ],
)
def test_parameters_of_no_clay_are_refused(changed: dict[str, float], message: str) -> None:
    given = {"material": "modified_cam_clay"}
    given |= {f"material.{it}" if it in OWN else it: value for it, value in changed.items()}
    refused(partial(ElementTest.of, given), ParameterError, message)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"critical_state_ratio": 0.0}, "critical_state_ratio = 0.0 is not allowed: must be"),
        ({"ratio": 0.9}, "isotropic_overconsolidation_ratio = 0.9 is not allowed: must be"),
        ({"critical_state_shape": "cirle"}, "did you mean 'circle'"),
        ({"ratio": 2.0, "vertical_overconsolidation_ratio": 2.0}, "keep one of them"),
        ({"earth_pressure_at_rest": 0.5}, "must be >= 1.562: the stress of the ground is outside"),
    ],
)
def test_a_law_made_by_hand_is_checked_too(changed: dict[str, Any], message: str) -> None:
    refused(partial(cam_clay, **changed), SceneError, message)
    refused(partial(cam_clay, **changed), SceneError, "ModifiedCamClay: ")


def test_a_strain_path_outside_the_yield_surface_is_refused() -> None:
    """Of whoever builds the path by hand too, with no scene that looks at its parameters."""
    stress = np.array([[STRESS, -STRESS, 0.0, 0.0]])
    with pytest.raises(SceneError, match="the stress of the ground is outside the yield surface"):
        StrainPaths(material=cam_clay(), gradient=np.zeros((1, 5)), stress=stress, step_count=1)
