"""Sliding and flying blocks against the motion of rigid ones, with the bounds users rely on."""

import tracemalloc
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from mpm_warp import FlyingBlock, ParameterError, Simulation, SlidingBlock
from mpm_warp.fields.declaration import Value
from mpm_warp.scenes.blocks.block_on_base import SlidingMotion
from mpm_warp.scenes.blocks.flying_block import TIME_STEP_FRACTION, free_flight

pytestmark = pytest.mark.slow

NO_WEIGHT: dict[str, Value] = {"slope": 0.0, "gravity": 0.0, "friction": 0.0, "drive": 1500.0}
COARSE: dict[str, Value] = {"cells_per_length": 6, "height_ratio": 0.5}


def along(slope: float, adhesion: float, friction: float) -> dict[str, Value]:
    return {"slope": slope, "adhesion": adhesion, "friction": friction, "drive": 8000.0}


def turned(angle: float, offset: float, stiffness_ratio: float | None) -> dict[str, Any]:
    given = {"grid_angle": angle, "grid_offset": offset, "drive": 5000.0}
    return {**given, "stiffness_ratio": stiffness_ratio}


@pytest.mark.parametrize(
    ("bound", "given"),
    [
        (0.01, along(0.0, 0.0, 0.3)),
        (0.01, along(0.0, 500.0, 0.0)),
        (0.01, along(0.0, 2000.0, 0.3)),
        (0.01, along(30.0, 0.0, 0.0)),
        (0.01, along(30.0, 2000.0, 0.3)),
        (0.03, turned(5, 0.0, None)),
        (0.03, turned(15, 0.3, 1.0)),
        (0.03, turned(26, 0.6, None)),
        (0.03, turned(45, 0.25, 1.0)),
        (0.03, turned(45, 0.25, None)),
        (0.01, {"drive": 5000.0, "driving": "ramped"}),
        (0.01, {**COARSE, "stiffness_ratio": 1e-3, "drive": 2e4, "travel": 0.01}),
        (0.01, {**COARSE, "stiffness_ratio": 1e3, "drive": 2e4, "travel": 0.01}),
    ],
)
def test_acceleration(bound: float, given: dict[str, Any]) -> None:
    """Along the grid, at an angle to it, by a rising force, and on another base."""
    assert float(SlidingBlock(**given).run().acceleration_error) <= bound


@pytest.mark.parametrize(
    ("mass_scale", "interface_radius", "normal_pressure"),
    [(1.0, None, 5e4), (1.0, 2.0, 500.0), (1.0, 2.0, 5e5), (100.0, None, 5e5), (100.0, 2.0, 500.0)],
)
def test_adhesion_does_not_depend_on_pressure_shape_or_mass(
    mass_scale: float, interface_radius: float | None, normal_pressure: float
) -> None:
    block = SlidingBlock(
        **NO_WEIGHT,
        normal_pressure=normal_pressure,
        interface_radius=interface_radius,
        mass_scale=mass_scale,
    )
    assert float(block.run().base_shear_error) <= 0.01


def test_momentum_and_energy_balance() -> None:
    """Momentum to the step in which a load has a kink; energy to what the transfer dissipates."""
    block = SlidingBlock(drive=5000.0)
    result = block.run()
    assert float(result.momentum_error) <= (float(result.time_step) / block.duration) ** 2
    assert float(result.energy_error) <= 0.01
    work = result.load_work[-1] - result.slip_work[-1] - result.kinetic_energy[-1]
    assert abs(float(work)) <= 0.01 * float(result.load_work[-1])


@pytest.mark.parametrize("grid_angle", [0.0, 20.0])
@pytest.mark.parametrize(
    "held",
    [{"friction": 0.8}, {"friction": 0.0, "adhesion": 4000.0, "slope": 0.0, "drive": 2000.0}],
)
def test_block_at_rest_does_not_creep(held: dict[str, Value], grid_angle: float) -> None:
    """A share of the 1e-4 of its length that it may creep in a million steps."""
    result = SlidingBlock(**COARSE, **held, grid_angle=grid_angle, rest_time=20.0).run()
    assert float(result.error) <= 1e-4 * float(result.step_count) / 1e6


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"friction": -0.1}, "friction"),
        ({"slope": 0.0}, "drive"),
        ({"gravity": 0.0, "drive": 1.0}, "normal_pressure"),
        ({"height_ratio": 0.2}, "height_ratio"),
        ({"height_ratio": 1.0, "friction": 0.8}, "height_ratio"),
        ({"interface_radius": 2.0}, "friction"),
        ({"interface_radius": 2.0, "friction": 0.0, "grid_angle": 5.0}, "grid_angle"),
        ({"interface_radius": 0.5, "friction": 0.0}, "interface_radius"),
    ],
)
def test_a_block_without_its_exact_solution_is_refused(given: dict[str, Value], key: str) -> None:
    with pytest.raises(ParameterError, match=key) as refusal:
        SlidingBlock(**given)
    assert refusal.value.key == key


