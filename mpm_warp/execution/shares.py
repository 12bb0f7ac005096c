"""How threads share a launch: what each has to do, and what the first to get there does."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from mpm_warp.plan.launch import Launch

WORTH_CLAIMING = 10_000
"""Items of a launch, at least, of which a part is left to whoever comes first."""
PARTS = 4
"""One of so many parts of what a thread has to do is left to whoever comes first."""
PIECES = 4
"""Pieces of that part, each of them claimed by itself."""


@dataclass(frozen=True)
class ThreadShare:
    """What a thread does of a launch.

    Attributes:
        own: what no other does.
        open: pieces that are for the first thread to claim them, by number, in the order in which
            this one tries: those of its own part, then those of others, the last ones first.

    Parts without items, as of a launch with fewer rows than shares, are in neither.
    """

    own: list[Launch]
    open: dict[int, Launch] = field(default_factory=dict)


def has_open_pieces(launch: Launch) -> bool:
    """Whether several threads leave pieces of a launch to the first of them."""
    return launch.is_shared and not launch.adds_up and launch.item_count >= WORTH_CLAIMING


def share_of(launch: Launch, thread: int, threads: int, share_count: int) -> ThreadShare:
    """What one of so many threads does of a launch.

    Args:
        launch: any of a plan.
        thread: number of the thread; the first does what is not shared.
        threads: how many there are, >= 1.
        share_count: into how many shares a launch is split that adds up; a multiple of `threads`.
    """
    if not launch.is_shared:
        return ThreadShare(_filled([launch.share(0, 1)]) if thread == 0 else [])
    if launch.adds_up:
        numbers = range(thread * share_count // threads, (thread + 1) * share_count // threads)
        return ThreadShare(_filled(launch.share(number, share_count) for number in numbers))
    if threads == 1 or not has_open_pieces(launch):
        return ThreadShare(_filled([launch.share(thread, threads)]))
    own = range(PARTS * thread, PARTS * thread + PARTS - 1)
    pieces = {
        piece: launch.share(_place(piece), PARTS * PIECES * threads)
        for piece in _tried(thread, threads)
    }
    return ThreadShare(
        own=_filled(launch.share(number, PARTS * threads) for number in own),
        open={number: piece for number, piece in pieces.items() if piece.item_count > 0},
    )


def _filled(parts: Iterable[Launch]) -> list[Launch]:
    """Those that have items: Warp records no launch of nothing."""
    return [part for part in parts if part.item_count > 0]


def _tried(thread: int, threads: int) -> Iterator[int]:
    """Open pieces in the order in which a thread tries to claim them."""
    yield from range(PIECES * thread, PIECES * (thread + 1))
    for step in range(1, threads):
        owner = (thread + step) % threads
        yield from reversed(range(PIECES * owner, PIECES * (owner + 1)))


def _place(piece: int) -> int:
    """Where an open piece is among the pieces that all parts have."""
    owner, number = divmod(piece, PIECES)
    return PIECES * (PARTS * owner + PARTS - 1) + number
