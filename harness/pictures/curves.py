"""The pictures of curves that a result declares: a line per case, in the panels that it names.

Up to eight cases have a colour and a label each. Of more, if two parameters with few values are
combined, colour shows one and dashes the other; else colour shows the varied number that the ends
of the curves follow most, or the scene if there are several. In a one-at-a-time study the first
case and those that differ most from it have a colour and a label.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from matplotlib.figure import Figure

from harness.archive.conventions import (
    is_there,
    over_cases,
    scenes_of,
    uncertainty_of,
    varied_within,
)
from harness.pictures.declared import HALF_WIDTH, Curve, Picture, picture_of, pieces_of
from harness.pictures.drawing.caption import captioned, of_half_widths
from harness.pictures.drawing.plot_parts import MOST_LABELS, CurveEnd, label_ends, panels, series
from harness.pictures.drawing.quantities import (
    SYMLOG_SHARE,
    Floats,
    Values,
    assigned,
    axis_label,
    in_words,
    named,
    wrapped,
)
from harness.pictures.drawing.style import DASHES, GREY, INK, SHADES, STYLED, THIN, shade
from harness.pictures.studied import Studied

JOINED = "Pieces run side by side are joined; where two overlap the curve is their mean."
BESIDE = 96
"""Number of letters of the labels of panels beside each other, all together."""
STYLES = dict(zip(("solid", "dashed", "dash-dotted", "dotted"), DASHES, strict=True))
"""Dashes of several curves in one panel, by their names in the caption."""
FURTHEST = 5
"""Number of cases of a one-at-a-time study that have a label beside the first."""


@dataclass(frozen=True)
class _Lines:
    """The colours of the cases that are drawn, in order, and the labels of some of them."""

    colours: Mapping[int, str]
    labels: Mapping[int, str]
    along: Values | None = None  # the parameter that the colours show
    of_scenes: bool = False  # whether labels are of scenes
    dashes: Mapping[int, str] = field(default_factory=dict)  # of cases whose line is not solid
    key: Mapping[str, dict[str, Any]] = field(default_factory=dict)  # looks of values, by label

    def marker(self, line: int) -> str:
        """The marker of a case, by its rank."""
        return dict(series(self.colours, None))[line].marker


@STYLED
def curves_figure(dataset: xr.Dataset, names: Sequence[str]) -> Figure | None:
    """The picture of the curves with these names; None if no case has a value."""
    picture = picture_of(dataset, names)
    ends = picture.curves[0].ends
    if not ends:
        return None
    lines = _lines(dataset, picture, ends)
    is_by_depth = all(curve.place.downward for curve in picture.curves)
    count = len(picture.panels)
    figure, all_axes = panels(count, by_depth=is_by_depth, sharey=is_by_depth)
    if lines.along is not None:
        _scale_above(figure, all_axes, dataset, lines.along)
    told = []
    for axes, curves in zip(all_axes, picture.panels, strict=True):
        styles = iter(STYLES)
        for curve in curves:
            style = "marks" if curve.place.as_marks else next(styles)
            told += _draw(axes, curve, lines, style, is_named=len(curves) > 1)
        _dress(axes, curves, BESIDE // count)
        if is_by_depth and axes is not all_axes[0]:
            axes.set_ylabel("")
        told += _draw_slope(axes, dataset, picture.cases[[*ends]], curves[0].place.slope)
    legend = _label(all_axes[0], picture, ends, lines)
    failed = picture.cases.size - len(ends)
    return captioned(
        figure,
        dataset,
        f"{len(ends)} cases." if len(ends) > MOST_LABELS else "",
        *told,
        *dict.fromkeys(curve.described for curve in picture.curves),
        _error(dataset, names),
        JOINED if pieces_of(dataset) else "",
        f"{failed} of {picture.cases.size} cases have no curve." if failed else "",
        legend=legend,
    )


def _error(dataset: xr.Dataset, names: Sequence[str]) -> str:
    """Sentences on half widths that are drawn, or on why nothing in the result has one."""
    if any(name.endswith(HALF_WIDTH) for name in names):
        return of_half_widths(dataset, "Half widths hold the value", are_shown=True)
    none = not np.isfinite(uncertainty_of(dataset).astype(float)).any()
    return of_half_widths(dataset, "", are_shown=False) if none else ""


def _lines(dataset: xr.Dataset, picture: Picture, ends: Mapping[int, float]) -> _Lines:
    """How the cases that have a curve are drawn, by the last values of their curves."""
    of_cases = {line: int(picture.cases[line]) for line in ends}
    scenes, studied = scenes_of(dataset), Studied.of(dataset)
    kinds = list(dict.fromkeys(scenes[case] for case in of_cases.values()))
    names = [it for it in (studied.varied if studied else ()) if it not in pieces_of(dataset)]

    def label(line: int) -> str:
        if len(kinds) > 1:
            return _with_scene(dataset, of_cases[line])
        return studied.label(of_cases[line], names) if studied and names else ""

    if len(ends) <= MOST_LABELS:
        looks = dict(series(ends))
        return _Lines(
            {line: look.colour for line, look in looks.items()},
            {line: label(line) for line in ends},
            of_scenes=len(kinds) > 1,
            dashes={line: look.dashes for line, look in looks.items()},
        )
    if len(kinds) > 1:
        first = {scenes[case]: line for line, case in reversed(of_cases.items())}
        of_kinds = dict(series(kinds, None))
        colours = {line: of_kinds[scenes[case]].colour for line, case in of_cases.items()}
        return _Lines(colours, {first[kind]: in_words(kind) for kind in kinds}, of_scenes=True)
    if studied is not None and studied.is_one_at_a_time:
        told_apart = _furthest(ends)
        colours = dict.fromkeys(ends, GREY)
        colours |= {line: look.colour for line, look in series(told_apart)}
        return _Lines(colours, {line: label(line) for line in told_apart})
    if studied is not None and all(len(panel) == 1 for panel in picture.panels):
        varied = [studied.varied[name] for name in names]
        if studied.is_combined and (lines := _by_colour_and_dashes(dataset, of_cases, varied)):
            return lines
    along = _followed(studied, of_cases, ends)
    if along is None:
        return _Lines(dict.fromkeys(ends, GREY), {})
    norm = _norm(along)
    numbers = {line: along.numbers[case] for line, case in of_cases.items()}
    return _Lines({it: shade(float(norm(number))) for it, number in numbers.items()}, {}, along)


def _by_colour_and_dashes(
    dataset: xr.Dataset, of_cases: Mapping[int, int], varied: Sequence[Values]
) -> _Lines | None:
    """Lines whose colour shows one of two parameters, and whose dashes the other with fewer values.

    None if not two vary, or if colours or dashes do not suffice.
    """
    sizes = [it.different.size for it in varied]
    if len(sizes) != 2 or min(sizes) > len(DASHES) or max(sizes) > MOST_LABELS:
        return None
    by_dashes, by_colour = sorted(varied, key=lambda it: it.different.size)
    colours = {it: {"color": line.colour} for it, line in series(by_colour.different.tolist())}
    dashes = {it: {"color": INK, "ls": line.dashes} for it, line in series(by_dashes.different)}
    key = {
        assigned(dataset, shown.name, shown.value(value)): look
        for shown, looks in ((by_colour, colours), (by_dashes, dashes))
        for value, look in looks.items()
    }
    return _Lines(
        {line: colours[by_colour.numbers[case]]["color"] for line, case in of_cases.items()},
        {},
        dashes={line: dashes[by_dashes.numbers[case]]["ls"] for line, case in of_cases.items()},
        key=key,
    )


def _with_scene(dataset: xr.Dataset, case: int) -> str:
    """The label of a case in a study of several scenes: scene and varied values."""
    values = {name: over_cases(dataset, name)[case] for name in varied_within(dataset)}
    own = [assigned(dataset, name, value) for name, value in values.items() if is_there(value)]
    return ", ".join([in_words(scenes_of(dataset)[case]), *own])


def _furthest(ends: Mapping[int, float]) -> list[int]:
    """The first line, if it is drawn, and those whose ends are furthest from its own."""
    if 0 not in ends:
        return []
    others = sorted(ends, key=lambda line: abs(ends[line] - ends[0]), reverse=True)
    return [0, *[line for line in others if line != 0][:FURTHEST]]


def _followed(
    studied: Studied | None, of_cases: Mapping[int, int], ends: Mapping[int, float]
) -> Values | None:
    """The varied number that the ends of curves follow most, or a text if no number varies."""
    from scipy.stats import spearmanr

    if studied is None:
        return None
    cases, last = [*of_cases.values()], [*ends.values()]
    varied = [studied.varied[name] for name in studied.numbers or studied.varied]
    found = [values for values in varied if np.ptp(values.numbers[cases]) > 0.0]
    return max(
        found,
        key=lambda values: abs(spearmanr(values.numbers[cases], last).statistic),
        default=None,
    )


def _norm(along: Values) -> Normalize:
    """Colours are spaced as on the axis of the parameter."""
    low, high = along.different[[0, -1]]
    if along.scale == "symlog":
        return SymLogNorm(along.different[1], SYMLOG_SHARE, low, high)
    return (LogNorm if along.scale == "log" else Normalize)(low, high)


def _scale_above(
    figure: Figure, all_axes: Sequence[Axes], dataset: xr.Dataset, along: Values
) -> None:
    """A scale of colours for a parameter, above the panels."""
    scale = ScalarMappable(_norm(along), SHADES)
    bar = figure.colorbar(scale, ax=all_axes, location="top", aspect=50, pad=0.02)
    along.dress(bar.ax, room=10)
    bar.ax.set_xlim(*along.different[[0, -1]])
    bar.set_label(axis_label(dataset, along.name))


def _draw(axes: Axes, curve: Curve, lines: _Lines, style: str, *, is_named: bool) -> list[str]:
    """Draw a curve of all cases, or of one if it has several lines; sentences on what it is."""

    def line(x: Floats, y: Floats, **own: Any) -> None:
        axes.plot(*((y, x) if curve.place.downward else (x, y)), **own)

    if curve.along:
        case = curve.changes_most
        rows = curve.lines(case)
        looks = reversed([look for _, look in series(range(max(2, len(rows))), None)])
        for values, look in zip(rows, looks, strict=False):  # the last one is dark
            line(curve.x[case], values, color=look.colour)
        whose = f" of {label}" if (label := lines.labels.get(case, "")) else ""
        return [f"Lines{whose} by {curve.along}, from light to dark."]
    for case, colour in lines.colours.items():
        own = np.isfinite(curve.x[case])
        x, values = curve.x[case][own], curve.values[case][own]
        if curve.place.as_marks:
            line(x, values, color=colour, ls="", marker=lines.marker(case), clip_on=False)
        else:
            width = None if case in lines.labels or lines.key else THIN
            dashes = STYLES[style] if is_named else lines.dashes.get(case, "-")
            line(x, values, color=colour, ls=dashes, lw=width)
    return [f"{style.capitalize()}: {curve.name}."] if is_named else []


def _dress(axes: Axes, curves: Sequence[Curve], letters: int) -> None:
    """Labels and limits: an axis begins at 0 if nothing on it is negative."""
    first = curves[0]
    of_values, of_other = ("x", "y") if first.place.downward else ("y", "x")
    labels = {of_values: first.label, of_other: first.over}
    axes.set(xlabel=wrapped(labels["x"], letters), ylabel=labels["y"])
    if not any((curve.values < 0.0).any() for curve in curves):
        axes.set(**{f"{of_values}lim": (0.0, None)})
    if first.place.downward:
        axes.yaxis.set_inverted(True)
    elif not any((curve.x < 0.0).any() for curve in curves):
        end = None if first.place.over else max(float(np.nanmax(it.x)) for it in curves)
        axes.set_xlim(0.0, _rest(first) if first.place.to_rest else end)


def _rest(curve: Curve) -> float:
    """Twice the place from which all lines are within 1 % of their last values, or the end."""
    end, reached = float(np.nanmax(curve.x)), 0.0
    for case, last in curve.ends.items():
        far = curve.x[case][np.abs(curve.values[case] - last) > 0.01 * abs(last)]
        reached = max(reached, float(np.nanmax(far, initial=0.0)))
    return min(end, 2.0 * reached) or end


def _draw_slope(axes: Axes, dataset: xr.Dataset, cases: np.ndarray, slope: str) -> list[str]:
    """Draw dashed lines from the origin whose slopes are a parameter's values in some cases."""
    if slope not in dataset:
        return []
    values = over_cases(dataset, slope)[cases].astype(float)
    high = axes.get_xlim()[1]
    for value in np.unique(values[np.isfinite(values)]):
        axes.plot([0.0, high], [0.0, value * high], ls="--", color=GREY, scaley=False)
    axes.set_xlim(0.0, high)
    return [f"Dashed: {named(dataset, slope)}."]


def _label(axes: Axes, picture: Picture, ends: Mapping[int, float], lines: _Lines) -> Axes | None:
    """Label the lines of a single panel at their ends, else in a legend; the axes that have it."""
    told = {case: label for case, label in lines.labels.items() if label}
    at_ends = not (lines.of_scenes or lines.key or picture.curves[0].place.downward)
    if len(picture.panels) == 1 and at_ends:
        x = picture.curves[0].x
        label_ends(
            axes,
            [
                CurveEnd(np.nanmax(x[case]), ends[case], label, lines.colours[case])
                for case, label in told.items()
            ],
        )
        return None
    marks = any(curve.place.as_marks for curve in picture.curves)
    for case, label in told.items():
        dashes = lines.dashes.get(case, "-")
        marker, ls = (lines.marker(case), "") if marks else ("", dashes)
        axes.plot([], [], color=lines.colours[case], label=label, marker=marker, ls=ls)
    for label, look in lines.key.items():
        axes.plot([], [], label=label, **look)
    return axes
