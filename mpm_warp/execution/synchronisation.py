"""How threads that share launches wait for each other and divide work: a barrier, dynamic chunks.

Warp runs a kernel on one thread of the processor. Each thread therefore launches these two kernels
for itself; they work on arrays that the threads have in common.
"""

import functools
from typing import Any

import warp as wp

LEFT = -1
"""Arrivals of a thread that has left: the others do not wait for it any more."""


@functools.cache
def make_barrier() -> Any:
    """The kernel that waits until all threads have launched it as often as this one.

    What a thread wrote before the barrier, all threads see after it (release and acquire). It waits
    actively, because the others arrive within a microsecond; after a thousand looks it lets other
    processes have the core, in case one of the threads has none.

    Kernel arguments:
        arrivals: how many barriers each thread has reached, or `LEFT`, shape [threads].
        thread: number of this thread.
    """

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
    def wait_for_all(arrivals: wp.array[wp.int64], thread: int, left: int): ...

    @wp.kernel(module="mpm_warp.barrier", enable_backward=False)
    def barrier(arrivals: wp.array[wp.int64], thread: int):
        wait_for_all(arrivals, thread, wp.static(LEFT))

    return barrier


@functools.cache
def make_claim_chunk() -> Any:
    """The kernel by which a thread claims a dynamic chunk: the first thread that asks gets it.

    A claim is the number of the next barrier, so every chunk is free again after that barrier.

    Kernel arguments:
        chunk: number of the chunk.
        thread: number of this thread.
        arrivals: how many barriers each thread has reached, shape [threads].
        claims: the last claim of each chunk, shape [chunks].
        claimed: set to 1 if this thread has got the chunk, else to 0, shape [1].
    """

    @wp.func_native("""
        const wp::int64 now = arrivals.data[thread] + 1;
        const wp::int64 before = __atomic_exchange_n(&claims.data[chunk], now, __ATOMIC_RELAXED);
        claimed.data[0] = before != now;
    """)
    def exchange(
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
        exchange(chunk, thread, arrivals, claims, claimed)

    return claim_chunk
