"""The literature and experience in a picture of cone factors: curves, and bands."""

import itertools
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from harness.compare.compared import conditions_of, stored_experience, stored_references
from harness.pictures.drawing.plot_parts import CurveEnd, once
from harness.pictures.drawing.quantities import Floats, plain
from harness.references.cone_factors import (
    CONE_FACTORS,
    ConeFactor,
    Quantity,
    envelope,
    envelope_applies,
)
from harness.references.experience import Factor
from harness.study.compared import OwnReference

HATCHES = ("///", "\\\\\\", "...", "---")
"""Hatches of bands, one after the other: a reader can tell them apart where they overlap."""
COLOUR = "#8C8C8C"


def draw_experience(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the bands of cone factors that a result is set beside.

    They span the whole width, since the field has no value along the axis, and stand in the legend
    with their bounds.
    """
    entries = [entry for entry in stored_experience(dataset) if entry.factor is Factor.RESISTANCE]
    for rank, entry in enumerate(entries):
        axes.axhspan(
            *entry.bounds,
            facecolor="none",
            edgecolor=COLOUR,
            hatch=HATCHES[rank % len(HATCHES)],
            linewidth=0,
            alpha=0.5,
            zorder=0.5,
            label=f"experience, {entry.label}: {entry.band}, su {entry.strength.partition(',')[0]}",
        )


COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#666666")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; one for each reference."""
ENVELOPE_LABEL = "envelope of the literature (no confidence interval)"


def draw_literature(
    axes: Axes,
    one: xr.Dataset,
    name: str,
    along: Floats,
    colour: str | None = None,
    index: Floats | None = None,
) -> list[CurveEnd]:
    """Draw the envelope and the references of a case over values of one of its parameters.

    `index` is the rigidity index at these values, where it changes along with that parameter.

    A curve is solid where its reference applies and dashed outside. Of a case that is one of a
    series in a colour the envelope alone is drawn, in that colour.

    Returns:
        The ends of the references' curves, with their names.
    """
    values = xr.Variable(name, along, one[name].attrs)
    changed = {} if index is None else {"rigidity_index": (name, index)}
    conditions = conditions_of(one.drop_vars(name).assign_coords({name: values} | changed))

    def over(value: Quantity) -> np.ndarray:
        return np.broadcast_to(np.asarray(value), along.shape)

    lower, upper = (over(bound) for bound in envelope(conditions))
    inside = over(envelope_applies(conditions))
    if inside.any():
        own = colour or "0.6"
        band = axes.fill_between(along, lower, upper, inside, color=own, alpha=0.2, lw=0)
        band.set_label(once(axes, ENVELOPE_LABEL))
        # A band has no width where the references hold for one value alone, as of the apex angle.
        beside = np.pad(inside, 1)
        alone = inside & ~beside[:-2] & ~beside[2:]
        if alone.any():
            axes.vlines(along[alone], lower[alone], upper[alone], color=own, alpha=0.4, lw=5)
    ends = []
    references = stored_references(one) if colour is None else ()
    for reference, own in zip(references, _colours(references), strict=True):
        value, applies = over(reference.evaluate(conditions)), over(reference.applies(conditions))
        axes.plot(along, np.where(applies, value, np.nan), color=own)
        known = np.flatnonzero(np.isfinite(value))
        if known.size == 0:  # a reference of the study's own has no value outside its range
            continue
        if not applies[known].all():
            label = once(axes, "outside its validity")
            axes.plot(along, value, color=own, lw=0.9, ls=(0, (4, 3)), alpha=0.7, label=label)
        ends.append(CurveEnd(along[known[-1]], value[known[-1]], reference.label, own))
    return ends


def _colours(references: Sequence[ConeFactor]) -> list[str]:
    """Those that ship have the same colour in all pictures; a study's own have what is left."""
    shipped = {
        reference.id: COLOURS[place % len(COLOURS)] for place, reference in enumerate(CONE_FACTORS)
    }
    taken = {shipped.get(reference.id) for reference in references}
    left = itertools.cycle([colour for colour in COLOURS if colour not in taken] or COLOURS)
    return [shipped.get(reference.id) or next(left) for reference in references]


def ranges_of_own(dataset: xr.Dataset) -> str:
    """Where the curves of the study's own references are drawn, in sentences."""
    own = [
        reference
        for reference in stored_references(dataset)
        if isinstance(reference, OwnReference) and reference.ranges
    ]
    return " ".join(
        f"{plain(reference.label)} is drawn within its range: {reference.validity}."
        for reference in own
    )
