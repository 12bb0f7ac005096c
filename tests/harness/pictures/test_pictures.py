"""All pictures: which is meant for which study, what a page has room for, and the files."""

import re
import sys
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
import xarray as xr
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from harness.archive.own_files import NotOwnFileError
from harness.archive.study_files import write_study
from harness.compare.compared import with_experience
from harness.pictures.drawing.caption import captioned, fixed
from harness.pictures.drawing.plot_parts import (
    MOST_LABELS,
    image,
    legend_above,
    panels,
)
from harness.pictures.drawing.style import FAINT, PAGE, SHADES, WIDE
from harness.pictures.map import map_figure
from harness.pictures.pictures import PICTURES, draw
from mpm_warp import CatalogueScene, ConePenetration, Sounding
from mpm_warp.results import parameter_variables
from tests.conftest import finished
from tests.harness.conftest import Command

from .conftest import MADE, caption_of, drawn, figures, legend, result, texts

pytestmark = pytest.mark.slow

MadeUp = tuple[xr.Dataset, dict[str, Figure]]
MAIN = {
    "one parameter": "curve",
    "two parameters": "map",
    "a text and many values": "curve",
    "one at a time": "tornado",
    "at random": "effects",
    "a few cases": "cases",
    "many differences": "cases",
    "a mesh": "convergence",
}


@pytest.mark.parametrize("kind", MADE)
def test_the_main_picture_fits_the_design(kind: str) -> None:
    assert next(iter(drawn(kind)[1])) == MAIN[kind]


def words(figure: Figure) -> Iterator[tuple[str, Bbox]]:
    """All that is written, and where, once it is laid out; not what is written aslant."""
    drawn: list[Text] = []
    draw_text = Text.draw

    def note(text: Text, renderer: RendererBase) -> None:
        drawn.append(text)
        draw_text(text, renderer)

    figure.draw_without_rendering()
    with patch.object(Text, "draw", note):
        figure.draw_without_rendering()
    for text in drawn:
        box = Text.get_window_extent(text)  # of an annotation: without its leader
        if text.get_visible() and text.get_text() and text.get_rotation() in (0.0, 90.0):
            yield text.get_text(), box


def test_nothing_overlaps_and_nothing_is_wider_than_the_page(made_up: MadeUp) -> None:
    for name, figure in made_up[1].items():
        assert figure.get_figwidth() == pytest.approx(PAGE if name == "map" else WIDE)
        written = list(words(figure))
        for text, box in written:
            inside = box.x0 >= -1 and box.x1 <= figure.bbox.width + 1
            assert inside, (name, text)
            assert box.y0 >= -1, (name, text)
            assert box.y1 <= figure.bbox.height + 1, (name, text)
        for (one, first), (other, second) in combinations(written, 2):
            # Boxes of letters have a margin: they may touch.
            shrunk = first.padded(-0.1 * min(first.height, first.width))
            assert not shrunk.overlaps(second), (name, one, other)


def test_no_picture_labels_more_than_eight_curves(made_up: MadeUp) -> None:
    for name, figure in made_up[1].items():
        # A tornado has a label at each end of a bar, a map on its contours.
        for axes in figure.axes[1:] if name in ("map", "tornado") else figure.axes:
            assert len(axes.texts) <= MOST_LABELS
        for shown in figure.legends:
            # Beside the curves it tells what the band is, and what is outside its validity.
            assert len(shown.get_texts()) <= MOST_LABELS + 2


def test_the_caption_says_what_was_fixed(made_up: MadeUp) -> None:
    for figure in made_up[1].values():
        told = caption_of(figure)
        assert told.startswith("A demonstration.")
        assert "Fixed: " in told
        for name, written in (
            ("rigidity_index", r"$I_{\mathrm{r}}$ = 100"),
            ("adhesion_factor", "$α$ = 0.5"),
        ):
            assert (written in told.partition("Fixed: ")[2]) == (made_up[0][name].ndim == 0)


@pytest.mark.parametrize("title", ["A study.", "Does it matter?"])
def test_a_caption_begins_with_the_title_as_a_sentence(title: str, made_up: MadeUp) -> None:
    for given in (title, title.rstrip(".")):
        figure = captioned(Figure(), made_up[0].assign_attrs(title=given), "What is shown.")
        assert caption_of(figure).startswith(f"{title} What is shown.")


ROWS = ConePenetration().cells_per_radius
INDEX = r"$I_{\mathrm{r}}$"
LAW = {"law": "modified_cam_clay", "critical_state_shape": "matsuoka_nakai"}
PROFILE = "depth [m], strength [kPa], adhesion_factor [1]; 0, 20, 0.3; 9, 20, 0.6"


