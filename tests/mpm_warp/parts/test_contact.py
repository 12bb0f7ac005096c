"""Contact with a rigid body: areas, where soil may part from it, nodes that the axis holds."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.parts.boundaries import FarField
from mpm_warp.parts.contact import SurfaceContact, nodal_areas
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

PRESSURE = 1e3


@pytest.fixture
def surface(cone: Scene) -> SurfaceContact:
    """Of the cone and its shaft."""
    return cone[SurfaceContact]


def test_nodal_areas_integrate_linear_functions_exactly() -> None:
    """Of r over a line of slope: the whole, and its first moment along the line."""
    radius = np.array([0.0, 0.5, 0.8, 2.0])
    length = 2.0 * np.diff(radius)
    area = nodal_areas(radius, length)
    assert area.sum() == pytest.approx(2.0 * 0.5 * 2.0**2, rel=1e-13)
    assert area @ radius == pytest.approx(2.0 * 2.0**3 / 3.0, rel=1e-13)


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


def test_only_nodes_of_the_surface_can_be_held(surface: SurfaceContact) -> None:
    with pytest.raises(SceneError, match=r"^SurfaceContact: on_axis"):
        dataclasses.replace(surface, on_axis=np.array([len(surface.nodes)]))


def after_a_step(scene: Scene, speed: float, **changes: object) -> tuple[Simulation, Floats]:
    """A run of one step without a window, and the velocity of the soil past the body [m/s]."""
    contact = dataclasses.replace(scene[SurfaceContact], speed=speed, **changes)
    # The contact alone, in a step so short that no stress matters.
    alone = dataclasses.replace(scene, parts=(contact,), time_step_fraction=1e-6)
    simulation = Simulation(alone)
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


def test_adhesion_acts_for_the_length_of_a_step(cone: Scene, surface: SurfaceContact) -> None:
    """The shear impulse where soil slips is adhesion times area times step, at any speed."""
    for speed in (2.0, 4.0):
        simulation, _ = after_a_step(cone, speed)
        shear = np.abs(simulation.array("contact.impulse")[1:, 1])  # at the tip nothing slips
        limit = simulation.plan.time_step * surface.adhesion_forces[1:]
        np.testing.assert_allclose(shear, limit, rtol=1e-9)


def test_friction_is_that_of_the_total_stress(cone: Scene, surface: SurfaceContact) -> None:
    """The in-situ stress presses too, though the simulation leaves it out."""
    simulation, _ = after_a_step(
        cone, 1e4, friction=0.3, adhesion_forces=0.0 * surface.adhesion_forces
    )
    normal, shear = simulation.array("contact.impulse")[1:].T
    in_situ = simulation.plan.time_step * surface.in_situ_stress * surface.normal_areas[1:]
    np.testing.assert_allclose(np.abs(shear), 0.3 * (normal + in_situ), rtol=1e-9)
    # On the shaft that stress is all that presses.
    assert np.abs(normal[-2:]).max() < 1e-9 * in_situ[-2:].min()


def test_the_share_in_touch_is_of_the_area_that_something_presses(
    surface: SurfaceContact,
) -> None:
    """Where the simulated stress pulls by as much as the ground presses, nothing does."""
    in_situ = surface.in_situ_stress * surface.normal_areas
    assert surface.share_in_touch(np.zeros(len(in_situ))) == 1.0
    assert surface.share_in_touch(-in_situ) == 0.0
    parted = np.where(np.arange(len(in_situ)) < 3, -in_situ, 0.0)
    left = surface.normal_areas[3:].sum() / surface.normal_areas.sum()
    assert surface.share_in_touch(parted) == pytest.approx(left, rel=1e-12)


def impulse_at_the_tip(cone: Scene, share: float, *, held: bool) -> tuple[float, float]:
    """Normal impulse of one step under a uniform pressure, and time step, with so much soil left.

    Args:
        cone: with contact; its tip is the first of the nodes.
        share: of its mass that every particle keeps, in a stress that stays.
        held: whether the tip is a node that is held.
    """
    numbers = np.arange(int(held), dtype=np.int32)
    contact = dataclasses.replace(
        cone[SurfaceContact], speed=0.0, in_situ_stress=1e9, on_axis=numbers
    )
    simulation = Simulation(cone.without(Window, FarField).with_parts(contact))
    simulation.assign("particle.mass", share * simulation.array("particle.mass"))
    pressed = np.zeros((len(simulation.array("particle.mass")), 4))
    pressed[:, [0, 1, 3]] = -PRESSURE
    simulation.assign("particle.stress", pressed)
    simulation.advance(1)
    return float(simulation.array("contact.impulse")[0, 0]), simulation.plan.time_step


@pytest.mark.parametrize("share", [1.0, 0.5, 0.1])
def test_the_body_bears_what_the_least_mass_keeps_from_the_node(cone: Scene, share: float) -> None:
    """The force of the stress does not depend on how much soil there is to give it."""
    full, time_step = impulse_at_the_tip(cone, 1.0, held=True)
    assert full > 0.1 * PRESSURE * cone[SurfaceContact].normal_areas[0] * time_step
    assert impulse_at_the_tip(cone, share, held=True)[0] == pytest.approx(full, rel=1e-9)


def test_where_nothing_is_held_little_soil_gives_little_force(cone: Scene) -> None:
    full, _ = impulse_at_the_tip(cone, 1.0, held=False)
    assert full == impulse_at_the_tip(cone, 1.0, held=True)[0]
    assert impulse_at_the_tip(cone, 0.1, held=False)[0] < 0.3 * full
