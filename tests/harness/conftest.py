"""Studies that run in no time."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from harness.study import Study, load_study

SMALL = """
    title = "A study for tests"
    scene = "cone_penetration"

    [fixed]
    penetration = 1
    cells_per_radius = 1
    particles_per_cell = 4

    [vary]
    adhesion_factor = [0, 0.5, 1]
"""


@pytest.fixture
def small_file(tmp_path: Path) -> Path:
    """The definition of three cases of next to no cost."""
    path = tmp_path / "small.toml"
    path.write_text(dedent(SMALL))
    return path


@pytest.fixture
def small(small_file: Path) -> Study:
    """Three cases of next to no cost."""
    return load_study(str(small_file))