@pytest.mark.parametrize(
    ("case", "told", "untold"),
    [
        (ConePenetration(), (), ("$R/h$", "$R$")),
        (ConePenetration(cells_per_radius=ROWS), (), ("$R/h$", "$R$")),
        # a choice, where the scene would derive another
        (ConePenetration(cells_per_radius=2.31), ("$R/h$",), ("$R$",)),
        (ConePenetration(cells_per_radius=2.31, cone_radius=1.0), ("$R/h$", "$R$"), ()),
        (ConePenetration(remoulded_strength_ratio=0.3, ductility=15), ("0.3", "15"), ("$R/h$",)),
        (ConePenetration(material=LAW), ("matsuoka nakai",), ("κ",)),  # κ is that of the law
        (Sounding(from_depth=2.0), (INDEX, "$α$"), ()),
        # a profile takes their place
        (
            Sounding(from_depth=2.0, profile=PROFILE),
            ("$α$ = 0.3 to 0.6 by the profile", "$ν$"),
            (INDEX,),
        ),
    ],
)
def test_the_caption_names_what_is_no_default(
    case: CatalogueScene, told: Sequence[str], untold: Sequence[str]
) -> None:
    variables = parameter_variables(case, []) | {"status": xr.Variable((), "completed")}
    attributes = {"scene": case.catalogue_name()}
    caption = fixed(xr.Dataset(variables, attrs=attributes)).replace("\N{NO-BREAK SPACE}", " ")
    assert [it for it in (*told, *untold) if it in caption] == list(told)


def test_a_title_with_dollars_is_no_mathematics() -> None:
    title = f"Costs $5 {'and more ' * 20}"
    dataset = result({"adhesion_factor": [0.0, 1.0]}).assign_attrs(title=f"{title}$x_$")
    figure = figures(dataset)["curve"]
    assert image(figure)
    lines = figure.get_supxlabel().splitlines()
    assert max(map(len, lines)) < 160  # wrapped: 104 letters, and those of symbols
    assert all(len(re.findall(r"(?<!\\)\$", line)) % 2 == 0 for line in lines)


def test_long_labels_of_a_legend_stay_on_the_page() -> None:
    figure = Figure(layout="constrained")
    axes = figure.subplots()
    for number in (50, 100):
        axes.plot([0, 1], label=f"$I_{{\\mathrm{{r}}}}$ = {number}, " * 20)
    legend_above(figure, axes)
    (above,) = figure.legends
    assert above.get_window_extent().width <= figure.bbox.width
    assert all("\n" in text for text in texts(above.get_texts()))


def test_the_colours_of_a_scale_can_be_told_apart_in_grey() -> None:
    red, green, blue, _ = SHADES(np.linspace(0.0, 1.0, 9)).T
    luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    # eight steps between black and white, none less than half the even one
    assert np.diff(luminance).min() > 0.5 * np.ptp(luminance) / 8


