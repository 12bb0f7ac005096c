"""Stretches joined to one sounding; pictures of soundings and of interpreted cone tests."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.pictures.sounding import (
    interpretation_figure,
    joined,
    sounding_figure,
    soundings_figure,
)
from tests.harness.pictures.conftest import IN_A_ROW, caption_of, collected, figures, legend, texts

DEPTH = np.arange(1.0, 7.0)


def cut(values: list[list[float]], half_width: float = 3.0) -> xr.Dataset:
    """A result of two stretches for each of some adhesion factors, with made-up resistances."""
    resistance = np.array(values).reshape(-1, 2, DEPTH.size)
    dims = ("adhesion_factor", "stretch_number", "depth")
    width = np.where(np.isnan(resistance), np.nan, half_width)
    return xr.Dataset(
        {
            "net_resistance": (dims, resistance, {"units": "Pa"}),
            "net_resistance_uncertainty": (dims, width),
            "strength": (dims, resistance / 10.0),
            "status": (dims[:2], np.full(resistance.shape[:2], "completed")),
        },
        coords={
            "depth": DEPTH,
            "stretch_number": ("stretch_number", [1, 2], {"role": "parameter"}),
            "adhesion_factor": (
                "adhesion_factor",
                np.linspace(0.0, 1.0, len(resistance)),
                {"role": "parameter"},
            ),
        },
        attrs={"design": "full"},
    )


NAN = np.nan
ONE = [[10.0, 10.0, 14.0, 10.0, NAN, NAN], [NAN, NAN, 6.0, 10.0, 20.0, 20.0]]


def test_an_overlap_is_the_mean_and_widens_the_uncertainty_by_half_its_difference() -> None:
    """Halves of the differences of 8 and 0: a root mean square of 4 / sqrt(2)."""
    result = cut(ONE)
    one = joined(result).isel(sounding=0)
    np.testing.assert_allclose(one.net_resistance, [10.0, 10.0, 10.0, 10.0, 20.0, 20.0])
    half = 4.0 / np.sqrt(2.0)
    np.testing.assert_allclose(one.overlap_difference, [0.0, 0.0, half, half, 0.0, 0.0])
    widened = np.hypot(3.0, half)
    expected = [3.0, 3.0, widened, widened, 3.0, 3.0]
    np.testing.assert_allclose(one.net_resistance_uncertainty, expected)
    assert one.net_resistance.attrs["units"] == "Pa"


def test_soundings_stay_apart() -> None:
    """Each value of another parameter is a sounding of its own, known by its first case."""
    both = joined(cut([*ONE, *(np.array(ONE) * 2.0).tolist()]))
    assert both.sizes["sounding"] == 2
    np.testing.assert_allclose(both.net_resistance[1], 2.0 * both.net_resistance[0])
    np.testing.assert_array_equal(both["case"], [0, 2])


def test_a_result_without_stretches_is_itself() -> None:
    whole = cut(ONE).isel(stretch_number=0, drop=True)
    one = joined(whole).isel(sounding=0)
    np.testing.assert_allclose(one.net_resistance, whole.net_resistance[0])
    np.testing.assert_array_equal(one.overlap_difference, 0.0)


def test_where_no_error_is_known_there_is_no_half_width() -> None:
    unknown = cut(ONE).drop_vars("net_resistance_uncertainty")
    assert np.isnan(joined(unknown).net_resistance_uncertainty).all()


def result() -> xr.Dataset:
    made = cut([*ONE, *(np.array(ONE) * 2.0).tolist()])
    made["cone_factor_at_tip"] = made.net_resistance / made.strength
    last = made.cone_factor_at_tip.max("depth").assign_attrs(role="headline")
    return made.assign(last_cone_factor=last).assign_attrs(
        study="demo", title="A demonstration", scene="sounding"
    )


def test_it_is_drawn_of_curves_over_depth_alone() -> None:
    assert "sounding" in figures(result())
    assert "sounding" not in figures(result().isel(depth=0))


@pytest.mark.parametrize("design", IN_A_ROW)
def test_it_is_drawn_of_cases_that_are_no_grid(design: str, tmp_path: Path) -> None:
    of_each = result().isel(adhesion_factor=0, stretch_number=0, drop=True)
    one = of_each.drop_vars(["status", "net_resistance_uncertainty"])
    dataset = collected(
        tmp_path, "sounding", design, one, one.map(lambda it: 2.0 * it, keep_attrs=True)
    )
    assert dataset["status"].dims == ("case",)
    resistance = figures(dataset)["sounding"].axes[1]
    drawn = [line.get_xdata()[0] for line in resistance.lines]
    np.testing.assert_allclose(drawn, [0.01, 0.02])  # kPa


def test_of_one_at_a_time_each_curve_is_whole_and_called_by_what_it_changes(tmp_path: Path) -> None:
    """Cases have samples at depths of their own."""
    design = IN_A_ROW[1].replace("[1]", "[1]\nrigidity_index = [50]")
    of_each = result().isel(adhesion_factor=0, stretch_number=0, drop=True).isel(depth=slice(4))
    one = of_each.drop_vars(["status", "net_resistance_uncertainty"])
    between = one.assign_coords(depth=one.depth + 0.5)
    figure = figures(collected(tmp_path, "sounding", design, one, between, between))["sounding"]
    assert legend(figure) == ["start", "$α$ = 1", r"$I_{\mathrm{r}}$ = 50"]
    for axes in figure.axes:
        assert [np.isfinite(line.get_xdata()).sum() for line in axes.lines] == [4, 4, 4]
        assert [line.get_xdata().size for line in axes.lines] == [4, 4, 4]


def test_depth_goes_downward_and_each_sounding_is_one_curve_with_a_band() -> None:
    figure = sounding_figure(result())
    strength, resistance, factor = figure.axes
    low, high = strength.get_ylim()
    assert low > high
    for axes in (strength, resistance, factor):
        assert len(axes.lines) == 2
        np.testing.assert_array_equal(axes.lines[0].get_ydata(), np.arange(1.0, 7.0))
    expected = [0.01, 0.01, 0.01, 0.01, 0.02, 0.02]  # kPa
    np.testing.assert_allclose(resistance.lines[0].get_xdata(), expected)
    assert len(resistance.collections) == 2
    assert legend(figure) == ["$α$ = 0", "$α$ = 1"]


def test_the_caption_names_what_the_profile_has_and_that_stretches_are_joined() -> None:
    text = "depth [m], strength [kPa], rigidity_index [1], stress_anisotropy [1]"
    of_profile = result().assign(
        profile=((), f"{text}; 0, 20, 100, 0; 9, 40, 150, 0.3", {"role": "parameter"})
    )
    told = caption_of(sounding_figure(of_profile))
    assert "$I_{\\mathrm{r}}$ = 100 to 150 by the profile, $Δ$ = 0 to 0.3 by the profile" in told
    assert "where two overlap the curve is their mean" in told


def test_where_there_is_no_band_the_caption_says_why() -> None:
    reasons = np.full(
        (2, 2), "Delta: it is beyond 0.5, from 2 to 3 m; speed: the speed is too high"
    )
    dims = ("adhesion_factor", "stretch_number")
    told = result().assign(why_no_uncertainty=(dims, reasons, {"role": "reason"}))
    said = "Where there is none the error is not known: Delta, speed."
    assert said in caption_of(sounding_figure(told))
    assert "not known" not in caption_of(sounding_figure(result()))


def interpreted(title: str = "A site") -> xr.Dataset:
    """Clay from 2 to 10 m, with a gap between 5 and 7 m, and soil that drains at 9 m."""
    depth = np.concatenate([np.arange(1.0, 5.01, 0.1), np.arange(7.0, 12.0, 0.1)])
    strength = np.outer(10.0e3 + 1.0e3 * depth, [0.8, 1.0, 1.3])
    reason = np.where((depth < 2.0) | (depth > 10.0), 1, np.where(np.isclose(depth, 9.0), 2, 0))
    meanings = {"flag_meanings": "used no_layer not_undrained_clay"}
    return xr.Dataset(
        {
            "net_resistance": ("depth", 12.0 * strength[:, 1]),
            "sleeve_friction": ("depth", 0.4 * strength[:, 1]),
            "pore_pressure": ("depth", 6.0 * strength[:, 1]),
            "strength": (("depth", "percentile"), np.where(reason[:, None], np.nan, strength)),
            "resistance_factor": (("depth", "percentile"), np.full_like(strength, 12.0)),
            "error_share": (("depth", "cause"), np.full((len(depth), 2), 0.5)),
            "reason": ("depth", reason.astype(np.int8), meanings),
            "near_border": ("depth", (np.abs(depth - 8.0) < 0.35).astype(np.int8)),
        },
        {"depth": depth, "percentile": [5.0, 50.0, 95.0], "cause": ["test", "model"]},
        {"title": title, "site": f"site_{title}"},
    )


def test_no_line_is_drawn_across_a_gap() -> None:
    for figure in (interpretation_figure(interpreted()), soundings_figure([interpreted()])):
        for axes in figure.axes:
            for line in axes.get_lines():
                depth, value = line.get_ydata(), line.get_xdata()
                assert np.isnan(value[(depth > 4.95) & (depth < 6.95)]).any()


def test_the_layers_fill_the_picture() -> None:
    figure = interpretation_figure(interpreted())
    assert figure.axes[0].get_ylim() == pytest.approx((11.0, 1.0))


def test_several_tests_have_a_line_and_a_band_each() -> None:
    figure = soundings_figure([interpreted("one"), interpreted("two")])
    test, strength = figure.axes
    assert texts(test.get_legend().get_texts()) == ["one", "two"]
    alike = soundings_figure([interpreted("one"), interpreted("one")]).axes[0]
    assert texts(alike.get_legend().get_texts()) == ["one (site_one)"] * 2
    assert len(strength.get_lines()) == len(strength.collections) == 2
    assert len({line.get_color() for line in strength.get_lines()}) == 2


def test_shares_fill_the_panel_where_a_layer_lacks_a_cause() -> None:
    found = interpreted()
    found.error_share[:] = [0.25, 0.75]
    below = found.depth.values > 7.0
    found.error_share[below] = [1.0, np.nan]
    panel = interpretation_figure(found).axes[3]
    paths = [path.vertices for it in panel.collections for path in it.get_paths()]
    ends = np.concatenate(paths)
    used = found.depth.values[below & (found.reason.values == 0)]
    assert np.isin(used, ends[np.isclose(ends[:, 0], 100.0), 1]).all()
