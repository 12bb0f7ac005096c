"""The page of the open benchmark: all submissions beside one another, and their picture."""

import math
from collections.abc import Sequence

from matplotlib.figure import Figure

from harness.benchmark.cases import META_KEYS, Submission
from harness.benchmark.score import Score, case_rows, summary_rows
from harness.pictures.drawing.plot_parts import MAKER, MARKERS, STYLED, series_colour
from harness.report.report import TEMPLATES, embedded

SIZE = 9.0, 5.0
LEAST_ERROR = 1e-5
"""Smaller errors are drawn there [relative]."""
NO_TIME = 0.002, 0.1
"""Between these run times [s] stand the submissions that tell none."""
PHASES = ("exact anchors", "cone factors", "layers and gradient")


@STYLED
def benchmark_figure(found: Sequence[Score]) -> Figure:
    """Error over run time, a panel a phase; submissions that tell no time stand at the left."""
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


def benchmark_page(
    submissions: Sequence[Submission], found: Sequence[Score], picture: bytes, against: str
) -> str:
    """The page as text, with a PNG of errors over run time; `against` is the yardstick."""
    cases = {it.case.name: it.case for it in found}
    exact = {
        name: " to ".join(dict.fromkeys(f"{it:g}" for it in case.exact)) if case.exact else ""
        for name, case in cases.items()
    }
    return TEMPLATES.get_template("benchmark.html").render(
        maker=MAKER,
        against=against,
        picture=embedded("errors over run time", picture),
        summary=summary_rows(found),
        meta=[
            ["submission", *META_KEYS],
            *([it.name, *(it.meta.get(key, "") for key in META_KEYS)] for it in submissions),
        ],
        titles=[
            ["case", "what is computed", "unit", "exact"],
            *([it.name, it.title, it.unit, exact[it.name]] for it in cases.values()),
        ],
        results=case_rows(found),
    )