def test_the_surroundings_of_a_command_change_no_picture(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither the backend that Jupyter gives to all commands, nor a matplotlibrc of the user."""
    made = result({"adhesion_factor": [0.0, 1.0]}).drop_vars("penetration_resistance")
    write_study(Path("demo.nc"), made)
    plot = [sys.executable, "-m", "harness", "plot", "demo.nc", "--out"]
    assert finished([*plot, "plain"]).returncode == 0
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    Path("matplotlibrc").write_text("text.usetex: True\nfigure.facecolor: red\n", encoding="utf-8")
    told = finished([*plot, "other"])
    assert told.returncode == 0, told.stderr
    plain, other = (
        {path.name: path.read_bytes() for path in Path(folder).iterdir()}
        for folder in ("plain", "other")
    )
    assert plain == other


def test_formats_from_the_command_line(tmp_path: Path, command: Command) -> None:
    file = tmp_path / "demo.nc"
    write_study(file, result({"adhesion_factor": [0.0, 1.0]}).drop_vars("penetration_resistance"))
    plot = ("plot", file, "--format", "pdf", "svg")
    paths = [Path(line) for line in command(*plot).out.splitlines()]
    assert [path.name for path in paths] == ["demo_curve.pdf", "demo_curve.svg"]
    first = [path.read_bytes() for path in paths]
    assert first[0].startswith(b"%PDF")
    assert b"<svg" in first[1]
    assert b"href" not in re.sub(rb'xlink:href="#|xmlns:xlink|rdf:resource="http', b"", first[1])
    command(*plot)  # its own files are written again, with the same bytes
    assert [path.read_bytes() for path in paths] == first


def test_what_another_program_wrote_is_not_overwritten(tmp_path: Path) -> None:
    dataset = result({"adhesion_factor": [0.0, 1.0]})
    foreign = tmp_path / "demo_resistance.png"
    foreign.write_bytes(b"a photograph")
    with pytest.raises(NotOwnFileError, match=r"demo_resistance\.png: was not written by"):
        draw(dataset, tmp_path)
    assert foreign.read_bytes() == b"a photograph"
    assert list(tmp_path.iterdir()) == [foreign]


def test_map_has_contours_over_both_and_a_curve_for_each_of_few_values() -> None:
    figure = drawn("two parameters")[1]["map"]
    left, right = figure.axes[:2]
    assert left.get_xscale() == "log"
    figure.draw_without_rendering()
    assert texts(left.get_xticklabels()) == ["25", "50", "100", "500"]
    assert texts(left.get_yticklabels()) == ["0", "0.25", "0.5", "1"]
    assert texts(right.texts) == [f"$α$ = {value}" for value in ("0", "0.25", "0.5", "1")]


def test_a_map_has_the_literature_beside_each_of_its_curves() -> None:
    figure = drawn("two parameters")[1]["map"]
    right = figure.axes[1]
    colours = [line.get_color() for line in right.lines if line.get_marker() in "osD^"]
    of_references = [it for it in right.lines if it.is_dashed() and len(it.get_xdata())]
    valid = [it.get_color() for it in of_references if it.get_alpha() == 1.0]
    assert valid == colours  # Lu et al. from Ir 50 on; below it, and of von Mises clay, pale
    pale = [it.get_color() for it in of_references if it.get_alpha() == FAINT]
    assert pale == [it for it in colours for _ in range(3)]
    others = ("Teh & Houlsby 1991", "Yu et al. 2000")
    assert {"Lu et al. 2004", *(f"{it} (von Mises)" for it in others)} <= {*legend(figure)}


@pytest.mark.filterwarnings("error")
def test_numbers_too_great_for_an_axis_are_left_out_and_said() -> None:
    made = result({"adhesion_factor": [0.0, 0.5, 1.0]}, [11.0, 1e308, -1e308], uncertainty=1e308)
    for figure in figures(made).values():
        assert image(figure)
        assert "Numbers of 1e+100 and more are not drawn." in caption_of(figure)


@pytest.mark.filterwarnings("error")
def test_a_title_of_a_megabyte_and_long_labels_leave_room_for_the_axes() -> None:
    made = result({"adhesion_factor": [0.0, 1.0]}).assign_attrs(title="A title " * 2**17)
    own = {"label": "L" * 100, "range": "{}", "formula": "10", "validity": "v" * 1000}
    made["reference_own"] = made["reference_lu_2004"].assign_attrs(own)
    figure = figures(made)["curve"]
    assert image(figure)
    assert len(caption_of(figure)) < 1500
    assert "…" in caption_of(figure)


def test_a_map_has_the_bands_of_experience_behind_its_curves() -> None:
    figure = map_figure(with_experience(drawn("two parameters")[0], ["karlsrud_2005"]))
    left, right = figure.axes[:2]
    (band,) = right.patches
    assert isinstance(band, Rectangle)
    assert band.get_hatch()
    assert not left.patches
    (legend,) = figure.legends
    assert "Karlsrud et al. 2005: Nkt 6.2 to 18.1" in legend.get_texts()[0].get_text()


def test_a_picture_that_fails_takes_nothing_from_the_others(
    two_soils: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    def fails(dataset: xr.Dataset) -> Figure:
        raise KeyError("ductility")

    monkeypatch.setitem(PICTURES, "convergence", fails)
    file = tmp_path / "made.nc"
    write_study(file, two_soils)
    for words in (("plot", file), ("report", file, "-o", tmp_path / "page.html")):
        *_, line = command(*words, code=1).err.splitlines()  # before: other sources
        assert "convergence could not be drawn: an error of the program" in line
        assert "KeyError: 'ductility'" in line
    assert (tmp_path / "made_work_precision.png").exists()
    assert "Traceback" in command("plot", file, "--debug", code=1).err
    assert "The picture convergence could not be drawn" in (tmp_path / "page.html").read_text()


def test_what_is_no_mathematics_is_drawn_letter_by_letter() -> None:
    figure, (axes,) = panels()
    axes.set_title("$x_{$")
    assert image(figure)
