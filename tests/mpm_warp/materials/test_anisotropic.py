"""Strength by direction: stress on strain paths, strengths by mode, the isotropic limit."""

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from mpm_warp import ParameterError, SceneError
from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import Material
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.parts.boundaries import RadialMotion
from mpm_warp.scenes.catalogue import scene_class
from mpm_warp.scenes.cavity.exact import cavity_pressure
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import changing_clay, layers
from tests.mpm_warp.materials.conftest import points_on
from tests.mpm_warp.materials.rates import Softening, stress_along

ELASTIC = {"shear_modulus": 200.0, "poissons_ratio": 0.3, "density": 4.0}
STRENGTHS = {
    "strength_compression": 2.0,
    "strength_extension": 1.0,
    "strength_simple_shear": 1.5,
    "strength_horizontal": 1.4,
}
CLAY = Anisotropic(**ELASTIC, **STRENGTHS)
MEASURED = {
    "strength_compression": 20e3,
    "strength_extension": 9e3,
    "strength_simple_shear": 15e3,
    "strength_horizontal": 13e3,
}
SMALL = 0.01
"""Strain of yield, about."""
PATHS = {
    "compression": (3, 0, 0, -6, 3),
    "extension": (-3, 0, 0, 6, -3),
    "shear of horizontal planes": (0, 6, 6, 0, 0),
    "simple shear": (0, 10, 0, 0, 0),
    "simple shear, far": (0, 100, 0, 0, 0),
    "simple shear of vertical planes": (0, 0, 10, 0, 0),
    "pressuremeter": (4, 0, 0, 0, -4),
    "plane strain": (4, 0, 0, -4, 0),
    "mixed, turned one way": (3, 4, -2, -4, 1),
    "mixed, turned the other": (-3, 5, 60, 4, -2),
}


def after(material: Material, gradients: Any, steps: int, start: Any = (0, 0, 0, 0)) -> Simulation:
    """Points at the ends of strain paths."""
    simulation = points_on(gradients, material, steps, start)
    simulation.advance(steps)
    return simulation


def changing(**given: float) -> EinavRandolph:
    """That clay, where its strengths change."""
    whole = {"strength": CLAY.strength, "shape": CLAY.shape}
    return changing_clay(Anisotropic, **ELASTIC, **whole, **given)


def small(name: str) -> tuple[float, ...]:
    return tuple(SMALL * rate for rate in PATHS[name])


@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0, 0.0), (0.6, -0.9, 0.1, 0.5)])
def test_stress_on_strain_paths_is_that_of_the_rate_equations(start: tuple[float, ...]) -> None:
    """Within 1e-6 of su; the return has an error of first order in the step."""
    exact = np.array([stress_along(CLAY, small(name), start=start)[0] for name in PATHS])
    errors = []
    for steps in (10_000, 100_000):
        simulation = after(CLAY, [small(name) for name in PATHS], steps, start)
        errors.append(np.abs(simulation.array("particle.stress") - exact).max(axis=1))
        assert simulation.array("particle.yield_excess").max() < 1e-13
    coarse, fine = np.array(errors) / CLAY.strength
    np.testing.assert_array_less(fine, 1e-6)
    # Proportional paths are exact; the integrator has an error of 1e-9.
    np.testing.assert_array_less(fine - 1e-8, 0.11 * coarse)


def test_stress_of_clay_that_softens_and_has_a_rate_effect_is_that_of_the_rate_equations() -> None:
    soft = Softening(remoulded=0.25, ductility=0.2)
    softens = changing(remoulded_strength_ratio=soft.remoulded, ductility=soft.ductility)
    names = ("compression", "extension", "simple shear", "pressuremeter", "mixed, turned one way")
    exact = np.array([stress_along(CLAY, small(name), softening=soft)[0] for name in names])
    simulation = after(softens, [small(name) for name in names], 100_000)
    error = np.abs(simulation.array("particle.stress") - exact) / CLAY.strength
    np.testing.assert_array_less(error, 1e-6)


def test_softening_in_large_steps_is_that_of_the_plastic_strain() -> None:
    """In steps of 2 % of shear strain, of which Newton's second error is 1e-7 at most."""
    softens = changing(remoulded_strength_ratio=0.25, ductility=2.0)
    for sign, su in ((1.0, 2.0), (-1.0, 1.0)):
        path = sign * np.array([0.5, 0.0, 0.0, -1.0, 0.5]) / math.sqrt(3.0)
        rr, zz, _, _ = after(softens, [path], 50).array("particle.stress")[0]
        half = 0.5 * abs(zz - rr)
        # A second at shear strain rate 1: sqrt(J2) / G of it is elastic.
        plastic = 1.0 - 2.0 / math.sqrt(3.0) * half / 200.0
        expected = su * (0.25 + 0.75 * math.exp(-1.5 * plastic))
        assert half == pytest.approx(expected, rel=1e-7)


