"""The picture of one parameter: what is drawn, on which axes, under which labels; bands."""

from typing import cast

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from harness.compare.compared import with_experience
from harness.pictures.curve import curve_figure
from harness.pictures.drawing.plot_parts import panels
from harness.pictures.drawing.quantities import Values
from harness.pictures.drawing.style import FAINT
from harness.pictures.literature import draw_experience

from .conftest import MADE, REFERENCES, legend, result, texts

LU = "Lu et al. 2004"
LABELS = {LU, "Teh & Houlsby 1991", "Yu et al. 2000"}
ENVELOPE = "envelope of the literature (no confidence interval)"
DASHED = "outside its validity or criterion"


def of_von_mises(varied: dict[str, list[float]]) -> Figure:
    dataset = result(varied).assign(material=((), "von_mises", {"role": "parameter"}))
    return cast("Figure", curve_figure(dataset))


def written(figure: Figure) -> list[str]:
    """What is written beside the curves."""
    return texts(figure.axes[0].texts)


def points(figure: Figure) -> list[Line2D]:
    """The computed series: lines with a marker that are no failures."""
    return [line for line in figure.axes[0].lines if line.get_marker() not in ("None", "x")]


def curves(figure: Figure) -> list[Line2D]:
    return [line for line in figure.axes[0].lines if line.get_marker() == "None"]


def test_cone_factor_over_adhesion_shows_points_curves_and_envelope() -> None:
    dataset = result({"adhesion_factor": [1.0, 0.0, 0.5]})
    figure = curve_figure(dataset)
    (computed,) = points(figure)
    assert computed.get_xdata().tolist() == [0.0, 0.5, 1.0]
    assert computed.get_ydata().tolist() == pytest.approx([11.1, 11.2, 11.0])
    assert legend(figure) == [DASHED, "computed"]
    others = {"Teh & Houlsby 1991 (von Mises)", "Yu et al. 2000 (von Mises)"}
    assert set(written(figure)) == {"Lu et al. 2004"} | others
    assert len({line.get_color() for line in curves(figure)}) == len(REFERENCES)
    lu = curves(figure)[0]
    # check values of the formula, given to two decimals
    assert lu.get_ydata()[[0, -1]] == pytest.approx([10.77, 12.07], abs=0.005)
    assert not figure.axes[0].collections  # one reference of Tresca clay is no envelope


def test_the_envelope_is_that_of_the_references_with_the_criterion_of_the_case() -> None:
    """By hand, at adhesion factor 0 and 1; the least is by su in triaxial compression."""
    figure = of_von_mises({"adhesion_factor": [0.0, 1.0]})
    (band,) = figure.axes[0].collections
    bounds = band.get_paths()[0].get_extents()
    assert (bounds.ymin, bounds.ymax) == pytest.approx((8.511315, 11.910340), abs=1e-5)
    assert ENVELOPE in legend(figure)


def test_a_factor_of_a_scene_without_an_adhesion_factor_is_drawn_alone() -> None:
    """The literature, which depends on it, has nothing to say."""
    dataset = result({"density": [1.0, 2.0, 4.0]}).drop_vars("adhesion_factor")
    figure = curve_figure(with_experience(dataset, ["karlsrud_2005"]))
    assert len(points(figure)) == 1
    assert curves(figure) == []
    assert len(legend(figure)) == 2
    assert curve_figure(dataset.isel(density=0)) is None


def test_an_envelope_for_one_value_alone_is_a_bar() -> None:
    figure = of_von_mises({"apex_angle": [45.0, 60.0, 90.0]})
    (bar,) = [it for it in figure.axes[0].collections if isinstance(it, LineCollection)]
    ((begin, end),) = bar.get_segments()
    assert begin[0] == end[0] == 60.0
    assert begin[1] < end[1]


def test_rigidity_index_has_a_logarithmic_axis_and_dashes_outside_the_validity() -> None:
    figure = curve_figure(result({"rigidity_index": [25.0, 100.0, 500.0]}))
    axes = figure.axes[0]
    assert axes.get_xscale() == "log"
    figure.draw_without_rendering()
    assert texts(axes.get_xticklabels()) == ["25", "100", "500"]
    solid, dashed = (curves(figure)[i] for i in (0, 1))
    assert not solid.is_dashed()
    assert dashed.is_dashed()
    valid = np.isfinite(solid.get_ydata())
    assert solid.get_xdata()[valid].min() == pytest.approx(50, rel=0.01)
    assert np.isfinite(dashed.get_ydata()).all()
    assert legend(figure).count(DASHED) == 1


