"""A law of another package: pressure-dependent stiffness, plastic volume, a state of its own."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mpm_warp import CavityCylinder
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cavity.exact import cavity_pressure
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.simulation import Simulation
from tests.mpm_warp.materials.cam_clay import CamClay

DENSITY = 1700.0


def clay(**changed: float) -> CamClay:
    return CamClay(density=DENSITY, **changed)


def sheared(material: CamClay, gradient: list[float], step_count: int) -> tuple[Floats, Floats]:
    """Shear stress q [Pa] and state of a point at every hundredth of a path from rest."""
    paths = StrainPaths(
        material=material,
        gradient=np.array([gradient]),
        stress=np.zeros((1, 4)),
        step_count=step_count,
    )
    simulation = Simulation(paths)
    q, state = [], []
    for _ in range(100):
        simulation.advance(step_count // 100)
        stress = simulation.array("particle.stress")[0]
        normal = stress[[0, 1, 3]] - stress[[0, 1, 3]].mean()
        q.append(math.sqrt(1.5 * float(normal @ normal) + 3.0 * stress[2] ** 2))
        state.append(simulation.array("particle.state")[0].copy())
    return np.array(q), np.array(state)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 4.0])
def test_the_undrained_triaxial_path_is_that_of_the_closed_form(ratio: float) -> None:
    """p' / p'_y = ((M^2 + eta_y^2) / (M^2 + eta^2))^Lambda, in steps of any size.

    It ends at the critical state: su = M p0' / 2 (R / 2)^Lambda.
    """
    material = clay(overconsolidation_ratio=ratio, critical_state_ratio=1.2)
    M, start = material.critical_state_ratio, material.mean_effective_stress
    q, state = sheared(material, [0.5, 0, 0, -1.0, 0.5], 40_000)
    p = state[:, 0]
    eta_y = M * math.sqrt(ratio - 1.0)
    expected = start * ((M**2 + eta_y**2) / (M**2 + (q / p) ** 2)) ** material.plastic_share
    np.testing.assert_allclose(p, expected, rtol=1e-8)
    assert 0.5 * q[-1] == pytest.approx(material.strength, rel=1e-6)


def test_the_strain_that_a_path_takes_is_of_first_order_in_the_step() -> None:
    """The return is backward Euler: q at a strain of 1 %, halfway to the critical state."""
    material = clay(overconsolidation_ratio=1.0)
    ends = [sheared(material, [5e-3, 0, 0, -1e-2, 5e-3], n)[0][-1] for n in (400, 800, 1600, 3200)]
    changes = np.abs(np.diff(ends))
    orders = np.log2(changes[:-1] / changes[1:])
    np.testing.assert_allclose(orders, 1.0, atol=0.1)
    assert changes[-1] / ends[-1] < 1e-3


def test_stiffness_follows_the_effective_stress() -> None:
    """Elastic shear at R = 4 has q = 3 G e_q, with G = 3 (1 - 2 nu) / 2 (1 + nu) v p' / kappa."""
    for stress in (20e3, 80e3):
        material = clay(overconsolidation_ratio=4.0, mean_effective_stress=stress)
        q, _ = sheared(material, [5e-4, 0, 0, -1e-3, 5e-4], 100)
        stiffness = 0.6 * 2.0 * stress / 0.04  # nu 0.25, v 2, kappa 0.04
        assert q[-1] == pytest.approx(3.0 * stiffness * 1e-3, rel=1e-9)
        assert material.ground_shear_modulus == pytest.approx(stiffness)


def test_the_pressure_in_a_cavity_is_the_integral_of_the_law_along_its_strain_path() -> None:
    """Of total stress, around a cylinder: p - p0 = int tau dgamma / (e^gamma - 1); see ExactCavity.

    The path is that of a soil that keeps its volume; here the water gives by 1 / 100 of G, as much
    as soil with a Poisson's ratio of 0.495, in which the scene is allowed 1.5 %.
    """
    material = clay(overconsolidation_ratio=1.5)
    test = CavityCylinder(cells_per_radius=4, expansion=2.0, rigidity_index=100)
    strength = material.strength
    # The wall moves as fast as in clay of that strength.
    wall = replace(test.wall, speed=test.wall.speed * math.sqrt(strength / 1e3))
    scene = test.build()
    parts = (*test.boundaries(scene.grid, material), wall)
    simulation = Simulation(replace(scene, material=material, parts=parts))
    duration = test.duration(wall)
    simulation.advance_to(0.95 * duration)
    simulation.assign("wall.impulse", 0.0)
    before, radius_before = simulation.time, float(simulation.array("wall.motion")[0, 2])
    simulation.advance_to(duration)
    radius = 0.5 * (radius_before + float(simulation.array("wall.motion")[0, 2]))
    force = simulation.array("wall.impulse").sum() / (simulation.time - before)
    pressure = force / test.wall_area(scene.grid, radius)

    # The curve of shear stress over shear strain, in three pieces: it is steep where it begins.
    end = 2.0 * math.log(2.0)
    strain, tau = np.zeros(1), np.zeros(1)
    for last, step_count in ((1e-3, 1_000), (0.02, 5_000), (1.1, 20_000)):
        half = 0.5 * last * end
        q, _ = sheared(material, [half, 0, 0, 0, -half], step_count)
        reached = last * end * np.arange(1, 101) / 100
        new = reached > strain[-1]
        strain, tau = np.append(strain, reached[new]), np.append(tau, q[new] / math.sqrt(3.0))
    expected = cavity_pressure(
        lambda gamma: np.interp(gamma, strain, tau), strain=2.0 * math.log(radius), factor=1.0
    )
    assert pressure == pytest.approx(expected, rel=0.015)
