"""Cone factors as a table for a terminal, beside the literature's and those of exact statics."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from harness.archive.conventions import Role, over_cases, uncertainty_of
from harness.compare.cone_factors import (
    conditions_of,
    cone_factor_of,
    exact_shear,
    stored_references,
)
from harness.compare.experience import experience_notes
from harness.compare.text_table import (
    MISSING,
    Column,
    heading,
    number,
    parameter_columns,
    run_columns,
    table_lines,
    with_half_width,
)
from harness.references.cone_factors import ENVELOPE, ConeFactor, envelope, envelope_applies

RESOLUTION = "cells_per_radius"
"""The parameter that refines the mesh: its finest two values give the discretisation's share."""


def cone_factor_table(dataset: xr.Dataset) -> str:
    """A text table for a terminal: one row a case, and how to read it below.

    Raises:
        NothingToCompareError: the dataset has no cone factor, or not its parameters.
    """
    cone_factor_of(dataset)
    references = stored_references(dataset)
    columns = [
        *parameter_columns(dataset),
        *_cone_factor_columns(dataset),
        *(_reference_column(dataset, reference) for reference in references),
        _envelope_column(dataset),
        *run_columns(dataset),
    ]
    notes = [*_resolution_notes(dataset), *_notes(references), *experience_notes(dataset)]
    return "\n".join([*table_lines(columns), "", *notes])


def _cone_factor_columns(dataset: xr.Dataset) -> list[Column]:
    factors = zip(over_cases(dataset, "cone_factor"), uncertainty_of(dataset), strict=True)
    parts = [
        Column(("cone", "factor"), [with_half_width(value, half) for value, half in factors]),
        *(
            Column(heading, [number(value, "#.3g") for value in over_cases(dataset, name)])
            for name, heading in (
                ("cone_factor_simulated", ("as", "simulated")),
                ("cone_factor_normal", ("normal", "part")),
            )
            if name in dataset
        ),
    ]
    if "cone_factor_shear" not in dataset:
        return parts
    shear, exact = dataset["cone_factor_shear"], exact_shear(dataset)
    deviations = shear / exact.where(exact > 0) - 1
    statics = [
        _with_deviation(value, deviation, digits=3)
        for value, deviation in zip(
            over_cases(dataset, exact),
            over_cases(dataset, deviations),
            strict=True,
        )
    ]
    return [
        *parts,
        Column(("shear", "part"), [number(value, ".3f") for value in over_cases(dataset, shear)]),
        Column(("exact", "shear"), statics),
    ]


def _reference_column(dataset: xr.Dataset, reference: ConeFactor) -> Column:
    texts = [
        _bracketed(_with_deviation(value, deviation), inside)
        for value, deviation, inside in zip(
            over_cases(dataset, f"{Role.REFERENCE}_{reference.id}"),
            over_cases(dataset, f"{Role.DEVIATION}_{reference.id}"),
            over_cases(dataset, reference.applies(conditions_of(dataset))),
            strict=True,
        )
    ]
    return Column(heading(reference.id), texts)


def _envelope_column(dataset: xr.Dataset) -> Column:
    conditions = conditions_of(dataset)
    bounds = (over_cases(dataset, bound) for bound in envelope(conditions))
    inside = over_cases(dataset, envelope_applies(conditions))
    texts = [
        _bracketed(_place(value, lower, upper), applies)
        for value, lower, upper, applies in zip(
            over_cases(dataset, "cone_factor"), *bounds, inside, strict=True
        )
    ]
    return Column(("in the", "envelope"), texts)


def _resolution_notes(dataset: xr.Dataset) -> list[str]:
    computed = cone_factor_of(dataset)
    if RESOLUTION not in computed.dims or computed.sizes[RESOLUTION] < 2:
        return []
    finest = computed.sortby(RESOLUTION).isel({RESOLUTION: slice(-2, None)})
    coarse, fine = finest[RESOLUTION].values
    changes = (finest.isel({RESOLUTION: 1}) / finest.isel({RESOLUTION: 0}, drop=True) - 1).values
    texts = [f"{change:+z.2%}" if np.isfinite(change) else "failed" for change in changes.flat]
    return [f"finest two ({RESOLUTION} {coarse:g} to {fine:g}): cone factor {', '.join(texts)}"]


def _notes(references: Iterable[ConeFactor]) -> list[str]:
    shown = {reference.id: reference for reference in (*references, *ENVELOPE)}.values()
    members = ", ".join(reference.id for reference in ENVELOPE)
    return [
        "cone factor: +- half width of 95 %; without it nothing is known of the error",
        "computed: su is the strength in pure shear, for von_mises too (sqrt(J2) = su)",
        "exact shear: adhesion_factor / tan(apex_angle / 2) by statics; the shear part's deviation",
        f"envelope: least to greatest of {members}; it is no confidence interval",
        "literature: value, computed / literature - 1; [outside the validity of the reference]",
        *(f"  {it.id}: {it.source}; {it.criterion}; {it.validity}" for it in shown),
        f"how known: {'; '.join(dict.fromkeys(it.how_known for it in shown))}",
    ]


def _with_deviation(value: float, deviation: float, digits: int = 2) -> str:
    percent = f"{deviation:+z.1%}" if np.isfinite(deviation) else MISSING
    return f"{number(value, f'.{digits}f')} {percent:>6}"


def _bracketed(text: str, inside: bool) -> str:
    # A blank in the place of the bracket keeps the numbers of a column aligned.
    return f"{text} " if inside else f"[{text}]"


def _place(value: float, lower: float, upper: float) -> str:
    if not np.isfinite(value):
        return MISSING
    return "below" if value < lower else "above" if value > upper else "yes"
