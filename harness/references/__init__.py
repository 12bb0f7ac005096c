"""What results are compared with: a registry of references, each with its source and its range.

Importing this package loads no numerical library, so that a command line can name the
references at once.
"""

from __future__ import annotations

from harness.errors import HarnessError
from harness.references.cone_factors import CONE_FACTORS, ConeFactor
from mpm_warp.parameters import nearest_name

__all__ = ["UnknownReferenceError", "cone_factor_reference", "reference_ids"]

_BY_ID = {reference.id: reference for reference in CONE_FACTORS}


class UnknownReferenceError(HarnessError):
    """No reference has that id; the message is one line and names the nearest one."""


def reference_ids() -> tuple[str, ...]:
    """Ids of all references, in the order of the registry."""
    return tuple(_BY_ID)


def cone_factor_reference(reference_id: str) -> ConeFactor:
    """The literature cone factor called `reference_id`.

    Raises:
        UnknownReferenceError: there is none of that id.
    """
    if reference_id not in _BY_ID:
        raise UnknownReferenceError(
            f"unknown reference {reference_id!r}{nearest_name(reference_id, _BY_ID)}"
        )
    return _BY_ID[reference_id]
