"""Threads of a processor that execute the parts of one launch at the same time.

Here are the shares of each thread in a launch, the barrier at which they wait for each other, and
the threads themselves. Warp runs a kernel on one thread of the processor, so each thread launches
the barrier itself; all of them share its array.
"""

import functools
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import ParamSpec, TypeVar

import warp as wp

from mpm_warp.plan.plan import Launch

_WARP = threading.RLock()
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def in_turn(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """The same function, which no two threads of the process are in at the same time.

    What Warp records into a graph is whatever any thread launches meanwhile. So simulations in
    several threads of one process take turns; in several processes they do not need to.
    """

    @functools.wraps(function)
    def alone(*args: Arguments.args, **options: Arguments.kwargs) -> Result:
        with _WARP:
            return function(*args, **options)

    return alone


def share_of(launch: Launch, thread: int, threads: int, share_count: int) -> list[Launch]:
    """What one of several threads does of a launch; every part has items.

    Thread 0 does the launches that are not shared. One that adds up sums has so many shares, a
    multiple of the number of threads.
    """
    if not launch.is_shared:
        parts = [launch.share(0, 1)] if thread == 0 else []
    elif launch.adds_up:
        numbers = range(thread * share_count // threads, (thread + 1) * share_count // threads)
        parts = [launch.share(number, share_count) for number in numbers]
    else:
        parts = [launch.share(thread, threads)]
    # Warp records no launch of nothing, as of fewer rows than shares.
    return [part for part in parts if part.item_count > 0]


LEFT = wp.constant(-1)
"""Number of arrivals given to a thread that has ended, so that others do not wait for it."""


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
    """Wait until all threads have launched this as often as this one.

    What a thread wrote before the barrier, all threads see after it (release and acquire). It waits
    actively, because the others arrive within a microsecond; after a thousand looks it lets other
    processes have the core, in case one of the threads has none. `arrivals` holds how many barriers
    each thread has reached, or `LEFT`.
    """
    _wait_for_all(arrivals, thread, LEFT)


def run_together(count: int, part: Callable[[int], None], leave: Callable[[int], None]) -> None:
    """Do a work on so many threads: each calls ``part(number)``, the caller's with 0; wait for all.

    Parts may wait for each other; ``leave(number)`` is called where one raised: no other part is to
    wait for it. Works are done in turn, so that the parts of two do not mix.

    Raises:
        BaseException: the first that a part raised, or one that reached the caller, as by Ctrl-C.
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
    """So many threads of a process, which end with it; started once: a fork has none at first."""
    return ThreadPoolExecutor(count)
