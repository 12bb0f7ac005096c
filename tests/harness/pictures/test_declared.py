"""Curves that say where they are drawn: what a file keeps of it, and the pictures made of it."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from harness.archive.netcdf_files import read_netcdf, write_netcdf
from harness.errors import HarnessError
from harness.pictures.curves import curves_figure
from harness.pictures.declared import declared
from harness.pictures.drawing.style import GREY, SHADES
from harness.pictures.pictures import NothingToDrawError, draw, rendered
from mpm_warp.errors import SceneError
from mpm_warp.results import Drawn, curves

from .conftest import caption_of, figures, legend, one_at_a_time, result, texts

PLACES = [
    Drawn(picture="load"),
    Drawn(picture="load", panel=2, over="mean", divided_by="strength", downward=True),
    Drawn(picture="load", as_marks=True, to_rest=True, slope="ratio", joined_over="part"),
    None,
]


@pytest.mark.parametrize("place", PLACES)
def test_the_file_of_a_result_keeps_where_a_curve_is_drawn(
    place: Drawn | None, tmp_path: Path
) -> None:
    load = np.array([1.0, 2.0]), "Pa", "load"
    axis = np.array([0.0, 1.0]), "s", "time"
    made = curves("time", axis, load=load if place is None else (*load, "measured", place))
    write_netcdf(made, tmp_path / "x.nc")
    kept = read_netcdf(tmp_path / "x.nc")["load"]
    assert Drawn.of(kept) == place
    assert kept.attrs["long_name"] == "load"
    assert kept.attrs.get("description") == (place and "measured")


@pytest.mark.parametrize("name", ["../load", "a load", ""])
def test_a_name_that_is_no_part_of_a_file_name_is_refused(name: str) -> None:
    with pytest.raises(SceneError, match="give it letters"):
        Drawn(picture=name)


def test_a_name_that_the_harness_has_is_refused_with_the_curve() -> None:
    made = result({"adhesion_factor": [0.0, 1.0]})
    made["penetration_resistance"].attrs["drawn_picture"] = "tornado"
    with pytest.raises(HarnessError, match="tornado: the harness has one of this name"):
        rendered(made, lambda figure: figure)


def test_nothing_to_draw_is_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(NothingToDrawError, match="no curve that says where it is drawn"):
        draw(xr.Dataset({"status": ((), "completed")}, attrs={"study": "demo"}), tmp_path)


TIME = np.array([0.0, 0.5, 1.0, 1.5])


def of_two_loads(**place: object) -> xr.Dataset:
    """Two cases of 1 and 2 kN, of which the second has fallen by a tenth at the end."""
    drawn = Drawn(picture="load", **place).attributes
    values = 1e3 * np.array([[0.0, 1.0, 1.0, 1.0], [0.0, 2.0, 2.0, 1.8]])
    made = xr.Dataset(
        {
            "load": (("width", "time"), values, {"units": "N", "long_name": "load", **drawn}),
            "mean": (("width", "time"), values / 10.0, {"units": "N", "long_name": "mean load"}),
            "area": ("width", [1.0, 2.0], {"units": "m2", "long_name": "area"}),
            "ratio": ((), 0.5, {"long_name": "ratio", "role": "parameter", "units": "1"}),
            "end": ("width", [1.0, 1.8], {"role": "headline", "units": "1"}),
        },
        {
            "width": ("width", [1.0, 2.0], {"role": "parameter", "units": "m"}),
            "time": ("time", TIME, {"units": "s", "long_name": "time"}),
        },
    )
    return made.assign(status=("width", ["completed"] * 2)).assign_attrs(study="demo", title="T")


def drawn_load(**place: object) -> Figure:
    return figures(of_two_loads(**place))["load"]


@pytest.mark.parametrize(
    ("place", "second", "labels", "limits"),
    [
        ({}, (TIME, [0, 2000, 2000, 1800]), ("time [s]", "load [N]"), (0.0, 1.5)),
        ({"downward": True}, ([0, 2000, 2000, 1800], TIME), ("load [N]", "time [s]"), None),
        ({"over": "mean"}, ([0, 200, 200, 180],) * 2, ("mean load [N]", "load [N]"), None),
        (
            {"divided_by": "area"},
            (TIME, [0, 1000, 1000, 900]),
            ("time [s]", "load / area [N/(m2)]"),
            (0.0, 1.5),
        ),
        (
            {"divided_by": "mean"},
            (TIME, [np.nan, 1000, 1000, 1000]),
            ("time [s]", "load [% of mean load]"),
            (0.0, 1.5),
        ),
    ],
    ids=["over its dim", "downward", "over a curve", "over a scalar", "over a curve of its own"],
)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_curve_is_drawn_where_it_says(
    place: dict[str, object],
    second: tuple[list[float], list[float]],
    labels: tuple[str, str],
    limits: tuple[float, float] | None,
) -> None:
    figure = drawn_load(**place)
    (axes,) = figure.axes
    x, y = axes.lines[1].get_data()
    np.testing.assert_allclose(x, second[0])
    np.testing.assert_allclose(y, second[1] if "over" not in place else np.multiply(second[1], 10))
    assert (axes.get_xlabel(), axes.get_ylabel()) == labels
    low, high = axes.get_ylim()
    assert (low > high) == ("downward" in place)
    assert limits in (None, axes.get_xlim())
    assert sorted(texts(axes.texts) + legend(figure)) == ["width = 1 m", "width = 2 m"]


def test_marks_slope_and_rest() -> None:
    (marks,) = drawn_load(as_marks=True).axes
    assert [line.get_linestyle() for line in marks.lines] == ["None"] * 2
    assert [line.get_marker() for line in marks.lines] == ["o", "s"]
    sloping = drawn_load(slope="ratio")
    x, y = sloping.axes[0].lines[-1].get_data()
    assert y[1] / x[1] == 0.5
    assert "Dashed: ratio." in caption_of(sloping)
    # the second is within 1 % of its last value from its end on, the first from 0.5 on
    first = of_two_loads(to_rest=True).isel(width=[0])
    assert figures(first)["load"].axes[0].get_xlim() == (0.0, 1.5)
    early = first.assign_coords(time=[0.0, 0.2, 0.4, 1.5])
    early["load"][:, 1] = 500.0
    assert figures(early)["load"].axes[0].get_xlim() == (0.0, 0.4)


def test_of_several_curves_in_a_panel_the_caption_says_which_is_which() -> None:
    made = of_two_loads(as_marks=True)
    made["mean"].attrs |= Drawn(picture="load").attributes | {"description": "a tenth of it"}
    told = caption_of(figures(made)["load"])
    assert "Marks: load. Solid: mean load. Mean load (a tenth of it)." in told
    made["mean"].attrs |= Drawn(picture="load", panel=2).attributes
    figure = figures(made)["load"]
    assert [axes.get_ylabel() for axes in figure.axes] == ["load [N]", "mean load [N]"]
    assert legend(figure) == ["width = 1 m", "width = 2 m"]


def test_what_a_result_lacks_is_not_drawn() -> None:
    assert "load" not in figures(of_two_loads().drop_vars("load"))
    assert "load" not in figures(of_two_loads(divided_by="area").drop_vars("area"))
    undeclared = of_two_loads()
    undeclared["load"].attrs = {"units": "N"}
    assert declared(undeclared) == {}
    failed = of_two_loads()
    failed["status"].values[1] = "diverged"
    figure = figures(failed)["load"]
    assert len(figure.axes[0].lines) == 1
    assert "1 of 2 cases have no curve." in caption_of(figure)


def test_a_gap_of_a_case_stays_and_samples_of_other_cases_make_none() -> None:
    made = of_two_loads()
    made["load"][0, 1] = np.nan  # among its own samples: `mean` has a value there
    made["load"][1, 2] = made["mean"][1, 2] = np.nan
    first, second = figures(made)["load"].axes[0].lines
    np.testing.assert_array_equal(np.isfinite(first.get_ydata()), [True, False, True, True])
    np.testing.assert_array_equal(second.get_xdata(), [0.0, 0.5, 1.5])


def of_cycles() -> xr.Dataset:
    """Loops of two cases: the second loses more; and a mark for each cycle."""
    left = np.array([[8.0, 6.0, 5.0], [6.0, 4.0, 3.0]])
    loops = left[:, :, None] * np.array([1.0, -1.0, 1.0])[:, None] * np.ones(4)
    place = Drawn(picture="cycles", panel=2, as_marks=True).attributes
    made = of_two_loads().drop_vars(["load", "mean"])
    by_depth = Drawn(picture="cycles", downward=True).attributes | {"long_name": "resistance"}
    return made.assign(
        resistance=(("width", "cycle", "time"), loops, by_depth),
        factor=(("width", "cycle"), left, {"long_name": "factor", **place}),
    ).assign_coords(cycle=("cycle", [0.25, 0.75, 1.25], {"long_name": "number of the cycle"}))


def test_loops_are_of_the_case_that_changes_most_and_marks_of_all() -> None:
    figure = figures(of_cycles())["cycles"]
    loops, factors = figure.axes
    assert [line.get_xdata()[0] for line in loops.lines[:3]] == [6.0, -4.0, 3.0]
    assert len([line for line in factors.lines if line.get_marker() in "os"]) == 2
    assert factors.get_ylim()[0] == 0.0
    assert legend(figure) == ["width = 1 m", "width = 2 m"]
    assert "Lines of width = 2 m by cycle, from light to dark." in caption_of(figure)


def twelve(design: str) -> xr.Dataset:
    """Cases of more and more stiffness and resistance."""
    columns = {"density": [1.0, 2.0] * 6, "rigidity_index": [100.0 + it for it in range(12)]}
    if design == "one_at_a_time":
        columns["density"] = [1.0] * 12
    return result(columns, [11.0 + 0.1 * case for case in range(12)], design)


def resistance(dataset: xr.Dataset) -> Figure:
    figure = curves_figure(dataset, ["penetration_resistance"])
    assert figure is not None
    return figure


def test_each_of_few_curves_has_a_label_at_its_end() -> None:
    few = resistance(result({"adhesion_factor": [0.0, 0.5, 1.0]}, [11.0, 11.1, np.nan]))
    (axes,) = few.axes
    assert [line.get_ydata()[-1] for line in axes.lines] == pytest.approx([11.0, 11.1])
    assert texts(axes.texts) == ["$α$ = 0", "$α$ = 0.5"]
    assert axes.get_ylabel() == r"net cone resistance / $s_{\mathrm{u}}$ [-]"
    assert "Net cone resistance (as simulated)." in caption_of(few)
    (alone,) = resistance(result({"adhesion_factor": [0.3]}, [11.0])).axes
    assert texts(alone.texts) == []


def test_of_many_curves_only_those_that_differ_most_from_the_start_are_labelled() -> None:
    figure = resistance(twelve("one_at_a_time"))
    labels = texts(figure.axes[0].texts)
    assert labels[0] == "start"
    assert labels[1:] == [rf"$I_{{\mathrm{{r}}}}$ = {100 + case}" for case in range(7, 12)]
    assert [line.get_color() for line in figure.axes[0].lines].count(GREY) == 6
    few = resistance(one_at_a_time()).axes[0].texts
    assert few[0].get_text().startswith("$I")


def test_many_curves_have_the_colours_of_the_number_that_they_follow() -> None:
    figure = resistance(twelve("latin_hypercube"))
    axes, scale = figure.axes
    assert scale.get_xlabel().startswith("rigidity index")
    colours = [line.get_color() for line in axes.lines]
    assert colours == [to_hex(SHADES(it / 11)) for it in range(12)]
    assert "12 cases." in caption_of(figure)


def test_of_two_parameters_colour_shows_one_and_dashes_the_one_of_fewer_values() -> None:
    index, adhesion = [50.0, 100.0, 300.0], [0.0, 0.25, 0.5, 0.75, 1.0]
    figure = resistance(result({"adhesion_factor": adhesion, "rigidity_index": index}))
    (axes,) = figure.axes
    cases = [line for line in axes.lines if len(line.get_xdata())]
    looks = [(line.get_color(), line.get_linestyle()) for line in cases]
    colours = [to_hex(SHADES(it / 4)) for it in range(5)]
    assert looks == [(colour, dashes) for colour in colours for dashes in ("-", "--", "-.")]
    of_adhesion = [f"$α$ = {it:g}" for it in adhesion]
    assert legend(figure) == of_adhesion + [rf"$I_{{\mathrm{{r}}}}$ = {it:g}" for it in index]


def test_of_two_parameters_with_many_values_one_has_a_scale() -> None:
    many = {"rigidity_index": [50.0, 60.0, 70.0, 80.0, 90.0], "density": [1.0, 2.0, 3.0, 4.0, 5.0]}
    assert len(resistance(result(many)).axes) == 2


def test_many_curves_of_several_scenes_have_the_colours_of_their_scenes() -> None:
    scenes = ["cone_penetration", "ball_penetration"] * 6
    figure = resistance(twelve("random").assign_coords(scene=("case", scenes)))
    assert legend(figure) == ["cone penetration", "ball penetration"]
    colours = [line.get_color() for line in figure.axes[0].lines[:12]]
    assert colours == colours[:2] * 6
    assert colours[0] != colours[1]
