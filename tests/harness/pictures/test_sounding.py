"""The picture of soundings: depth downward, strength beside resistance."""

import numpy as np
import xarray as xr

from harness.pictures.sounding import sounding_figure
from tests.harness.pictures.conftest import figures
from tests.harness.pictures.test_joined_soundings import ONE, cut


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
    assert [it.get_text() for it in figure.legends[0].get_texts()] == ["$α$ = 0", "$α$ = 1"]


def test_where_there_is_no_band_the_caption_says_why() -> None:
    reasons = np.full((2, 2), "Delta: it is beyond 0.5, from 2 to 3 m; speed: it is too high")
    dims = ("adhesion_factor", "stretch_number")
    told = result().assign(why_no_uncertainty=(dims, reasons, {"role": "reason"}))
    said = "Where there is none the error is not known: Delta, speed."
    captions = [sounding_figure(it).get_supxlabel() for it in (told, result())]
    assert said in " ".join(captions[0].split())
    assert "not known" not in captions[1]
