"""The picture `stability` and its table: where cases complete, with what margin, what fails.

Each parameter has a row of bars: shares of cases by how they ended at a value, or in a part of the
range of random cases. Beside it stands the distance from the default to the first failures.
"""

import re
import textwrap
from collections.abc import Sequence
from statistics import mode
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive import conventions
from harness.archive.conventions import COMPLETED, MISSING, over_cases
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import once
from harness.pictures.drawing.quantities import Floats, Texts, Values
from harness.pictures.drawing.rows import labelled_rows
from harness.pictures.drawing.style import INK, PAGE, STATUSES, STYLED
from harness.pictures.studied import changing
from harness.study.designs import ONE_AT_A_TIME
from harness.study.study import STABILITY_MAP

PART_COUNT = 5
"""Intervals with equally many cases into which the range of a random parameter is divided."""
ROW_HEIGHT, BAR, BOTTOM = 0.7, 0.6, 0.15
"""Height of the row of a parameter [inch]; over it height of a full bar, and its lower end."""
EXPLAINED = "Bars: shares of cases that ended so, at a value or in parts of equally many cases."


def short_reason(message: str) -> str:
    """The cause in a message, without the name of the exception, places, times and remedy."""
    text = re.sub(r" (at|is) \[[^]]*\]( m)?", "", re.sub(r"^\w+: ", "", message))
    return re.split(r", at |, more than |; |: ", text)[0]


class Part(NamedTuple):
    """How the cases ended in a part of a parameter's range: at a value, or between two."""

    text: str  # the values in words
    number: float  # the least of them
    status: Texts  # of each case
    message: Texts  # why it failed; "" if it completed
    limits: Floats  # greatest ratios of results to their limits, of the cases that have one

    def share(self, status: str = COMPLETED) -> float:
        """Share of the cases that ended so."""
        return float(np.mean(self.status == status))

    @property
    def cause(self) -> str:
        """How most failures ended, and the reason of the first of these."""
        status = mode(self.status[self.status != COMPLETED].tolist())
        message = self.message[self.status == status][0]
        return ": ".join(filter(None, (status, short_reason(message))))


