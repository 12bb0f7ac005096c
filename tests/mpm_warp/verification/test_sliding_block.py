"""The sliding block against the motion of a rigid one: bounds are those that users rely on."""

from __future__ import annotations

import pytest

from mpm_warp.parameters import Value
from mpm_warp.scenes.sliding_block import SlidingBlock

PUSHED: dict[str, Value] = {
    "friction": 0.0,
    "adhesion": 500.0,
    "slope": 0.0,
    "gravity": 0.0,
    "drive": 1500.0,
}


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("adhesion", [0.0, 500.0, 2000.0])
@pytest.mark.parametrize("slope", [0.0, 30.0])
def test_acceleration_along_the_grid(friction: float, adhesion: float, slope: float) -> None:
    block = SlidingBlock(friction=friction, adhesion=adhesion, slope=slope, drive=8000.0)
    assert block.motion.slides
    assert float(block.run().acceleration_error) <= 0.01


@pytest.mark.parametrize(("angle", "offset"), [(5, 0.0), (15, 0.3), (26, 0.6), (45, 0.25)])
@pytest.mark.parametrize("stiffness_ratio", [None, 1.0])
def test_acceleration_at_an_angle_to_the_grid(
    angle: float, offset: float, stiffness_ratio: float | None
) -> None:
    block = SlidingBlock(
        drive=5000.0, grid_angle=angle, grid_offset=offset, stiffness_ratio=stiffness_ratio
    )
    assert float(block.run().acceleration_error) <= 0.03


@pytest.mark.parametrize("normal_pressure", [500.0, 5e4, 5e5])
@pytest.mark.parametrize("interface_radius", [None, 2.0])
@pytest.mark.parametrize("mass_scale", [1.0, 100.0])
def test_adhesion_does_not_depend_on_pressure_shape_or_mass(
    normal_pressure: float, interface_radius: float | None, mass_scale: float
) -> None:
    block = SlidingBlock(
        **PUSHED,  # type: ignore[arg-type]
        normal_pressure=normal_pressure,
        interface_radius=interface_radius,
        mass_scale=mass_scale,
    )
    assert float(block.run().base_shear_error) <= 0.01


@pytest.mark.parametrize(
    "held",
    [
        {"friction": 0.8, "adhesion": 0.0},
        {"friction": 0.0, "adhesion": 4000.0, "slope": 0.0, "drive": 2000.0},
    ],
)
@pytest.mark.parametrize("grid_angle", [0.0, 20.0])
def test_block_held_below_slip_does_not_creep(held: dict[str, Value], grid_angle: float) -> None:
    result = SlidingBlock(**held, grid_angle=grid_angle).run()  # type: ignore[arg-type]
    assert float(result.creep) <= 1e-4


@pytest.mark.parametrize("stiffness_ratio", [0.01, 100.0])
def test_bodies_of_unlike_stiffness(stiffness_ratio: float) -> None:
    block = SlidingBlock(drive=5000.0, stiffness_ratio=stiffness_ratio, travel=0.1)
    assert float(block.run().acceleration_error) <= 0.01


def test_force_that_rises_steadily() -> None:
    result = SlidingBlock(drive=5000.0, driving="ramped").run()
    assert float(result.acceleration_error) <= 0.01


def test_momentum_and_energy_balance() -> None:
    """Momentum to the step in which a load has a kink; energy to what the transfer dissipates."""
    block = SlidingBlock(drive=5000.0)
    result = block.run()
    kink = float(result.time_step) / block.duration
    assert float(result.momentum_error) <= kink**2
    assert float(result.energy_error) <= 0.01
    work = result.load_work[-1] - result.slip_work[-1] - result.kinetic_energy[-1]
    assert abs(float(work)) <= 0.01 * float(result.load_work[-1])