def test_rate_raises_all_strengths_alike() -> None:
    hurried = changing(rate_factor=0.1, reference_strain_rate=0.01)
    # Uniaxial strain rate a: shear strain rate sqrt(3) a, three log cycles above the reference.
    rate = 10.0 / math.sqrt(3.0)
    paths = [np.array([0.5, 0, 0, -1, 0.5]) * it * rate for it in (1.0, -1.0)]
    stress = after(hurried, paths, 100).array("particle.stress")
    np.testing.assert_allclose(0.5 * np.ptp(stress[:, [0, 1]], axis=1), [2.6, 1.3], rtol=1e-12)


def test_equal_strengths_are_those_of_von_mises() -> None:
    k = 2.0
    triaxial = math.sqrt(0.75) * k
    equal = Anisotropic(
        **ELASTIC,
        strength_compression=triaxial,
        strength_extension=triaxial,
        strength_simple_shear=k,
    )
    assert equal.strength_horizontal == pytest.approx(k, rel=1e-15)
    gradients = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 5))
    found, expected = (
        after(it, gradients, 1000).array("particle.stress")
        for it in (equal, VonMises(**ELASTIC, strength=k))
    )
    # Rounding of mean stresses of up to 1e3, in a thousand steps.
    np.testing.assert_allclose(found, expected, atol=1e-10)


MODES = ("triaxial_compression", "triaxial_extension", "simple_shear", "pressuremeter")


@pytest.mark.parametrize(("test", "strength"), list(zip(MODES, MEASURED.values(), strict=True)))
def test_strengths_come_out_of_element_tests(test: str, strength: float) -> None:
    result = scene_class("element_test")(
        test=test, material={"law": "anisotropic", **MEASURED}
    ).run()
    assert float(result.strength) == pytest.approx(strength, rel=1e-4)
    assert float(result.strength_exact) == pytest.approx(strength, rel=1e-12)


def test_plane_strain_is_as_strong_as_the_law_says() -> None:
    given = {**MEASURED, "law": "anisotropic", "strength_horizontal": None}
    result = scene_class("element_test")(test="plane_strain", material=given).run()
    assert float(result.error) < 1e-4
    assert float(result.undrained_shear_strength) == 20e3


def test_the_axis_turns_with_the_soil() -> None:
    """A turn by 90 degrees makes compression along z what extension was: the stress turns too."""
    turn = (0.0, math.pi / 2, -math.pi / 2, 0.0, 0.0)
    simulation = after(CLAY, [turn], 1000, (0.6, -0.9, 0.1, 0.5))
    cayley = (math.pi / 2) ** 3 / (12 * 1000**2)
    axis = simulation.array("particle.state")[0]
    np.testing.assert_allclose(axis, [-1.0, 0.0], atol=2 * cayley)
    compression = np.array([[0.5, 0.0, 0.0, -1.0, 0.5]])
    simulation.assign("particle.velocity_gradient", compression)
    simulation.assign("particle.stress", np.zeros((1, 4)))
    simulation.advance(1000)
    rr, zz, _, tt = simulation.array("particle.stress")[0]
    expected = stress_along(CLAY, (-1.0, 0.0, 0.0, 0.5, 0.5))[0]
    np.testing.assert_allclose([zz, rr, tt], expected[[0, 1, 3]], atol=1e-5)


def test_ground_that_varies_has_the_shape_of_its_place() -> None:
    weaker = Anisotropic(**ELASTIC, **{**STRENGTHS, "strength_extension": 0.8})
    ground = layers((0, 0.5, 1), (1, 1, 1), rows=(CLAY, weaker))
    varied = Anisotropic(**ELASTIC, **STRENGTHS, variation=ground)
    G, K, su, *_ = CLAY.properties
    at = varied.properties_at(np.array([[0.0, 0.0], [0.0, -1.0]]))
    np.testing.assert_allclose(at, [[G, K, 0.5 * su, *CLAY.shape], [G, K, su, *weaker.shape]])


