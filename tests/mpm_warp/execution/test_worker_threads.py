"""Worker threads: a part that raises ends the work, not the threads."""

import threading

import pytest

from mpm_warp.execution.threads import WorkerThreads


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

    workers = WorkerThreads(3)
    with pytest.raises(ArithmeticError, match=f"part {unlucky}"):
        workers.run(part, leave)
    assert left == [unlucky]
    assert sorted(done) == sorted({0, 1, 2} - {unlucky})
    workers.run(done.append, leave)  # they work on
    assert len(done) == 5
    assert left == [unlucky]
