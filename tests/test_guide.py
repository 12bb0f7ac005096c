"""The guide: its commands run as they stand, in an empty folder, and give what it says."""

import re
from pathlib import Path

import pytest

from tests.conftest import blocks, said_by_commands

GUIDE = Path(__file__).parents[1] / "studies" / "guide.md"
STEPS = dict(re.findall(r"^## (\d)\. .*?\n(.*?)(?=^## |\Z)", GUIDE.read_text(), re.M | re.S))


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_a_step_runs_in_an_empty_folder(step: str, tmp_path: Path) -> None:
    told = said_by_commands("".join(blocks(STEPS[step], "sh")), tmp_path)
    for picture in re.findall(r"`(results/[^`]+)`", STEPS[step]):
        assert (tmp_path / picture).stat().st_size > 0
    said = re.findall(r"[\d.]+ ± [\d.]+\d", STEPS[step])
    assert {*said} <= {*re.findall(r"[\d.]+ ± [\d.]+\d", told.replace("+-", "±"))}


def test_the_contents_lead_to_every_step() -> None:
    headings = re.findall(r"^## (.*)$", GUIDE.read_text(), re.M)
    assert headings == re.findall(r"^\| \[(.*?)\]", GUIDE.read_text(), re.M)
