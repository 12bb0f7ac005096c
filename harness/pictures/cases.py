"""The pictures `cases` and `scenes`, with a row per case or soil, and `spread`, a histogram.

Beside the histogram are the shares of the inputs in the variance.
"""

from statistics import mode

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.archive.conventions import (
    COMPLETED,
    DISTRIBUTION,
    alike,
    headline_values,
    headlines_of,
    over_cases,
    scenes_of,
    spoken,
    stated,
    uncertainty_of,
    varied_names,
    varied_within,
)
from harness.compare.spread import DEVIATIONS, Spread, spreads_of
from harness.pictures.drawing.caption import captioned, not_completed, of_half_widths
from harness.pictures.drawing.plot_parts import (
    ACCENT,
    INK,
    LIGHT,
    STYLED,
    labelled_rows,
    mark_failures,
    panels,
    series,
)
from harness.pictures.drawing.quantities import assigned, axis_label, named, spelt, unit_of
from harness.pictures.effects import has_few_cases, much_varied
from harness.pictures.studied import BARS

CASE_HEIGHT, SOIL_HEIGHT = 0.32, 0.45
"""Heights [inch] of the row of a case, and of a soil."""


@STYLED
def cases_figure(dataset: xr.Dataset) -> Figure | None:
    """A row for each case, if much varies but there are too few cases for the effects."""
    studied = much_varied(dataset)
    if studied is None or not has_few_cases(studied):
        return None
    count, varied = studied.computed.size, studied.varied
    usual = {name: mode(parameter.numbers.tolist()) for name, parameter in varied.items()}
    labels = [
        studied.label(case, [name for name in varied if varied[name].numbers[case] != usual[name]])
        for case in range(count)
    ]
    figure, axes = labelled_rows([label or "as most" for label in labels], CASE_HEIGHT)
    x, y, half_width = studied.computed, range(count), studied.half_width
    axes.errorbar(x, y, xerr=half_width, fmt="o", color=INK, ms=4, capsize=3)
    mark_failures(axes, np.flatnonzero(~np.isfinite(x)).astype(float), of_rows=True)
    axes.set_xlabel(axis_label(dataset, studied.headline))
    most = [assigned(dataset, name, varied[name].value(usual[name])) for name in varied]
    beside = f"Beside each case: where it differs from {', '.join(most)}."
    failed = not_completed(dataset)
    return captioned(figure, dataset, beside, studied.bars, failed, legend=axes)


def _soils(dataset: xr.Dataset) -> tuple[list[str], dict[str, list[int]]]:
    """Labels of soils, and the cases of each scene in the order of the soils.

    Both are empty if not all scenes have the same soils.
    """
    scenes, names = scenes_of(dataset), varied_within(dataset)
    kinds, soils = list(dict.fromkeys(scenes)), alike(dataset, names)
    own = [sorted(cases, key=lambda case: kinds.index(scenes[case])) for cases in soils.values()]
    if any([scenes[case] for case in cases] != kinds for cases in own):
        return [], {}
    labels = [
        ", ".join(assigned(dataset, *pair) for pair in zip(names, soil, strict=True))
        for soil in soils
    ]
    return labels, dict(zip(kinds, map(list, zip(*own, strict=True)), strict=True))


@STYLED
def scenes_figure(dataset: xr.Dataset) -> Figure | None:
    """A row for each soil, with a mark for each scene; the first of the study on top.

    It is for up to 24 soils that all scenes share, and results of one unit.
    """
    if "scene" not in dataset.coords:
        return None
    headlines, (labels, soils) = headlines_of(dataset), _soils(dataset)
    units = {unit_of(dataset, name) for name in headlines}
    if len(soils) < 2 or len(units) != 1 or len(labels) > 24:
        return None
    figure, axes = labelled_rows(labels, SOIL_HEIGHT)
    completed = over_cases(dataset, "status").astype(str) == COMPLETED
    values = np.where(completed, headline_values(dataset), np.nan)
    half_width = uncertainty_of(dataset)
    beside = np.linspace(-0.25, 0.25, len(soils))  # of the height of a row
    for (kind, cases), line in series(soils.items(), None):
        axes.errorbar(
            values[cases],
            np.arange(len(cases)) + beside[line.place],
            xerr=half_width[cases].astype(float),
            fmt=line.marker,
            color=line.colour,
            ms=4,
            capsize=3,
            label=spelt(spoken(kind)),
        )
    unit = units.pop() or "-"
    axes.set_xlabel(f"{', '.join(named(dataset, name) for name in headlines)} [{unit}]")
    bars = of_half_widths(dataset, BARS, are_shown=bool(np.isfinite(half_width).any()))
    return captioned(figure, dataset, bars, not_completed(dataset), legend=axes)


@STYLED
def spread_figure(dataset: xr.Dataset) -> Figure | None:
    """A histogram of the first headline, and the shares of the inputs in its variance."""
    spread = next(iter(spreads_of(dataset)), None)
    if spread is None:
        return None
    figure, (counts, shares) = panels(2, height=3.4, width_ratios=(3, 2))
    _histogram(counts, spread)
    counts.set_xlabel(axis_label(dataset, spread.name))
    _bars(shares, dataset, spread)
    inputs = [
        f"{name.replace('_', ' ')}: {text}"
        for name in varied_names(dataset)
        if (text := dataset[name].attrs.get(DISTRIBUTION))
    ]
    below = ", and below it numerical U" if spread.numerical else ""
    return captioned(
        figure,
        dataset,
        f"{len(spread.values)} samples; {stated(spread.mean, spread.combined)} is the mean with "
        f"the {spread.called}.",
        f"Shade: 90 % of the samples; line: median; bar: mean, {spread.called}{below}.",
        f"Inputs: {'; '.join(inputs)}.",
    )


def _histogram(axes: Axes, spread: Spread) -> None:
    low, middle, high = spread.percentiles
    axes.hist(spread.values, bins="auto", color=ACCENT, alpha=0.7)
    axes.axvspan(low, high, color=LIGHT, alpha=0.25, lw=0, zorder=0)
    axes.axvline(middle, color=INK, lw=1.0)
    top = axes.get_ylim()[1]
    for height, half in ((1.10, spread.combined), (1.03, DEVIATIONS * spread.numerical)):
        if half:
            axes.errorbar(spread.mean, height * top, xerr=half, fmt="o", color=INK, ms=3, capsize=3)
    axes.set(ylim=(0.0, 1.17 * top), ylabel="samples")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _bars(axes: Axes, dataset: xr.Dataset, spread: Spread) -> None:
    shares = sorted(spread.shares.items(), key=lambda it: it[1])
    names = [named(dataset, cause) if cause in dataset else cause for cause, _ in shares]
    axes.barh(
        np.arange(len(shares)), [100.0 * share for _, share in shares], color=ACCENT, alpha=0.7
    )
    axes.set_yticks(np.arange(len(shares)), names, fontsize=8)
    axes.set_xlabel("share of the variance [%]")
    if not shares:
        words = f"{spread.needed} cases are needed"
        axes.text(0.5, 0.5, words, ha="center", transform=axes.transAxes)
