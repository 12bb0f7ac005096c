"""All references and bands of experience: looked up by id, and listed as text."""

import textwrap
from collections.abc import Collection, Iterable, Iterator, Mapping

from harness.errors import HarnessError
from harness.references.cone_factors import CONE_FACTORS, ConeFactor
from harness.references.experience import BESIDE_COMPRESSION, EXPERIENCE, HOLDS, Experience, Factor
from mpm_warp.names import nearest_name

WIDTH = 80
"""Columns of a terminal, at least."""
SYMBOLS = (
    "Ir = G / su, alpha_c and alpha_s: adhesion factor of the cone's face and of the shaft (alpha: "
    "both), Delta = (sigma_v0 - sigma_h0) / (2 su)"
)
"""The meaning of the symbols in the formulas."""


class UnknownReferenceError(HarnessError, LookupError):
    """There is no reference of that id; the message names the nearest one."""


_REFERENCES = {reference.id: reference for reference in CONE_FACTORS}
_BANDS = {entry.id: entry for entry in EXPERIENCE}
REFERENCE_IDS, EXPERIENCE_IDS = tuple(_REFERENCES), tuple(_BANDS)


def cone_factor_reference(reference_id: str) -> ConeFactor:
    """The cone factor reference with this id."""
    return _REFERENCES[_known(reference_id, _REFERENCES, "reference")]


def experience_entry(entry_id: str) -> Experience:
    """The band of experience with this id."""
    return _BANDS[_known(entry_id, _BANDS, "band of experience")]


def _known(entry_id: str, ids: Collection[str], kind: str) -> str:
    if entry_id not in ids:
        raise UnknownReferenceError(f"unknown {kind} {entry_id!r}{nearest_name(entry_id, ids)}")
    return entry_id


def all_entries() -> str:
    """All references, then all bands, about four lines each, without a final line end."""
    factors = " and ".join(factor.definition for factor in Factor)
    references = {
        reference.id: (
            reference.formula,
            f"criterion: {reference.criterion}; valid for: {reference.validity}",
            reference.source,
        )
        for reference in CONE_FACTORS
    }
    bands = {
        f"{entry.id}: {entry.band}": (
            f"{entry.formula}, for {entry.spans}",
            entry.clays,
            entry.source,
            f"how known: {entry.how_known}",
        )
        for entry in EXPERIENCE
    }
    lines = [
        *_wrapped(
            "REFERENCES: cone factors by analysis, Nc = (qc - sigma_v0) / su, for a 60 degree "
            "cone. A study names them under [compare] references; those of its own it defines as "
            "[references.NAME]."
        ),
        *_wrapped(SYMBOLS),
        *_listed(references),
        "",
        *_wrapped(f"how known: {_once(reference.how_known for reference in CONE_FACTORS)}"),
        "",
        "",
        *_wrapped(
            f"EXPERIENCE: factors measured in the field, {factors}. A study names them under "
            "[compare] experience. They are bands, no references."
        ),
        *_wrapped(f"They hold {HOLDS}."),
        *_wrapped(f"su: {_once(entry.strength for entry in EXPERIENCE)}; {BESIDE_COMPRESSION}."),
        *_listed(bands),
    ]
    return "\n".join(lines)


def one_entry(entry_id: str) -> str:
    """One reference or band of experience in full."""
    entries: dict[str, ConeFactor | Experience] = {**_REFERENCES, **_BANDS}
    entry = entries[_known(entry_id, entries, "reference")]
    rows = _of_reference(entry) if isinstance(entry, ConeFactor) else _of_experience(entry)
    width = max(map(len, rows)) + 2
    lines = [entry.id]
    for name, text in rows.items():
        lines += textwrap.wrap(
            text, WIDTH, initial_indent=f"  {name:{width}}", subsequent_indent=" " * (width + 2)
        )
    return "\n".join(lines)


def _of_reference(entry: ConeFactor) -> Mapping[str, str]:
    in_envelope = "one of those that form the envelope" if entry.in_envelope else "not part of it"
    return {
        "kind": "reference: a cone factor by analysis, Nc = (qc - sigma_v0) / su",
        "authors": entry.label,
        "formula": entry.formula,
        "symbols": SYMBOLS,
        "criterion": entry.criterion,
        "method": entry.method,
        "range": entry.validity,
        "envelope": in_envelope,
        "source": entry.source,
        "how known": entry.how_known,
    }


def _of_experience(entry: Experience) -> Mapping[str, str]:
    return {
        "kind": "experience: a band of factors measured in the field, no reference",
        "authors": entry.label,
        "factor": entry.factor.definition,
        "formula": entry.formula,
        "band": f"{entry.band}, for {entry.spans}",
        **{f"range of {given.symbol}": given.chosen for given in entry.inputs},
        "scatter": "reported for su, taken for the factor" if entry.scatter else "not known",
        "clays": entry.clays,
        "su": f"{entry.strength}; {BESIDE_COMPRESSION}",
        "holds": HOLDS,
        "source": entry.source,
        "how known": entry.how_known,
    }


def _once(texts: Iterable[str]) -> str:
    """Texts without duplicates, joined."""
    return "; ".join(dict.fromkeys(texts))


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH)


def _listed(entries: Mapping[str, Iterable[str]]) -> Iterator[str]:
    """Entries below one another, each a title and indented texts."""
    for title, texts in entries.items():
        yield from ("", title)
        for text in texts:
            yield from textwrap.wrap(text, WIDTH, initial_indent="  ", subsequent_indent="    ")
