"""Replay of steps: the same bits with any number of threads, and however steps are divided."""

import gc
import multiprocessing
import threading
import weakref

import numpy as np
import pytest
import warp as wp

import mpm_warp.execution.replay
from mpm_warp import CatalogueScene, Execution, GravityColumn, Simulation, SlidingBlock
from mpm_warp.execution.replay import (
    COST_OF_TRIALS,
    FEWEST,
    MOST_TOGETHER,
    DeviceRun,
    ThreadChoice,
)
from mpm_warp.grid.fitted import Floats
from tests.conftest import wait_until
from tests.mpm_warp.conftest import assert_same_bits
from tests.mpm_warp.execution.conftest import CONE, FEW_ROWS

pytestmark = pytest.mark.slow


def penetrated(*threads: int) -> Simulation:
    """A run after a radius of penetration, whose threads change on the way."""
    execution = Execution()
    simulation = Simulation(CONE.build(), execution)
    for part, execution.threads in enumerate(threads, start=1):
        simulation.travel_to(CONE.cone_radius * part / len(threads))
    assert any(launch.is_shared for launch in simulation.plan.step)
    return simulation


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("threads", [(2,), (4,), (1, 4, 2, 1)], ids=["2", "4", "come and go"])
def test_threads_do_not_change_a_bit(threads: tuple[int, ...]) -> None:
    # The same stops, because a run takes whole steps up to each.
    assert_same_bits(penetrated(*(1 for _ in threads)), penetrated(*threads))


@pytest.mark.usefixtures("all_take_part")
def test_simulations_in_threads_of_one_process_take_turns() -> None:
    scene = GravityColumn(cell_count=10)
    alone = Simulation(scene.build())
    alone.advance(200)
    positions = list[Floats]()

    def simulate() -> None:
        simulation = Simulation(scene.build())
        for _ in range(20):
            simulation.advance(10)
        positions.append(simulation.array("particle.position").copy())

    threads = [threading.Thread(target=simulate) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(positions) == len(threads)
    for position in positions:
        np.testing.assert_array_equal(position, alone.array("particle.position"))


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("unlucky", [0, 1])
def test_nobody_waits_for_a_thread_that_has_left_a_step(
    unlucky: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by Ctrl-C, which reaches the caller between two calls."""
    simulation = Simulation(CONE.build(), Execution(threads=2))
    # Each step by a call of its own.
    monkeypatch.setattr(mpm_warp.execution.replay, "UPDATES_PER_CALL", 0)
    simulation.advance(50)
    replay, main = wp.capture_launch, threading.main_thread()
    calls = [0, 0]

    def interrupted(graph: wp.Graph) -> None:
        thread = int(threading.current_thread() is not main)
        calls[thread] += 1
        if thread == unlucky and calls[thread] == 3:
            wait_until(lambda: calls[1 - unlucky] >= 3)  # the other is in the step
            raise InterruptedError
        replay(graph)

    with monkeypatch.context() as patch:
        patch.setattr(wp, "capture_launch", interrupted)
        with pytest.raises(InterruptedError):
            simulation.advance(400)
    assert calls[unlucky] == 3
    assert calls[1 - unlucky] < 100  # the other does not go on alone for long
    test_threads_do_not_change_a_bit((2,))  # of another run, with the same threads


def test_steps_are_the_same_one_by_one_as_on_a_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    at_once, one_by_one = (Simulation(CONE.build()) for _ in range(2))
    at_once.advance(100)
    replay = DeviceRun._replay_one_by_one
    monkeypatch.setattr(DeviceRun, "replay", lambda self, steps, threads: replay(self, steps))
    one_by_one.advance(100)
    assert_same_bits(at_once, one_by_one)


@pytest.mark.parametrize("scene", [CONE, GravityColumn(cell_count=3)])
def test_steps_are_the_same_however_they_are_parted(
    scene: CatalogueScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, parted = Simulation(scene.build()), Simulation(scene.build())
    whole.advance(100)
    updates = 7 * parted.plan.particle_count
    monkeypatch.setattr(mpm_warp.execution.replay, "UPDATES_PER_CALL", updates)
    for count in (1, 15, 16, 17, 3, 48):
        parted.advance(count)
    assert_same_bits(whole, parted)


def test_steps_are_counted_beyond_what_the_state_of_a_loop_holds() -> None:
    early, late = (Simulation(CONE.build()) for _ in range(2))
    late.step_count = late._healthy_step = 2**31 - 16
    for simulation in (early, late):
        simulation.advance(40)
    assert_same_bits(early, late)


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_goes_on_with_threads_of_its_own() -> None:
    """It has none of those of its parent, for which it would wait without end."""
    parent, alone = (Simulation(CONE.build(), Execution(threads=count)) for count in (2, 1))
    parent.advance(40)
    alone.advance(80)

    def go_on() -> None:
        parent.advance(40)
        assert_same_bits(parent, alone)

    child = multiprocessing.get_context("fork").Process(target=go_on)
    child.start()
    child.join(60.0)
    child.kill()
    assert child.exitcode == 0


def test_threads_that_are_slower_than_one_pause_and_are_tried_again() -> None:
    choice = ThreadChoice()
    assert choice.choose(1, 1000) == (1, 1000)
    assert choice.choose(2, 1000) == (1, MOST_TOGETHER)  # to know what one thread takes
    choice.note(1, step_count=100, seconds=1.0)
    assert choice.choose(2, 1000) == (2, FEWEST)
    choice.note(2, step_count=100, seconds=0.6)
    assert choice.choose(2, 1000) == (2, MOST_TOGETHER)
    choice.note(2, step_count=100, seconds=2.0)  # late by chance
    assert choice.choose(2, 10) == (2, 10)
    choice.note(2, step_count=100, seconds=2.0)  # a second more than one thread takes
    for _ in range(round(1.0 / COST_OF_TRIALS)):
        assert choice.choose(2, 1000) == (1, MOST_TOGETHER)
        choice.note(1, step_count=100, seconds=1.0)
    assert choice.choose(2, 1000) == (2, FEWEST)
    choice.note(2, step_count=FEWEST - 1, seconds=9.0)  # too short to tell
    assert choice.choose(2, 1000) == (2, FEWEST)


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("scene", [FEW_ROWS, SlidingBlock(friction=0.0)], ids=["rows", "block"])
def test_scenes_with_fewer_shares_than_threads_give_the_same_bits(scene: CatalogueScene) -> None:
    alone, together = (Simulation(scene.build(), Execution(threads=count)) for count in (1, 4))
    for simulation in (alone, together):
        simulation.advance(40)
    assert_same_bits(alone, together)


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("threads", [1, 2])
def test_a_run_that_is_over_lets_go_of_its_arrays_at_once(threads: int) -> None:
    """A collection of cycles may come late: the next case would find the memory still taken."""
    gc.collect()
    gc.disable()
    try:
        simulation = Simulation(FEW_ROWS.build(), Execution(threads=threads))
        simulation.advance(20)
        arrays = [weakref.ref(array) for array in simulation.arrays.values()]
        del simulation
        assert not any(array() for array in arrays)
    finally:
        gc.enable()
