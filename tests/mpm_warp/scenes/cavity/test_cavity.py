"""Cavity expansion: the closed form, the grid that follows the wall, and the two together."""

import math
from typing import Any

import numpy as np
import pytest

from mpm_warp import InaccurateRun, ParameterError, RadialMotion, Simulation
from mpm_warp.scenes.cavity.shapes import CavityCylinder, CavitySphere

pytestmark = pytest.mark.slow

RADII = np.array([1.01, 1.05, 1.1, 1.2, 1.5, 2.0, 4.0])


@pytest.mark.parametrize(
    ("rigidity_index", "pressures"),
    [
        (100.0, [1.681, 3.232, 3.856, 4.422, 5.020, 5.320, 5.543]),
        (500.0, [3.288, 4.840, 5.464, 6.029, 6.627, 6.927, 7.151]),
    ],
)
def test_closed_form_has_tabulated_values(rigidity_index: float, pressures: list[float]) -> None:
    computed = CavityCylinder(rigidity_index=rigidity_index).exact.pressure(RADII)
    np.testing.assert_allclose(computed, pressures, atol=5e-4)  # given to three decimals


CELLS = 4
"""Cells per radius at the wall; they widen by half of that share of the distance from it."""


@pytest.mark.parametrize(
    ("rigidity_index", "material"), [(50.0, "tresca"), (100.0, "tresca"), (50.0, "von_mises")]
)
def test_a_cylinder_follows_the_closed_form(rigidity_index: float, material: str) -> None:
    """Expanded fourfold."""
    result = CavityCylinder(
        rigidity_index=rigidity_index, material=material, cells_per_radius=CELLS
    ).run()
    # Beside the wall the stress falls by 2 su per radius: that of half a cell, over the limit.
    half_cell, logarithm = 2.0 / (2 * CELLS), math.log(rigidity_index)
    assert float(result["error"]) <= half_cell / (1.0 + logarithm)
    # At the end the cavity is four times as wide, and the half cell with it a quarter as much.
    last = float(result["cavity_pressure"][-1] - result["cavity_pressure_exact"][-1])
    assert abs(last) <= half_cell / 4.0
    # The pore pressure falls by 2 su per ln r; a cell has at most the share 1 / (2 n) of its r.
    assert float(result.pore_pressure_error) <= 0.5 * half_cell / logarithm


def test_a_sphere_follows_the_closed_form() -> None:
    """Expanded twofold; the soil's compressibility lowers the limit by 0.018."""
    result = CavitySphere(cells_per_radius=CELLS, rigidity_index=50.0, expansion=2.0).run()
    limit = 4 / 3 * (1 + math.log(50.0))
    # The wall cell stands for the soil half a cell away: 4 su times the strain over it.
    assert float(result.error) <= (0.018 + 4 / (2 * CELLS) / 4) / limit
    assert float(result.departure) <= 1 / CELLS**2
    # The pore pressure falls by 4 su per ln r.
    half_cell = 4.0 / (2 * 2 * CELLS)
    assert float(result.pore_pressure_error) <= (half_cell + 0.018) / (4 / 3 * math.log(50.0))


def test_pore_pressure_is_that_of_the_exact_stress_around_a_cavity() -> None:
    """In equilibrium the mean stress is p + r/m dp/dr, p being the radial one."""
    for scene in (CavityCylinder(expansion=2.0), CavitySphere(expansion=2.0)):
        m, r = scene.exponent, np.linspace(1.0, 20.0, 40_001)
        local = r / (r**m - 1.0 + 2.0**-m) ** (1.0 / m)
        radial = scene.exact.pressure(local)
        mean = radial + r / m * np.gradient(radial, r)
        computed = scene.exact.pore_pressure(r, expansion=2.0) / 1e3
        # Of second order in the steps, but for the jump of the slope at the yield surface.
        assert np.median(np.abs(computed - mean)) < 1e-6
        assert np.abs(computed - mean)[1:-1].max() < 2e-3


@pytest.mark.parametrize("anisotropy", [-0.4, 0.4])
def test_pressure_of_a_cylinder_is_the_same_whatever_the_vertical_stress(anisotropy: float) -> None:
    """While that stays between the others: p - sigma_h0 = su (1 + ln Ir) in the limit."""
    small = {"cells_per_radius": 2, "rigidity_index": 20.0, "expansion": 2.0}
    expected = CavityCylinder(**small).run()
    result = CavityCylinder(**small, stress_anisotropy=anisotropy).run()
    for curve in ("cavity_pressure", "excess_pore_pressure"):
        rounding = 1e-9 * float(np.abs(expected[curve]).max())
        np.testing.assert_allclose(result[curve], expected[curve], rtol=0.0, atol=rounding)


def test_around_a_sphere_von_mises_yields_at_less_than_tresca() -> None:
    """As soil of Tresca with sqrt(3)/2 of the strength, and of that rigidity index."""
    von_mises = CavitySphere(rigidity_index=100.0, material="von_mises").exact.pressure(RADII)
    weaker = CavitySphere(rigidity_index=100.0 / math.sqrt(0.75)).exact.pressure(RADII)
    np.testing.assert_allclose(von_mises, math.sqrt(0.75) * weaker, rtol=1e-12)


