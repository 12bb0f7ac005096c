"""Contact with a rigid body: its law, areas, where soil parts from it, adhesion beside soil."""

import dataclasses
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.parts.boundaries import FarField
from mpm_warp.parts.contact import SurfaceContact, contact_law
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.parts.window import Window
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.planning import make_plan
from mpm_warp.scene import Part, Scene
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import changing_clay, layers

ROUNDING = 1e-14
NORMAL = np.array([-0.6, 0.8])
TANGENT = np.array([0.8, 0.6])
MASS = 2.0


@wp.kernel(enable_backward=False)
def apply_contact_law(
    mass: wp.float64,
    jump: wp.array(dtype=wp.vec2d),
    normal: wp.array(dtype=wp.vec2d),
    pressing: wp.float64,
    most_shear: wp.float64,
    pressure: wp.float64,
    impulse: wp.array(dtype=wp.vec3d),
):
    k = wp.tid()
    impulse[k] = contact_law(mass, jump[k], normal[k], pressing, most_shear, pressure)


@pytest.mark.parametrize(
    ("normal_speed", "slip", "given", "normal", "tangential"),
    [
        # An approach to a smooth body stops the normal motion alone.
        (0.5, 3.0, {}, MASS * 0.5, 0.0),
        # Bodies that part exchange nothing, not even adhesion.
        (-0.5, 3.0, {"most_shear": 100.0}, 0.0, 0.0),
        # Sticking cancels the slip.
        (0.5, 0.1, {"most_shear": 0.3}, MASS * 0.5, MASS * 0.1),
        # Sliding transmits what it can against the slip, whatever the normal impulse.
        (0.5, 3.0, {"most_shear": 0.2}, MASS * 0.5, 0.2),
        (0.5, -3.0, {"most_shear": 0.2}, MASS * 0.5, -0.2),
        (1e6, 1e3, {"most_shear": 0.2}, MASS * 1e6, 0.2),
        # Excess tension up to the in-situ pressure is carried.
        (-0.5, 3.0, {"most_shear": 0.2, "pressure": 1.5}, -MASS * 0.5, 0.2),
        # Beyond it the bodies part, and no total traction is left.
        (-1.0, 3.0, {"most_shear": 0.2, "pressure": 1.5}, -1.5, 0.0),
        # A node that parts in a pressed neighbourhood is sheared still.
        (-0.5, 3.0, {"most_shear": 0.2, "pressing": 2.0}, 0.0, 0.2),
    ],
)
def test_the_impulse_is_that_of_each_branch(
    normal_speed: float, slip: float, given: dict[str, float], normal: float, tangential: float
) -> None:
    """What presses the bodies is the node's own impulse where no other is given."""
    pressure = given.get("pressure", 0.0)
    pressing = given.get("pressing", MASS * normal_speed + pressure)
    jump = wp.array([normal_speed * NORMAL + slip * TANGENT], dtype=wp.vec2d, device="cpu")
    unit = wp.array([NORMAL], dtype=wp.vec2d, device="cpu")
    impulse = wp.zeros(1, dtype=wp.vec3d, device="cpu")
    bounds = [given.get("most_shear", 0.0), pressure]
    wp.launch(apply_contact_law, 1, [MASS, jump, unit, pressing, *bounds, impulse], device="cpu")
    expected = [normal, *(tangential * TANGENT)]
    rounding = ROUNDING * np.hypot(MASS * normal_speed, MASS * slip)
    np.testing.assert_allclose(impulse.numpy()[0], expected, rtol=ROUNDING, atol=rounding)


PRESSURE, IN_SITU = 1e3, 1e9


@pytest.fixture
def surface(cone: Scene) -> SurfaceContact:
    """Of the cone and its shaft."""
    return cone[SurfaceContact]


def test_parting_is_physics_where_the_ground_presses_less_than_soil_can_pull(
    surface: SurfaceContact,
) -> None:
    """By the limit pressure of a sphere, 4/3 su (1 + ln 100) = 7.5 su, twice taken."""
    strength, index = 1e3, 100.0
    material = Tresca(
        shear_modulus=index * strength, poissons_ratio=0.3, density=1.0, strength=strength
    )
    elastic = LinearElastic(shear_modulus=1e5, poissons_ratio=0.3, density=1.0)
    for in_situ, may_part in ((14e3, True), (16e3, False)):
        contact = dataclasses.replace(surface, in_situ_stress=in_situ)
        assert contact.can_part(material, speed=0.0) is may_part
        assert contact.can_part(elastic, speed=0.0)
        assert contact.can_part(material, speed=100.0)