@pytest.mark.slow
def test_cylindrical_cavity_has_the_pressure_of_the_horizontal_strength() -> None:
    """Of the integral of the law along the exact strain path, at the finest of its grids."""
    strengths = {name: 10.0 * su for name, su in STRENGTHS.items()} | {"strength_horizontal": 13.0}
    result = scene_class("cavity_cylinder")(
        material={"law": "anisotropic", **strengths}, rigidity_index=50, cells_per_radius=8
    ).run()
    clay = Anisotropic(shear_modulus=1000.0, poissons_ratio=0.4999, density=1.0, **strengths)
    strains = np.geomspace(1e-9, 4.0, 4000)
    path = (-0.5 * strains[-1], 0.0, 0.0, 0.0, 0.5 * strains[-1])
    stress = stress_along(clay, path, strains / strains[-1])
    shear = 0.5 * (stress[:, 3] - stress[:, 0]) / clay.strength
    known = partial(np.interp, xp=strains, fp=shear)
    exact = [
        cavity_pressure(known, strain=gamma, factor=1.0)
        for gamma in 2.0 * np.log(result.expansion.values[-20:])
    ]
    np.testing.assert_allclose(result.cavity_pressure.values[-20:], exact, rtol=5e-3)
    assert exact[-1] == pytest.approx(0.65 * (1.0 + math.log(50.0 / 0.65)), rel=0.1)


@pytest.mark.slow
def test_spherical_cavity_has_the_pressure_of_all_triaxial_paths() -> None:
    """Soil that moves along the rays alone; exact is the mean over their angles to the axis."""
    strengths = {name: 10.0 * su for name, su in STRENGTHS.items()}
    # At Poisson's ratio 0.495 the compressible soil would bear 0.3 % less than the exact one.
    cavity = scene_class("cavity_sphere")(
        material=Anisotropic(**strengths),
        rigidity_index=50,
        poissons_ratio=0.498,
        cells_per_radius=4,
        expansion=2.5,
    )
    built = cavity.build()
    along_rays = replace(built, parts=(RadialMotion(), *built.parts))
    result = cavity.record(Simulation(along_rays), lambda _done: None)
    clay = Anisotropic(shear_modulus=1000.0, poissons_ratio=0.4999, density=1.0, **strengths)
    last = result.cavity_pressure[-30:].mean()  # it swings by 0.5 %
    strain = 3.0 * math.log(float(result.expansion[-30:].mean()))
    strains = np.geomspace(1e-9, strain, 3000)
    exact = 0.0
    for x, weight in zip(*np.polynomial.legendre.leggauss(5), strict=True):
        cosine = 0.5 * (1.0 + x)
        sine = math.sqrt(1.0 - cosine * cosine)
        # For each unit of shear strain: a third of it across the ray, less two thirds along it.
        rr, zz, rz, tt = 1 / 3 - sine**2, 1 / 3 - cosine**2, -sine * cosine, 1 / 3
        path = tuple(strain * it for it in (rr, rz, rz, zz, tt))
        work = stress_along(clay, path, strains / strain) @ np.array([rr, zz, 2.0 * rz, tt])
        known = partial(np.interp, xp=strains, fp=0.75 * work / clay.strength)
        exact += 0.5 * weight * cavity_pressure(known, strain=strain, factor=4.0 / 3.0)
    assert float(last) == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"strength_extension": None}, r"Anisotropic: strength_extension is missing"),
        ({"strength_compression": 0.0}, r"strength_compression = 0 Pa must be > 0"),
        ({"strength_horizontal": -1.0}, r"strength_horizontal = -1 Pa must be > 0"),
        ({"strength_extension": 5.0}, r"strength_extension = 5 Pa must be > 0 and < 5, as"),
        ({"strength_simple_shear": 0.5}, r"strength_extension = 1 Pa must be > 1 and < 3, as"),
    ],
)
def test_strengths_that_are_not_possible_are_refused(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError, match=message):
        Anisotropic(**ELASTIC, **{**STRENGTHS, **changed})


def test_ground_that_yields_before_is_refused() -> None:
    for over_vertical in (-1.99, 3.99):
        CLAY.check_stress_at_rest(np.array([1.0, 0.0, 0.0, 1.0]) * over_vertical)
    for over_vertical, most in ((-2.01, "<= 2 Pa in extension"), (4.01, "<= 4 Pa in compression")):
        with pytest.raises(SceneError, match=f"differ by .* must be {most}"):
            CLAY.check_stress_at_rest(np.array([1.0, 0.0, 0.0, 1.0]) * over_vertical)


def test_a_scene_refuses_strengths_in_a_line() -> None:
    with pytest.raises(ParameterError, match="Anisotropic: strength_compression is missing"):
        scene_class("cone_penetration")(material={"law": "anisotropic", "strength_extension": 9e3})
