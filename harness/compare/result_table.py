"""The result of a study as a table for a terminal: beside cone factors, or exact solutions."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    CASE,
    COMPLETED,
    HALF_WIDTH,
    Role,
    labels_of,
    limits_of,
    over_cases,
    reasons_of,
    scenes_of,
    spoken,
    stated,
    uncertainty_of,
    varied_names,
    with_role,
)
from harness.compare.compared import (
    NothingToCompareError,
    conditions_of,
    cone_factor_of,
    exact_shear,
    experience_notes,
    stored_references,
)
from harness.compare.finest_error import error_name
from harness.compare.ratios import change_notes, ratio_notes
from harness.references.cone_factors import (
    COMPARED,
    ENVELOPE,
    ConeFactor,
    envelope,
    envelope_applies,
)

MISSING = "-"
"""In the place of a number that there is not."""

MOST_CASES = 3
"""Cases that a note names at most."""


@dataclass(frozen=True)
class Column:
    """One column of a table: a heading of two lines and a text for each case."""

    heading: tuple[str, str]
    texts: list[str]

    @property
    def width(self) -> int:
        """Characters of its longest text."""
        return max(len(text) for text in (*self.heading, *self.texts))


def table_lines(columns: Sequence[Column]) -> list[str]:
    """The lines of a table: two of headings, a rule, and one for each case."""
    rows = [
        [column.heading[0] for column in columns],
        [column.heading[1] for column in columns],
        ["-" * column.width for column in columns],
        *zip(*(column.texts for column in columns), strict=True),
    ]
    return ["  ".join(_justified(row, columns)).rstrip() for row in rows]


def parameter_columns(dataset: xr.Dataset) -> list[Column]:
    """A column for each parameter that the study varies."""
    return [
        Column(heading(name), [_text(value) for value in over_cases(dataset, name)])
        for name in varied_names(dataset)
    ]


def run_columns(dataset: xr.Dataset) -> list[Column]:
    """Run time, where it is known, and status."""
    columns = []
    if "run_time" in dataset:
        seconds = over_cases(dataset, "run_time")
        columns.append(Column(("run time", "[s]"), [number(value, ".1f") for value in seconds]))
    status = over_cases(dataset, "status")
    return [*columns, Column(("", "status"), [_text(value) for value in status])]


def heading(name: str) -> tuple[str, str]:
    """A name on two lines, to keep its column narrow."""
    head, _, tail = name.rpartition("_")
    return head, tail


def number(value: float, form: str) -> str:
    """A number in a format, a dash where there is none."""
    return format(value, form) if np.isfinite(value) else MISSING


def half_width_column(dataset: xr.Dataset, name: str, heading: tuple[str, str]) -> Column:
    """A number with its half width, or why it has none; a dash where there is no number."""
    told = zip(over_cases(dataset, name), uncertainty_of(dataset), reasons_of(dataset), strict=True)
    texts = [stated(it, *known) if np.isfinite(it) else MISSING for it, *known in told]
    return Column(heading, texts)


def _text(value: object) -> str:
    return number(value, "g") if isinstance(value, float) else str(value)


def _justified(row: Sequence[str], columns: Sequence[Column]) -> list[str]:
    return [text.rjust(column.width) for text, column in zip(row, columns, strict=True)]


BY_MODE = {
    "cone_factor_by_compression": ("by su in", "compression"),
    "cone_factor_by_simple_shear": ("by su in", "simple shear"),
    "cone_factor_by_extension": ("by su in", "extension"),
    "cone_factor_by_average": ("by su,", "average"),
}
"""Cone factors by the test that su is from, and their headings."""
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
    notes = [
        *_resolution_notes(dataset),
        *reason_notes(dataset),
        *_notes(dataset, references),
        *experience_notes(dataset),
    ]
    return "\n".join([*table_lines(columns), "", *notes])


def _cone_factor_columns(dataset: xr.Dataset) -> list[Column]:
    parts = [
        half_width_column(dataset, "cone_factor", ("cone", "factor")),
        *(
            Column(heading, [number(value, "#.3g") for value in over_cases(dataset, name)])
            for name, heading in (
                ("cone_factor_simulated", ("as", "simulated")),
                ("cone_factor_normal", ("normal", "part")),
                *BY_MODE.items(),
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
        if inside or np.isfinite(value)
        else "[outside]"
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


def reason_notes(dataset: xr.Dataset) -> list[str]:
    """Why cases have no uncertainty: a line for each reason, with the cases that it is of."""
    reasons = reasons_of(dataset)
    if not any(reasons):
        return []
    labels, notes = labels_of(dataset), []
    for reason in dict.fromkeys(filter(None, reasons)):
        cases = [label for label, it in zip(labels, reasons, strict=True) if it == reason]
        further = f" and {len(cases) - MOST_CASES} more" if len(cases) > MOST_CASES else ""
        of_cases = f" of {', '.join(cases[:MOST_CASES])}{further}"
        every = len(cases) == len(reasons)
        notes.append(f"no uncertainty{'' if every else of_cases}: {reason}")
    return notes


def _resolution_notes(dataset: xr.Dataset) -> list[str]:
    computed = cone_factor_of(dataset)
    if RESOLUTION not in computed.dims or computed.sizes[RESOLUTION] < 2:
        return []
    finest = computed.sortby(RESOLUTION).isel({RESOLUTION: slice(-2, None)})
    coarse, fine = finest[RESOLUTION].values
    changes = (finest.isel({RESOLUTION: 1}) / finest.isel({RESOLUTION: 0}, drop=True) - 1).values
    texts = [f"{change:+z.2%}" if np.isfinite(change) else "failed" for change in changes.flat]
    return [f"finest two ({RESOLUTION} {coarse:g} to {fine:g}): cone factor {', '.join(texts)}"]


def _notes(dataset: xr.Dataset, references: Iterable[ConeFactor]) -> list[str]:
    shown = {reference.id: reference for reference in (*references, *ENVELOPE)}.values()
    members = ", ".join(reference.id for reference in ENVELOPE)
    return [
        f"cone factor: +- {HALF_WIDTH}; without it nothing is known of the error",
        f"computed: {_which_strength(dataset)}",
        "exact shear: adhesion_factor / tan(apex_angle / 2) by statics; the shear part's deviation",
        f"envelope: least to greatest of {members}; it is no confidence interval",
        "literature: value, computed / literature - 1; [outside the validity of the reference]",
        *(
            f"  {reference.id}: {reference.source}; {reference.criterion}; {reference.validity}"
            for reference in shown
        ),
        f"how known: {'; '.join(dict.fromkeys(reference.how_known for reference in shown))}",
    ]


def _which_strength(dataset: xr.Dataset) -> str:
    """Which su the cone factors are over."""
    named = str(cone_factor_of(dataset).attrs.get("long_name", ""))
    if any(name in dataset for name in BY_MODE):
        return f"{named}: by su in that test; beside it by su in others, and by their average"
    return "su is the strength in pure shear, for von_mises too (sqrt(J2) = su)"


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


def result_table(dataset: xr.Dataset) -> str:
    """A text table for a terminal: one row a case, and how to read it below.

    Where cone factors stand beside results of other scenes, these have a table of their own, and
    each ratio of two scenes in one soil stands below.

    Raises:
        NothingToCompareError: no case has a result, or a cone factor lacks its parameters.
    """
    return "\n".join([_tables(dataset), *ratio_notes(dataset), *change_notes(dataset)])


def _tables(dataset: xr.Dataset) -> str:
    if COMPARED not in dataset:
        return _exact_table(dataset)
    scenes = np.array(scenes_of(dataset))
    of_cones = np.isin(scenes, scenes[np.isfinite(over_cases(dataset, COMPARED).astype(float))])
    if of_cones.all() or not of_cones.any():
        return cone_factor_table(dataset)
    others = _cases(dataset, ~of_cones)
    try:
        of_others = _exact_table(others)
    except NothingToCompareError as error:
        of_others = f"{', '.join(dict.fromkeys(scenes_of(others)))}: {error}"
    return f"{cone_factor_table(_cases(dataset, of_cones))}\n\n{of_others}"


def _cases(dataset: xr.Dataset, chosen: np.ndarray) -> xr.Dataset:
    """Some cases of several scenes, with the variables that they have."""
    part = dataset.isel({CASE: np.flatnonzero(chosen)})
    return part.drop_vars([name for name, it in part.data_vars.items() if it.isnull().all()])


def _exact_table(dataset: xr.Dataset) -> str:
    """What each case was run for, its exact value, and its error."""
    headlines = [
        name for name in with_role(dataset, Role.HEADLINE) if _is_one_a_case(dataset, name)
    ]
    error = error_name(dataset)
    headlines = [name for name in headlines if name != error]
    if not headlines and error is None:
        raise NothingToCompareError(_why_nothing(dataset))
    columns = parameter_columns(dataset)
    notes = []
    for name in headlines:
        columns.append(_headline_column(dataset, name))
        notes.append(_note(dataset, name))
        exact = f"{name}_exact"
        if exact in dataset and _is_one_a_case(dataset, exact):
            columns.append(_column(dataset, exact, ".4g"))
            notes.append(_note(dataset, exact))
    if error is not None:
        columns.append(_column(dataset, error, ".2%"))
        notes.append(_note(dataset, error))
    for name, limit in limits_of(dataset).items():
        if name != error and name not in headlines and _is_one_a_case(dataset, name):
            columns.append(_column(dataset, name, ".2%"))
            notes.append(f"{_note(dataset, name)}; at most {limit:g}")
    lines = table_lines([*columns, *run_columns(dataset)])
    if with_role(dataset, Role.UNCERTAINTY):
        notes.append(f"+-: {HALF_WIDTH}")
    return "\n".join([*lines, "", *notes, *reason_notes(dataset)])


def _is_one_a_case(dataset: xr.Dataset, name: str) -> bool:
    return set(dataset[name].dims) <= set(dataset["status"].dims)


def _column(dataset: xr.Dataset, name: str, form: str) -> Column:
    return Column(heading(name), [number(value, form) for value in over_cases(dataset, name)])


def _headline_column(dataset: xr.Dataset, name: str) -> Column:
    if f"{name}_uncertainty" not in with_role(dataset, Role.UNCERTAINTY):
        return _column(dataset, name, ".4g")
    return half_width_column(dataset, name, heading(name))


def _note(dataset: xr.Dataset, name: str) -> str:
    """What a variable is, in its own words."""
    said = dataset[name].attrs
    unit = "" if said.get("units", "1") == "1" else f" [{said['units']}]"
    description = f"; {said['description']}" if "description" in said else ""
    return f"{name}: {said.get('long_name', spoken(name))}{unit}{description}"


def _why_nothing(dataset: xr.Dataset) -> str:
    completed = int((dataset["status"] == COMPLETED).sum())
    if completed == 0:
        return f"nothing to compare: no case of {dataset['status'].size} completed"
    return "nothing to compare: the scene has neither a headline nor an error"