def after_a_step(scene: Scene, speed: float, **changes: object) -> tuple[Simulation, Floats]:
    """A run of one step without a window, and the velocity of the soil past the body [m/s].

    Past a body at rest the soil moves up.
    """
    contact = dataclasses.replace(scene[SurfaceContact], speed=speed, **changes)
    # The contact alone, in a step so short that no stress matters.
    alone = dataclasses.replace(scene, parts=(contact,), time_step_fraction=1e-6)
    simulation = Simulation(alone)
    simulation.array("particle.velocity")[:, 1] = float(not speed)
    simulation.advance(1)
    return simulation, simulation.array("node.velocities")[contact.nodes, :2] + [0.0, speed]


def test_soil_slides_along_a_smooth_body_and_does_not_enter_it(
    cone: Scene, surface: SurfaceContact
) -> None:
    simulation, past = after_a_step(cone, 2.0, adhesion_forces=0.0 * surface.adhesion_forces)
    np.testing.assert_allclose(np.sum(past * surface.normals, axis=1), 0.0, atol=1e-12)
    tangents = np.stack([surface.normals[:, 1], -surface.normals[:, 0]], axis=-1)
    slip = np.sum(past * tangents, axis=1)
    np.testing.assert_allclose(slip, 2.0 * tangents[:, 1], rtol=1e-12, atol=1e-12)
    # What the body has given is the momentum of the nodes, and none along the surface.
    mass = simulation.array("node.mass")[surface.nodes]
    impulse = simulation.array("contact.impulse")
    np.testing.assert_allclose(impulse[:, 0], mass * 2.0 * surface.normals[:, 1], rtol=1e-12)
    np.testing.assert_array_equal(impulse[:, 1], 0.0)


@pytest.mark.parametrize(("planar", "area"), [(False, 1.0), (True, 0.5 * math.pi)])
def test_the_area_of_a_round_body_is_exact_but_for_its_chords(planar: bool, area: float) -> None:
    """Half a sphere or cylinder of radius 1, in a grid that begins on the axis below it."""
    short = []
    for count in (8, 32):
        angle = np.linspace(0.0, 0.5 * math.pi, count + 1)
        grid = Grid(
            columns=np.array([0.0, 1.0]),
            rows=np.append([-3.0, -2.0], -np.cos(angle)),
            surface_radius=np.append([0.0, 0.0], np.sin(angle)),
            fitted_radius=2.0,
            planar=planar,
        )
        body = SurfaceContact.on(grid, np.arange(2, count + 3), in_situ_stress=0.0)
        below = 1.0 if planar else 0.5
        assert body.normal_areas @ body.normals[:, 1] == pytest.approx(below, rel=ROUNDING * count)
        short.append(1.0 - body.normal_areas.sum() / area)
        with pytest.raises(SceneError, match="row 0 has no surface"):
            SurfaceContact.on(grid, np.arange(count + 3), in_situ_stress=0.0)
    assert math.log(short[0] / short[1], 4.0) == pytest.approx(2.0, abs=0.1)


def test_the_speed_is_that_of_the_window_or_its_own(cone: Scene) -> None:
    with pytest.raises(SceneError, match="SurfaceContact: speed: not together with a window"):
        cone.with_parts(dataclasses.replace(cone[SurfaceContact], speed=0.1))


RUBS: dict[str, Any] = {"friction": 0.3, "adhesion": 0.0}


