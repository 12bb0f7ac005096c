"""All references and bands of experience that ship, from entries.toml, and the envelope."""

import functools
import operator
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import xarray as xr

from harness.errors import HarnessError
from harness.references.band import Band
from harness.references.reference import Reference
from harness.references.strength import Conditions, StrengthMode
from mpm_warp.fields.names import nearest_name

Entry = TypeVar("Entry")


class UnknownReferenceError(HarnessError, LookupError):
    """There is no reference of that id; the message names the nearest one."""


def _read(kind: str, every: str) -> dict[str, dict[str, Any]]:
    """Tables of a kind by name, with what holds for every one of them."""
    document = tomllib.loads(Path(__file__).with_name("entries.toml").read_text("utf-8"))
    shared: dict[str, Any] = document[every]
    return {
        name: {**shared, **entry, "range": {**shared.get("range", {}), **entry.get("range", {})}}
        for name, entry in document[kind].items()
    }


REFERENCES: Mapping[str, Reference] = {
    name: Reference.of(name, entry)
    for name, entry in _read("references", "every_reference").items()
}
BANDS: Mapping[str, Band] = {
    name: Band.of(name, entry) for name, entry in _read("experience", "every_band").items()
}
ENVELOPE = tuple(reference for reference in REFERENCES.values() if reference.in_envelope)


def known(entry_id: str, entries: Mapping[str, Entry], kind: str) -> Entry:
    """The entry with this id, of `REFERENCES` or `BANDS`."""
    if entry_id not in entries:
        raise UnknownReferenceError(f"unknown {kind} {entry_id!r}{nearest_name(entry_id, entries)}")
    return entries[entry_id]


def reference_of(reference_id: str) -> Reference:
    """The reference with this id."""
    return known(reference_id, REFERENCES, "reference")


def without_mode(reading_id: str) -> str:
    """The id of a reference, from that of a reading of it; see `Reference.readings`."""
    endings = (f"_{mode}" for mode in StrengthMode if reading_id.endswith(f"_{mode}"))
    return reading_id.removesuffix(next(endings, ""))


def band_of(entry_id: str) -> Band:
    """The band of experience with this id."""
    return known(entry_id, BANDS, "band of experience")


def envelope(conditions: Conditions) -> tuple[xr.DataArray, xr.DataArray]:
    """Smallest and largest cone factor among the references of the envelope, by any reading.

    Those of another criterion than the case's are not part of it, and one alone is no envelope:
    NaN. It is not a confidence interval: the references differ in meaning of su and method.
    """
    readings = [it for member in ENVELOPE for it in member.readings(conditions)]
    values = [it.evaluate(conditions).where(it.has_criterion(conditions)) for it in readings]
    of_all = xr.concat(xr.broadcast(*values), "reference").where(_count(conditions) > 1)
    return of_all.min("reference"), of_all.max("reference")


def envelope_applies(conditions: Conditions) -> xr.DataArray:
    """Whether all references of the envelope are valid, element by element."""
    fails = (it.has_criterion(conditions) & ~it.applies(conditions) for it in ENVELOPE)
    return (_count(conditions) > 1) & ~functools.reduce(operator.or_, fails)


def _count(conditions: Conditions) -> xr.DataArray:
    """Number of the references of the envelope that have the criterion of the case."""
    return functools.reduce(
        operator.add, (it.has_criterion(conditions).astype(int) for it in ENVELOPE)
    )
