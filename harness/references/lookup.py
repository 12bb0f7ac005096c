"""Finding a reference by its id."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeVar

from harness.errors import HarnessError
from mpm_warp.parameters import nearest_name


class UnknownReferenceError(HarnessError, LookupError):
    """No reference has that id; the message is one line and names the nearest one."""


class HasId(Protocol):
    """What can be found by its id."""

    @property
    def id(self) -> str:
        """Name in study definitions and in the variables of a result."""


Entry = TypeVar("Entry", bound=HasId)


def entry_of(entries: Iterable[Entry], entry_id: str, *, kind: str) -> Entry:
    """The entry that has an id.

    Args:
        entries: all that there are.
        entry_id: the id.
        kind: what the entries are, in the words of a message.

    Raises:
        UnknownReferenceError: none has it.
    """
    by_id = {entry.id: entry for entry in entries}
    if entry_id not in by_id:
        raise UnknownReferenceError(f"unknown {kind} {entry_id!r}{nearest_name(entry_id, by_id)}")
    return by_id[entry_id]
