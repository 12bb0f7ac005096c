"""Threads of a processor that execute the shares of one launch at the same time.

This file has the shares of each thread in a launch, the barrier at which threads wait for each
other, and the threads themselves. Warp runs a kernel on one thread of the processor, so each thread
launches the barrier; all use the same array.
"""

import functools
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import ParamSpec, TypeVar

import warp as wp

from mpm_warp.plan.launch import Launch

_WARP = threading.RLock()
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def in_turn(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """The same function, called by one thread of the process at a time.

    A graph of Warp records the launches of all threads. So simulations in several threads of a
    process take turns; in several processes they need not.
    """

    @functools.wraps(function)
    def alone(*args: Arguments.args, **options: Arguments.kwargs) -> Result:
        with _WARP:
            return function(*args, **options)

    return alone


def share_of(launch: Launch, thread: int, threads: int, share_count: int) -> list[Launch]:
    """The parts of a launch that one of several threads does; none is empty.

    Thread 0 does launches that are not shared. A launch that adds up sums has `share_count` shares,
    a multiple of the number of threads.
    """
    if not launch.is_shared:
        parts = [launch.share(0, 1)] if thread == 0 else []
    elif launch.adds_up:
        numbers = range(thread * share_count // threads, (thread + 1) * share_count // threads)
        parts = [launch.share(number, share_count) for number in numbers]
    else:
        parts = [launch.share(thread, threads)]
    # Warp records no empty launch, which occurs with fewer rows than shares.
    return [part for part in parts if part.item_count > 0]


LEFT = wp.constant(-1)
"""Number of arrivals of a thread that has ended, so that others do not wait for it."""


@wp.func_native("""
#if defined(_WIN32)
    auto yield_core = [] {};
#else
    extern int yield_core() __asm__("sched_yield");
#endif
    const wp::int64 now = arrivals.data[thread] + 1;
    __atomic_store_n(&arrivals.data[thread], now, __ATOMIC_RELEASE);
    for (int other = 0; other < arrivals.shape[0]; ++other) {
        for (int looks = 0;; ++looks) {
            const wp::int64 seen = __atomic_load_n(&arrivals.data[other], __ATOMIC_ACQUIRE);
            if (seen >= now || seen == left)
                break;
            if (looks > 1000)
                yield_core();
        }
    }
""")
def _wait_for_all(arrivals: wp.array[wp.int64], thread: int, left: int): ...


@wp.kernel(module="mpm_warp.barrier", enable_backward=False)
def barrier(arrivals: wp.array[wp.int64], thread: int):
    """Wait until all threads have launched the barrier as often as this one.

    After it all threads see what each wrote before it (release and acquire). The wait is active,
    because the others arrive within a microsecond. After a thousand looks it yields the core to
    other processes, in case one of the threads has no core. `arrivals` holds the number of barriers
    that each thread has reached, or `LEFT`.
    """
    _wait_for_all(arrivals, thread, LEFT)


def run_together(count: int, part: Callable[[int], None], leave: Callable[[int], None]) -> None:
    """Call ``part(number)`` on each of `count` threads, 0 on the caller's, and wait for all.

    Parts may wait for each other. If a part raises an exception, ``leave(number)`` must tell the
    others not to wait for it.

    Raises:
        BaseException: the first exception of a part or of the caller, as by Ctrl-C.
    """

    def attempt(number: int) -> None:
        try:
            part(number)
        except BaseException:
            leave(number)
            raise

    pool = _pool(count - 1, os.getpid())
    others = [pool.submit(attempt, number) for number in range(1, count)]
    try:
        attempt(0)
    finally:
        wait(others)
    for other in others:
        other.result()


@functools.cache
def _pool(count: int, process: int) -> ThreadPoolExecutor:
    """This number of threads, started once for each process: a forked process has none at first."""
    return ThreadPoolExecutor(count)