@pytest.mark.parametrize(
    ("cells", "given", "expected"),
    [
        pytest.param(1e-8, {}, lambda it: it.adhesion, id="adhesion"),
        pytest.param(1e3, {}, lambda it: it.adhesion, id="adhesion, fast"),
        # The in-situ stress presses too, though the simulation leaves it out.
        pytest.param(1e3, RUBS, lambda it: 0.3 * (it.in_situ + it.normal), id="friction"),
        # It follows the pressure over a way of a cell, and at once where there is no way.
        pytest.param(0.25, RUBS, lambda it: 0.3 * (it.in_situ + 0.25 * it.normal), id="on the way"),
        pytest.param(0.0, RUBS, lambda it: 0.3 * (it.in_situ + it.normal), id="at rest"),
        # However rough the surface is, and whatever presses.
        pytest.param(1e3, RUBS | {"strength": 2.0}, lambda it: 2.0 * it.adhesion, id="bounded"),
    ],
)
def test_the_shear_of_a_step_in_which_soil_slips(
    cone: Scene, surface: SurfaceContact, cells: float, given: Any, expected: Any
) -> None:
    """Over the length of the step; the body goes so many cells in it."""
    forces = {"adhesion_forces": given.get("adhesion", 1.0) * surface.adhesion_forces}
    if "strength" in given:
        forces["strength_forces"] = given["strength"] * surface.adhesion_forces
    step = after_a_step(cone, 1.0)[0].plan.time_step
    speed = cells * cone.grid.cell_lengths.min() / step
    friction = given.get("friction", 0.0)
    simulation, _ = after_a_step(cone, speed, friction=friction, **forces)
    normal, shear = simulation.array("contact.impulse")[1:].T / step  # at the tip nothing slips
    in_situ = surface.in_situ_stress * surface.normal_areas[1:]
    pressing = SimpleNamespace(normal=normal, in_situ=in_situ, adhesion=surface.adhesion_forces[1:])
    np.testing.assert_allclose(np.abs(shear), expected(pressing), rtol=1e-9)
    if cells:  # soil presses the face, and the shaft no more than at rest
        assert np.abs(normal[-2:]).max() < 1e-9 * in_situ.min()
        assert normal.max() > 10.0 * in_situ.max()


def impulses_under_pressure(
    cone: Scene, share: float, *parts: Part, friction: float = 0.0, pressure: float = PRESSURE
) -> Floats:
    """Impulses of one step under a uniform pressure, with so much of its mass left to each point.

    They are over the time step, shape [node_count, 2]; the soil flows past as fast as it does.
    """
    contact = dataclasses.replace(
        cone[SurfaceContact],
        speed=1e9 * friction,
        friction=friction,
        in_situ_stress=IN_SITU,
        adhesion_forces=0.0 * cone[SurfaceContact].adhesion_forces,
    )
    simulation = Simulation(cone.without(Window, FarField).with_parts(contact, *parts))
    simulation.assign("particle.mass", share * simulation.array("particle.mass"))
    pressed = np.zeros((len(simulation.array("particle.mass")), 4))
    pressed[:, [0, 1, 3]] = -pressure
    simulation.assign("particle.stress", pressed)
    simulation.advance(1)
    impulses: Floats = simulation.array("contact.impulse") / simulation.plan.time_step
    return impulses


def test_the_body_bears_what_the_least_mass_keeps_from_the_node(cone: Scene) -> None:
    """The force of the stress does not depend on how much soil there is to give it, at any node."""
    areas = cone[SurfaceContact].normal_areas
    full = impulses_under_pressure(cone, 1.0)[:, 0]
    assert full[0] > 0.1 * PRESSURE * areas[0]
    for share in (0.5, 0.1):
        np.testing.assert_allclose(impulses_under_pressure(cone, share)[:, 0], full, rtol=1e-9)
    # Soil pulls no more than the in-situ stress presses; friction is by all that presses.
    pulled = impulses_under_pressure(cone, 0.1, pressure=-1e3 * IN_SITU)[:, 0]
    np.testing.assert_allclose(pulled, -IN_SITU * areas, rtol=1e-9)
    normal, shear = impulses_under_pressure(cone, 0.1, friction=0.3)[1:].T
    np.testing.assert_allclose(np.abs(shear), 0.3 * (normal + IN_SITU * areas[1:]), rtol=1e-9)


@pytest.mark.parametrize("filling", [1.0, 0.4, 0.1])
def test_above_a_free_surface_the_body_bears_what_the_soil_gives(
    cone: Scene, filling: float
) -> None:
    """The stress acts by the filling s, and the soil takes m / M of it; of the rest s is borne."""
    full = impulses_under_pressure(cone, 1.0)[:, 0]
    simulation = Simulation(cone)
    simulation.advance(1)
    mass, least = (simulation.array(f"node.{name}") for name in ("mass", "least_mass"))
    taken = np.minimum(filling * mass / least, 1.0)[cone[SurfaceContact].nodes]
    borne = filling * (taken + filling * (1.0 - taken)) * full
    cut = impulses_under_pressure(cone, filling, FreeSurface())[:, 0]
    np.testing.assert_allclose(cut, borne, rtol=1e-9)


