"""The ground around a window and the travelling source: flow, stress, springs, what enters."""

import dataclasses
import math

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import principal_stresses
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.scene import Scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import layers

SOURCE = TravellingSource(radius=0.5, height=0.2, shear_modulus=3.0)
PLACES = np.array([[4.0, -6.0], [5.0, 0.2], [3.0, 7.0], [0.0, -5.0]])
"""(r, z): below the source, beside it, above it, and on the axis below it."""
STEP = 1e-4
SHORT = ConePenetration(
    cells_per_radius=2, domain_radius=10, domain_above=4, domain_below=5, approach=0
)
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A cone in a small window."""
    return SHORT.build()


def test_bottom_and_top_move_as_the_source_has_them_move(scene: Scene) -> None:
    """Off the shaft, along which soil goes as the contact says."""
    simulation = Simulation(scene)
    simulation.advance(200)
    speed = simulation.array("window.motion")[1]
    simulation.advance(1)
    velocity = simulation.array("node.velocities")[:, :2]
    places = scene.grid.node_positions
    flow = speed * scene[SurroundingGround].source.velocity(places)
    bottom, top = (places[:, 1] == scene.grid.rows[row] for row in (0, -1))
    np.testing.assert_allclose(velocity[bottom], flow[bottom], rtol=ROUNDING)
    off_the_shaft = top & (places[:, 0] > SHORT.cone_radius)
    np.testing.assert_allclose(velocity[off_the_shaft], flow[off_the_shaft], rtol=ROUNDING)


def test_a_step_of_the_side_is_that_of_its_equation(scene: Scene) -> None:
    """From rest, springs displaced: m dv = -k w dt with the dashpots implicit, to rounding."""
    ground = dataclasses.replace(scene[SurroundingGround], from_afar=False)
    simulation = Simulation(scene.with_parts(ground))
    side = ground.far.nodes
    pushed = 1e-6 * np.linspace([1.0, -2.0], [3.0, 1.0], len(side))
    simulation.assign("far_field.displacement", pushed)
    simulation.advance(1)  # the window still rests
    mass, step = simulation.array("node.mass")[side, None], simulation.plan.time_step
    expected = -step * ground.spring * pushed / (mass + step * ground.far.dashpot)
    velocity = simulation.array("node.velocities")[side, :2]
    between = slice(1, -1)  # the ends have the last word in the corners
    np.testing.assert_allclose(velocity[between], expected[between], rtol=1e-9)
    moved = simulation.array("far_field.displacement") - pushed
    np.testing.assert_allclose(moved, step * expected, rtol=1e-6)


def test_side_nodes_that_move_with_the_source_are_pulled_by_its_traction_alone(
    scene: Scene,
) -> None:
    """Then dw/dt = -V A t / k: the spring comes to pull as the elastic ground does."""
    ground = scene[SurroundingGround]
    flow = ground.source.velocity(ground.side_positions)
    plan = Simulation(scene).plan
    drawn, shown = (plan.arrays[f"far_field.{name}"].initial for name in ("drawn", "flow"))
    assert drawn is not None
    assert shown is not None
    np.testing.assert_allclose(shown, flow)
    pull_rate = ground.spring * (drawn - flow)
    expected = ground.side_areas[:, None] * ground.source.traction_rate(ground.side_positions)
    np.testing.assert_allclose(pull_rate, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_a_spring_that_enters_holds_the_stress_of_the_soil_beside_it(scene: Scene) -> None:
    ground, travel = scene[SurroundingGround], 2.0 * SHORT.cone_radius
    stressed = dataclasses.replace(scene, stress_at_rest=np.array([4e3, 0.0, 0.0, 4e3]))
    stress = ground.stress(stressed, ground.side_positions[:1], travel)[0]
    force = -ground.spring[0] * ground.entering_spring(stressed, travel)
    np.testing.assert_allclose(force, ground.side_areas[0] * stress[[0, 2]], rtol=ROUNDING)


@pytest.mark.parametrize("anisotropy", [-0.4, 0.4])
def test_anisotropic_ground_rests(anisotropy: float) -> None:
    """Before a body that starts there moves nothing does: the springs hold the stress at rest."""
    scene = dataclasses.replace(SHORT, stress_anisotropy=anisotropy).build()
    scene = scene.with_parts(dataclasses.replace(scene[SurroundingGround], from_afar=False))
    # The contact would let the soil go where it pulls at the shaft, so that is held instead.
    held = np.zeros((scene.grid.row_count + 1, scene.grid.column_count + 1), dtype=bool)
    held[:, 0] = True
    fixed = type(scene[Fixed]).where(radial=held, vertical=held)
    simulation = Simulation(scene.without(SurfaceContact).with_parts(fixed))
    simulation.advance(1)
    stress = simulation.array("particle.stress")
    soil = simulation.array("particle.cell")[:, 0] >= 0
    horizontal = 2.0 * anisotropy * SHORT.undrained_shear_strength
    np.testing.assert_allclose(
        stress[soil],
        np.tile([horizontal, 0.0, 0.0, horizontal], (soil.sum(), 1)),
        atol=1e-6 * abs(horizontal),
    )


def test_soil_starts_with_the_stress_that_the_body_has_left_as_far_as_it_bears_it(
    scene: Scene,
) -> None:
    """Elastic where its shear stress is below su, with the same pressure and su elsewhere.

    The elastic stress is that of a source 0.3 R sqrt(G / su) ahead.
    """
    ground = dataclasses.replace(
        scene[SurroundingGround], strength=4.0 * SHORT.undrained_shear_strength
    )
    simulation = Simulation(scene.with_parts(ground))
    soil = simulation.array("particle.cell")[:, 0] >= 0
    stress = simulation.array("particle.stress")[soil]
    ahead = 0.3 * SHORT.cone_radius * math.sqrt(100.0 / 4.0)
    source = dataclasses.replace(ground.source, height=ground.source.height - ahead)
    elastic = source.stress_from_afar(simulation.array("particle.position")[soil])
    greatest, borne = (0.5 * np.ptp(principal_stresses(it), axis=-1) for it in (elastic, stress))
    yields = greatest > ground.strength
    assert 0.1 < yields.mean() < 0.9
    np.testing.assert_allclose(stress[~yields], elastic[~yields], rtol=ROUNDING)
    np.testing.assert_allclose(borne[yields], ground.strength, rtol=1e-9)
    pressure = stress[:, [0, 1, 3]].sum(axis=-1)
    np.testing.assert_allclose(pressure, 0.0, atol=1e-9 * ground.strength)


def test_the_stress_of_a_long_way_is_that_of_one_without_end(scene: Scene) -> None:
    """From d radii away all that is still to come falls with 1 / d^2."""
    source = scene[SurroundingGround].source
    place = np.array([[4.0 * source.radius, 9.0 * source.radius]])
    end = source.stress_from_afar(place)
    left = [np.abs(source.stress_since(place, way) - end).max() for way in (10.0, 20.0)]
    assert left[0] == pytest.approx(4.0 * left[1], rel=0.05)


def test_soil_enters_with_the_motion_and_the_stress_of_the_ground(scene: Scene) -> None:
    simulation = Simulation(scene)
    row = float(scene.grid.rows[1] - scene.grid.rows[0])
    simulation.travel_to(0.25 * row)  # where the first layer enters
    ground, (_, speed, travel) = scene[SurroundingGround], simulation.array("window.motion")
    position = simulation.array("layer.position")
    np.testing.assert_allclose(
        simulation.array("layer.stress"), ground.stress(scene, position, travel), rtol=ROUNDING
    )
    np.testing.assert_allclose(
        simulation.array("layer.velocity"), speed * ground.source.velocity(position), rtol=ROUNDING
    )


def test_ground_around_another_grid_is_refused(scene: Scene) -> None:
    other = dataclasses.replace(SHORT, domain_radius=11.0).build()
    with pytest.raises(SceneError, match="SurroundingGround: grid has other nodes"):
        scene.with_parts(other[SurroundingGround])
    with pytest.raises(SceneError, match="SurroundingGround: source = 1 must be of type"):
        dataclasses.replace(scene[SurroundingGround], source=1)


def test_springs_and_dashpots_are_as_stiff_as_the_soil_that_comes_up_beside_them(
    scene: Scene,
) -> None:
    """Soil four times as stiff from a depth on: four times the spring, twice the dashpot."""
    rows, ground = scene.grid.rows, scene[SurroundingGround]
    border = float(rows[0] - 0.5 * (rows[1] - rows[0]))  # half a row below the grid
    stiffer = layers((-border, 1, 0.25), (-border, 1, 1))
    material = dataclasses.replace(scene.material, variation=stiffer)
    simulation = Simulation(dataclasses.replace(scene, material=material))
    spring = simulation.array("far_field.spring") / ground.spring
    np.testing.assert_allclose(spring, 0.25, rtol=ROUNDING)
    simulation.travel_to(float(rows[3] - rows[0]))
    height = border + simulation.travel
    # What is beside a node is known by the layers that have entered.
    near = np.abs(rows - height) < float(rows[1] - rows[0])
    spring = simulation.array("far_field.spring") / ground.spring
    dashpot = simulation.array("far_field.dashpot") / ground.far.dashpot
    stiff = rows[~near] < height
    assert stiff.any()
    expected = np.where(stiff, 1.0, 0.25)[:, None]
    np.testing.assert_allclose(spring[~near], expected * np.ones(2), rtol=ROUNDING)
    np.testing.assert_allclose(dashpot[~near], np.sqrt(expected) * np.ones(2), rtol=ROUNDING)


def test_stress_that_enters_is_that_of_the_soil_s_own_stiffness(scene: Scene) -> None:
    half = dataclasses.replace(scene.material, variation=layers((0, 1, 0.5)))
    soft = dataclasses.replace(scene, material=half)
    ground, travel = scene[SurroundingGround], 2.0 * SHORT.cone_radius
    position = ground.side_positions[:1]
    np.testing.assert_allclose(
        ground.stress(soft, position, travel),
        0.5 * ground.stress(scene, position, travel),
        rtol=ROUNDING,
    )
    # The spring is half as stiff too.
    np.testing.assert_allclose(
        ground.entering_spring(soft, travel), ground.entering_spring(scene, travel), rtol=ROUNDING
    )


def gradients(place: Floats) -> Floats:
    """(dv_r/dr, dv_z/dz, (dv_r/dz + dv_z/dr) / 2, v_r / r), by central differences."""
    along_r, along_z = (
        (SOURCE.velocity(place + step) - SOURCE.velocity(place - step)) / (2.0 * STEP)
        for step in (np.array([STEP, 0.0]), np.array([0.0, STEP]))
    )
    hoop = along_r[0] if place[0] == 0.0 else SOURCE.velocity(place)[0] / place[0]
    return np.array([along_r[0], along_z[1], 0.5 * (along_z[0] + along_r[1]), hoop])


def test_the_volume_of_the_body_flows_through_any_sphere() -> None:
    """pi R^2 V, whatever the sphere; per radian R^2 / 2."""
    points, weights = np.polynomial.legendre.leggauss(4)
    for distance in (2.0, 9.0):
        sine = np.sqrt(1.0 - points**2)
        place = np.stack([distance * sine, SOURCE.height + distance * points], axis=-1)
        outward = (SOURCE.velocity(place) * np.stack([sine, points], axis=-1)).sum(axis=-1)
        flow = distance**2 * weights @ outward
        assert flow == pytest.approx(0.5 * SOURCE.radius**2, rel=1e-12)


@pytest.mark.parametrize("place", PLACES, ids=str)
def test_the_stress_is_that_of_the_flow_along_the_way_of_the_soil(place: Floats) -> None:
    """2 G grad v, integrated while the soil rises past the source, by Gauss's rule."""
    strain = gradients(place)
    # Central differences are exact to the square of their step: the volume stays.
    assert abs(strain[[0, 1, 3]].sum()) < 10.0 * STEP**2 * np.abs(strain).max()
    doubled = 2.0 * SOURCE.shear_modulus
    traction, rate = doubled * strain[[0, 2]], SOURCE.traction_rate(place)
    np.testing.assert_allclose(rate, traction, atol=1e-6 * np.abs(traction).max())
    travel = 6.0
    points, weights = np.polynomial.legendre.leggauss(40)
    heights = place[1] - 0.5 * travel * (1.0 - points)
    rates = np.array([gradients(np.array([place[0], height])) for height in heights])
    expected = 0.5 * travel * weights @ (doubled * rates)
    stress = SOURCE.stress_since(place[None], travel)[0]
    np.testing.assert_allclose(stress, expected, atol=1e-6 * np.abs(expected).max())
