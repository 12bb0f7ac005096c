"""Who does a piece of work that any of the threads may do: the first that gets there.

The others are told that it is not theirs. A piece is free again after the next rendezvous, because
what claims it is the number of arrivals so far.
"""

import functools
from typing import Any

import warp as wp


@functools.cache
def make_claim() -> Any:
    """The kernel, launched once by each thread for each piece; `mine` is then 1 or 0, shape [1].

    `arrivals` are those of `mpm_warp.execution.barrier`, `claims` by piece.
    """

    @wp.func_native("""
        const wp::int64 now = arrivals.data[thread] + 1;
        const wp::int64 before = __atomic_exchange_n(&claims.data[piece], now, __ATOMIC_RELAXED);
        mine.data[0] = before != now;
    """)
    def take(
        piece: int,
        thread: int,
        arrivals: wp.array(dtype=wp.int64),
        claims: wp.array(dtype=wp.int64),
        mine: wp.array(dtype=int),
    ): ...

    @wp.kernel(module="mpm_warp.claim", enable_backward=False)
    def claim(
        piece: int,
        thread: int,
        arrivals: wp.array(dtype=wp.int64),
        claims: wp.array(dtype=wp.int64),
        mine: wp.array(dtype=int),
    ):
        take(piece, thread, arrivals, claims, mine)

    return claim
