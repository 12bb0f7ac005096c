"""The lines su = a + b z of an interpretation: in sentences, on its page, and as a table."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from harness.interpret.result import PERCENTILES, in_digits
from harness.interpret.site import Site
from mpm_warp.grid.fitted import Floats

FIGURES = ("a", "kPa"), ("b", "kPa/m"), ("su at top", "kPa"), ("su at bottom", "kPa")
"""What is said of a line, with its unit."""
TITLES = [
    *("layer", "strength", "from [m]", "to [m]"),
    *(f"{name} {share:g}% [{unit}]" for name, unit in FIGURES for share in PERCENTILES),
]
"""Columns of the table."""


def lines_in_words(found: xr.Dataset) -> list[str]:
    """A sentence for each layer."""
    sentences = []
    for title in found.layer.values:
        own = found.sel(layer=title)
        figures = _figures(own)
        (a, of_a), (b, of_b), (top, of_top), (bottom, of_bottom) = map(_spoken, figures)
        along = "kPa from z = {:g} to {:g} m".format(*own.line_depth.values)
        if np.isnan(figures).any():
            words = "no line; no depth with a strength is free of other layers"
        elif figures[1].any():
            sign = "-" if figures[1, 1] < 0.0 else "+"
            words = (
                f"line su = a + b z = {a} {sign} {b.lstrip('-')} z {along}. It has {top} kPa, "
                f"{of_top} with 90 %, at the top and {bottom} kPa, {of_bottom} with 90 %, at the "
                f"bottom. With 90 % a is {of_a} kPa and b {of_b} kPa/m"
            )
        else:
            words = f"line su = {a} {along}, {of_a} with 90 %; no significant slope"
        sentences.append(f"{title}: {words}.")
    return sentences


def line_rows(found: xr.Dataset) -> list[tuple[str, ...]]:
    """A row for each layer with a line, the heading first."""
    rows: list[tuple[str, ...]] = [
        ("layer", "depth [m]", *(f"{name} [{unit}]" for name, unit in FIGURES))
    ]
    for title in found.layer.values:
        own = found.sel(layer=title)
        if own.line_slope.notnull().all():
            spoken = map(_spoken, _figures(own))
            cells = ("0" if middle == "0" else f"{middle} ({band})" for middle, band in spoken)
            rows.append((str(title), "{:g} to {:g}".format(*own.line_depth.values), *cells))
    return rows


def line_table(site: Site, found: xr.Dataset) -> Iterator[list[str]]:
    """The titles of the columns, then a row for each layer; cells without a value are empty."""
    yield TITLES
    for layer in site.layers:
        own = found.sel(layer=layer.title)
        numbers = np.concatenate([own.line_depth.values, _figures(own).ravel()])
        cells = ("" if np.isnan(number) else f"{number:.6g}" for number in numbers)
        yield [layer.title, layer.strength, *cells]


def _figures(own: xr.Dataset) -> Floats:
    """Percentiles of `FIGURES` of a layer, shape [figures, percentiles]."""
    figures: Floats = np.vstack([own.line_intercept, own.line_slope, own.line_strength]) / 1e3
    return figures


def _spoken(percentiles: Floats) -> tuple[str, str]:
    """Median and band in words."""
    low, middle, high = in_digits(*percentiles)
    return middle, f"{low} to {high}"
