"""References and bands of experience as text: all in a list, or one in full."""

import textwrap
from collections.abc import Iterable, Iterator, Mapping

from harness.references.band import Band, Factor
from harness.references.reference import SYMBOLS, Reference
from harness.references.registry import BANDS, REFERENCES, known

WIDTH = 80
"""Columns of a terminal, at least."""
SYMBOLS_IN_WORDS = "; ".join(f"{name}: {meaning}" for name, meaning in SYMBOLS.items())


def all_entries() -> str:
    """All references, then all bands, about four lines each, without a final line end."""
    references, bands = REFERENCES.values(), BANDS.values()
    factors = " and ".join(factor.definition for factor in Factor)
    lines = [
        *_wrapped(
            "REFERENCES: cone factors by analysis, Nc = (qc - sigma_v0) / su. A study names them "
            "under [compare] references; those of its own it defines as [references.NAME]."
        ),
        *_wrapped(SYMBOLS_IN_WORDS),
        *_listed(
            {
                it.id: (it.text, f"{it.definition}; valid for {it.validity}", it.source)
                for it in references
            }
        ),
        "",
        *_wrapped(f"how known: {_once(it.how_known for it in references)}"),
        "",
        "",
        *_wrapped(
            f"EXPERIENCE: factors measured in the field, {factors}. A study names them under "
            "[compare] experience. They are bands, no references."
        ),
        *_wrapped(f"They hold {_once(it.holds for it in bands)}."),
        *_wrapped(f"su: {_once(f'{it.strength}; {it.other_strengths}' for it in bands)}."),
        *_listed(
            {
                f"{it.id}: {it.band}": (
                    f"{it.formula.text}, for {it.spans}",
                    it.clays,
                    it.source,
                    f"how known: {it.how_known}",
                )
                for it in bands
            }
        ),
    ]
    return "\n".join(lines)


def one_entry(entry_id: str) -> str:
    """One reference or band of experience in full."""
    entries: dict[str, Reference | Band] = {**REFERENCES, **BANDS}
    entry = known(entry_id, entries, "reference")
    rows = _of_reference(entry) if isinstance(entry, Reference) else _of_band(entry)
    width = max(map(len, rows)) + 2
    lines = [entry.id]
    for name, text in rows.items():
        lines += textwrap.wrap(
            text, WIDTH, initial_indent=f"  {name:{width}}", subsequent_indent=" " * (width + 2)
        )
    return "\n".join(lines)


def _of_reference(entry: Reference) -> Mapping[str, str]:
    in_envelope = "one of those that form the envelope" if entry.in_envelope else "not part of it"
    return {
        "kind": "reference: a cone factor by analysis, Nc = (qc - sigma_v0) / su",
        "authors": entry.label,
        "formula": entry.text,
        "symbols": SYMBOLS_IN_WORDS,
        "definition": entry.definition,
        "method": entry.method,
        "range": entry.validity,
        "envelope": in_envelope,
        "source": entry.source,
        "how known": entry.how_known,
    }


def _of_band(entry: Band) -> Mapping[str, str]:
    return {
        "kind": "experience: a band of factors measured in the field, no reference",
        "authors": entry.label,
        "factor": entry.factor.definition,
        "formula": entry.formula.text,
        "band": f"{entry.band}, for {entry.spans}",
        **{f"range of {name}": entry.chosen[name] for name in entry.range},
        "scatter": "reported for su, taken for the factor" if entry.scatter else "not known",
        "clays": entry.clays,
        "su": f"{entry.strength}; {entry.other_strengths}",
        "holds": entry.holds,
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
