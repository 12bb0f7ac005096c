"""Work-precision pictures: error against run time."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from harness.archive.atomic_files import write_whole
from harness.archive.conventions import (
    COMPLETED,
    is_there,
    over_cases,
    scenes_of,
    spoken,
    uncertainty_of,
    varied_names,
)
from harness.compare.finest_error import FLOOR, credited_error, error_name, states_its_error
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import (
    FAILED,
    INK,
    MARKERS,
    MOST_LABELS,
    STYLED,
    chosen,
    empty_figure,
    image,
    legend_above,
    once,
    series_colour,
)
from harness.pictures.drawing.quantities import Floats, Values, assigned, plain, quantity, symbol
from harness.pictures.studied import method_of
from harness.study.designs import ONE_AT_A_TIME


@dataclass(frozen=True)
class Problem:
    """Cases that ask the same question: they differ in parameters of the method alone.

    Attributes:
        cases: which they are.
        scene: their scene.
        soil: what else the study varies, by name, in words.
        settings: the parameters of the method that vary among them.
    """

    cases: np.ndarray
    scene: str
    soil: dict[str, str]
    settings: tuple[str, ...]


def problems_of(dataset: xr.Dataset) -> list[Problem]:
    """The problems that a study solves with different settings, in the order of the study."""
    scenes = np.array(scenes_of(dataset))
    varied = [name for name in varied_names(dataset) if name != "scene"]
    columns = {name: Values.of(dataset, name) for name in varied}
    groups: dict[tuple[object, ...], list[int]] = {}
    for case, scene in enumerate(scenes.tolist()):
        method = method_of(dataset, scene)
        key = [columns[name].numbers[case] for name in varied if name not in method]
        groups.setdefault((scene, *key), []).append(case)
    found = []
    for (scene, *_), members in groups.items():
        cases, method = np.array(members), method_of(dataset, str(scene))
        own = [name for name in varied if _has(dataset, name, scenes == scene)]
        different = {name: np.unique(columns[name].numbers[scenes == scene]) for name in own}
        settings = tuple(
            name
            for name in own
            if name in method and np.unique(columns[name].numbers[cases]).size > 1
        )
        soil = {
            name: assigned(dataset, name, _value(columns[name], int(cases[0])))
            for name in own
            if name not in method and different[name].size > 1
        }
        found.append(Problem(cases, str(scene), soil, settings))
    return [problem for problem in found if problem.settings]


def _has(dataset: xr.Dataset, name: str, cases: np.ndarray) -> bool:
    """Whether one of these cases has a value of a parameter; others may leave it to the scene."""
    return any(map(is_there, over_cases(dataset, name)[cases].tolist()))


def problem_names(problems: list[Problem]) -> list[str]:
    """What each is called among the others: its scene and soil, as far as these differ."""
    scenes = {problem.scene for problem in problems}
    names = []
    for problem in problems:
        of_scene = [it for it in problems if it.scene == problem.scene]
        parts = [plain(problem.scene).replace("_", " ")] if len(scenes) > 1 else []
        parts += [
            text
            for name, text in problem.soil.items()
            if len({other.soil[name] for other in of_scene}) > 1
        ]
        names.append(", ".join(parts))
    return names


def setting_of(dataset: xr.Dataset, problem: Problem, case: int) -> str:
    """The settings of a case that vary; of one at a time those that differ from the start."""
    columns = {name: Values.of(dataset, name) for name in problem.settings}
    if dataset.attrs.get("design") == ONE_AT_A_TIME:
        start = problem.cases[0]
        texts = [
            assigned(dataset, name, _value(it, case))
            for name, it in columns.items()
            if it.numbers[case] != it.numbers[start]
        ]
        return ", ".join(texts) or "start"
    if len(columns) == 1:
        return "".join(assigned(dataset, name, _value(it, case)) for name, it in columns.items())
    return " / ".join(quantity(_value(column, case)) for column in columns.values())


def settings_key(dataset: xr.Dataset, problems: list[Problem]) -> str:
    """What the values of :func:`setting_of` are, in a sentence."""
    if dataset.attrs.get("design") == ONE_AT_A_TIME:
        return ""
    keys = dict.fromkeys(
        " / ".join(symbol(name) or plain(spoken(name)) for name in problem.settings)
        for problem in problems
        if len(problem.settings) > 1
    )
    return f"Beside points: {'; '.join(keys)}." if keys else ""


def _value(values: Values, case: int) -> float | str:
    return values.value(float(values.numbers[case]))


FRONT = "front: no other is faster and better"
NOT_STATED = "does not state its own error"
OF_HALF_WIDTH = "An error is no less than the half width that the case states."
LEGEND_LINE = 0.15
"""Inches of a line of a legend."""
LABEL_GAP = 0.06
"""Least distance of two labels, of the range of errors."""


def draw_work_precision(dataset: xr.Dataset, path: Path) -> None:
    """Write the picture of `error` and `run_time` over `check` and `rank`, whole or not at all.

    Raises:
        ArchiveError: it cannot be written.
    """
    write_whole(image(work_precision_figure(dataset)), path)


@STYLED
def work_precision_figure(dataset: xr.Dataset) -> Figure:
    """Errors of checks against their run times; runs that failed are left out."""
    figure, axes = empty_figure()
    checks = dataset["check"].values
    figure.set_figheight(figure.get_figheight() + LEGEND_LINE * checks.size / 2)
    for index, check in enumerate(checks):
        curve = dataset.isel(check=index)
        marker, colour = MARKERS[index % len(MARKERS)], series_colour(index, checks.size)
        axes.loglog(
            curve["run_time"], curve["error"], marker=marker, color=colour, label=plain(check)
        )
    _dress(figure, axes, "error against the exact solution")
    return figure


def shows_work_precision(dataset: xr.Dataset) -> bool:
    """Whether a result holds errors and run times of several settings for one problem."""
    if error_name(dataset) is None or "run_time" not in dataset or "status" not in dataset:
        return False
    return bool(problems_of(dataset))


@STYLED
def study_figure(dataset: xr.Dataset) -> Figure:
    """Error against run time of a study's cases, and the front of those that no other beats.

    Each problem, a scene with one soil, has a front of its own: another is not easier or harder to
    compute, but another. An error is no less than the half width that the case states. A case that
    states none, among others that do, is on no front: its error may be small by luck. A case that
    did not complete has no error: it stands on the upper edge, at the time it took.
    """
    name = error_name(dataset)
    assert name is not None, "the dataset has no errors"
    measured, errors = over_cases(dataset, name).astype(float), credited_error(dataset)
    seconds = over_cases(dataset, "run_time").astype(float)
    timed = np.isfinite(measured) & np.isfinite(seconds)
    sound = timed & (errors > 0.0)
    silent = timed & (measured > 0.0) & ~states_its_error(dataset)
    problems = problems_of(dataset)
    names = problem_names(problems)
    figure, axes = empty_figure()
    axes.set_xscale("log")
    axes.set_yscale("log")
    budget = MOST_LABELS
    for rank, (problem, its_name) in enumerate(zip(problems, names, strict=True)):
        own = problem.cases[sound[problem.cases]]
        front = _pareto(seconds, errors, own)
        beaten = np.setdiff1d(own, front)
        if beaten.size:
            label = once(axes, "beaten by another")
            axes.plot(seconds[beaten], errors[beaten], "o", color="0.6", ms=3.5, label=label)
        colour, marker = series_colour(rank, len(problems)), MARKERS[rank % len(MARKERS)]
        shown_name = its_name if len(problems) <= MOST_LABELS else ""
        label = shown_name or once(axes, FRONT)
        axes.plot(seconds[front], errors[front], f"{marker}-", color=colour, label=label, zorder=3)
        apart = _apart(front, errors, np.ptp(np.log(errors[sound])))
        share = min(len(apart), budget // (len(problems) - rank))
        budget -= share
        for case in apart[chosen(len(apart), share)]:
            place = (float(seconds[case]), float(errors[case]))
            text = setting_of(dataset, problem, int(case))
            axes.annotate(
                text,
                place,
                xytext=(4, 4),
                textcoords="offset points",
                size=6,
                bbox={"fc": "white", "ec": "none", "pad": 0.5, "alpha": 0.8},
            )
    if silent.any():
        place = seconds[silent], measured[silent]
        axes.plot(*place, "o", mfc="none", color="0.6", ms=3.5, label=NOT_STATED)
    floor = over_cases(dataset, FLOOR).astype(float)
    if np.isfinite(floor).any() and np.nanmax(floor) < 1.1 * np.nanmin(floor):
        label = "uncertainty of the reference"
        axes.axhline(np.nanmax(floor), ls=":", lw=1.2, color=INK, label=label)
    failed = over_cases(dataset, "status") != COMPLETED
    if "case_time" in dataset and failed.any():
        axes.plot(
            over_cases(dataset, "case_time")[failed],
            np.ones(failed.sum()),
            "x",
            color=FAILED,
            transform=axes.get_xaxis_transform(),
            clip_on=False,
            label="not completed",
        )
    several = len(set(scenes_of(dataset))) > 1
    _dress(figure, axes, name if several else dataset[name].attrs.get("long_name", name))
    key = settings_key(dataset, problems)
    remark = "Run times of cases side by side are not to be compared."
    if np.isfinite(uncertainty_of(dataset)).any():
        remark = f"{OF_HALF_WIDTH} {remark}"
    write_caption(figure, dataset, key, remark)
    return figure


def _apart(front: np.ndarray, errors: Floats, log_range: float) -> np.ndarray:
    """The points of a front whose labels do not meet, the best among them."""
    kept: list[int] = []
    for case in front[::-1]:
        if not kept or np.log(errors[case] / errors[kept[-1]]) > LABEL_GAP * log_range:
            kept.append(int(case))
    return np.array(kept[::-1], dtype=int)


def _dress(figure: Figure, axes: Axes, meaning: str) -> None:
    axes.set_xlabel("run time [s]")
    axes.set_ylabel(f"{plain(meaning)} [-]")
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        # Over less than two decades there would be a tick or none, over less than one two or three.
        digits = (1, 2, 3, 4, 5, 6, 8) if high < 10.0 * low else (1, 2, 5)
        axis.set_major_locator(LogLocator(subs=digits if high < 100.0 * low else (1,)))
        axis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axis.set_minor_formatter(NullFormatter())
    legend_above(figure, axes)


def _pareto(seconds: Floats, errors: Floats, cases: np.ndarray) -> np.ndarray:
    """The cases that no other is both faster and better than, the fastest first."""
    ordered = cases[np.lexsort((errors[cases], seconds[cases]))]
    best = np.minimum.accumulate(errors[ordered]) if ordered.size else errors[ordered]
    before = np.concatenate([[np.inf], best[:-1]])
    front: np.ndarray = ordered[errors[ordered] < before[: ordered.size]]
    return front
