"""Threads that share a run: the same bits whatever their number, and no share left out."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest
import warp as wp

import mpm_warp.execution.worker_threads
import mpm_warp.execution.shares
from mpm_warp.execution.execution import THREAD_COUNTS, Execution
from mpm_warp.grid.fitted import Floats
from mpm_warp.execution.thread_count import PAUSE, SHORTEST, Pace
from mpm_warp.plan.plan import OFFSET, WORTH_SHARING
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.execution.replay import Player
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.scenes.gravity_column import GravityColumn
from mpm_warp.scenes.blocks.sliding_block import SlidingBlock
from mpm_warp.execution.shares import has_open_pieces, share_of
from mpm_warp.simulation import Simulation
from mpm_warp.execution.team import Team
from mpm_warp.travel import Travel

CONE = ConePenetration(
    cells_per_radius=4, domain_radius=10, domain_above=4, domain_below=4, adhesion_factor=0.5
)


def wait_until(happened: Callable[[], bool]) -> None:
    """Wait for another thread, which is to be soon."""
    deadline = time.monotonic() + 60
    while not happened():
        assert time.monotonic() < deadline, "the other thread never came"
        time.sleep(0.001)


@pytest.fixture
def all_take_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads share the steps, and leave pieces of them open, even where one would be faster."""
    monkeypatch.setattr(mpm_warp.execution.shares, "WORTH_CLAIMING", 1000)
    monkeypatch.setattr(Pace, "choose", lambda self, wanted: wanted)
    monkeypatch.setattr(Pace, "note", lambda self, threads, step_count, seconds: None)


def penetrated(execution: Execution, switches: tuple[int, ...] = ()) -> dict[str, Floats]:
    """All arrays after a radius of penetration, whose threads change on the way."""
    simulation = Simulation(CONE.build()[0], execution)
    travel = Travel(simulation)
    for fraction, threads in enumerate(switches or (execution.threads,), start=1):
        execution.threads = threads
        travel.advance_to(CONE.cone_radius * fraction / len(switches or (1,)))
    assert any(map(has_open_pieces, simulation.plan.step))
    return {name: simulation.array(name).copy() for name in simulation.arrays}


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("threads", [2, 4])
def test_threads_do_not_change_a_bit(threads: int) -> None:
    alone, together = penetrated(Execution()), penetrated(Execution(threads=threads))
    for name, values in alone.items():
        np.testing.assert_array_equal(together[name], values, err_msg=name)


@pytest.mark.usefixtures("all_take_part")
def test_threads_may_come_and_go_during_a_run() -> None:
    # The same stops, because a run takes whole steps up to each.
    steady = penetrated(Execution(), (1, 1, 1, 1))
    changing = penetrated(Execution(), (1, 4, 2, 1))
    for name, values in steady.items():
        np.testing.assert_array_equal(changing[name], values, err_msg=name)


def test_a_scene_whose_launches_are_not_shared_runs_with_any_number_of_threads() -> None:
    block = SlidingBlock(friction=0.0)
    alone, together = block.run(), block.run(execution=Execution(threads=2))
    np.testing.assert_array_equal(alone.displacement, together.displacement)


@pytest.mark.parametrize("scene", [CONE, GravityColumn(cell_count=3)])
@pytest.mark.parametrize("count", [1, 3, SHARE_COUNT, 1000])
def test_the_shares_of_a_launch_make_up_the_whole(
    scene: ConePenetration | GravityColumn, count: int
) -> None:
    soil = scene.simulated_scene()
    assert soil is not None
    for launch in make_plan(soil).step:
        if OFFSET not in launch.arguments:
            continue
        place = next(k for k, item in enumerate(launch.share(0, count).arguments) if item == 0)
        covered = []
        for number in range(count):
            share = launch.share(number, count)
            first = share.arguments[place]
            covered += range(first, first + share.dim[0])
        assert covered == list(range(launch.dim[0]))


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("threads", [1, 2, 4])
def test_what_threads_do_of_a_launch_makes_up_the_whole(threads: int) -> None:
    for launch in make_plan(CONE.build()[0]).step:
        if OFFSET not in launch.arguments:
            continue
        place = launch.arguments.index(OFFSET)
        shares = [share_of(launch, it, threads, SHARE_COUNT) for it in range(threads)]
        parts = [part for share in shares for part in share.own] + [*shares[0].open.values()]
        done = [it + part.arguments[place] for part in parts for it in range(part.dim[0])]
        assert sorted(done) == list(range(launch.dim[0]))
        assert len({frozenset(share.open) for share in shares}) == 1
        assert bool(shares[0].open) == (threads > 1 and has_open_pieces(launch))


