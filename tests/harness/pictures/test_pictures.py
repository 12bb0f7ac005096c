"""The pictures: what is drawn, on which axes, under which labels."""

import errno
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from harness.archive.atomic_files import ArchiveError
from harness.compare.cone_factors import with_references
from harness.pictures.cone_factor_plot import cone_factor_figure
from harness.pictures.pictures import NothingToDrawError, draw
from harness.pictures.resistance_plot import resistance_figure

REFERENCES = ("lu_2004", "teh_houlsby_1991", "yu_2000")
LABELS = {"Lu et al. 2004", "Teh & Houlsby 1991", "Yu et al. 2000"}
ENVELOPE = "envelope of the literature (no confidence interval)"
STRENGTH = 20e3


def result(**varied: Sequence[object]) -> xr.Dataset:
    """A study's result with invented numbers; `varied` are its dims."""
    fixed = {"rigidity_index": 100.0, "adhesion_factor": 0.5, "material": "tresca"}
    dataset = xr.Dataset(
        {name: value for name, value in fixed.items() if name not in varied},
        coords={name: (name, values) for name, values in varied.items()},
        attrs={"study": "demo"},
    )
    shape = tuple(len(values) for values in varied.values())
    factor = 11 + 0.1 * np.arange(np.prod(shape, dtype=int)).reshape(shape)
    dataset["undrained_shear_strength"] = STRENGTH
    dataset["cone_factor"] = tuple(varied), factor, {"units": "1", "long_name": "cone factor"}
    dataset["status"] = tuple(varied), np.full(shape, "completed")
    depth = xr.DataArray(np.arange(1.0, 19.0), dims="penetration")
    dataset["penetration_resistance"] = dataset.cone_factor * STRENGTH * depth / 18
    dataset = dataset.assign_coords(penetration=depth)
    dataset["penetration"].attrs = {"units": "1", "long_name": "penetration over cone radius"}
    return with_references(dataset, REFERENCES)


def legend(figure: Figure) -> list[str]:
    shown = figure.axes[0].get_legend()
    return [] if shown is None else [text.get_text() for text in shown.get_texts()]


def written(figure: Figure) -> list[str]:
    """What is written beside the curves."""
    return [text.get_text() for text in figure.axes[0].texts]


def points(figure: Figure) -> list[Line2D]:
    """The computed series: lines with a marker that are no failures."""
    return [line for line in figure.axes[0].lines if line.get_marker() not in ("None", "x")]


def curves(figure: Figure) -> list[Line2D]:
    return [line for line in figure.axes[0].lines if line.get_marker() == "None"]


def test_cone_factor_over_adhesion_shows_points_curves_and_envelope() -> None:
    dataset = result(adhesion_factor=[1.0, 0.0, 0.5])
    figure = cone_factor_figure(dataset)
    (computed,) = points(figure)
    assert computed.get_xdata().tolist() == [0.0, 0.5, 1.0]
    assert computed.get_ydata().tolist() == pytest.approx([11.1, 11.2, 11.0])
    assert legend(figure) == [ENVELOPE, "computed"]
    assert set(written(figure)) == LABELS
    lu = curves(figure)[0]
    # check values of the formula, given to two decimals
    assert lu.get_ydata()[[0, -1]] == pytest.approx([10.77, 12.07], abs=0.005)
    (band,) = figure.axes[0].collections
    # the envelope at adhesion factor 0 and 1
    bounds = band.get_paths()[0].get_extents()
    assert (bounds.ymin, bounds.ymax) == pytest.approx((9.54, 12.07), abs=0.005)


def test_an_envelope_for_one_value_alone_is_a_bar() -> None:
    figure = cone_factor_figure(result(apex_angle=[45.0, 60.0, 90.0]))
    (bar,) = [it for it in figure.axes[0].collections if isinstance(it, LineCollection)]
    ((begin, end),) = bar.get_segments()
    assert begin[0] == end[0] == 60.0
    assert begin[1] < end[1]


def test_each_reference_has_a_colour_of_its_own() -> None:
    colours = [line.get_color() for line in curves(cone_factor_figure(result()))]
    assert len(set(colours)) == len(REFERENCES)


def test_rigidity_index_has_a_logarithmic_axis_and_dashes_outside_the_validity() -> None:
    figure = cone_factor_figure(result(rigidity_index=[25.0, 100.0, 500.0]))
    axes = figure.axes[0]
    assert axes.get_xscale() == "log"
    figure.draw_without_rendering()
    assert [text.get_text() for text in axes.get_xticklabels()] == ["25", "100", "500"]
    solid, dashed = (curves(figure)[i] for i in (0, 1))
    assert not solid.is_dashed()
    assert dashed.is_dashed()
    valid = np.isfinite(solid.get_ydata())
    assert solid.get_xdata()[valid].min() == pytest.approx(50, rel=0.01)
    assert np.isfinite(dashed.get_ydata()).all()
    assert legend(figure).count("outside its validity") == 1


