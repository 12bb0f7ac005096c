"""The page on a scene of one's own: its scenes, its bounds, and its way into the harness."""

import math
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.conftest import blocks, said_by_commands

PAGE = (Path(__file__).parents[1] / "mpm_warp/scenes/own_scene.md").read_text(encoding="utf-8")
PIPE, COLUMN = blocks(PAGE)
DEEP = PIPE.replace("maximum=0.29", "maximum=1")
ROUGH = PIPE.replace("in_situ_stress=1e5", "in_situ_stress=1e5, adhesion=STRENGTH")
VON_MISES = PIPE.replace("Tresca", "VonMises")
DEEPEST = 0.29
"""Embedment up to which the upper bound holds."""


@pytest.fixture
def pipe(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Any]:
    """The module of the page, or a text made of it."""
    (tmp_path / "pipe.py").write_text(getattr(request, "param", PIPE), encoding="utf-8")
    sys.path.insert(0, str(tmp_path))
    invalidate_caches()
    yield import_module("pipe")
    sys.path.remove(str(tmp_path))
    del sys.modules["pipe"]


@pytest.mark.parametrize("pipe", [DEEP], indirect=True)
def test_the_lower_bound_is_that_of_a_strip_and_4_where_the_pipe_is_half_buried(pipe: Any) -> None:
    """Beside 2 + pi over the width in contact there is -t sin t, to the first order in t."""
    shallow = 1e-6
    t = math.acos(1 - shallow)
    lower, upper = pipe.Pipe(embedment=shallow).bounds
    assert lower / math.sin(t) == pytest.approx(2 + math.pi - t, rel=t**2)
    assert upper / lower - 1 < t**2
    assert pipe.Pipe(embedment=1).bounds[0] == pytest.approx(4, rel=1e-12)


def dissipated(t: float, *, counted_as_positive: bool) -> float:
    """Dissipation of the field of slip lines, over su, the speed and the radius of half a pipe.

    Soil moves at v = sqrt(2) cos a along the line that begins at the angle a of the face, at the
    distance s = (t - a) / sqrt(2) from the rim. With the radius of curvature q of a line the shear
    rate is v / q - dv/ds. The regions are the wedge at the surface, the fan, and that of the face,
    where the straight lines of the other family begin at the angle b. By the midpoint rule.
    """
    size = np.abs if counted_as_positive else np.asarray
    count = 400
    a = t * (np.arange(count) + 0.5) / count
    step = t / count
    s, v, slope = (t - a) / math.sqrt(2), math.sqrt(2) * np.cos(a), 2 * np.sin(a)
    strip = step / math.sqrt(2)
    fan = math.pi / 2 - t
    q = (1 + a[:, None] - a) / math.sqrt(2)
    below = np.where(a < a[:, None], 1.0, np.where(a == a[:, None], 0.5, 0.0))
    rates = float(np.sum(size(-slope) * s * strip))
    rates += float(np.sum(size(v / s - slope) * fan * s * strip))
    rates += float(np.sum(below * size(v / q - slope) * q * step * strip))
    length = float(np.sum((1 + a) / math.sqrt(2)) * step) + (fan + 1) * t / math.sqrt(2)
    return rates + math.sqrt(2) * length


@pytest.mark.parametrize("embedment", [0.05, 0.25, DEEPEST])
def test_the_bounds_are_the_dissipation_of_the_field_of_slip_lines(
    embedment: float, pipe: Any
) -> None:
    t = math.acos(1 - embedment)
    lower, upper = pipe.Pipe(embedment=embedment).bounds
    assert dissipated(t, counted_as_positive=False) == pytest.approx(lower, rel=1e-4)
    assert dissipated(t, counted_as_positive=True) == pytest.approx(upper, rel=1e-4)
    # Beyond 45 degrees there is such dissipation at the face too.
    more = dissipated(1.0, counted_as_positive=True) - dissipated(1.0, counted_as_positive=False)
    assert more > 2.01 * (1.0 - math.sin(1.0))


