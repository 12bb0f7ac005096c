"""Curves that are run in pieces, and cases with samples of their own."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.pictures.declared import declared, picture_of
from mpm_warp.results import Drawn

from .conftest import IN_A_ROW, caption_of, collected, figures, legend

NAN = np.nan
PIECES = [[10.0, 10.0, 14.0, 10.0, NAN, NAN], [NAN, NAN, 6.0, 10.0, 20.0, 20.0]]
OVERLAP = 4.0 / np.sqrt(2.0)
"""Halves of the differences of 8 and 0: a root mean square of 4 / sqrt(2)."""


def in_pieces(half_width: float = 3.0) -> xr.Dataset:
    """Soundings of two clays, each in two pieces with an overlap."""
    one = np.array(PIECES)
    values, dims = np.stack([one, 2.0 * one]), ("adhesion_factor", "stretch_number", "depth")
    by_depth = {"downward": True, "joined_over": "stretch_number"}
    places = [Drawn(picture="sounding", panel=it, **by_depth).attributes for it in (1, 2)]
    of_error = Drawn(picture="sounding", panel=2, divided_by="net", **by_depth).attributes
    places[1] |= of_error
    made = xr.Dataset(
        {
            "net": (dims, values, {"units": "Pa", "long_name": "net", **places[0]}),
            "net_uncertainty": (
                dims,
                np.where(np.isnan(values), NAN, half_width),
                {"units": "Pa", "long_name": "half width", **places[1]},
            ),
            "last": (dims[:2], values[:, :, 3], {"role": "headline", "units": "1"}),
            "status": (dims[:2], np.full((2, 2), "completed")),
        },
        {
            "depth": ("depth", np.arange(1.0, 7.0), {"units": "m", "long_name": "depth"}),
            "stretch_number": ("stretch_number", [1, 2], {"role": "parameter"}),
            "adhesion_factor": ("adhesion_factor", [0.0, 1.0], {"role": "parameter"}),
        },
    )
    return made.assign_attrs(study="demo", title="T", design="full")


def test_pieces_are_joined_and_widen_the_half_width_where_they_differ() -> None:
    made = in_pieces()
    picture = picture_of(made, declared(made)["sounding"])
    net, share = (panel[0] for panel in picture.panels)
    expected = np.array([10.0, 10.0, 10.0, 10.0, 20.0, 20.0])
    np.testing.assert_allclose(net.values, 1e-3 * np.stack([expected, 2.0 * expected]))
    widened = np.hypot(3.0, [0.0, 0.0, OVERLAP, OVERLAP, 0.0, 0.0])
    np.testing.assert_allclose(share.values[0], 100.0 * widened / expected)
    assert share.label == "half width [%]"
    assert picture.cases.tolist() == [0, 2]
    whole = made.isel(stretch_number=0, drop=True)
    (own,) = picture_of(whole, ["net"]).panels[0]
    np.testing.assert_allclose(own.values, 1e-3 * whole.net)


def test_joined_pieces_go_down_the_page_with_their_half_width_beside_them() -> None:
    figure = figures(in_pieces())["sounding"]
    assert "curve" not in figures(in_pieces())
    for axes in figure.axes:
        assert axes.get_ylim()[0] > axes.get_ylim()[1]
        curve = axes.lines[0] if axes.lines[0].get_xdata().size else axes.lines[2]
        np.testing.assert_array_equal(curve.get_ydata(), np.arange(1.0, 7.0))
    assert [axes.get_ylabel() for axes in figure.axes] == ["depth [m]", ""]
    assert legend(figure) == ["$α$ = 0", "$α$ = 1"]
    told = caption_of(figure)
    assert "Half widths hold the value with 95 %" in told
    assert "where two overlap the curve is their mean" in told


def test_where_no_half_width_is_known_the_caption_says_why() -> None:
    made = in_pieces(NAN)
    reasons = np.full((2, 2), "Delta: it is beyond 0.5, from 2 to 3 m; speed: too high")
    told = made.assign(why_no_uncertainty=(made["status"].dims, reasons, {"role": "reason"}))
    figure = figures(told)["sounding"]
    assert len(figure.axes) == 1
    assert "There are no half widths: the error is not known: Delta, speed." in caption_of(figure)


def one_sounding(shift: float = 0.0) -> xr.Dataset:
    of_each = in_pieces().isel(adhesion_factor=0, stretch_number=0, drop=True)
    one = of_each.drop_vars(["status", "net_uncertainty"]).isel(depth=slice(4))
    return one.assign_coords(depth=one.depth + shift)


@pytest.mark.parametrize("design", IN_A_ROW)
def test_curves_are_drawn_of_cases_that_are_no_grid(design: str, tmp_path: Path) -> None:
    """Cases have samples at depths of their own; each curve is whole."""
    dataset = collected(tmp_path, "sounding", design, one_sounding(), one_sounding(0.5))
    assert dataset["status"].dims == ("case",)
    (axes,) = figures(dataset)["sounding"].axes
    drawn = axes.lines[:2]
    assert [np.isfinite(line.get_xdata()).tolist() for line in drawn] == [[True] * 4] * 2