@pytest.mark.parametrize(
    ("varied", "scale"),
    [
        ({"cells_per_radius": [2.0, 4.0, 8.0]}, "linear"),
        ({"density": [100.0, 1500.0]}, "log"),
        ({"rigidity_index": [100.0, 200.0]}, "log"),
    ],
)
def test_scale_of_the_axis(varied: dict[str, list[float]], scale: str) -> None:
    assert cone_factor_figure(result(**varied)).axes[0].get_xscale() == scale


def test_text_parameter_has_a_categorical_axis() -> None:
    figure = cone_factor_figure(result(material=["tresca", "von_mises"]))
    labels = [text.get_text() for text in figure.axes[0].get_xticklabels()]
    assert labels == ["tresca", "von_mises"]
    (computed,) = points(figure)
    assert computed.get_linestyle() == "None"


def test_second_parameter_makes_series_beside_shared_curves() -> None:
    varied = {"material": ["tresca", "von_mises"], "adhesion_factor": [0.0, 1.0]}
    figure = cone_factor_figure(result(**varied))
    assert legend(figure) == [ENVELOPE, "material tresca", "material von_mises"]
    assert len({line.get_marker() for line in points(figure)}) == 2
    assert len(curves(figure)) == len(REFERENCES)


def test_labels_beside_the_axes_are_clear_of_the_legend() -> None:
    many = {"rigidity_index": [25.0, 100.0, 500.0], "adhesion_factor": [0.0, 0.25, 0.5, 0.75, 1.0]}
    figure = cone_factor_figure(result(**many))
    figure.draw_without_rendering()
    axes = figure.axes[0]
    box = axes.get_legend().get_window_extent()
    labels = [Text.get_window_extent(label) for label in axes.texts]  # without their leaders
    assert max(label.y1 for label in labels) > box.y0  # they rise as high
    assert not any(label.overlaps(box) for label in labels)


def test_curves_that_depend_on_the_series_take_its_colour() -> None:
    figure = cone_factor_figure(result(adhesion_factor=[0.0, 1.0], rigidity_index=[50.0, 300.0]))
    assert len(curves(figure)) == 2 * len(REFERENCES)
    colours = {line.get_color() for line in curves(figure)}
    assert colours == {line.get_color() for line in points(figure)}


def test_single_case_is_a_point_over_the_adhesion_factor() -> None:
    (computed,) = points(cone_factor_figure(result()))
    assert (computed.get_xdata().tolist(), computed.get_ydata().tolist()) == ([0.5], [11.0])


def test_failed_case_is_marked_on_the_axis() -> None:
    dataset = result(adhesion_factor=[0.0, 0.5, 1.0])
    dataset["cone_factor"][1] = np.nan
    figure = cone_factor_figure(dataset)
    (mark,) = (line for line in figure.axes[0].lines if line.get_marker() == "x")
    assert mark.get_xdata().tolist() == [0.5]
    assert "failed" in legend(figure)


def test_labels_of_curves_do_not_overlap() -> None:
    dataset = result(adhesion_factor=[0.0, 1.0], rigidity_index=[50.0, 51.0, 52.0])
    heights = sorted(text.xyann[1] for text in cone_factor_figure(dataset).axes[0].texts)
    assert len(heights) == 9
    # the relaxation that spreads them leaves a few thousandths of the distance
    assert np.diff(heights).min() > 0.99 * 0.05


def test_resistance_is_over_the_strength_with_a_label_for_each_case() -> None:
    dataset = result(adhesion_factor=[0.0, 0.5, 1.0])
    dataset["penetration_resistance"][2] = np.nan
    figure = resistance_figure(dataset)
    axes = figure.axes[0]
    assert [line.get_ydata()[-1] for line in axes.lines] == pytest.approx([11.0, 11.1])
    assert written(figure) == ["adhesion factor 0", "adhesion factor 0.5"]
    assert "failed: adhesion factor 1" in axes.get_title(loc="left")
    assert axes.get_xlabel() == "penetration over cone radius [-]"


def test_pictures_are_written_under_the_name_of_the_study(tmp_path: Path) -> None:
    folder = tmp_path / "pictures"
    paths = draw(result(adhesion_factor=[0.0, 1.0]), folder)
    assert [path.name for path in paths] == ["demo_cone_factor.png", "demo_resistance.png"]
    assert sorted(folder.iterdir()) == sorted(paths)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in paths)


def test_a_picture_that_cannot_be_finished_leaves_the_earlier_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    earlier = tmp_path / "demo_cone_factor.png"
    earlier.write_bytes(b"earlier")

    def disk_full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "no space left")

    monkeypatch.setattr(os, "fsync", disk_full)
    with pytest.raises(ArchiveError, match="cannot be written: no space left"):
        draw(result(), tmp_path)
    assert earlier.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [earlier]


def test_nothing_to_draw_is_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(NothingToDrawError, match="neither cone_factor nor"):
        draw(xr.Dataset(attrs={"study": "demo"}), tmp_path)
