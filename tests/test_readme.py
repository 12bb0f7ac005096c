"""The front door: its Python runs as it stands there, and the links of all pages lead on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("[!.]*/**/*.md")])


def blocks(page: Path) -> list[str]:
    """The Python of a page, as a reader would copy it."""
    return re.findall(r"^```python\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)


def run(*arguments: str, folder: Path) -> str:
    """What a Python process of its own prints, started in a folder and without a screen."""
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_its_python_runs(tmp_path: Path) -> None:
    # The main job, coarse and short: the names and dims of its result are those of the full one.
    short = ("cells_per_radius=1", "penetration=1", "steady_tolerance=0")
    settings = [word for setting in short for word in ("--set", setting)]
    run("-m", "harness", "run", "adhesion_factor", *settings, folder=tmp_path)
    from_python, from_file = (run("-c", block, folder=tmp_path) for block in blocks(README))
    assert f"`{from_python.strip()}`" in README.read_text()
    assert (tmp_path / "resistance.png").stat().st_size > 0
    assert from_file.count("completed") == 5


def test_python_of_the_method_runs(tmp_path: Path) -> None:
    for block in blocks(ROOT / "mpm_warp" / "README.md"):
        run("-c", block, folder=tmp_path)


def test_a_stranger_reads_it_in_five_minutes() -> None:
    assert len(README.read_text().splitlines()) <= 150


def anchors(page: Path) -> set[str]:
    """What the headings of a page are called in links, as GitHub makes it of them."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_what_is_there(page: Path) -> None:
    broken = []
    for link in re.findall(r"\]\(([^)]+)\)", page.read_text()):
        file, _, anchor = link.partition("#")
        target = page.parent / file if file else page
        if "://" not in link and not (
            target.exists() and (not anchor or anchor in anchors(target))
        ):
            broken.append(link)
    assert broken == []
