"""HTML pages: on interpreted cone tests, and on the open benchmark.

The page on tests has all values that may be quoted, and all inputs that they depend on.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.own_files import MAKER
from harness.benchmark.cases import META_KEYS, Submission
from harness.benchmark.score import Score, case_rows, summary_rows
from harness.interpret.description import test_rows
from harness.interpret.lines import line_rows
from harness.interpret.measured import REASONS
from harness.interpret.result import (
    in_digits,
    in_words,
    laboratory_in_words,
    laboratory_rows,
    rate_in_words,
)
from harness.interpret.site import BY_SLEEVE, Layer, Site
from harness.interpret.tables.model_factor import DEPTH, SIMULATED, SITE
from harness.pictures.drawing.caption import caption
from harness.pictures.drawing.plot_parts import image, legend_above, panels, runs, series
from harness.pictures.drawing.style import PALE, PAPER, STYLED
from harness.report.report import TEMPLATES, embedded
from mpm_warp.provenance import provenance

Rows = list[tuple[str, ...]]
"""Rows of a table, the heading first."""
MOST_STRETCHES = 8
"""Stretches without a strength for one reason; of more, only the first and last depth are given."""


@dataclass(frozen=True)
class Interpreted:
    """One interpreted test."""

    path: Path  # the site file
    site: Site  # its content
    found: xr.Dataset  # the result of `interpret`
    figure: Figure  # its picture


def interpretation_page(tests: Sequence[Interpreted], together: Figure | None) -> str:
    """The page on tests as text; `together` is a picture of all tests if there are several."""
    overview = None if together is None else embedded("all tests", image(together))
    made = provenance()
    return TEMPLATES.get_template("interpretation.html").render(
        maker=MAKER,
        sections=[_section(test, place) for place, test in enumerate(tests, start=1)],
        together=overview,
        made=[(name, made[name]) for name in ("mpm_warp_version", "commit", "time_written")],
    )


def _section(test: Interpreted, place: int) -> dict[str, Any]:
    """The variables of interpretation.html for one test."""
    site, found = test.site, test.found
    return {
        "anchor": f"test-{place}",
        "title": site.title,
        "sentences": in_words(site, found) + laboratory_in_words(site, found),
        "laboratory": laboratory_rows(found),
        "lines": line_rows(found),
        "picture": embedded(site.name, image(test.figure)),
        "inputs": [
            ("layer", "input", "as given", "before: median (90 %)", "by the test: median (90 %)"),
            *(row for layer in site.layers for row in _input_rows(layer, found)),
        ],
        "causes": _cause_rows(site, found),
        "left_out": _left_out(site, found),
        "notes": [piece for piece in found.attrs["notes"].split("; ") if piece],
        "test": [("key", "as given", "meaning"), *test_rows(test.path)],
    }


def _input_rows(layer: Layer, found: xr.Dataset) -> Rows:
    """A row for each input of a layer, and rows for the meaning of su."""
    by_sleeve = {} if "adhesion_factor" in layer.inputs else {"adhesion_factor": BY_SLEEVE}
    given = {name: distribution.text for name, distribution in layer.inputs.items()} | by_sleeve
    texts = given | {
        "rigidity_strength": layer.rigidity_strength,
        "strength": layer.strength,
        "laboratory_rate": rate_in_words(layer),
    }
    if layer.strength != SIMULATED:
        texts |= dict.fromkeys((SITE, DEPTH), "measured sites")
    rows: Rows = []
    for name, text in texts.items():
        spans = ["", ""]
        if name in layer.inputs or name in (SITE, DEPTH):
            both = (found[f"input_{time}"] for time in ("before", "after"))
            spans = [_span(*it.sel(layer=layer.title, cause=name).values) for it in both]
        assumed = " (assumed)" if name in layer.assumed else ""
        rows.append((layer.title, name, f"{text}{assumed}", *spans))
    return rows


def _span(*percentiles: float) -> str:
    low, middle, high = in_digits(*percentiles)
    return f"{middle} ({low} to {high})" if np.isfinite(percentiles).all() else "-"


def _cause_rows(site: Site, found: xr.Dataset) -> Rows:
    """Mean share of each cause in the variance of ln su in each layer, the largest first."""
    used = found.error_share[found.reason == 0]
    in_layer = site.layer_at(used.depth.values)
    means = xr.concat(
        [used[in_layer == number].mean("depth") for number in range(len(site.layers))], "layer"
    )
    total = means.sum("layer")
    rows: Rows = [("cause", *(layer.title for layer in site.layers))]
    for cause in total.sortby(-total).cause.values:
        if float(total.sel(cause=cause)) > 0.0:
            own = means.sel(cause=cause).values
            shares = ("-" if np.isnan(share) else f"{100.0 * share:.0f} %" for share in own)
            rows.append((str(cause).replace("_", " "), *shares))
    return rows


def _left_out(site: Site, found: xr.Dataset) -> Rows:
    """Number and stretches of the depths without a strength, by layer and reason."""
    rows: Rows = [("layer", "why", "depths", "of", "depth [m]")]
    depth, in_layer = found.depth.values, site.layer_at(found.depth.values)
    for place, layer in enumerate(site.layers):
        inside = in_layer == place
        for number, why in enumerate(REASONS):
            here = inside & (found.reason.values == number)
            if number and here.any():
                pieces = [depth[run] for run in runs(here)]
                if (more := len(pieces)) > MOST_STRETCHES:
                    pieces = [depth[here]]
                ends = (f"{it[0]:g}" + (f" to {it[-1]:g}" if len(it) > 1 else "") for it in pieces)
                span = ", ".join(ends) + (f", in {more} stretches" if more > len(pieces) else "")
                rows.append((layer.title, why, str(here.sum()), str(inside.sum()), span))
    return rows


LEAST_ERROR = 1e-5
"""Relative error at which smaller ones are drawn."""
NO_TIME = 0.002, 0.1
"""Run times [s] between which submissions without a run time are drawn."""
PHASES = ("exact anchors", "cone factors", "layers and gradient")


@STYLED
def benchmark_figure(found: Sequence[Score], against: str) -> Figure:
    """Error over run time, a panel for each phase; results without a run time are at the left."""
    judged = [scored for scored in found if math.isfinite(scored.error)]
    names = list(dict.fromkeys(scored.submission for scored in judged))
    untimed = np.geomspace(*NO_TIME, 2 * len(names) + 1)[1::2]
    figure, all_axes = panels(len(PHASES), sharex=True, sharey=True)
    for phase, (axes, title) in enumerate(zip(all_axes, PHASES, strict=True), start=1):
        axes.axvspan(*NO_TIME, color=PALE)
        for (name, without), line in series(zip(names, untimed, strict=True), None):
            axes.plot([], [], **line.style, ls="", label=name)
            for scored in judged:
                if scored.submission == name and scored.case.phase == phase:
                    result, error = scored.result, max(abs(scored.error), LEAST_ERROR)
                    seconds = result.seconds if math.isfinite(result.seconds) else without
                    fill = line.colour if math.isfinite(result.uncertainty) else PAPER
                    axes.plot(seconds, error, **line.style, ls="", mfc=fill)
        axes.set(title=title, xscale="log", yscale="log")
    all_axes[0].set_xlim(left=NO_TIME[0])  # of all, once all points are there
    all_axes[0].set_ylabel("|E| over the yardstick [-]")
    all_axes[1].set_xlabel("run time [s]")
    legend_above(figure, all_axes[0])
    caption(
        figure,
        "E is the difference from the exact value, or if that is unknown from the value of "
        f"{against}, which is not exact. Filled: the uncertainty U is stated. Hollow: it is not. "
        f"Grey: no run time is given. Errors below {LEAST_ERROR:g} are drawn there.",
    )
    return figure


def benchmark_page(
    submissions: Sequence[Submission], found: Sequence[Score], figure: Figure, against: str
) -> str:
    """The page as text, with the figure of errors over run time; `against` is the yardstick."""
    cases = {scored.case.name: scored.case for scored in found}
    exact = {
        name: " to ".join(dict.fromkeys(f"{value:g}" for value in case.exact or ()))
        for name, case in cases.items()
    }
    return TEMPLATES.get_template("benchmark.html").render(
        maker=MAKER,
        against=against,
        picture=embedded("errors over run time", image(figure)),
        summary=summary_rows(found),
        meta=[
            ["submission", "key", "value"],
            *(
                [submission.name, key, submission.meta[key]]
                for submission in submissions
                for key in META_KEYS
                if key in submission.meta
            ),
        ],
        titles=[
            ["case", "what is computed", "unit", "exact"],
            *([case.name, case.title, case.unit, exact[case.name]] for case in cases.values()),
        ],
        results=case_rows(found),
    )