def test_a_cavity_expanded_by_a_few_steps_has_a_sample_a_step() -> None:
    hasty = CavityCylinder(
        expansion=1.1, cells_per_radius=1, rigidity_index=10, poissons_ratio=0.4, speed_ratio=0.3
    )
    with pytest.raises(InaccurateRun, match="try more cells_per_radius") as end:
        hasty.run()
    result = end.value.curves
    assert result.sizes["expansion"] == int(result.step_count)
    assert np.isfinite(result.cavity_pressure).all()


SOFT = {"remoulded_strength_ratio": 0.2, "ductility": 1.0}
HURRIED = {"rate_factor": 0.1, "reference_strain_rate": 0.01}


def test_pressure_in_clay_that_softens_follows_the_integral_the_finer_the_better() -> None:
    """The strength falls fivefold within the first cells: the worst of usual ductilities."""
    errors = [float(CavityCylinder(cells_per_radius=n, **SOFT).run()["error"]) for n in (4, 8)]
    assert errors[1] <= 0.01
    # Of first order in the cells beside the wall, or better.
    assert math.log2(errors[0] / errors[1]) >= 1.0


def test_pressure_around_a_sphere_in_clay_that_softens_follows_the_integral() -> None:
    """Once the waves of the start have gone; soil that is free to part from the rays bears less."""
    result = CavitySphere(cells_per_radius=CELLS, expansion=2.0, **SOFT).run()
    late = result.cavity_pressure[result.expansion > 1.5]
    # Compressibility lowers it by 0.018, the end of the grid by 0.006, and the wall cell stands for
    # the soil half a cell away, where the stress has fallen by 4 times the remoulded strength.
    expected = 0.018 + 0.006 + 4 * 0.2 / (2 * CELLS) / 1.5
    assert abs(float((late - result.cavity_pressure_exact).mean())) <= expected


@pytest.mark.parametrize("material", ["tresca", "von_mises"])
def test_a_sphere_in_clay_that_softens_stays_round(material: str) -> None:
    """Points that began at the same distance have lost the same, to second order in the angle."""
    cavity = CavitySphere(cells_per_radius=3, expansion=1.5, material=material, **SOFT)
    scene = cavity.build()
    simulation = Simulation(scene)
    simulation.advance_to(cavity.end_time)
    lost = simulation.array("particle.state")[:, 0].reshape(2 * scene.grid.row_count, -1)
    turn = 0.5 * math.pi / scene.grid.row_count
    assert float(lost.max()) > 0.9
    assert float(np.ptp(lost, axis=0).max()) <= turn**2


def test_soil_is_guided_along_rays_where_it_softens_alone() -> None:
    for changing, is_guided in (({}, False), (HURRIED, False), (SOFT, True)):
        assert (CavitySphere(**changing).build().find(RadialMotion) is not None) is is_guided


def test_pressure_in_clay_with_a_rate_effect_follows_the_integral() -> None:
    """Of which the pressure of clay at the reference rate is 6 % off."""
    result = CavityCylinder(cells_per_radius=4, **HURRIED).run()
    assert float(result["error"]) <= 0.01
    assert float(result.pore_pressure_error) <= 0.02


@pytest.mark.parametrize("changing", [SOFT, HURRIED], ids=["softening", "rate"])
@pytest.mark.parametrize("scene", [CavityCylinder, CavitySphere])
def test_pore_pressure_is_that_of_the_exact_stress_where_the_strength_changes(
    scene: type[CavityCylinder | CavitySphere], changing: dict[str, float]
) -> None:
    """The mean stress has no resultant: over m r^(m-1) dr it adds up to that at the wall.

    From m (p - mean) = -r dp/dr: d(r^m p)/dr = m r^(m-1) mean.
    """
    cavity = scene(expansion=2.0, **changing)
    m, far = cavity.exponent, 30.0
    r = np.geomspace(1.0, far, 201)
    mean = cavity.exact.pore_pressure(r, expansion=2.0)
    added_up = float(np.trapezoid(mean * m * r ** (m - 1), r))
    at_wall = 1e3 * float(cavity.exact.pressure(np.array([2.0]))[0])
    # Far away the soil is elastic: p = k G (1 - (a0/a)^m) (a/r)^m.
    beyond = cavity.exact.factor * 1e5 * (1.0 - 2.0**-m)
    assert at_wall + added_up == pytest.approx(beyond, rel=1e-3)


def test_halving_the_speed_of_the_run_leaves_the_effect_of_the_rate() -> None:
    """Strain rates are those of the real expansion: what is left is the inertia of the soil."""
    small = {"cells_per_radius": 2, "rigidity_index": 20.0, "expansion": 2.0, **HURRIED}
    fast, slow = (CavityCylinder(speed_ratio=it, **small).run() for it in (0.03, 0.015))
    at = np.linspace(1.1, 1.9, 99)
    means = [np.interp(at, it.expansion, it.cavity_pressure).mean() for it in (fast, slow)]
    # rho V^2 / su is 1e-3; mu log10(2) of the strength would be 2.5 % of the pressure.
    assert means[0] == pytest.approx(means[1], rel=0.005)


@pytest.mark.parametrize("changed", [SOFT, {"material": "von_mises"}])
def test_the_vertical_stress_counts_in_other_clay(changed: dict[str, Any]) -> None:
    told = rf"stress_anisotropy = 0\.2 is not allowed: must be 0 where {next(iter(changed))}"
    with pytest.raises(ParameterError, match=told):
        CavityCylinder(stress_anisotropy=0.2, **changed)
