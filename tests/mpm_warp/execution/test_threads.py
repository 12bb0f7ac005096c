"""Threads: their shares of a launch are the whole of it; a part that raises ends the work."""

import threading

import pytest

from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.threads import run_together, share_of
from mpm_warp.plan.launch import OFFSET
from mpm_warp.planning import SHARE_COUNT
from mpm_warp.scenes import CatalogueScene
from tests.mpm_warp.execution.conftest import CONE, FEW_ROWS


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("scene", [CONE, FEW_ROWS], ids=["cone", "few_rows"])
@pytest.mark.parametrize("threads", THREAD_COUNTS)
def test_what_threads_do_of_a_launch_makes_up_the_whole(
    threads: int, scene: CatalogueScene
) -> None:
    assert SHARE_COUNT % threads == 0
    for launch in scene.plan().step:
        if OFFSET not in launch.arguments:
            continue
        place = launch.arguments.index(OFFSET)
        shares = [share_of(launch, it, threads, SHARE_COUNT) for it in range(threads)]
        parts = [part for share in shares for part in share]
        done = [it + part.arguments[place] for part in parts for it in range(part.dim[0])]
        assert sorted(done) == list(range(launch.dim[0]))
        assert all(part.item_count > 0 for part in parts)


@pytest.mark.parametrize("unlucky", [0, 1])
def test_what_a_part_raises_is_raised_after_all_have_ended(unlucky: int) -> None:
    done, left, has_left = list[int](), list[int](), threading.Event()

    def part(number: int) -> None:
        if number == unlucky:
            raise ArithmeticError(f"part {number}")
        assert has_left.wait(60), "the other thread never came"
        done.append(number)

    def leave(number: int) -> None:
        left.append(number)
        has_left.set()

    with pytest.raises(ArithmeticError, match=f"part {unlucky}"):
        run_together(3, part, leave)
    assert left == [unlucky]
    assert sorted(done) == sorted({0, 1, 2} - {unlucky})
    run_together(3, done.append, leave)  # they work on
    assert len(done) == 5
    assert left == [unlucky]
