"""Where threads that share the launches of a step wait for each other.

A kernel runs on one thread of the processor; a launch that is split into shares is followed by this
one. It waits actively, because the others are there within a microsecond; where one of them has no
core to run on, it makes room. Nobody waits for a thread that has left.
"""

import functools
from typing import Any

import warp as wp

LEFT = -1
"""In the place of a thread's arrivals: it does not come any more."""


@functools.cache
def make_rendezvous() -> Any:
    """The kernel, launched once by each thread; `arrivals` counts those of each, shape [threads].

    Acquire and release: what a thread wrote before, all see after.
    """

    @wp.func_native("""
    #if defined(_WIN32)
        auto make_room = [] {};
    #else
        extern int make_room() __asm__("sched_yield");
    #endif
        const wp::int64 now = arrivals.data[thread] + 1;
        __atomic_store_n(&arrivals.data[thread], now, __ATOMIC_RELEASE);
        for (int other = 0; other < arrivals.shape[0]; ++other) {
            for (int looks = 0;; ++looks) {
                const wp::int64 seen = __atomic_load_n(&arrivals.data[other], __ATOMIC_ACQUIRE);
                if (seen >= now || seen == left)
                    break;
                if (looks > 1000)
                    make_room();
            }
        }
    """)
    def meet(arrivals: wp.array(dtype=wp.int64), thread: int, left: int): ...

    @wp.kernel(module="mpm_warp.rendezvous", enable_backward=False)
    def rendezvous(arrivals: wp.array(dtype=wp.int64), thread: int):
        meet(arrivals, thread, wp.static(LEFT))

    return rendezvous
