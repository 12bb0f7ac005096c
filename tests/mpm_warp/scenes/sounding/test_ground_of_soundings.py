"""What the ground of a sounding may have: softening, adhesion and stress by depth."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import ParameterError, Simulation, SurfaceContact, SurroundingGround
from mpm_warp.grid.fitted import Floats
from mpm_warp.sampling import excess_pore_pressure, soil_scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from tests.mpm_warp.conftest import SMALL_WINDOW
from tests.mpm_warp.scenes.sounding.conftest import after_a_step, changed

pytestmark = pytest.mark.slow

SOFT = {
    "remoulded_strength_ratio": 0.2,
    "ductility": 10.0,
    "rate_factor": 0.1,
    "reference_strain_rate": 1e-4,
}


UNIFORM_DELTA = "depth [m], strength [kPa], stress_anisotropy [1]; 0, 20, 0.3; 30, 20, 0.3"
UNIFORM_ADHESION = "depth [m], strength [kPa], adhesion_factor [1]; 0, 20, 0.5; 30, 20, 0.5"


@pytest.mark.parametrize(
    ("of_sounding", "of_cone"),
    [
        (SOFT, SOFT),
        ({"stress_anisotropy": 0.3}, {"stress_anisotropy": 0.3}),
        ({"profile": UNIFORM_DELTA}, {"stress_anisotropy": 0.3}),
        ({"profile": UNIFORM_ADHESION, "adhesion_factor": 0.0}, {"adhesion_factor": 0.5}),
    ],
)
def test_uniform_clay_is_that_of_the_cone(
    of_sounding: dict[str, float | str], of_cone: dict[str, float]
) -> None:
    """To the bit, by the forces of a cone test that goes as far, without an approach."""
    sounding = changed(to_depth=12.2, **of_sounding)
    small = {**SMALL_WINDOW, "domain_below": 4, "cone_radius": 1.0, "cells_per_radius": 1.5}
    small |= {"approach": 0.0, "steady_tolerance": 0.0, "speed_ratio": 0.2}
    vertical = 17e3 * sounding.start_depth
    test = ConePenetration(**small, in_situ_stress=vertical, **{"adhesion_factor": 0.5, **of_cone})
    runs = [Simulation(it.build()) for it in (sounding, test)]
    for run in runs:
        run.travel_to(2.0)
    assert runs[0].plan.arrays.keys() == runs[1].plan.arrays.keys()
    for name in ("contact.impulse", "particle.stress"):
        np.testing.assert_array_equal(runs[0].array(name), runs[1].array(name))


IN_SITU = (
    "depth [m], strength [kPa], shear_modulus [kPa], stress_anisotropy [1]; 0, 20, 2000, -0.4; "
    "13, 20, 2000, -0.4; 13, 30, 4000, 0.5; 40, 30, 4000, 0.5"
)


def test_ground_under_stress_by_depth_is_at_rest_where_nothing_moves() -> None:
    """At the first step no node is pulled but those beside the body, and at the side of the border.

    A cell there that the border cuts has the mean stress, and each node holds that of its depth.
    """
    scene = changed(profile=IN_SITU).build()
    undisturbed = dataclasses.replace(scene[SurroundingGround], from_afar=False)
    simulation, speeds, free = after_a_step(scene.with_parts(undisturbed), 30e3)
    scene = soil_scene(simulation)
    assert speeds[:, 1:-1].max() < 1e-12 * free
    rows = scene.grid.rows
    depth, height = scene.material.variation.origin_depth - rows, np.diff(rows).min()
    assert speeds[np.abs(depth - 13.0) > height, -1].max() < 1e-12 * free
    pressure = np.abs(excess_pore_pressure(simulation)).reshape(scene.grid.row_count, -1)
    assert np.count_nonzero(pressure.max(axis=1) > 1e-9 * 30e3) <= 1


def test_soil_and_springs_that_enter_have_the_stress_of_their_depth() -> None:
    """Beside what ground without it has there: the second layer pulls sideways by 2 Delta su."""
    with_stress, without = (
        changed(profile=it) for it in (IN_SITU, IN_SITU.replace("-0.4", "0").replace("0.5", "0"))
    )
    runs = [Simulation(it.build()) for it in (with_stress, without)]
    for run in runs:
        run.travel_to(13.0 - with_stress.start_depth)
    entered, nothing_before = (run.array("layer.stress") for run in runs)
    assert len(entered) > 0
    np.testing.assert_allclose(entered[:, [0, 3]] - nothing_before[:, [0, 3]], 30e3, rtol=1e-9)
    np.testing.assert_array_equal(entered[:, [1, 2]], nothing_before[:, [1, 2]])
    ground = soil_scene(runs[0])[SurroundingGround]
    held, free = (ground.entering_spring(soil_scene(it), it.travel)[0] for it in runs)
    stretched = -ground.side_areas[0] * 30e3 / ground.spring[0, 0]
    assert held - free == pytest.approx(stretched, rel=1e-9)


def test_the_resistance_goes_with_the_stress_of_the_ground_before() -> None:
    """From a layer with a low vertical stress to one with a high one, three radii behind it."""
    row = "{}, 20, {}".format
    low, high, layers = (
        changed(
            profile="depth [m], strength [kPa], stress_anisotropy [1]; "
            + "; ".join([row(0, first), row(13, first), row(13, then), row(30, then)]),
            to_depth=16.0,
        )
        .run()
        .net_resistance[-5:]
        .mean()
        for first, then in ((-0.4, -0.4), (0.4, 0.4), (-0.4, 0.4))
    )
    assert high < low
    assert abs(layers - high) < 0.5 * abs(low - high)


def test_adhesion_factors_by_depth_are_those_of_the_soil_beside() -> None:
    """In uniform clay that is smooth above 13 m and rough below: nodes, then the resistance."""
    by_depth = changed(
        profile="depth [m], strength [kPa], adhesion_factor [1]; 0, 20, 0; 13, 20, 0; 13, 20, 1; "
        "30, 20, 1",
        adhesion_factor=0.0,
        to_depth=15.0,
    )
    scene = by_depth.build()
    simulation = Simulation(scene)

    def ratio(tip_depth: float) -> Floats:
        simulation.travel_to(tip_depth - by_depth.start_depth)
        return simulation.array("contact.adhesion") / scene[SurfaceContact].adhesion_forces

    height = scene.grid.node_positions[scene[SurfaceContact].nodes, 1]
    # Soil beside the surface is dragged down by some radii at most.
    at_border = ratio(15.0)
    np.testing.assert_array_equal(at_border[15.0 - height < 12.0], 0.0)
    assert at_border[0] > 0.9
    np.testing.assert_array_equal(ratio(22.0), 1.0)

    smooth, rough = (changed(adhesion_factor=it, to_depth=15.0) for it in (0.0, 1.0))
    net, least, most = (it.run().net_resistance for it in (by_depth, smooth, rough))
    above, below = net.depth < 12.4, net.depth > 14.0
    np.testing.assert_allclose(net[above], least[above], rtol=1e-9)
    assert float(least[below].mean()) < float(net[below].mean()) < float(most[below].mean())


def test_the_shaft_keeps_its_share_of_the_adhesion_of_the_face() -> None:
    """Of ground the roughest of which the window does not pass."""
    sounding = changed(
        profile="depth [m], strength [kPa], adhesion_factor [1]; 0, 20, 0.2; 90, 20, 0.2; "
        "90, 20, 0.8; 99, 20, 0.8",
        adhesion_factor=0.0,
        shaft_adhesion_factor=0.4,
    )
    contact = sounding.build()[PenetrometerContact]
    assert contact.face_adhesion == pytest.approx(0.2 * 20e3)
    assert contact.shaft_adhesion == pytest.approx(0.1 * 20e3)


@pytest.mark.parametrize("softening", [{}, SOFT])
def test_eight_times_the_strength_gives_eight_times_the_curves(softening: dict[str, float]) -> None:
    """With eight times the density waves are as fast; a power of two changes no digit."""
    once, eightfold = (
        changed(
            profile="depth [m], strength [kPa], unit_weight [kN/m3]; "
            f"0, {10 * scale}, {17 * scale}; 13, {10 * scale}, {17 * scale}; "
            f"13, {30 * scale}, {17 * scale}; 20, {30 * scale}, {17 * scale}",
            density=scale * changed().density,
            **softening,
        ).run()
        for scale in (1, 8)
    )
    for name in ("net_resistance", "sleeve_friction", "excess_pore_pressure"):
        np.testing.assert_allclose(eightfold[name], 8.0 * once[name], rtol=1e-12)


def test_ground_that_softens_resists_less_and_has_no_half_width() -> None:
    soft, intact = (changed(to_depth=12.5, **it).run() for it in (SOFT, {}))
    assert (soft.net_resistance < intact.net_resistance).all()
    assert soft.net_resistance_uncertainty.isnull().all()


def test_ground_that_softens_too_steeply_somewhere_is_refused() -> None:
    """The second layer is ten times as strong over its stiffness as the clay that is stiffest."""
    profile = (
        "depth [m], strength [kPa], shear_modulus [kPa]; 0, 10, 9000; 13, 10, 9000; "
        "13, 30, 2700; 20, 30, 2700"
    )
    changed(profile=profile, remoulded_strength_ratio=0.2, ductility=0.5)
    with pytest.raises(ParameterError, match=r"too brittle, must be >= 0\.053"):
        changed(profile=profile, remoulded_strength_ratio=0.2, ductility=0.05)
