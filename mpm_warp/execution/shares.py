"""How threads share a launch: static parts, each of one thread, and dynamic chunks.

A dynamic chunk is done by the first thread that claims it. So a thread that is late, because other
processes take its core, leaves its chunks to the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from mpm_warp.plan.launch import Launch

DYNAMIC_FROM = 10_000
"""Items of a launch from which on a part of it is done in dynamic chunks."""
PARTS_PER_THREAD = 4
"""Equal parts of what a thread has to do; all are static but the last."""
CHUNKS_PER_THREAD = 4
"""Dynamic chunks of the last part."""


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