@pytest.mark.slow
def test_the_load_falls_at_first_order_to_between_the_bounds(tmp_path: Path) -> None:
    """What the page prints; at the rim the load is too high by at most half a cell."""
    (tmp_path / "pipe.py").write_text(PIPE, encoding="utf-8")
    said = said_by_commands("python pipe.py", tmp_path)
    rows, loads, excess = np.array(
        re.findall(r"(\d+) rows: load ([\d.]+), ([\d.]+)% above", said), dtype=float
    ).T
    (low, high), t = np.array(re.findall(r"[\d.]{5}", said.splitlines()[-1]), dtype=float), 0.723
    assert low <= loads[-1] <= high
    orders = np.log2(excess[:-1] / excess[1:])
    assert orders.min() >= 0.9
    at_rim = (2.5 - math.sin(t)) * (5 ** (1 / (2 * rows)) - 1) / 4  # width of the cells
    assert np.all(loads - low <= (2 + math.pi - 2 * t) * 0.5 * at_rim + 0.0005)
    assert [f"{it:.3f}" for it in loads] == cells("load over diameter and su")
    assert [f"{it:.2f} %" for it in excess] == cells("above the lower bound, 2.945")
    assert f"orders {orders[0]:.1f} and {orders[1]:.1f}" in PAGE
    assert f"The upper bound is {high:.3f}" in PAGE


def cells(first: str) -> list[str]:
    """The other cells of a row of a table of the page."""
    (row,) = re.findall(rf"^\| {first} \| (.*) \|$", PAGE, re.MULTILINE)
    return [cell.strip() for cell in row.split("|")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pipe", "given", "told"),
    [
        (DEEP, {"embedment": 1.0}, "4.20, 4.24"),
        (ROUGH, {}, "3.575 and 3.466"),
        (VON_MISES, {}, "is 2.983"),
    ],
    ids=["half buried", "rough", "von Mises"],
    indirect=["pipe"],
)
def test_other_pipes_bear_what_the_page_says(pipe: Any, given: Any, told: str) -> None:
    assert told in " ".join(PAGE.split())
    loads = [float(pipe.Pipe(cells=it, **given).run().limit_load) for it in (4, 8)]
    *others, last = re.findall(r"[\d.]+", told)
    assert f"{loads[1]:.{len(last) - 2}f}" == last
    assert [f"{loads[0]:.{len(last) - 2}f}"][: len(others)] == others


@pytest.mark.slow
def test_a_package_brings_the_scene_into_the_harness(tmp_path: Path) -> None:
    """What pip makes of the project file of the page, and then its study."""
    project, study = blocks(PAGE, "toml")
    ((group, offered),) = tomllib.loads(project)["project"]["entry-points"].items()
    info = tmp_path / "my_scenes-0.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-scenes\nVersion: 0.1\n")
    entries = "".join(f"{name} = {place}\n" for name, place in offered.items())
    (info / "entry_points.txt").write_text(f"[{group}]\n{entries}")
    (tmp_path / "pipe.py").write_text(PIPE, encoding="utf-8")
    (tmp_path / "embedment.toml").write_text(study, encoding="utf-8")
    here, (commands,) = 'export PYTHONPATH="$PWD:$PYTHONPATH"\n', blocks(PAGE, "sh")
    # What `harness verify` runs is run already by the test above.
    typed = re.sub(r"^(pip|harness verify) .*\n", "", commands, flags=re.MULTILINE)
    assert typed.count("harness") == 3
    said = said_by_commands(here + typed, tmp_path)
    assert "limit load of a smooth pipe" in said
    assert said.count("completed") == 4
    (told,) = re.findall(r"The loads are (.*?)\. ", PAGE)
    loads = re.findall(r"^ +0[.\d]+ +([\d.]+)", said, re.MULTILINE)
    assert loads == re.findall(r"[\d.]+", told)
    assert (tmp_path / "results/embedment_curve.png").stat().st_size > 0


@pytest.mark.slow
def test_a_free_column_stands_on_what_it_weighs(tmp_path: Path) -> None:
    """But for the corner, whose quarter of a cell counts twice: an error of second order."""
    (tmp_path / "column.py").write_text(COLUMN, encoding="utf-8")
    found = re.findall(r"cells: ([\d.]+)%", said_by_commands("python column.py", tmp_path))
    excess = [float(it) for it in found]
    assert f"bears {excess[0]:.2f}, {excess[1]:.2f} and {excess[2]:.2f} % too much" in PAGE
    assert np.log2(excess[0] / excess[1]) == pytest.approx(2.0, abs=0.1)
    for cell, it in zip((1 / 4, 1 / 8, 1 / 16), excess, strict=True):
        corner = 0.25 * cell**2 / (0.5 * (1 - 0.5 * cell))
        assert it / 100 == pytest.approx(corner, rel=cell)
