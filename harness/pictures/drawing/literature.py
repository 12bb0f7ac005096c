"""The literature's cone factors as curves, and the band between them, beside computed ones."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from harness.compare.cone_factors import conditions_of, stored_references
from harness.pictures.drawing.plot_parts import CurveEnd, once
from harness.pictures.drawing.values import Floats
from harness.references.cone_factors import (
    CONE_FACTORS,
    Quantity,
    envelope,
    envelope_applies,
)

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#666666")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; one for each reference."""
ENVELOPE_LABEL = "envelope of the literature (no confidence interval)"


def draw_literature(
    axes: Axes, one: xr.Dataset, name: str, along: Floats, colour: str | None = None
) -> list[CurveEnd]:
    """Draw the envelope and the references of a case, over one of its parameters.

    A curve is solid where its reference applies and dashed outside.

    Args:
        axes: where to.
        one: a case: its parameters, and the references that it was compared with.
        name: the parameter.
        along: its values.
        colour: of the series that the case is one of: the envelope alone is drawn, in this colour.

    Returns:
        The ends of the references' curves, with their names.
    """
    conditions = conditions_of(one.drop_vars(name).assign_coords({name: (name, along)}))

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
    for reference in stored_references(one) if colour is None else ():
        own = COLOURS[CONE_FACTORS.index(reference) % len(COLOURS)]
        value, applies = over(reference.evaluate(conditions)), over(reference.applies(conditions))
        axes.plot(along, np.where(applies, value, np.nan), color=own)
        if not applies.all():
            label = once(axes, "outside its validity")
            axes.plot(along, value, color=own, lw=0.9, ls=(0, (4, 3)), alpha=0.7, label=label)
        ends.append(CurveEnd(along[-1], value[-1], reference.label, own))
    return ends
