"""The notebook: its cells run in an empty folder, and give what is stored in it."""

import re
from pathlib import Path
from typing import Any

import nbformat
import pytest

from tests.tour import TOUR, executed

STORED = nbformat.read(TOUR, as_version=4)
OUTPUTS = [output for cell in STORED.cells for output in cell.get("outputs", ())]


def said(output: Any) -> str:
    """The text of an output; that of a picture is its size."""
    return str(output.get("text") or output["data"]["text/plain"])


@pytest.mark.slow
def test_the_cells_give_in_an_empty_folder_what_is_stored(tmp_path: Path) -> None:
    made = [output for cell in executed(tmp_path).cells for output in cell.get("outputs", ())]
    assert [said(it) for it in made] == [said(it) for it in OUTPUTS]


def test_what_is_stored_is_small_and_the_same_for_everyone() -> None:
    assert TOUR.stat().st_size < 150_000
    assert {it.get("name", "stdout") for it in OUTPUTS} == {"stdout"}
    assert not re.search(r"/(home|root|tmp|Users|site-packages)\b", "".join(map(said, OUTPUTS)))
    assert all(cell.metadata == {} for cell in STORED.cells)
    assert dict(STORED.metadata.language_info) == {"name": "python"}


def test_a_factor_that_the_text_quotes_is_one_that_a_cell_gives() -> None:
    text = "".join(cell.source for cell in STORED.cells if cell.cell_type == "markdown")
    quoted = re.findall(r"[\d.]+ ± [\d.]+\d", text)
    assert quoted
    assert all(any(it in said(output) for output in OUTPUTS) for it in quoted)
