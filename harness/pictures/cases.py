"""The picture of a few cases that differ in many parameters: the headline of each, with its bar."""

from collections import Counter

import xarray as xr
from matplotlib.figure import Figure

from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import INK, STYLED
from harness.pictures.drawing.quantities import assigned, axis_label
from harness.pictures.effects import much_varied, shows_effects
from harness.pictures.studied import Studied

ROW_HEIGHT, MARGIN = 0.32, 1.5
"""Inches of a row, and of axis and caption."""


def shows_cases(dataset: xr.Dataset) -> bool:
    """Whether a result varies much in a few cases, too few to tell the effect of a parameter."""
    return much_varied(dataset) is not None and not shows_effects(dataset)


@STYLED
def cases_figure(dataset: xr.Dataset) -> Figure:
    """A row for each case, the first of the study on top."""
    studied = Studied.known(dataset)
    count = studied.computed.size
    figure = Figure(figsize=(Figure().get_figwidth(), ROW_HEIGHT * count + MARGIN))
    axes = figure.subplots()
    rows = range(count)
    axes.errorbar(
        studied.computed, rows, xerr=studied.half_width, fmt="o", color=INK, ms=4, capsize=3
    )
    usual = {
        name: Counter(it.numbers.tolist()).most_common(1)[0][0]
        for name, it in studied.varied.items()
    }
    axes.set_yticks(rows, [_label(studied, case, usual) for case in rows], fontsize=8)
    axes.set_ylim(count - 0.5, -0.5)
    axes.set_xlabel(axis_label(dataset, studied.headline))
    failed = studied.failed
    most = [assigned(dataset, name, it.value(usual[name])) for name, it in studied.varied.items()]
    lost = f"{failed.size} of {count} cases did not complete." if failed.size else ""
    beside = f"Beside each case: where it differs from {', '.join(most)}."
    write_caption(figure, dataset, beside, studied.bars, lost)
    return figure


def _label(studied: Studied, case: int, usual: dict[str, float]) -> str:
    """What a case has that most have not."""
    own = [name for name, it in studied.varied.items() if it.numbers[case] != usual[name]]
    return studied.label(case, own) or "as most"
