"""The count of what kernels do: of a kernel with known operations, and of a step of the cone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.benchmark.counting import SAMPLED, Count, stage_work
from mpm_warp.plan.plan import OFFSET, Launch, ShareRow
from mpm_warp.scenes.step_cost import StepCost
from mpm_warp.simulation import Simulation

COUNT = 1000
HALF = wp.constant(wp.float64(0.5))


@wp.func
def scaled(a: wp.float64, x: wp.vec2d) -> wp.vec2d:
    return a * x


@wp.kernel(module="tests.counted", enable_backward=False)
def known(
    first: int,
    scale: wp.float64,
    x: wp.array(dtype=wp.vec2d),
    y: wp.array(dtype=wp.float64),
    total: wp.array(dtype=wp.vec2d),
):
    p = first + wp.tid()
    near = (scale * scale) * y[p]  # one multiplication: the square of the scale is an argument's
    again = (scale * scale) * y[p]  # none: done before
    v = scaled(near + again, x[p])  # an addition, two multiplications
    if y[p] > HALF:  # a comparison, and then
        v = v / wp.sqrt(y[p])  # a root and two divisions
    y[p] = -wp.min(v[0], v[1])  # a minimum
    wp.atomic_add(total, 0, v)  # two additions


def arrays_of(values: np.ndarray) -> dict[str, Any]:
    x = np.arange(2.0 * COUNT).reshape(-1, 2)
    return {
        "x": wp.array(x, dtype=wp.vec2d, device="cpu"),
        "y": wp.array(values, dtype=wp.float64, device="cpu"),
        "total": wp.zeros((2, 1), dtype=wp.vec2d, device="cpu"),
    }


LAUNCH = Launch(kernel=known, dim=(COUNT,), arguments=(OFFSET, 3.0, "x", "y", ShareRow("total")))


@pytest.mark.parametrize(("value", "divisions"), [(0.25, 0), (0.75, 3)])
def test_operations_of_a_known_kernel(value: float, divisions: int) -> None:
    work = Count(LAUNCH, arrays_of(np.full(COUNT, value))).work()
    assert work.operations == pytest.approx(8 * COUNT, rel=1e-12)
    assert work.divisions == pytest.approx(divisions * COUNT, rel=1e-12)
    # x and y read, y written; the sum, which all threads add to, once each way.
    assert work.traffic == pytest.approx((16 + 8 + 8) * COUNT + 2 * 16, rel=1e-12)


def test_branches_count_as_often_as_they_are_taken() -> None:
    values = np.random.default_rng(1).uniform(0.0, 1.0, COUNT)
    work = Count(LAUNCH, arrays_of(values)).work()
    share = work.divisions / (3 * COUNT)
    # As many as among all of them, but for the chance of the sample: three times its deviation.
    assert abs(share - np.mean(values > 0.5)) < 3 * 0.5 / np.sqrt(SAMPLED)


def test_counting_leaves_the_arrays_as_they_are() -> None:
    arrays = arrays_of(np.full(COUNT, 0.75))
    Count(LAUNCH, arrays)
    assert (arrays["y"].numpy() == 0.75).all()
    assert not arrays["total"].numpy().any()


def flat(element: Any) -> list[float]:
    if isinstance(element, tuple):
        return [number for part in element for number in flat(part)]
    return [getattr(element, "value", element)]


@pytest.mark.parametrize("physics", ["cone", "elastic"])
def test_what_is_counted_computes_what_the_kernels_do(physics: str) -> None:
    simulation = Simulation(StepCost(physics=physics, size=600).build())
    stress = simulation.arrays["particle.stress"]
    strength = 0.01 * simulation.scene.material.shear_modulus
    stress.assign(np.random.default_rng(0).uniform(-strength, strength, (len(stress), 4)))
    simulation.advance(20)
    compared = 0
    for launch in simulation.plan.step:
        memories = Count(launch, simulation.arrays).memories
        simulation.launch(launch)
        if launch.adds_up:
            continue  # one thread's part of a sum is not seen in it
        for name, memory in memories.items():
            values = simulation.array(name)
            for index, element in memory.stored:
                # Kernels may add up in another order: some tens of roundings.
                scale = np.abs(values).max()
                np.testing.assert_allclose(
                    flat(element), values[index].ravel(), rtol=0, atol=1e-13 * scale
                )
                compared += 1
    assert compared > 1000


def test_plasticity_and_contact_count() -> None:
    works = {}
    for physics in ("cone", "elastic"):
        simulation = Simulation(StepCost(physics=physics, size=600).build())
        works[physics] = stage_work(simulation)
    cone, elastic = works["cone"], works["elastic"]
    assert cone["surface_contact"].operations > 0
    # At rest none yields; to see that takes the square of the radius of Mohr's circle.
    assert cone["grid_to_particles"].operations > elastic["grid_to_particles"].operations
