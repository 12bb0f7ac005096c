"""Threads that share a run: the same bits whatever their number, and no share left out."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.execution import THREAD_COUNTS, Execution
from mpm_warp.grids import Floats
from mpm_warp.pace import PAUSE, SHORTEST, Pace
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.scenes.gravity_column import GravityColumn
from mpm_warp.scenes.sliding_block import SlidingBlock
from mpm_warp.simulation import Simulation
from mpm_warp.team import Team
from mpm_warp.travel import Travel

CONE = ConePenetration(
    cells_per_radius=2, domain_radius=10, domain_above=4, domain_below=4, adhesion_factor=0.5
)


def penetrated(execution: Execution, switches: tuple[int, ...] = ()) -> dict[str, Floats]:
    """All arrays after a radius of penetration, whose threads change on the way."""
    simulation = Simulation(CONE.build()[0], execution)
    travel = Travel(simulation)
    for fraction, threads in enumerate(switches or (execution.threads,), start=1):
        execution.threads = threads
        travel.advance_to(CONE.cone_radius * fraction / len(switches or (1,)))
    return {name: simulation.array(name).copy() for name in simulation.arrays}


@pytest.mark.parametrize("threads", [2, 4])
def test_threads_do_not_change_a_bit(threads: int) -> None:
    alone, together = penetrated(Execution()), penetrated(Execution(threads=threads))
    for name, values in alone.items():
        np.testing.assert_array_equal(together[name], values, err_msg=name)


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
        if not launch.is_shared:
            continue
        place = next(k for k, item in enumerate(launch.share(0, count).arguments) if item == 0)
        covered = []
        for number in range(count):
            share = launch.share(number, count)
            first = share.arguments[place]
            covered += range(first, first + share.dim[0])
        assert covered == list(range(launch.dim[0]))


def test_thread_counts_divide_the_shares_so_that_all_have_as_many() -> None:
    assert all(SHARE_COUNT % threads == 0 for threads in THREAD_COUNTS)


def test_what_a_part_of_a_team_raises_is_raised_after_all_have_ended() -> None:
    done = []

    def part(number: int) -> None:
        if number == 1:
            raise ArithmeticError("part 1")
        done.append(number)

    team = Team(3)
    with pytest.raises(ArithmeticError, match="part 1"):
        team.run(part)
    assert sorted(done) == [0, 2]
    team.run(done.append)  # it works on
    assert sorted(done) == [0, 0, 1, 2, 2]


def test_threads_that_are_slower_than_one_pause_and_are_tried_again() -> None:
    pace = Pace()
    assert pace.choose(2) == 1  # to know what one thread takes
    pace.note(1, step_count=100, seconds=1.0)
    assert pace.choose(2) == 2
    pace.note(2, step_count=100, seconds=0.6)
    assert pace.choose(2) == 2
    pace.note(2, step_count=100, seconds=1.1)
    for _ in range(PAUSE):
        assert pace.choose(2) == 1
        pace.note(1, step_count=1, seconds=0.01)
    assert pace.choose(2) == 2
    pace.note(2, step_count=SHORTEST - 1, seconds=9.0)  # too short to tell
    assert pace.choose(2) == 2
    assert pace.choose(1) == 1


def test_single_precision_gives_the_same_cone_factor() -> None:
    """Rounding grows with the root of the number of steps at most, and stays far below 0.5 %."""
    short = dataclasses.replace(CONE, penetration=2.0)
    double = float(short.run().cone_factor)
    single = float(dataclasses.replace(short, precision="float32").run().cone_factor)
    assert single == pytest.approx(double, rel=5e-3)
    assert single != double


def test_single_precision_halves_every_array_of_real_numbers() -> None:
    single = make_plan(dataclasses.replace(CONE, precision="float32").build()[0]).arrays
    double = make_plan(CONE.build()[0]).arrays
    whole = {"particle.cell", "layer.cell", "layer.places", "fixed.nodes", "contact.nodes"}
    for name, array in double.items():
        half = 1 if name in whole or name == "far_field.nodes" else 2
        assert array.byte_count == half * single[name].byte_count, name