DELTA = 0.25


@pytest.fixture
def softening(cone: Scene) -> Scene:
    """The scene with clay that softens."""
    soft = {"remoulded_strength_ratio": DELTA, "ductility": 10.0}
    return dataclasses.replace(cone, material=changing_clay(**vars(cone.material), **soft))


def test_a_surface_follows_the_mean_strength_in_the_cells_beside_a_node(softening: Scene) -> None:
    """By mass; the points of one row of cells are remoulded, so nodes above and below mix."""
    contact = softening[SurfaceContact]
    rubs = dataclasses.replace(contact, friction=0.3, strength_forces=3.0 * contact.adhesion_forces)
    simulation = Simulation(softening.with_parts(rubs))
    row = softening.grid.row_count - 2
    cell = simulation.array("particle.cell")
    simulation.array("particle.state")[(cell[:, 0] == 0) & (cell[:, 1] == row)] = 1.0
    simulation.advance(AUDIT_INTERVAL)
    mass = simulation.array("particle.mass")
    in_row = [mass[(cell[:, 0] == 0) & (cell[:, 1] == it)].sum() for it in range(row + 2)]
    share = np.ones(len(softening[SurfaceContact].nodes))
    # Nodes are numbered upward; the last is the upper end of the last row of cells.
    share[-3] = (in_row[row - 1] + DELTA * in_row[row]) / (in_row[row - 1] + in_row[row])
    share[-2] = (DELTA * in_row[row] + in_row[row + 1]) / (in_row[row] + in_row[row + 1])
    expected = share * softening[SurfaceContact].adhesion_forces
    np.testing.assert_allclose(simulation.array("contact.adhesion"), expected, rtol=1e-12)
    np.testing.assert_allclose(simulation.array("contact.strength"), 3.0 * expected, rtol=1e-12)


def test_without_friction_and_softening_there_are_no_arrays_for_them(cone: Scene) -> None:
    plan = make_plan(
        cone.with_parts(dataclasses.replace(cone[SurfaceContact], strength_forces=np.ones(7)))
    )
    of_friction = {"contact.normal_force", "contact.strength"}
    of_softening = {"contact.adhesion_at_first", "contact.strength_sum"}
    assert not (of_friction | of_softening) & set(plan.arrays)
    assert "sum_of_strength" not in {launch.name for launch in plan.launches}


def test_a_surface_elsewhere_than_along_the_first_column_is_refused(softening: Scene) -> None:
    nodes = softening[SurfaceContact].nodes.copy()
    nodes[3] += 1
    elsewhere = dataclasses.replace(softening[SurfaceContact], nodes=nodes)
    with pytest.raises(SceneError, match=r"nodes\[3\] is not in the first column"):
        softening.with_parts(elsewhere)


def test_adhesion_is_that_of_the_soil_which_has_come_beside_the_surface(cone: Scene) -> None:
    """Twice as strong below the tip: after a way of two cone heights all of the face has it.

    There a surface has a quarter of its adhesion factor, and soil bears what it bears all the same.
    """
    ground = layers((0, 1, 1), (0, 2, 1), adhesion_ratio=np.array([1.0, 0.25]))
    soil = dataclasses.replace(cone.material, variation=ground)
    contact = cone[SurfaceContact]
    rubs = dataclasses.replace(contact, friction=0.3, strength_forces=contact.adhesion_forces)
    scene = dataclasses.replace(cone.without(FarField), material=soil).with_parts(rubs)
    simulation = Simulation(scene)
    adhesion, strength = (simulation.array(f"contact.{it}") for it in ("adhesion", "strength"))
    # The tip, at the very border, belongs to what is below it.
    np.testing.assert_allclose(adhesion / contact.adhesion_forces, [0.5] + [1.0] * 6)
    height = math.sqrt(3.0)
    simulation.travel_to(2.0 * height)
    on_face = cone.grid.rows[cone.grid.rows >= 0.0] < height
    np.testing.assert_allclose((adhesion / contact.adhesion_forces)[on_face], 0.5)
    np.testing.assert_allclose((strength / contact.adhesion_forces)[on_face], 2.0)
