"""The picture of the benchmark: errors of all submissions over their run time."""

import math
from collections.abc import Sequence

from matplotlib.figure import Figure

from harness.benchmark.score import Score
from harness.pictures.drawing.plot_parts import MARKERS, STYLED, series_colour

SIZE = 9.0, 5.0
LEAST_ERROR = 1e-5
"""Smaller errors are drawn there [relative]."""
NO_TIME = 0.002, 0.1
"""Between these run times [s] stand the submissions that tell none."""
PHASES = ("exact anchors", "cone factors", "layers and gradient")


@STYLED
def benchmark_figure(found: Sequence[Score]) -> Figure:
    """Error over run time, a panel a phase; submissions that tell no time stand at the left.

    Args:
        found: scores; those without a yardstick are left out.
    """
    figure = Figure(figsize=SIZE, layout="constrained")
    judged = [it for it in found if math.isfinite(it.error)]
    names = list(dict.fromkeys(it.submission for it in judged))
    panels = figure.subplots(1, len(PHASES), sharex=True, sharey=True)
    for phase, (axes, title) in enumerate(zip(panels, PHASES, strict=True), start=1):
        axes.axvspan(*NO_TIME, color="0.95")
        for place, name in enumerate(names):
            own = [it for it in judged if it.submission == name and it.case.phase == phase]
            low, high = NO_TIME
            untimed = low * (high / low) ** ((place + 0.5) / len(names))
            seconds = [it.result.seconds for it in own]
            axes.plot(
                [it if math.isfinite(it) else untimed for it in seconds],
                [max(abs(it.error), LEAST_ERROR) for it in own],
                MARKERS[place % len(MARKERS)],
                color=series_colour(place, len(names)),
                ms=4,
                label=name,
            )
        axes.set(title=title, xscale="log", yscale="log", xlim=(NO_TIME[0], None))
    panels[0].set_ylabel("|E| over the yardstick [-]")
    panels[1].set_xlabel("run time [s]; grey: none told")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=7)
    return figure
