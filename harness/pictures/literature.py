"""The literature and experience in a picture of cone factors: curves, and bands."""

import itertools
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from harness.archive.conventions import Role, over_cases, parameter_of, with_role
from harness.compare.compared import (
    NothingToCompareError,
    conditions_of,
    stored_experience,
    stored_references,
)
from harness.pictures.drawing.plot_parts import CurveEnd, once
from harness.pictures.drawing.quantities import Floats, Values, plain
from harness.pictures.studied import Studied
from harness.references.cone_factors import (
    CONE_FACTORS,
    Conditions,
    ConeFactor,
    Quantity,
    envelope,
    envelope_applies,
)
from harness.references.experience import Factor
from harness.study.compared import OwnReference

HATCHES = ("///", "\\\\\\", "...", "---")
"""Hatches of bands, one after the other: a reader can tell them apart where they overlap."""
HATCH_COLOUR = "#8C8C8C"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#666666")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; one for each reference."""
ENVELOPE_LABEL = "envelope of the literature (no confidence interval)"
FINE = 400
"""Points of a literature curve."""


def draw_experience(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the bands of cone factors that a result is set beside.

    They span the whole width, since the field has no value along the axis, and stand in the legend
    with their bounds.
    """
    entries = [entry for entry in stored_experience(dataset) if entry.factor is Factor.RESISTANCE]
    for entry, hatch in zip(entries, itertools.cycle(HATCHES), strict=False):
        axes.axhspan(
            *entry.bounds,
            facecolor="none",
            edgecolor=HATCH_COLOUR,
            hatch=hatch,
            linewidth=0,
            alpha=0.5,
            zorder=0.5,
            label=plain(
                f"experience, {entry.label}: {entry.band}, su {entry.strength.partition(',')[0]}"
            ),
        )


def draw_literature(
    axes: Axes, studied: Studied, along: Values, cases: np.ndarray, colour: str | None
) -> list[CurveEnd]:
    """Draw the envelope and the references of a series of cases over one of its parameters.

    A curve is solid where its reference applies and dashed outside. Of one of several series in a
    colour the envelope alone is drawn, in that colour.

    Returns:
        The ends of the references' curves, with their names.
    """
    x, conditions = _over(studied, along, cases)

    def over(value: Quantity) -> np.ndarray:
        return np.broadcast_to(np.asarray(value), x.shape)

    lower, upper = (over(bound) for bound in envelope(conditions))
    inside = over(envelope_applies(conditions))
    if inside.any():
        own = colour or "0.6"
        band = axes.fill_between(x, lower, upper, inside, color=own, alpha=0.2, lw=0)
        band.set_label(once(axes, ENVELOPE_LABEL))
        # A band has no width where the references hold for one value alone, as of the apex angle.
        beside = np.pad(inside, 1)
        alone = inside & ~beside[:-2] & ~beside[2:]
        if alone.any():
            axes.vlines(x[alone], lower[alone], upper[alone], color=own, alpha=0.4, lw=5)
    ends = []
    references = stored_references(studied.dataset) if colour is None else ()
    for reference, own in zip(references, _colours(references), strict=True):
        value, applies = over(reference.evaluate(conditions)), over(reference.applies(conditions))
        axes.plot(x, np.where(applies, value, np.nan), color=own)
        known = np.flatnonzero(np.isfinite(value))
        if known.size == 0:  # a reference of the study's own has no value outside its range
            continue
        if not applies[known].all():
            label = once(axes, "outside its validity")
            axes.plot(x, value, color=own, lw=0.9, ls=(0, (4, 3)), alpha=0.7, label=label)
        ends.append(CurveEnd(x[known[-1]], value[known[-1]], plain(reference.label), own))
    return ends


def _over(studied: Studied, along: Values, cases: np.ndarray) -> tuple[Floats, Conditions]:
    """Places along an axis, from its first value to its last, and the conditions there."""
    name, dataset = along.name, studied.dataset
    # What the scene derives from a varied parameter goes along with it: it is left to be derived.
    follows = [
        parameter
        for parameter in with_role(dataset, Role.PARAMETER)
        if parameter in dataset.data_vars and dataset[parameter].ndim
    ]
    one = studied.case(int(cases[0])).drop_vars([*follows, name])
    if along.categories:
        # A text says nothing to the literature: its values stand side by side.
        x, attributes = np.linspace(-0.5, len(along.categories) - 0.5, FINE), {}
    else:
        x, attributes = _fine(along), dataset[name].attrs
    one = one.assign_coords({name: xr.Variable(name, x, attributes)})
    if "rigidity_index" not in one:  # a law has its own, which changes along the axis
        place = np.log if along.scale == "log" else np.asarray
        index = np.log(over_cases(dataset, "rigidity_index")[cases])
        between = np.interp(place(x), place(along.numbers[cases]), index)
        one = one.assign_coords(rigidity_index=(name, np.exp(between)))
    return x, conditions_of(one)


def _fine(values: Values) -> Floats:
    """Where the literature's curves are drawn: from the first value to the last."""
    low, high = values.different[[0, -1]].tolist()
    if low == high:
        low, high = (0.0, 1.0) if 0 <= low <= 1 else (low / 2, low * 2)
    space = np.geomspace if values.scale == "log" else np.linspace
    return np.union1d(space(low, high, FINE), values.different)


def _colours(references: Sequence[ConeFactor]) -> list[str]:
    """Those that ship have the same colour in all pictures; a study's own have what is left."""
    shipped = {
        reference.id: COLOURS[place % len(COLOURS)] for place, reference in enumerate(CONE_FACTORS)
    }
    taken = {shipped.get(reference.id) for reference in references}
    left = itertools.cycle([colour for colour in COLOURS if colour not in taken] or COLOURS)
    return [shipped.get(reference.id) or next(left) for reference in references]


def depends_on(dataset: xr.Dataset, name: str) -> bool:
    """Whether the references, the literature's or the study's own, depend on a parameter."""
    try:
        conditions = vars(conditions_of(dataset))
    except NothingToCompareError:
        return False
    if any(parameter_of(name) in reference.names for reference in _own(dataset)):
        return True
    column = over_cases(dataset, name)
    quantities = [condition for key, condition in conditions.items() if key != "parameters"]
    return any(np.array_equal(over_cases(dataset, quantity), column) for quantity in quantities)


def _own(dataset: xr.Dataset) -> list[OwnReference]:
    return [it for it in stored_references(dataset) if isinstance(it, OwnReference)]


def ranges_of_own(dataset: xr.Dataset) -> str:
    """Where the curves of the study's own references are drawn, in sentences."""
    return " ".join(
        plain(f"{reference.label} is drawn within its range: {reference.validity}.")
        for reference in _own(dataset)
        if reference.ranges
    )