class Strip(NamedTuple):
    """The parts of a parameter's range, ascending."""

    values: Values
    parts: Sequence[Part]
    default: float | None  # one at a time: the value from which the study starts

    def margin(self, side: int) -> str:
        """The distance from the default to the first failure below (-1) or above (1), and why."""
        assert self.default is not None
        beyond = [it for it in self.parts[::side] if side * (it.number - self.default) >= 0.0]
        failed = next((it for it in beyond if it.share() < 1.0), None)
        if failed is None:
            way = f" {'up' if side > 0 else 'down'} to {beyond[-1].text}"
            known = "none failed" + ("" if self.values.categories else way)
            return known if len(beyond) > 1 else "no case"
        if failed.number == self.default:
            return f"the default itself, {failed.cause}"
        is_ratio = not self.values.categories and min(failed.number, self.default) > 0.0
        factor = f" (factor {(failed.number / self.default) ** side:.3g})" if is_ratio else ""
        return f"{failed.text}{factor}, {failed.cause}"

    @property
    def fails(self) -> list[str]:
        """What fails: nearest to the default on either side, or in the part with most failures."""
        if self.default is not None:
            if self.values.categories:  # a text is neither below nor above the default
                return [self.margin(1)]
            return [f"below: {self.margin(-1)}", f"above: {self.margin(1)}"]
        worst = min(self.parts, key=Part.share)
        if worst.share() == 1.0:
            return [f"all {sum(part.status.size for part in self.parts)} complete"]
        return [f"{worst.share():.0%} complete at {worst.text}: {worst.cause}"]

    def words(self) -> tuple[str, ...]:
        """The row of the table; the default is in brackets."""
        default = "" if self.default is None else f" ({self.values.text(self.default)})"
        completed = (f"{it.text}: {it.share():.0%} of {it.status.size}" for it in self.parts)
        limits = np.concatenate([part.limits for part in self.parts])
        limit = f"up to {limits.max():.0%} of the limit" if limits.size else ""
        return self.values.label + default, ", ".join(completed), "; ".join(self.fails), limit

    def draw(self, axes: Axes, row: int) -> None:
        """Draw a bar for each part, coloured by how its cases ended; the default is framed."""
        bottom, wide = row + BOTTOM, 0.95 / len(self.parts)
        for place, part in enumerate(self.parts):
            middle, base = (place + 0.5) / len(self.parts), bottom
            for status in sorted(set(part.status), key=lambda it: [*STATUSES, it].index(it)):
                colour, hatch = STATUSES.get(status, (INK, ""))
                label = once(axes, status)
                height = -BAR * part.share(status)  # rows are counted downward
                axes.bar(middle, height, wide, base, fc=colour, hatch=hatch, label=label, gid=row)
                base += height
            if part.number == self.default:
                label = once(axes, "default")
                axes.bar(middle, -BAR, wide, bottom, fill=False, ec=INK, label=label)
            if part.limits.size:
                ends = middle - 0.5 * wide, middle + 0.5 * wide
                axes.hlines(bottom - BAR * np.median(part.limits), *ends, color=INK)
            text = part.text.replace("_", " ").replace(" to ", "\nto ")
            axes.text(middle, bottom + 0.04, text, ha="center", va="top")
        notes = "\n".join(textwrap.fill(line, 44, max_lines=2) for line in self.fails)
        axes.text(1.02, row, notes, va="center")


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a result has a stability map: the study asked for one, and cases were run."""
    ran = set(dataset["status"].values.flat) - {MISSING}
    return bool(dataset.attrs.get(STABILITY_MAP) and ran and conventions.freely_varied(dataset))


def stability_rows(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """The map in words: a heading, then a row for each parameter."""
    heading = "parameter", "completed", "what fails", "limit"
    return [heading, *(strip.words() for strip in _strips(dataset))]


def _strips(dataset: xr.Dataset) -> list[Strip]:
    """A strip for each varied parameter, from the cases that were run.

    One at a time a strip has the first case and those that change the parameter, in the order of
    the study. At random it has all cases; parameters over which shares differ most come first.
    """
    ran = over_cases(dataset, "status") != MISSING
    names = conventions.freely_varied(dataset)
    order = [*str(dataset.attrs[STABILITY_MAP]).split(), *names]
    varied = [Values.of(dataset, name) for name in sorted(names, key=order.index)]
    are_random = dataset.attrs["design"] != ONE_AT_A_TIME
    is_first = np.arange(ran.size) == 0
    owns = [ran] * len(varied) if are_random else changing(dataset, varied)
    strips = [
        Strip(
            values,
            _parts(dataset, values, ran & (own | is_first), are_random=are_random),
            None if are_random else float(values.numbers[0]),
        )
        for values, own in zip(varied, owns, strict=True)
    ]
    if are_random:
        strips.sort(key=lambda it: np.ptp([*map(Part.share, it.parts)]), reverse=True)
    return strips


def _parts(
    dataset: xr.Dataset, values: Values, cases: np.ndarray, *, are_random: bool
) -> list[Part]:
    """Parts of single values, or of about equally many cases where many are random."""
    numbers = values.numbers[cases]
    edges = np.unique(numbers)
    if are_random and not values.categories and edges.size > PART_COUNT:
        edges = np.unique(np.quantile(numbers, np.linspace(0.0, 1.0, PART_COUNT + 1)))[1:-1]
    limits = conventions.limits_of(dataset).items()
    ratios = [np.abs(over_cases(dataset, name)) / limit for name, limit in limits]
    ratio = np.fmax.reduce([np.full(cases.shape, np.nan), *ratios])
    part, found = np.searchsorted(edges, numbers), []
    for members in (np.flatnonzero(cases)[part == place] for place in np.unique(part)):
        low, high = values.numbers[members].min(), values.numbers[members].max()
        ends = (low,) if low == high else (float(f"{low:.3g}"), float(f"{high:.3g}"))
        status, message = (over_cases(dataset, it)[members] for it in ("status", "message"))
        text, known = " to ".join(map(values.text, ends)), members[np.isfinite(ratio[members])]
        found.append(Part(text, low, status.astype(str), message.astype(str), ratio[known]))
    return found


@STYLED
def stability_figure(dataset: xr.Dataset) -> Figure | None:
    """The picture, with a strip for each parameter."""
    if not shows_stability(dataset):
        return None
    strips = _strips(dataset)
    figure, axes = labelled_rows([strip.words()[0] for strip in strips], ROW_HEIGHT)
    figure.set_figwidth(PAGE)
    for row, strip in enumerate(strips):
        strip.draw(axes, row)
    axes.set(xlim=(0.0, 1.0), xticks=[])
    axes.spines[["left", "bottom"]].set_visible(False)
    if any(part.limits.size for strip in strips for part in strip.parts):
        limits = conventions.limits_of(dataset).items()
        names = (f"{conventions.spoken(it)} over its limit of {size:g}" for it, size in limits)
        axes.plot([], [], color=INK, label=f"{' or '.join(names)}, median")
    return captioned(figure, dataset, EXPLAINED, legend=axes)
