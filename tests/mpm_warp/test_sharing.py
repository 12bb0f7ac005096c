"""Launches that are too short in their first axis for all of the threads."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from mpm_warp.execution.execution import Execution
from mpm_warp.execution.thread_count import Pace
from mpm_warp.scenes.thick_cylinder import ThickCylinder
from mpm_warp.execution.shares import share_of
from mpm_warp.simulation import Simulation

TWO_ROWS = ThickCylinder(cell_count=120)


def test_nobody_is_given_a_part_of_a_launch_that_is_empty() -> None:
    plan = TWO_ROWS.plan()
    short = [launch for launch in plan.step if launch.is_shared and launch.dim[0] < 4]
    assert short
    for launch in short:
        shares = [share_of(launch, thread, 4, plan.share_count) for thread in range(4)]
        parts = [part for share in shares for part in (*share.own, *share.open.values())]
        assert all(part.item_count > 0 for part in parts)
        assert sum(part.item_count for share in shares for part in share.own) == launch.item_count


def test_fewer_rows_than_threads_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Pace, "choose", lambda self, wanted: wanted)
    monkeypatch.setattr(Pace, "note", lambda self, threads, step_count, seconds: None)
    runs = [Simulation(TWO_ROWS.simulated_scene(), Execution(threads=count)) for count in (1, 4)]
    for simulation in runs:
        simulation.advance(40)
    alone, together = runs
    for name in alone.arrays:
        np.testing.assert_array_equal(together.array(name), alone.array(name), err_msg=name)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_run_that_is_over_lets_go_of_its_arrays_at_once(
    threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A collection of cycles may come late: the next case would find the memory still taken."""
    monkeypatch.setattr(Pace, "choose", lambda self, wanted: wanted)
    monkeypatch.setattr(Pace, "note", lambda self, threads, step_count, seconds: None)
    gc.collect()
    gc.disable()
    try:
        simulation = Simulation(TWO_ROWS.simulated_scene(), Execution(threads=threads))
        simulation.advance(20)
        arrays = [weakref.ref(array) for array in simulation.arrays.values()]
        del simulation
        assert not any(array() for array in arrays)
    finally:
        gc.enable()
