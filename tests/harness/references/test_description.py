"""`harness references`: all that there is, and one in full."""

from typing import Any

import pytest

from harness.cli.main import main
from harness.references.cone_factors import CONE_FACTORS
from harness.references.experience import EXPERIENCE, HOLDS
from harness.references.registry import WIDTH, all_entries, one_entry
from tests.harness.conftest import Refusal

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


def test_the_command_prints_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["references"]) == 0
    assert capsys.readouterr().out == f"{all_entries()}\n"
    assert main(["references", "yu_2000"]) == 0
    assert capsys.readouterr().out == f"{one_entry('yu_2000')}\n"


@pytest.mark.parametrize(
    ("given", "meant"), [("lu_2005", "lu_2004"), ("karlsrud", "karlsrud_2005")]
)
def test_an_unknown_one_is_one_line(given: str, meant: str, refusal: Refusal) -> None:
    assert refusal(["references", given]).endswith(f"did you mean {meant!r}?")


def test_help_has_a_sentence_and_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["references", "--help"])
    text = plain(capsys.readouterr().out)
    assert "List the cone factors of the literature" in text
    assert "harness references lu_2004" in text
