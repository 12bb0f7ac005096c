"""Pictures in print: one style, letters and widths of a journal, colours in grey and colour-blind.

Colours are compared by CIELAB: its L* is the lightness in grey, from 0 (black) to 100, and a
distance of 2.3 is what can just be seen. A reader without red or green cones sees a colour by the
matrices of Machado, Oliveira & Fernandes 2009, A physiologically-based model for simulation of
color vision deficiency, IEEE Trans. Vis. Comput. Graph. 15:1291-1298, severity 1.
"""

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

import harness
from harness.pictures.drawing.plot_parts import MOST_LABELS, image, write_figure
from harness.pictures.drawing.style import (
    ACCENT,
    COLOURS,
    DASHES,
    INK,
    LIGHT,
    MARKS,
    STATUSES,
    WIDE,
    series_colour,
)

from .conftest import MADE, drawn

EYES: Mapping[str, np.ndarray] = {
    "usual": np.eye(3),
    "without red": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "without green": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
}
TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
"""From linear sRGB to XYZ (IEC 61966-2-1), white D65."""


def seen(colour: str, eye: str = "usual") -> np.ndarray:
    """The colour in CIELAB as an eye sees it."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = TO_XYZ @ np.clip(EYES[eye] @ linear, 0.0, 1.0) / TO_XYZ.sum(axis=1)
    x, y, z = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def nearest(colours: Sequence[str], eye: str) -> float:
    """The least distance between two of the colours."""
    pairs = combinations(colours, 2)
    return min(float(np.linalg.norm(seen(one, eye) - seen(other, eye))) for one, other in pairs)


@pytest.mark.parametrize("eye", EYES)
def test_colours_differ_to_all_eyes(eye: str) -> None:
    assert nearest(COLOURS, eye) > 15.0
    assert nearest([INK, ACCENT, LIGHT], eye) > 50.0
    assert nearest([colour for colour, _ in STATUSES.values()], eye) > 15.0
    for count in range(2, MOST_LABELS + 1):
        assert nearest([series_colour(rank, count) for rank in range(count)], eye) > 7.0


def test_colours_differ_in_grey_or_their_hatches_do() -> None:
    lightness = [seen(colour)[0] for colour in (INK, ACCENT, LIGHT)]
    assert np.diff(lightness).min() > 20.0
    for count in range(2, MOST_LABELS + 1):
        series = [seen(series_colour(rank, count))[0] for rank in range(count)]
        assert np.diff(series).min() > 0.9 * np.ptp(series) / (count - 1)
        assert series[-1] < 80.0  # it is to be seen on white paper
    hatches = [hatch for _, hatch in STATUSES.values()]
    assert len(set(hatches)) == len(hatches)
    assert len(set(MARKS)) == len(MARKS) > MOST_LABELS
    assert len(set(DASHES)) == len(DASHES)


SIZE = re.compile(
    "figsize|dpi|size|(title_)?fontsize|labelsize|lw|(e?line|markeredge)widths?|mew|ms|markersize|"
    "capsize|linespacing|alpha"
)
LOOK = re.compile("c|colors?|[fe]c|m[fe]c|(face|edge)color|foreground|cmap")
SOURCES = sorted(
    path
    for folder in ("pictures", "report")
    for path in (Path(harness.__file__).parent / folder).rglob("*.py")
    if path.name != "style.py"
)


def looks_of(source: str) -> Iterator[str]:
    """Numbers of sizes and names of colours that a module gives, in keywords and in dicts."""
    for node in ast.walk(ast.parse(source)):
        given: list[tuple[str, ast.expr]] = []
        if isinstance(node, ast.Call):
            given = [(str(it.arg), it.value) for it in node.keywords]
            texts = [it.value for it in node.args if isinstance(it, ast.Constant)]
            yield from (
                it for it in texts if isinstance(it, str) and re.fullmatch("[bgrcmykw][-.:o]+", it)
            )
        elif isinstance(node, ast.Dict):
            pairs = zip(node.keys, node.values, strict=True)
            given = [(str(it.value), value) for it, value in pairs if isinstance(it, ast.Constant)]
        for name, value in given:
            for part in ast.walk(value):
                it = part.value if isinstance(part, ast.Constant) else None
                is_size = SIZE.fullmatch(name) and isinstance(it, float | int) and it
                is_colour = LOOK.fullmatch(name) and isinstance(it, str) and it != "none"
                if is_size or is_colour:
                    yield f"{name}={it!r}"


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.name)
def test_only_the_style_has_sizes_and_colours(path: Path) -> None:
    assert list(looks_of(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    "source",
    ["f(lw=0.5)", 'f(color="0.5")', 'd = {"ms": 3}', 'f(x, "k:")', "Figure(figsize=(3, WIDE))"],
)
def test_what_a_module_sets_by_itself_is_found(source: str) -> None:
    assert list(looks_of(source))
    assert not list(looks_of('f(lw=THIN, color=INK, fc="none", ls=":", alpha=0)'))


@pytest.mark.slow
@pytest.mark.parametrize("kind", MADE)
def test_no_letter_is_smaller_than_seven_points(kind: str) -> None:
    for name, figure in drawn(kind)[1].items():
        for text in figure.findobj(Text):
            assert not text.get_text() or text.get_fontsize() >= 7.0, (name, text)


@pytest.fixture
def figure() -> Figure:
    """A picture with a legend, mathematics and a caption."""
    return drawn("one parameter")[1]["curve"]


def test_a_pdf_has_the_width_of_a_column_its_letters_and_no_date(figure: Figure) -> None:
    pdf = image(figure, "pdf")
    (box,) = re.findall(rb"/MediaBox \[ 0 0 (\S+) \S+ \]", pdf)
    assert float(box) == pytest.approx(72.0 * WIDE, abs=0.01)
    assert b"/FontFile2" in pdf  # the letters of a TrueType font
    assert b"/Type3" not in pdf
    assert b"CreationDate" not in pdf


@pytest.mark.parametrize("form", ["png", "pdf", "svg"])
def test_a_picture_has_the_same_bytes_each_time(form: str, figure: Figure, tmp_path: Path) -> None:
    (first,), (second,) = (write_figure(figure, tmp_path / it, [form]) for it in ("a.1", "b"))
    assert (first.name, second.name) == (f"a.1.{form}", f"b.{form}")
    assert first.read_bytes() == second.read_bytes()
