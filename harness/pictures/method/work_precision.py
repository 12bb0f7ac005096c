"""Work-precision pictures: error against run time."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from harness.archive.conventions import freely_varied, over_cases, scenes_of, uncertainty_of
from harness.compare.finest_error import FLOOR, credited_error, error_name, states_its_error
from harness.pictures.drawing.caption import NO_BREAK, captioned, largest_parts, not_completed
from harness.pictures.drawing.plot_parts import (
    MOST_LABELS,
    chosen,
    legend_above,
    once,
    panels,
    series,
)
from harness.pictures.drawing.quantities import (
    Floats,
    Values,
    assigned,
    in_words,
    plain,
    quantity,
    symbol,
)
from harness.pictures.drawing.style import DOT, GREY, INK, PAPER, STYLED
from harness.pictures.studied import label_of, method_of
from harness.study.designs import ONE_AT_A_TIME


class _Problem(NamedTuple):
    """Cases of one problem, which differ only in settings of the method."""

    cases: np.ndarray
    scene: str
    soil: list[str]  # values of all other varied parameters, in words
    settings: list[Values]


def _problems_of(dataset: xr.Dataset) -> list[_Problem]:
    """The problems that a study solves with different settings, in the order of the study."""
    scenes, problems = np.array(scenes_of(dataset)), []
    varied = [Values.of(dataset, name) for name in freely_varied(dataset) if name != "scene"]
    for scene in dict.fromkeys(scenes.tolist()):
        method, own = method_of(dataset, scene), np.flatnonzero(scenes == scene)
        soil = [it for it in varied if it.name not in method and np.ptp(it.numbers[own]) > 0.0]
        groups: dict[tuple[float, ...], list[int]] = {}
        for case in own.tolist():
            groups.setdefault(tuple(it.numbers[case] for it in soil), []).append(case)
        for cases in groups.values():
            texts = [assigned(dataset, it.name, it.of_case(cases[0])) for it in soil]
            settings = [
                it for it in varied if it.name in method and np.ptp(it.numbers[cases]) > 0.0
            ]
            problems.append(_Problem(np.array(cases), scene, texts, settings))
    return [problem for problem in problems if problem.settings]


def _setting_of(dataset: xr.Dataset, problem: _Problem, case: int) -> str:
    """The varied settings of a case; in a one-at-a-time study those that differ from the first."""
    if dataset.attrs.get("design") != ONE_AT_A_TIME and len(problem.settings) > 1:
        return " / ".join(quantity(it.of_case(case)) for it in problem.settings)
    return label_of(dataset, problem.settings, case, start=problem.cases[0])


def _settings_key(dataset: xr.Dataset, problems: list[_Problem]) -> str:
    """A sentence that explains the values of :func:`_setting_of`."""
    if dataset.attrs.get("design") == ONE_AT_A_TIME:
        return ""
    keys = dict.fromkeys(
        " / ".join(symbol(it.name) or in_words(it.name) for it in problem.settings)
        for problem in problems
        if len(problem.settings) > 1
    )
    return f"Beside points: {'; '.join(keys)}." if keys else ""


FRONT = "front: no other is faster and better"
NOT_STATED = "states no error of its own"
MEANING_OF_LINES = (
    "Points are measured errors. Thin lines lead to the half width of the case or of the "
    "reference, if it is greater; the front joins the upper ends."
)


@STYLED
def checks_figure(dataset: xr.Dataset) -> Figure:
    """`error` over `run_time` of each check and rank, in one style for each scene."""
    scenes = [str(check).partition(" ")[0] for check in dataset["check"].values]
    lines = dict(series(dict.fromkeys(scenes), None))
    figure, (axes,) = panels()
    for number, scene in enumerate(scenes):
        curve = dataset.isel(check=number)
        axes.loglog(
            curve["run_time"],
            curve["error"].where(curve["error"] > 0.0),
            **lines[scene].style,
            label=once(axes, plain(scene)),
        )
    _dress(figure, axes, "error against the exact solution")
    return figure


@STYLED
def study_figure(dataset: xr.Dataset) -> Figure | None:
    """Error over run time of a study's cases, with a front of the best for each problem.

    The point of a case is at its measured error. The front uses the half width that the case states
    if it is greater. If only some cases state one, the others are on no front, because their error
    may be small by chance. A case that did not complete is marked on the upper edge, at its time.
    """
    name = error_name(dataset)
    if name is None or "run_time" not in dataset:
        return None
    problems = _problems_of(dataset)
    if not problems:
        return None
    measured, errors = over_cases(dataset, name).astype(float), credited_error(dataset)
    seconds = over_cases(dataset, "run_time").astype(float)
    drawn = np.isfinite(measured) & np.isfinite(seconds) & (measured > 0.0)
    errors = np.where(drawn, errors, np.nan)
    if not np.isfinite(errors).any():
        return None
    figure, (axes,) = panels()
    axes.set(xscale="log", yscale="log")
    _draw_fronts(axes, dataset, problems, seconds, measured, errors)
    silent = drawn & ~states_its_error(dataset)
    if silent.any():
        place = seconds[silent], measured[silent]
        axes.plot(*place, "o", mfc="none", color=GREY, ms=DOT, label=NOT_STATED)
    floor = over_cases(dataset, FLOOR).astype(float)
    if np.isfinite(floor).any() and np.nanmax(floor) < 1.1 * np.nanmin(floor):
        label = "uncertainty of the reference"
        axes.axhline(np.nanmax(floor), ls=":", color=INK, label=label)
    has_scenes = len(set(scenes_of(dataset))) > 1
    soil = [text.replace(" ", NO_BREAK) for text in problems[0].soil] if len(problems) == 1 else []
    _dress(figure, axes, name if has_scenes else dataset[name].attrs.get("long_name", name))
    has_half_widths = np.isfinite(uncertainty_of(dataset)).any()
    return captioned(
        figure,
        dataset,
        f"All points: {', '.join(soil)}." if soil else "",
        _settings_key(dataset, problems),
        MEANING_OF_LINES if has_half_widths else "",
        largest_parts(dataset),
        "Run times are comparable only if the cases were run one at a time.",
        not_completed(dataset),
    )


def _draw_fronts(
    axes: Axes,
    dataset: xr.Dataset,
    problems: list[_Problem],
    seconds: Floats,
    measured: Floats,
    errors: Floats,
) -> None:
    """Draw the cases of each problem at their measured errors; the front joins `errors`."""
    several = len({problem.scene for problem in problems}) > 1
    budget = MOST_LABELS
    for problem, line in series(problems, None):
        own = problem.cases[np.isfinite(errors[problem.cases])]
        own = own[np.lexsort((errors[own], seconds[own]))]
        # A case is on the front if no other is both faster and better.
        is_best = errors[own] < np.minimum.accumulate([np.inf, *errors[own]])[:-1]
        front, beaten = own[is_best], own[~is_best]
        if beaten.size:
            label = once(axes, "beaten by another")
            axes.plot(seconds[beaten], measured[beaten], "o", color=GREY, ms=DOT, label=label)
        scene = [in_words(problem.scene)] if several else []
        soil = problem.soil if len(problems) > 1 else []
        name = ", ".join([*scene, *soil]) if len(problems) <= MOST_LABELS else ""
        label = name or once(axes, FRONT)
        axes.plot(seconds[front], measured[front], line.marker, color=line.colour, zorder=3)
        axes.plot(seconds[front], errors[front], color=line.colour, zorder=3)
        axes.plot([], [], f"{line.marker}-", color=line.colour, label=label)
        wider = front[errors[front] > measured[front]]
        axes.vlines(seconds[wider], measured[wider], errors[wider], color=line.colour)
        apart = _apart(front, measured, np.ptp(np.log(measured[np.isfinite(errors)])))
        share = min(len(apart), budget // (len(problems) - line.place))
        budget -= share
        for case in apart[chosen(len(apart), share)]:
            axes.annotate(
                _setting_of(dataset, problem, int(case)),
                (seconds[case], measured[case]),
                xytext=(4, 4),
                textcoords="offset points",
                bbox={"fc": PAPER, "ec": "none", "pad": 0.5},
            )


def _apart(front: np.ndarray, errors: Floats, log_range: float) -> np.ndarray:
    """The best point of a front, and others whose labels are 0.06 of the range apart."""
    kept: list[int] = []
    for case in front[::-1]:
        if not kept or abs(np.log(errors[case] / errors[kept[-1]])) > 0.06 * log_range:
            kept.append(int(case))
    return np.array(kept[::-1], dtype=int)


def _dress(figure: Figure, axes: Axes, meaning: str) -> None:
    axes.set(xlabel="run time [s]", ylabel=f"{plain(meaning)} [-]")
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        # Ticks at powers of ten would be too few on an axis of less than two decades.
        digits = (1, 2, 3, 4, 5, 6, 8) if high < 10.0 * low else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=digits if high < 100.0 * low else (1,)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())
    legend_above(figure, axes)