@pytest.mark.parametrize("varied", ["ductility", "penetration_speed"])
def test_formulas_are_dashed_beside_clay_whose_strength_changes(varied: str) -> None:
    dataset = result({varied: [1.0, 3.0, 10.0]}).assign(remoulded_strength_ratio=0.2)
    figure = curve_figure(dataset)
    drawn = [line for line in curves(figure) if np.isfinite(line.get_ydata()).any()]
    assert len(drawn) == len(REFERENCES)
    assert all(line.is_dashed() for line in drawn)
    assert DASHED in legend(figure)
    assert ENVELOPE not in legend(figure)


@pytest.mark.parametrize(
    ("numbers", "logarithmic"),
    [
        ([1.0, 10.0], True),
        ([1.0, 9.0], False),
        ([0.0, 1.0, 10.0], True),
        ([-1.0, 1.0, 10.0], False),
        ([0.0], False),
    ],
)
def test_an_axis_is_logarithmic_over_a_decade(numbers: list[float], logarithmic: bool) -> None:
    values = Values(name="stress", unit="Pa", numbers=np.array(numbers))
    assert values.logarithmic == logarithmic


def test_a_value_without_room_on_an_axis_is_told_by_its_number() -> None:
    texts_of_cases = ["", "von_mises", "depth [m], strength [kPa]; 0, 20; 99, 20"]
    cases = xr.Dataset({"status": ("case", ["completed"] * 3), "it": ("case", texts_of_cases)})
    values = Values.of(cases, "it")
    _, (axes,) = panels()
    values.dress(axes, room=6)
    assert texts(axes.get_xticklabels()) == ["derived", "von mises", "1"]
    assert values.of_case(2) == "1"


def test_text_parameter_has_a_categorical_axis() -> None:
    figure = curve_figure(result({"material": ["tresca", "von_mises"]}))
    assert texts(figure.axes[0].get_xticklabels()) == ["tresca", "von mises"]
    (computed,) = points(figure)
    assert computed.get_linestyle() == "None"


def test_no_line_joins_exact_values_of_texts() -> None:
    dataset = result({"material": ["tresca", "von_mises"]})
    attributes = {"role": "exact", "exact_of": "cone_factor"}
    figure = curve_figure(dataset.assign(exact=("material", [10.0, 11.0], attributes)))
    (exact,) = (line for line in figure.axes[0].lines if line.get_label() == "exact")
    assert exact.get_linestyle() == "None"
    assert exact.get_ydata().tolist() == [10.0, 11.0]


def test_second_parameter_makes_series_beside_shared_curves() -> None:
    varied = {"accuracy": ["quick", "fine"], "adhesion_factor": [0.0, 1.0]}
    figure = curve_figure(result(varied))
    assert legend(figure) == [DASHED, "accuracy = quick", "accuracy = fine"]
    assert len({line.get_marker() for line in points(figure)}) == 2
    assert len([line for line in curves(figure) if not line.is_dashed()]) == len(REFERENCES)


def test_beside_clays_of_two_criteria_each_has_the_literature_by_its_su() -> None:
    varied = {"material": ["tresca", "von_mises"], "adhesion_factor": [0.0, 1.0]}
    figure = curve_figure(result(varied))
    assert ENVELOPE in legend(figure)
    tresca, mises = (line.get_color() for line in points(figure))
    valid = [it for it in curves(figure) if it.get_alpha() == 1]
    # Lu et al. by two su; Teh & Houlsby, and Yu et al. by two su
    assert [it.get_color() for it in valid] == [tresca, tresca, mises, mises, mises]


def test_where_the_literature_depends_on_the_series_each_has_its_own_in_its_colour() -> None:
    figure = of_von_mises({"adhesion_factor": [0.0, 1.0], "rigidity_index": [50.0, 300.0]})
    colours = [line.get_color() for line in points(figure)]
    drawn: dict[float | None, list[str]] = {FAINT: [], 1.0: [], None: []}
    for line in curves(figure):
        drawn[line.get_alpha()].append(line.get_color())
    # two references are of von Mises clay; Lu et al. is of Tresca clay
    assert (drawn[FAINT], drawn[1.0]) == (colours, [it for it in colours for _ in range(2)])
    assert set(legend(figure)) >= (LABELS - {LU}) | {f"{LU} (Tresca)"}
    bands = [to_hex(band.get_facecolor()[0]) for band in figure.axes[0].collections]
    assert bands == list(map(to_hex, colours))


