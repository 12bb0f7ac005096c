"""Threads of a processor that do the parts of one launch at the same time.

What each does of a launch (shares), how they wait for each other and divide what is left (barrier
and chunks, on the device), and the threads themselves.

A part of a large launch is done in dynamic chunks, each by the first thread that claims it. So a
thread that is late, because other processes take its core, leaves its chunks to the others. Warp
runs a kernel on one thread of the processor. Each thread therefore launches barrier and claims for
itself; they work on arrays that the threads have in common.
"""

import functools
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from typing import ParamSpec, TypeVar

import warp as wp

from mpm_warp.plan.launch import Launch

DYNAMIC_FROM = 10_000
"""Items of a launch from which on a part of it is done in dynamic chunks."""
PARTS_PER_THREAD = 4
"""Equal parts of what a thread has to do; all are static but the last."""
CHUNKS_PER_THREAD = 4
"""Dynamic chunks of the last part."""

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


@dataclass(frozen=True)
class ThreadShare:
    """What one thread does of a launch.

    Neither holds anything without items, as there is in a launch with fewer rows than shares.

    Attributes:
        static: launches that only this thread does.
        dynamic: chunks that any thread may do, by number, in the order in which this thread claims
            them: first its own, then those of the other threads, the last ones first.
    """

    static: list[Launch]
    dynamic: dict[int, Launch] = field(default_factory=dict)


def has_dynamic_chunks(launch: Launch) -> bool:
    """Whether several threads do a part of a launch in dynamic chunks."""
    return launch.is_shared and not launch.adds_up and launch.item_count >= DYNAMIC_FROM


def share_of(launch: Launch, thread: int, threads: int, share_count: int) -> ThreadShare:
    """What one of several threads does of a launch.

    Args:
        launch: a launch of a plan.
        thread: number of the thread; thread 0 does the launches that are not shared.
        threads: number of threads, >= 1.
        share_count: number of shares of a launch that adds up sums, a multiple of `threads`.
    """
    if not launch.is_shared:
        return ThreadShare(_filled([launch.share(0, 1)]) if thread == 0 else [])
    if launch.adds_up:
        numbers = range(thread * share_count // threads, (thread + 1) * share_count // threads)
        return ThreadShare(_filled(launch.share(number, share_count) for number in numbers))
    if threads == 1 or not has_dynamic_chunks(launch):
        return ThreadShare(_filled([launch.share(thread, threads)]))
    parts = range(PARTS_PER_THREAD * thread, PARTS_PER_THREAD * (thread + 1) - 1)
    chunks = {
        chunk: launch.share(_position(chunk), PARTS_PER_THREAD * CHUNKS_PER_THREAD * threads)
        for chunk in _order_of_claims(thread, threads)
    }
    return ThreadShare(
        static=_filled(launch.share(part, PARTS_PER_THREAD * threads) for part in parts),
        dynamic={number: chunk for number, chunk in chunks.items() if chunk.item_count > 0},
    )


def _filled(parts: Iterable[Launch]) -> list[Launch]:
    """The parts that have items: Warp records no launch of nothing."""
    return [part for part in parts if part.item_count > 0]


def _order_of_claims(thread: int, threads: int) -> Iterator[int]:
    """Numbers of all dynamic chunks in the order in which a thread claims them."""
    yield from range(CHUNKS_PER_THREAD * thread, CHUNKS_PER_THREAD * (thread + 1))
    for step in range(1, threads):
        owner = (thread + step) % threads
        yield from reversed(range(CHUNKS_PER_THREAD * owner, CHUNKS_PER_THREAD * (owner + 1)))


def _position(chunk: int) -> int:
    """Position of a dynamic chunk in the launch, with every part counted as so many chunks."""
    owner, number = divmod(chunk, CHUNKS_PER_THREAD)
    return CHUNKS_PER_THREAD * (PARTS_PER_THREAD * (owner + 1) - 1) + number


LEFT = wp.constant(-1)
"""Arrivals of a thread that has left: the others do not wait for it any more."""


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
    processes have the core, in case one of the threads has none.

    Args:
        arrivals: how many barriers each thread has reached, or `LEFT`, shape [threads].
        thread: number of this thread.
    """
    _wait_for_all(arrivals, thread, LEFT)


@wp.func_native("""
    const wp::int64 now = arrivals.data[thread] + 1;
    const wp::int64 before = __atomic_exchange_n(&claims.data[chunk], now, __ATOMIC_RELAXED);
    claimed.data[0] = before != now;
""")
def _exchange(
    chunk: int,
    thread: int,
    arrivals: wp.array[wp.int64],
    claims: wp.array[wp.int64],
    claimed: wp.array[wp.int32],
): ...


@wp.kernel(module="mpm_warp.claim_chunk", enable_backward=False)
def claim_chunk(
    chunk: int,
    thread: int,
    arrivals: wp.array[wp.int64],
    claims: wp.array[wp.int64],
    claimed: wp.array[wp.int32],
):
    """Claim a dynamic chunk for a thread: the first thread that asks gets it.

    `claims` holds the last claim of each chunk: the number of the barrier that was next, so every
    chunk is free again after that barrier. `claimed` is 1 where this thread has got the chunk.
    """
    _exchange(chunk, thread, arrivals, claims, claimed)


class WorkerThreads:
    """The caller's thread and others, which are idle between two works and end with the process.

    Args:
        count: number of threads, the caller's included, >= 2.
    """

    def __init__(self, count: int) -> None:
        self._lock = threading.Lock()
        self._others = range(1, count)
        self._pool = ThreadPoolExecutor(count - 1)

    def run(self, part: Callable[[int], None], leave: Callable[[int], None]) -> None:
        """Do a work: every thread calls ``part(number)``, the caller's with 0; wait for all.

        Args:
            part: one thread's part of the work; parts may wait for each other.
            leave: called as ``leave(number)`` where a part raised: no other part is to wait for it.

        Raises:
            BaseException: the first that a part raised, or one that reached the caller, as by
                Ctrl-C.
        """

        def attempt(number: int) -> None:
            try:
                part(number)
            except BaseException:
                leave(number)
                raise

        # Parts may wait for each other, so the parts of two works must not mix.
        with self._lock:
            others = [self._pool.submit(attempt, number) for number in self._others]
            try:
                attempt(0)
            finally:
                wait(others)
        for other in others:
            other.result()


@functools.cache
def worker_threads(count: int) -> WorkerThreads:
    """The process's worker threads of this number, started once."""
    return WorkerThreads(count)
