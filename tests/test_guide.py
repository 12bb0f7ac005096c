"""The guide: its commands run as they stand, in an empty folder, and give what it says."""

import re
from pathlib import Path

import pytest

from tests.conftest import said_by_commands

GUIDE = Path(__file__).parents[1] / "studies" / "guide.md"
STEPS = dict(re.findall(r"^## (\d)\. .*?\n(.*?)(?=^## |\Z)", GUIDE.read_text(), re.M | re.S))
SLOW = ("3", "4", "7")
NEEDED = {"7": "2"}
"""A step that goes on with the study of another one."""


def commands(step: str) -> str:
    """The commands of a step, as a reader copies them; a script is saved by its name."""
    text = STEPS[step]
    lines = []
    for language, block in re.findall(r"^```(\w+)\n(.*?)^```$", text, re.M | re.S):
        if language == "python":
            (name,) = re.findall(r"Save it as `([^`]+)`", text)
            lines.append(f"cat > {name} <<'END_OF_SCRIPT'\n{block}END_OF_SCRIPT\n")
        else:
            assert language == "sh"
            lines.append(block)
    return "".join(lines)


@pytest.mark.parametrize(
    "step", [pytest.param(it, marks=[pytest.mark.slow] if it in SLOW else []) for it in STEPS]
)
def test_a_step_runs_in_an_empty_folder(step: str, tmp_path: Path) -> None:
    steps = [NEEDED[step], step] if step in NEEDED else [step]
    told = said_by_commands("".join(commands(it) for it in steps), tmp_path)
    for picture in re.findall(r"`(results/[^`]+)`", STEPS[step]):
        assert (tmp_path / picture).stat().st_size > 0
    said = re.findall(r"[\d.]+ ± [\d.]+\d", STEPS[step])
    assert {*said} <= {*re.findall(r"[\d.]+ ± [\d.]+\d", told.replace("+-", "±"))}


def test_the_contents_lead_to_every_step() -> None:
    headings = re.findall(r"^## (.*)$", GUIDE.read_text(), re.M)
    assert headings == re.findall(r"^\| \[(.*?)\]", GUIDE.read_text(), re.M)
