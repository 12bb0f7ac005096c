"""Experience beside a result: bands of factors measured in the field, kept in its file."""

from __future__ import annotations

from collections.abc import Sequence

import xarray as xr

from harness.archive.conventions import Role, with_role
from harness.references.experience import HOLDS, Experience, experience_entry

BOUND = "bound"
"""The dim of the two ends of a band."""


def with_experience(dataset: xr.Dataset, entry_ids: Sequence[str]) -> xr.Dataset:
    """Set bands of experience beside the result of a study.

    Args:
        dataset: the result.
        entry_ids: ids out of :func:`harness.references.experience.experience_ids`.

    Returns:
        The dataset with `experience_<id>` for each id, over the dim `bound`: the least and the
        greatest factor. The attributes say what the band is of, which su it means, what it spans,
        and how all of this is known.

    Raises:
        UnknownReferenceError: an id is unknown.
    """
    if not entry_ids:
        return dataset
    bands = {}
    for entry in map(experience_entry, entry_ids):
        said = {
            "units": "1",
            "long_name": f"{entry.factor} by {entry.label}",
            "role": Role.EXPERIENCE,
            "factor": entry.factor.definition,
            "formula": entry.formula,
            "validity": f"{entry.clays}; {entry.spans}",
            "strength": entry.strength,
            "holds": HOLDS,
            "source": entry.source,
            "how_known": entry.how_known,
        }
        bands[f"{Role.EXPERIENCE}_{entry.id}"] = (BOUND, list(entry.bounds), said)
    ends = (BOUND, ["least", "greatest"], {"long_name": "end of a band"})
    return dataset.assign_coords({BOUND: ends}).assign(bands)


def stored_experience(dataset: xr.Dataset) -> tuple[Experience, ...]:
    """The bands that :func:`with_experience` has set into `dataset`."""
    names = with_role(dataset, Role.EXPERIENCE)
    return tuple(experience_entry(name.removeprefix(f"{Role.EXPERIENCE}_")) for name in names)


def experience_notes(dataset: xr.Dataset) -> list[str]:
    """The bands that a result is set beside, in one line; none where there are none."""
    entries = stored_experience(dataset)
    if not entries:
        return []
    bands = ", ".join(f"{entry.id} {entry.band}" for entry in entries)
    strengths = " or ".join(dict.fromkeys(entry.strength for entry in entries))
    return [f"experience, bands and no references: {bands}; su: {strengths}"]
