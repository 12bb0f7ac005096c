"""Pictures of interpreted cone tests."""

import numpy as np
import pytest
import xarray as xr

from harness.pictures.measured.interpreted import interpretation_figure, soundings_figure
from tests.harness.pictures.conftest import texts

LINE_DEPTH = np.array([[2.0, 10.0]])
LINE_STRENGTH = 1e3 * np.array([[[10.0, 12.0, 15.0], [17.0, 20.0, 25.0]]])


def interpreted(title: str = "A site") -> xr.Dataset:
    """Clay from 2 to 10 m, with a gap between 5 and 7 m, and soil that drains at 9 m."""
    depth = np.concatenate([np.arange(1.0, 5.01, 0.1), np.arange(7.0, 12.0, 0.1)])
    strength = np.outer(10.0e3 + 1.0e3 * depth, [0.8, 1.0, 1.3])
    reason = np.where((depth < 2.0) | (depth > 10.0), 1, np.where(np.isclose(depth, 9.0), 2, 0))
    beside = strength[:, None, [1, 0, 2]] * np.ones((2, 1))
    meanings = {"flag_meanings": "used no_layer not_undrained_clay"}
    return xr.Dataset(
        {
            "net_resistance": ("depth", 12.0 * strength[:, 1]),
            "sleeve_friction": ("depth", 0.4 * strength[:, 1]),
            "pore_pressure": ("depth", 6.0 * strength[:, 1]),
            "water_pressure": ("depth", 10.0e3 * depth),
            "pore_pressure_ratio": ("depth", np.full_like(depth, 0.5)),
            "soil_index": ("depth", np.full_like(depth, 3.0)),
            "measure_at_depth": (("depth", "measure", "bound"), beside),
            "strength": (("depth", "percentile"), np.where(reason[:, None], np.nan, strength)),
            "resistance_factor": (("depth", "percentile"), np.full_like(strength, 12.0)),
            "error_share": (("depth", "cause"), np.full((len(depth), 2), 0.5)),
            "reason": ("depth", reason.astype(np.int8), meanings),
            "near_border": ("depth", (np.abs(depth - 8.0) < 0.35).astype(np.int8)),
            "line_depth": (("layer", "end"), LINE_DEPTH),
            "line_strength": (("layer", "end", "percentile"), LINE_STRENGTH),
        },
        {
            "depth": depth,
            "layer": ["clay"],
            "percentile": [5.0, 50.0, 95.0],
            "cause": ["test", "model"],
            "measure": ["sleeve", "pore_pressure"],
            "bound": ["measured", "least", "largest"],
        },
        {"title": title, "site": f"site_{title}"},
    )


def test_no_curve_is_drawn_across_a_gap() -> None:
    for figure in (interpretation_figure(interpreted()), soundings_figure([interpreted()], [[]])):
        for axes in figure.axes:
            for line in axes.get_lines():
                depth, value = line.get_ydata(), line.get_xdata()
                assert len(depth) == 2 or np.isnan(value[(depth > 4.95) & (depth < 6.95)]).any()


def test_the_layers_fill_the_picture() -> None:
    figure = interpretation_figure(interpreted())
    assert figure.axes[0].get_ylim() == pytest.approx((11.0, 1.0))


def test_the_line_of_a_layer_goes_from_its_top_to_its_bottom_with_its_band() -> None:
    strength = interpretation_figure(interpreted()).axes[3]
    drawn = [line for line in strength.get_lines() if len(line.get_xdata()) == 2]
    np.testing.assert_array_equal([line.get_ydata() for line in drawn], 3 * [LINE_DEPTH[0]])
    percentiles = sorted(line.get_xdata().tolist() for line in drawn)
    np.testing.assert_array_equal(percentiles, LINE_STRENGTH[0].T / 1e3)


def test_several_tests_have_a_line_and_a_band_each() -> None:
    figure = soundings_figure([interpreted("one"), interpreted("two")], [[], []])
    test, strength = figure.axes
    assert texts(test.get_legend().get_texts()) == ["one", "two"]
    alike = soundings_figure([interpreted("one"), interpreted("one")], [[], []]).axes[0]
    assert texts(alike.get_legend().get_texts()) == ["one (site_one)"] * 2
    assert len(strength.get_lines()) == len(strength.collections) == 2
    assert len({line.get_color() for line in strength.get_lines()}) == 2


def test_laboratory_tests_are_beside_their_sounding_and_inside_the_picture() -> None:
    points = [[(5.0, 40e3)], [(14.0, 90e3), (6.0, 30e3)]]
    figure = soundings_figure([interpreted("one"), interpreted("two")], points)
    strength = figure.axes[1]
    drawn = [line for line in strength.get_lines() if len(line.get_xdata()) == 1]
    found = [(float(it.get_ydata()[0]), 1e3 * float(it.get_xdata()[0])) for it in drawn]
    assert found == points[0] + points[1]
    assert len({line.get_color() for line in drawn}) == 2
    assert figure.axes[0].get_ylim() == pytest.approx((14.0, 1.0))
    assert strength.get_xlim()[1] > 90.0


def test_shares_fill_the_panel_where_a_layer_lacks_a_cause() -> None:
    found = interpreted()
    found.error_share[:] = [0.25, 0.75]
    below = found.depth.values > 7.0
    found.error_share[below] = [1.0, np.nan]
    panel = interpretation_figure(found).axes[4]
    paths = [path.vertices for it in panel.collections for path in it.get_paths()]
    ends = np.concatenate(paths)
    used = found.depth.values[below & (found.reason.values == 0)]
    assert np.isin(used, ends[np.isclose(ends[:, 0], 100.0), 1]).all()