def test_threads_share_what_takes_longer_than_to_wait_for_each_other() -> None:
    scene = CONE.build()[0]
    assert scene.contact is not None
    small = [
        launch
        for launch in make_plan(scene).step
        if OFFSET in launch.arguments and not launch.is_shared
    ]
    assert any(launch.dim == (len(scene.contact.nodes),) for launch in small)
    assert all(launch.item_count < WORTH_SHARING for launch in small)
    # What adds up is always split, else the number of threads would change how sums are rounded.
    few = GravityColumn(cell_count=3).simulated_scene()
    assert few is not None
    assert all(launch.is_shared == launch.adds_up for launch in make_plan(few).step)


def test_thread_counts_divide_the_shares_so_that_all_have_as_many() -> None:
    assert all(SHARE_COUNT % threads == 0 for threads in THREAD_COUNTS)


@pytest.mark.parametrize("unlucky", [0, 1])
def test_what_a_part_of_a_team_raises_is_raised_after_all_have_ended(unlucky: int) -> None:
    done: list[int] = []
    left: list[int] = []

    def part(number: int) -> None:
        if number == unlucky:
            raise ArithmeticError(f"part {number}")
        wait_until(lambda: bool(left))  # for the other
        done.append(number)

    team = Team(3)
    with pytest.raises(ArithmeticError, match=f"part {unlucky}"):
        team.run(part, left.append)
    assert left == [unlucky]
    assert sorted(done) == sorted({0, 1, 2} - {unlucky})
    team.run(done.append, left.append)  # it works on
    assert len(done) == 5
    assert left == [unlucky]


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("unlucky", [0, 1])
def test_nobody_waits_for_a_thread_that_has_left_a_step(
    unlucky: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by Ctrl-C, which reaches the caller between two calls."""
    simulation = Simulation(CONE.build()[0], Execution(threads=2))
    monkeypatch.setattr(mpm_warp.execution.worker_threads, "LONGEST_CALL", 0)  # each step by a call
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
    test_threads_do_not_change_a_bit(2)  # of another run, with the same threads


def test_steps_are_the_same_one_by_one_as_on_a_gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    at_once, one_by_one = (Simulation(CONE.build()[0]) for _ in range(2))
    at_once.advance(100)
    play = Player._play_one_by_one
    monkeypatch.setattr(Player, "play", lambda self, steps, threads: play(self, steps))
    one_by_one.advance(100)
    for name in at_once.arrays:
        np.testing.assert_array_equal(one_by_one.array(name), at_once.array(name), err_msg=name)


@pytest.mark.parametrize("scene", [CONE, GravityColumn(cell_count=3)])
def test_steps_are_the_same_however_they_are_parted(
    scene: ConePenetration | GravityColumn, monkeypatch: pytest.MonkeyPatch
) -> None:
    soil = scene.simulated_scene()
    assert soil is not None
    whole, parted = Simulation(soil), Simulation(soil)
    whole.advance(100)
    monkeypatch.setattr(mpm_warp.execution.worker_threads, "LONGEST_CALL", 7 * parted.plan.particle_count)
    for count in (1, 15, 16, 17, 3, 48):
        parted.advance(count)
    for name in whole.arrays:
        np.testing.assert_array_equal(parted.array(name), whole.array(name), err_msg=name)
    if soil.window is not None:
        time = float(whole.array("window.motion")[0])
        assert time == pytest.approx(100 * whole.plan.time_step, rel=1e-12)


def test_threads_that_are_slower_than_one_pause_and_are_tried_again() -> None:
    pace = Pace()
    assert pace.choose(2) == 1  # to know what one thread takes
    pace.note(1, step_count=100, seconds=1.0)
    assert pace.choose(2) == 2
    pace.note(2, step_count=100, seconds=0.6)
    assert pace.choose(2) == 2
    pace.note(2, step_count=100, seconds=2.0)  # late by chance
    assert pace.choose(2) == 2
    pace.note(2, step_count=100, seconds=2.0)
    for _ in range(PAUSE):
        assert pace.choose(2) == 1
        pace.note(1, step_count=1, seconds=0.01)
    assert pace.choose(2) == 2
    pace.note(2, step_count=SHORTEST - 1, seconds=9.0)  # too short to tell
    assert pace.choose(2) == 2
    assert pace.choose(1) == 1


def test_single_precision_halves_every_array_of_real_numbers() -> None:
    single = make_plan(dataclasses.replace(CONE, precision="float32").build()[0]).arrays
    double = make_plan(CONE.build()[0]).arrays
    same = {"particle.cell", "layer.cell", "layer.places", "window.motion"}
    same |= {"fixed.nodes", "contact.nodes", "far_field.nodes"}
    for name, array in double.items():
        half = 1 if name in same else 2
        assert array.byte_count == half * single[name].byte_count, name