@pytest.mark.parametrize(
    ("name", "values", "places", "index"),
    [
        ("swelling_slope", [1.0, 2.0, 4.0], [1.0, 2.0, 4.0], [100.0, 50.0, 25.0]),
        ("critical_state_shape", ["circle", "matsuoka_nakai"], [-0.5, 1.5], [200.0, 100.0]),
    ],
)
def test_the_literature_follows_a_rigidity_index_that_changes_along_the_axis(
    name: str, values: list[object], places: list[float], index: list[float]
) -> None:
    dataset = result({name: values})
    dataset["rigidity_index"] = name, index, {"role": "parameter"}
    lu = next(it for it in curves(curve_figure(dataset)) if np.isfinite(it.get_ydata()).all())
    found = np.interp(places, lu.get_xdata(), lu.get_ydata())
    assert found == pytest.approx(3.4 + 1.6 * np.log(index) + 1.3 * 0.5)


def test_beside_bands_factors_are_drawn_by_the_strength_of_the_bands_too() -> None:
    dataset = result({"swelling_slope": [1.0, 2.0, 4.0]})
    dataset["cone_factor_by_compression"] = 0.9 * dataset["cone_factor"].drop_attrs()
    assert len(points(curve_figure(dataset))) == 1
    figure = curve_figure(with_experience(dataset, ["karlsrud_2005"]))
    assert "by su in triaxial compression" in legend(figure)
    by_compression = next(it for it in points(figure) if it.get_linestyle() == ":")
    assert by_compression.get_ydata() == pytest.approx(0.9 * dataset["cone_factor"].values)


def test_uncertainty_is_drawn_as_error_bars() -> None:
    figure = curve_figure(MADE["one parameter"]())
    (drawn,) = (it for it in figure.axes[0].containers if isinstance(it, ErrorbarContainer))
    bars = drawn.lines[2][0]
    lengths = [float(np.ptp(segment[:, 1])) for segment in bars.get_segments()]
    assert lengths == pytest.approx([0.6] * 6)
    assert "Error bars hold the value with 95 %: numerical error only" in figure.get_supxlabel()


def test_single_case_is_a_point_over_the_adhesion_factor() -> None:
    figure = curve_figure(result({}))
    (computed,) = points(figure)
    assert len(figure.axes[0].get_xticks()) > 2
    assert (computed.get_xdata().tolist(), computed.get_ydata().tolist()) == ([0.5], [11.0])


def test_failed_case_is_marked_on_the_axis() -> None:
    dataset = result({"adhesion_factor": [0.0, 0.5, 1.0]}, [11.0, np.nan, 12.0])
    figure = curve_figure(dataset)
    (mark,) = (line for line in figure.axes[0].lines if line.get_marker() == "x")
    assert mark.get_xydata().tolist() == [[0.5, 0.0]]  # on the axis itself
    assert "not completed" in legend(figure)


IDS = ("karlsrud_2005", "karlsrud_2005_pore_pressure", "mayne_peuchen_2018")


def test_bands_of_the_cone_factor_are_hatched_and_named(two_soils: xr.Dataset) -> None:
    figure, (axes,) = panels()
    draw_experience(axes, with_experience(two_soils, IDS))
    figure.draw_without_rendering()
    wide, narrow = cast("list[Rectangle]", list(axes.patches))
    bounds = wide.get_y(), wide.get_y() + wide.get_height()
    assert bounds == pytest.approx((6.17, 18.07), abs=0.005)
    assert wide.get_hatch() != narrow.get_hatch()
    assert wide.get_facecolor()[3] == 0.0
    assert not axes.lines
    assert axes.get_legend_handles_labels()[1] == [
        "experience, Karlsrud et al. 2005: Nkt 6.2 to 18.1, su peak in triaxial compression",
        "experience, Mayne & Peuchen 2018: Nkt 10.1 to 13.7, su peak in triaxial compression",
    ]
