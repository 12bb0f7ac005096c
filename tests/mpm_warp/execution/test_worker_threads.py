"""Worker threads: a part that raises ends the work, not the threads."""

import time

import pytest

from mpm_warp.execution.threads import WorkerThreads


@pytest.mark.parametrize("unlucky", [0, 1])
def test_what_a_part_raises_is_raised_after_all_have_ended(unlucky: int) -> None:
    done: list[int] = []
    left: list[int] = []

    def part(number: int) -> None:
        if number == unlucky:
            raise ArithmeticError(f"part {number}")
        deadline = time.monotonic() + 60
        while not left:  # wait for the other
            assert time.monotonic() < deadline, "the other thread never came"
            time.sleep(0.001)
        done.append(number)

    threads = WorkerThreads(3)
    with pytest.raises(ArithmeticError, match=f"part {unlucky}"):
        threads.run(part, left.append)
    assert left == [unlucky]
    assert sorted(done) == sorted({0, 1, 2} - {unlucky})
    threads.run(done.append, left.append)  # they work on
    assert len(done) == 5
    assert left == [unlucky]
