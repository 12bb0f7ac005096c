"""Contact between bodies; those that do not fit their grid or each other, or leave it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mpm_warp import LinearElastic, SceneError, Simulation, SimulationDiverged
from mpm_warp.bodies.body import Body, InterfaceFrame, Load, UniformGrid
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.grid.fitted import Floats
from mpm_warp.planning import make_plan

CELL = 0.1
LENGTH, HEIGHT = 1.0, 0.3
MATERIAL = LinearElastic(shear_modulus=4e6, poissons_ratio=0.3, density=2000.0)
CROSSING = HEIGHT / MATERIAL.shear_wave_speed
MASS = MATERIAL.density * LENGTH * HEIGHT
ADHESION = 1000.0


def block_on_base(
    *, angle: float = 0.0, loads: tuple[tuple[Floats, float], ...] = (), rigid_base: bool = True
) -> Simulation:
    """A damped block on a base of thrice its length.

    Args:
        angle: between interface and grid [rad].
        loads: forces on the block, along the interface and out of it [N], and when they begin [s].
        rigid_base: whether the base is held; otherwise it is free to move.
    """
    frame = InterfaceFrame(angle=angle)
    spacing = 0.5 * CELL
    block = frame.body((0.0, LENGTH), (0.0, HEIGHT), spacing, MATERIAL)
    base = frame.body((-LENGTH, 2.0 * LENGTH), (-HEIGHT, 0.0), spacing, MATERIAL)
    axes = np.stack([frame.along, frame.outward])
    bodies = (
        replace(
            block,
            retardation_time=0.1 * CROSSING,
            loads=tuple(
                Load(
                    forces=np.tile(force @ axes / block.particle_count, (block.particle_count, 1)),
                    start=start,
                    rise_time=CROSSING,
                )
                for force, start in loads
            ),
        ),
        replace(base, held=np.full(base.particle_count, True) if rigid_base else None),
    )
    grid = frame.grid_around(bodies, travel=LENGTH, cell_size=CELL, offset=0.3)
    contact = BodyContact(adhesion=ADHESION)
    return Simulation(BodyScene(grid=grid, bodies=bodies, contact=contact))


def momentum(simulation: Simulation, body: int) -> Floats:
    of_body = simulation.array("particle.body") == body
    mass, velocity = simulation.array("particle.mass"), simulation.array("particle.velocity")
    return mass[of_body] @ velocity[of_body]


def mean_position(simulation: Simulation) -> Floats:
    block = simulation.array("particle.body") == 0
    return simulation.array("particle.position")[block].mean(axis=0)


@pytest.mark.parametrize("angle", [0.0, math.radians(25.0)])
def test_impulses_on_two_free_bodies_sum_to_zero(angle: float) -> None:
    simulation = block_on_base(angle=angle, rigid_base=False)
    velocity = simulation.array("particle.velocity")
    velocity[simulation.array("particle.body") == 0] = [1.0, -2.0]
    before = momentum(simulation, 0) + momentum(simulation, 1)
    simulation.advance_to(3.0 * CROSSING)
    exchanged = simulation.array("contact.total")[0][:2]
    assert np.linalg.norm(exchanged) > 0.1 * MASS
    after = momentum(simulation, 0) + momentum(simulation, 1)
    np.testing.assert_allclose(after, before, atol=1e-12 * np.linalg.norm(exchanged))
    np.testing.assert_allclose(
        momentum(simulation, 1), exchanged, atol=1e-12 * np.linalg.norm(exchanged)
    )


def test_block_that_is_lifted_off_is_free_and_sticks_when_it_is_dropped_again() -> None:
    """Pressed, lifted with twice the pressing force, let fall, then pushed below the adhesion."""
    weight = np.array([0.0, -3000.0])
    push = np.array([0.5 * ADHESION * LENGTH, 0.0])
    lift_at, drop_at = 20.0 * CROSSING, 25.0 * CROSSING
    simulation = block_on_base(
        loads=(
            (weight, 0.0),
            (-2.0 * weight, lift_at),
            (2.0 * weight, drop_at),
            (push, 120.0 * CROSSING),
        )
    )
    simulation.advance_to(lift_at + 2.0 * CROSSING)
    simulation.array("contact.total")[:] = 0.0
    start, begin = simulation.time, momentum(simulation, 0)
    simulation.advance_to(drop_at - 0.5 * CROSSING)
    # Nothing pulls the block back, the adhesion neither: it moves by the forces on it alone.
    np.testing.assert_array_equal(simulation.array("contact.total"), 0.0)
    gained = momentum(simulation, 0) - begin
    np.testing.assert_allclose(
        gained, -weight * (simulation.time - start), rtol=1e-10, atol=1e-10 * np.linalg.norm(gained)
    )

    simulation.advance_to(115.0 * CROSSING)
    assert np.abs(momentum(simulation, 0)).max() < 1e-3 * np.abs(gained).max()
    simulation.advance_to(160.0 * CROSSING)
    pushed = mean_position(simulation)
    simulation.array("contact.total")[:] = 0.0
    start = simulation.time
    simulation.advance_to(200.0 * CROSSING)
    force = simulation.array("contact.total")[0][:2] / (simulation.time - start)
    np.testing.assert_allclose(force, push + weight, rtol=1e-3)
    free = 0.5 * push[0] / MASS * (simulation.time - start) ** 2
    assert np.abs(mean_position(simulation) - pushed).max() < 1e-4 * free


@pytest.mark.parametrize("degrees", [0.0, 10.0, 20.0, 30.0, 45.0])
def test_interface_is_found_from_the_particles(degrees: float) -> None:
    """Area within 1 %, normals within 1.5 degrees where the area is, of the straight interface.

    Lattices of 2 x 2 particles a cell sample a surface with this error at worst, at 45 degrees.
    """
    simulation = block_on_base(angle=math.radians(degrees))
    simulation.advance(1)
    area, normal = simulation.array("contact.area"), simulation.array("contact.normal")
    assert area.sum() == pytest.approx(LENGTH, rel=0.01)
    outward = np.array([math.sin(math.radians(degrees)), -math.cos(math.radians(degrees))])
    turned = np.abs(normal[:, 0] * outward[1] - normal[:, 1] * outward[0])
    assert math.sqrt(area @ turned**2 / area.sum()) < math.sin(math.radians(1.5))
    assert (normal @ outward)[area > 0.05 * CELL].min() > 0.0


def test_bodies_feel_each_other_when_they_touch_and_not_a_cell_before() -> None:
    simulation = block_on_base()
    position = simulation.array("particle.position")
    gap = 0.5 * CELL
    position[simulation.array("particle.body") == 0, 1] += gap
    speed = 0.01 * MATERIAL.shear_wave_speed
    simulation.array("particle.velocity")[simulation.array("particle.body") == 0, 1] = -speed
    simulation.advance_to(0.8 * gap / speed)
    np.testing.assert_array_equal(simulation.array("contact.total"), 0.0)
    simulation.advance_to(1.2 * gap / speed)
    assert simulation.array("contact.total")[0][1] < 0.0


def test_impulse_of_a_step_is_the_law_summed_over_nodes() -> None:
    """In the first step, before any stress: adhesion acts on its area, friction on nothing."""
    simulation = block_on_base()
    velocity = simulation.array("particle.velocity")
    velocity[simulation.array("particle.body") == 0] = [10.0, -1e-3]
    simulation.advance(1)
    area = simulation.array("contact.pressing")[:, 1].sum()
    shear = simulation.array("contact.total")[0][0] / simulation.plan.time_step
    assert shear == pytest.approx(ADHESION * area, rel=1e-12)


def test_body_alone_has_no_part_that_it_does_not_need() -> None:
    frame = InterfaceFrame(angle=0.0)
    body = frame.body((0.0, LENGTH), (0.0, HEIGHT), 0.5 * CELL, MATERIAL)
    grid = frame.grid_around((body,), travel=0.0, cell_size=CELL, offset=0.0)
    plan = make_plan(BodyScene(grid=grid, bodies=(body,)))
    kernels = [launch.name for launch in plan.step]
    assert kernels == ["body_to_grid", "body_prediction", "grid_to_body"]
    assert {name.split(".")[0] for name in plan.arrays} == {"particle", "body", "field"}
    assert not {"particle.viscous_stress", "particle.load", "field.surface"} & set(plan.arrays)


def test_ring_breathes_at_its_frequency() -> None:
    """The hoop stress drives a thin ring back: omega = sqrt(E / rho) / R (Rayleigh)."""
    radius, thickness = 2.0, 0.2
    frame = InterfaceFrame(angle=0.0, interface_radius=radius + 0.5 * thickness)
    spacing = 0.05
    ring = frame.body((0.0, 0.2), (0.0, thickness), spacing, MATERIAL)
    grid = frame.grid_around((ring,), travel=0.2, cell_size=2.0 * spacing, offset=0.0)
    simulation = Simulation(BodyScene(grid=grid, bodies=(ring,)))
    speed = 1e-4 * MATERIAL.shear_wave_speed
    simulation.array("particle.velocity")[:, 0] = speed
    youngs_modulus = 2.0 * MATERIAL.shear_modulus * (1.0 + MATERIAL.poissons_ratio)
    frequency = math.sqrt(youngs_modulus / MATERIAL.density) / radius
    simulation.advance_to(0.5 * math.pi / frequency)
    mean = float(ring.mass @ simulation.array("particle.velocity")[:, 0]) / float(ring.mass.sum())
    # A quarter of a period later it stands still, but for what the thin ring's theory leaves out.
    assert mean / speed == pytest.approx(0.0, abs=2.0 * (thickness / radius) ** 2)


ELASTIC = LinearElastic(shear_modulus=1e6, poissons_ratio=0.2, density=1000.0)
GRID = UniformGrid(lower=(0.0, 0.0), cell_size=1.0, cell_counts=(8, 8))


def square(x: float, y: float) -> Body:
    """Four particles around a place."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
    return Body(
        position=np.array([x, y]) + 0.25 * corners,
        volume=np.full(4, 0.25),
        spacing=0.5,
        material=ELASTIC,
    )


ABOVE, BELOW = square(4.0, 4.5), square(4.0, 3.5)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"bodies": (ABOVE, square(4.0, 4.2))}, "bodies 0 and 1 overlap at"),
        ({"bodies": (square(9.0, 4.0),)}, "body 0: 4 particles, one at"),
        ({"bodies": (square(0.6, 4.0),)}, "body 0: 2 particles, one at"),
        (
            {"bodies": (ABOVE,), "contact": BodyContact()},
            "contact: needs two bodies, the scene has 1",
        ),
    ],
)
def test_bodies_that_do_not_fit_are_refused_in_one_line(
    given: dict[str, Any], message: str
) -> None:
    with pytest.raises(SceneError, match=f"^{message}") as refusal:
        BodyScene(grid=GRID, **given)
    assert "\n" not in str(refusal.value)


def test_a_body_that_leaves_the_grid_ends_the_run_by_name() -> None:
    simulation = Simulation(BodyScene(grid=GRID, bodies=(ABOVE,)))
    simulation.array("particle.velocity")[:, 0] = 0.5 * ELASTIC.pressure_wave_speed
    with pytest.raises(SimulationDiverged, match=r"position of particle.*outside|wider grid"):
        simulation.advance(500)
