"""Bands of experience against their formulas by hand, and what `harness references` prints."""

import itertools
from typing import Any

import pytest

from harness.references.cone_factors import CONE_FACTORS
from harness.references.experience import EXPERIENCE, HOLDS, Experience, Factor
from harness.references.registry import EXPERIENCE_IDS, REFERENCE_IDS, WIDTH, all_entries, one_entry
from tests.harness.conftest import Command, Refusal

# By hand: log10 1.2 = 0.0791812, log10 6.3 = 0.7993405, ln 0.5 = -0.6931472, ln 1.1 = 0.0953102.
BOUNDS = {
    # 0.7 (7.8 + 0.1979531 + 0.82), 1.3 (7.8 + 1.9983514 + 4.1)
    "karlsrud_2005": (6.172567, 18.067857),
    # 0.85 (8.5 + 0.1979531), 1.15 (8.5 + 1.9983514)
    "karlsrud_2005_sensitive": (7.393260, 12.073104),
    # 10.5 - 4.6 ln 1.1, 10.5 - 4.6 ln 0.5
    "mayne_peuchen_2018": (10.061573, 13.688477),
    "mayne_peuchen_2018_all": (8.0, 25.0),
    # 0.85 (6.9 - 3.1973622 + 0.7), 1.15 (6.9 - 0.3167250 + 3.5)
    "karlsrud_2005_pore_pressure": (3.742242, 11.595766),
    # 0.85 (9.8 - 3.5970325), 1.15 (9.8 - 0.3563156)
    "karlsrud_2005_pore_pressure_sensitive": (5.272522, 10.860237),
}

each_entry = pytest.mark.parametrize("entry", EXPERIENCE, ids=EXPERIENCE_IDS)


@each_entry
def test_band_is_the_one_calculated_by_hand(entry: Experience) -> None:
    assert entry.bounds == pytest.approx(BOUNDS[entry.id], abs=2e-6)
    low, high = entry.bounds
    assert entry.band == f"{entry.factor} {low:.1f} to {high:.1f}"


@each_entry
def test_nothing_within_the_ranges_is_outside_the_band(entry: Experience) -> None:
    """The band is taken from the ends of the ranges alone, so each formula has to be monotonic."""
    inside = [
        [it.low + share * (it.high - it.low) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
        for it in entry.inputs
    ]
    low, high = entry.bounds
    for values in itertools.product(*inside):
        for side in (1.0 - entry.scatter, 1.0 + entry.scatter):
            assert low <= entry.evaluate(*values) * side <= high


@each_entry
def test_every_entry_says_what_it_is_and_how_it_is_known(entry: Experience) -> None:
    assert all((entry.label, entry.formula, entry.clays, entry.source))
    assert "compression" in entry.strength
    assert "abstract was read" in entry.how_known
    assert all(it.chosen and it.span in entry.spans for it in entry.inputs)
    assert ("%" in entry.spans) == (entry.scatter > 0.0)


def test_formulas_of_the_pore_pressure_are_told_from_those_of_the_resistance() -> None:
    assert Factor.RESISTANCE.definition == "Nkt = (qt - sigma_v0) / su"
    assert Factor.PORE_PRESSURE.definition == "N_du = (u2 - u0) / su"
    for entry in EXPERIENCE:
        assert (entry.factor is Factor.PORE_PRESSURE) == ("pore_pressure" in entry.id)


def test_ids_are_those_of_no_reference() -> None:
    assert not {*EXPERIENCE_IDS} & {*REFERENCE_IDS}
    assert len({*EXPERIENCE_IDS}) == len(EXPERIENCE)


ENTRIES: list[Any] = [*CONE_FACTORS, *EXPERIENCE]


def plain(text: str) -> str:
    """The text without the line breaks of a terminal."""
    return " ".join(text.split())


def test_all_entries_are_listed_with_what_is_known_of_them() -> None:
    text = plain(all_entries())
    for entry in ENTRIES:
        for said in (entry.id, entry.formula, entry.source, entry.how_known):
            assert said in text
    for reference in CONE_FACTORS:
        assert f"criterion: {reference.criterion}; valid for: {reference.validity}" in text
    for entry in EXPERIENCE:
        assert f"{entry.id}: {entry.band} {entry.formula}, for {entry.spans} {entry.clays}" in text
    assert HOLDS in text


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.id for entry in ENTRIES])
def test_one_entry_is_told_in_full(entry: Any) -> None:
    text = plain(one_entry(entry.id))
    for name, value in vars(entry).items():
        if isinstance(value, str) and name != "factor":
            assert value in text
    kind = "reference: a cone factor" if entry in CONE_FACTORS else "experience: a band"
    assert kind in text


def test_a_terminal_is_wide_enough() -> None:
    texts = [all_entries(), *(one_entry(entry.id) for entry in ENTRIES)]
    assert max(len(line) for text in texts for line in text.splitlines()) <= WIDTH


def test_the_command_prints_them(command: Command) -> None:
    assert command("references").out == f"{all_entries()}\n"
    assert command("references", "yu_2000").out == f"{one_entry('yu_2000')}\n"


@pytest.mark.parametrize(
    ("given", "meant"), [("lu_2005", "lu_2004"), ("karlsrud", "karlsrud_2005")]
)
def test_an_unknown_one_is_one_line(given: str, meant: str, refusal: Refusal) -> None:
    assert refusal(["references", given]).endswith(f"did you mean {meant!r}?")