def test_a_block_at_rest_is_watched_for_as_long_as_it_would_slide_freely() -> None:
    block = SlidingBlock(friction=0.8, length=2.0)
    acceleration = block.driving_force / block.mass
    assert 0.5 * acceleration * block.rest_time**2 == pytest.approx(block.length)
    assert SlidingBlock(friction=0.8, rest_time=3.0).rest_time == 3.0


integral = partial(cumulative_trapezoid, initial=0.0)


@pytest.mark.parametrize("rise_time", [0.3, None])
def test_exact_motion_solves_its_equation(rise_time: float | None) -> None:
    travel = 0.7
    motion = SlidingMotion(mass=3.0, driving_force=20.0, resistance=8.0, rise_time=rise_time)
    since = np.linspace(0.0, motion.duration(travel), 20_001)
    velocity, displacement, shear = motion.at(since)
    rise = since[-1] if rise_time is None else rise_time
    force, step = 20.0 * np.minimum(since / rise, 1.0), since[1]
    # Trapezoids: off by a step of the force where it has a kink.
    np.testing.assert_allclose(3.0 * velocity, integral(force - shear, dx=step), atol=20.0 * step)
    np.testing.assert_allclose(displacement, integral(velocity, dx=step), atol=travel * step)
    at_rise, speed = (np.interp(rise, since, curve) for curve in (displacement, velocity))
    drift = speed * (since[-1] - rise)
    covered = displacement[-1] if rise_time is None else displacement[-1] - at_rise - drift
    assert covered == pytest.approx(travel, rel=1e-6 if rise_time is None else 1e-3)


def test_exact_motion_below_its_resistance_is_none() -> None:
    motion = SlidingMotion(mass=3.0, driving_force=5.0, resistance=8.0, rise_time=1.0)
    velocity, displacement, shear = motion.at(np.array([0.0, 0.5, 1.0, 4.0]))
    assert not motion.slides
    np.testing.assert_array_equal([velocity, displacement], 0.0)
    np.testing.assert_allclose(shear, [0.0, 2.5, 5.0, 5.0])


def test_free_flight_keeps_momentum_spin_and_shape() -> None:
    steps, rim_speed = 10_000, 0.02
    block = FlyingBlock(step_count=steps, rim_speed=rim_speed)
    result = block.run()
    rounding = steps * np.finfo(float).eps
    assert float(result.momentum_error) <= rounding
    assert float(result.spin_error) <= rounding
    # Of a finite turn second order is kept, the third is left over; and inertia strains the block
    # by rho (w l)^2 / E at most.
    turn = rim_speed * TIME_STEP_FRACTION / block.cells_per_side
    assert float(result.error) <= steps * turn**3 + rim_speed**2


def test_the_shape_of_a_block_costs_no_more_than_its_points() -> None:
    """Of each point its distances from as many others, however many there are."""
    small, large = (FlyingBlock(cells_per_side=cells).run_size() for cells in (4, 100))
    assert large.curve_bytes / large.particle_count == small.curve_bytes / small.particle_count
    block = FlyingBlock(cells_per_side=20, step_count=100, travel=0.1)
    simulation = Simulation(block.build())
    position = simulation.array("particle.position")
    simulation.assign("particle.velocity", 1.0 + position[:, ::-1] * [-1.0, 1.0])
    sampler = free_flight(simulation, 1.0 / block.cells_per_side)
    position[-1] += 0.01  # the last point, at a corner: of the lattice none
    tracemalloc.start()
    sampler.sample()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < block.run_size().curve_bytes
    assert 0.009 < float(sampler.dataset().shape_change[0]) * np.sqrt(2.0) < 0.016
