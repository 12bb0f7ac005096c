"""How fast a run is, stage by stage, beside what the machine gives to any kernel."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import warp as wp

from mpm_warp.kernels.timing import make_arithmetic, make_stamp, make_streaming
from mpm_warp.simulation import TimeLoop

REPEATS = 5


@dataclass(frozen=True)
class Yardsticks:
    """What a bare loop reaches on one thread, the best of a few times.

    Attributes:
        streaming: bytes read and written per second [byte/s].
        arithmetic: multiplications and additions in double precision per second [1/s].
    """

    streaming: float
    arithmetic: float


def stage_times(loop: TimeLoop, step_count: int) -> dict[str, float]:
    """Mean time of each launch of a step [s], by the name of its kernel, on one thread.

    The steps are really taken, with a clock between launches.

    Args:
        loop: a run on the processor.
        step_count: steps to take, >= 1.
    """
    step = loop.plan.step
    latest = wp.zeros(1, dtype=wp.int64, device="cpu")
    ticks = wp.zeros(len(step) + 1, dtype=wp.int64, device="cpu")

    def stamp(interval: int) -> None:
        wp.launch(make_stamp(), 1, [interval, latest, ticks], device="cpu")

    with wp.ScopedCapture(device="cpu") as capture:
        stamp(len(step))  # what lies between two steps
        for interval, launch in enumerate(step):
            loop.launch(launch)
            stamp(interval)
    wp.capture_launch(capture.graph)  # warm
    ticks.zero_()
    start = time.perf_counter()
    for _ in range(step_count):
        wp.capture_launch(capture.graph)
    seconds = time.perf_counter() - start
    counts = ticks.numpy()
    per_step = seconds / step_count * counts / counts.sum()
    return {
        launch.kernel.key.split("__")[-1]: float(spent)
        for launch, spent in zip(step, per_step, strict=False)
    }


def stage_bytes(loop: TimeLoop) -> dict[str, int]:
    """Bytes of the arrays that each launch of a step works on, each counted once."""
    arrays = loop.plan.arrays
    return {
        launch.kernel.key.split("__")[-1]: sum(
            arrays[name].byte_count for name in set(launch.arrays)
        )
        for launch in loop.plan.step
    }


def yardsticks() -> Yardsticks:
    """Measure the two bare loops on the processor."""
    count = 4_000_000  # far beyond any cache
    x, y = (wp.zeros(count, dtype=wp.float64, device="cpu") for _ in range(2))
    streaming = _least_time(lambda: wp.launch(make_streaming(), count, [x, y], device="cpu"))
    chains, length = 1000, 1000
    start = wp.zeros(chains, dtype=wp.vec4d, device="cpu")
    arguments = [length, 0.5, 1.0, start]
    arithmetic = _least_time(lambda: wp.launch(make_arithmetic(), chains, arguments, device="cpu"))
    return Yardsticks(
        streaming=3 * 8 * count / streaming, arithmetic=2 * 4 * chains * length / arithmetic
    )


def _least_time(work: Callable[[], object]) -> float:
    work()  # warm
    samples = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        samples.append(time.perf_counter() - start)
    return float(np.min(samples))
