"""The result of a study as a text table: beside published cone factors, or exact solutions."""

import re
from collections.abc import Iterable, Sequence

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    CASE,
    COMPLETED,
    HALF_WIDTH,
    Role,
    headlines_of,
    labels_of,
    largest_parts_of,
    limits_of,
    over_cases,
    reasons_of,
    scenes_of,
    spoken,
    with_role,
)
from harness.compare.columns import (
    MISSING,
    Column,
    column,
    half_width_column,
    number_text,
    numbers_column,
    stated_column,
    table,
    with_runs,
)
from harness.compare.compared import (
    NothingToCompareError,
    conditions_of,
    cone_factor_of,
    experience_notes,
    stored_references,
)
from harness.compare.differences import change_notes, ratio_notes
from harness.compare.finest_error import error_name
from harness.compare.spread import spread_notes
from harness.references.reference import COMPARED, Reference
from harness.references.registry import ENVELOPE, envelope, envelope_applies
from harness.references.strength import Conditions, in_test
from mpm_warp.scenes.strength_modes import BY_GIVEN

MOST_CASES = 3
"""A note lists up to so many cases; of more it gives the number."""
RESOLUTION = "cells_per_radius"
"""The parameter that refines the mesh. A note gives the change between its two finest values."""
BY_MODE = {
    "compression": "by su in_compression",
    "simple_shear": "by su in_simple shear",
    "extension": "by su in_extension",
    "average": "by su,_average",
}
"""Headings of cone factors, by the test that su comes from."""
BESIDE_FACTOR = {
    "cone_factor_simulated": ("as_simulated", "#.3g"),
    "cone_factor_normal": ("normal_part", "#.3g"),
    **{f"{COMPARED}_by_{mode}": (heading, "#.3g") for mode, heading in BY_MODE.items()},
    "Bq": ("_Bq", ".2f"),
    "N_ke": ("_N ke", ".2f"),
}
"""Results shown beside the cone factor: heading and number format."""
PRESSURE = "pore_pressure_factor_shoulder"
"""(u2 - u0) / su of a cone; it has an uncertainty of its own."""


def result_table(dataset: xr.Dataset, form: str = "text") -> str:
    """A table with one row per case in a form of `columns.FORMS`, and notes on how to read it.

    In a study of several scenes, scenes without a cone factor get a second table. The notes also
    give ratios of two scenes in the same soil, and the spread due to distributions of inputs.
    """
    if form != "text":
        return _tables(dataset, form)
    notes = [*ratio_notes(dataset), *change_notes(dataset), *spread_notes(dataset)]
    return "\n".join([_tables(dataset, form), *notes])


def _tables(dataset: xr.Dataset, form: str) -> str:
    if COMPARED not in dataset:
        return _exact_table(dataset, form)
    scenes = np.array(scenes_of(dataset))
    of_cones = np.isin(scenes, scenes[np.isfinite(over_cases(dataset, COMPARED).astype(float))])
    if of_cones.all() or not of_cones.any():
        return cone_factor_table(dataset, form)
    others = _cases(dataset, ~of_cones)
    try:
        of_others = _exact_table(others, form)
    except NothingToCompareError as error:
        of_others = f"{', '.join(dict.fromkeys(scenes_of(others)))}: {error}"
    return f"{cone_factor_table(_cases(dataset, of_cones), form)}\n\n{of_others}"


def _cases(dataset: xr.Dataset, chosen: np.ndarray) -> xr.Dataset:
    """The chosen cases, without variables that none of them has."""
    part = dataset.isel({CASE: np.flatnonzero(chosen)})
    return part.drop_vars(
        [name for name, variable in part.data_vars.items() if variable.isnull().all()]
    )


def cone_factor_table(dataset: xr.Dataset, form: str = "text") -> str:
    """The table of cone factors."""
    cone_factor_of(dataset)  # an error if there are none
    references = stored_references(dataset)
    columns = [
        *_cone_factor_columns(dataset),
        *(_reference_column(dataset, reference) for reference in references),
        *_envelope_columns(dataset),
    ]
    notes = [
        *_resolution_notes(dataset),
        *_largest_part_notes(dataset),
        *reason_notes(dataset),
        *_notes(dataset, references),
        *experience_notes(dataset),
    ]
    return table(with_runs(dataset, columns), notes, form)


def _cone_factor_columns(dataset: xr.Dataset) -> Iterable[Column]:
    yield half_width_column(dataset, COMPARED, COMPARED)
    for name, (heading, form) in BESIDE_FACTOR.items():
        if name in dataset:
            yield numbers_column(dataset, name, form, heading)
    if f"{PRESSURE}_uncertainty" in dataset:
        pressure, half_widths = (
            over_cases(dataset, name) for name in (PRESSURE, f"{PRESSURE}_uncertainty")
        )
        yield stated_column("u2_over su", pressure, half_widths, _reasons_of_pressure(dataset))
    if "cone_factor_shear" in dataset:
        yield numbers_column(dataset, "cone_factor_shear", ".3f", "shear_part")


def _reference_column(dataset: xr.Dataset, reference: Reference) -> Column:
    conditions, name = conditions_of(dataset), reference.id
    values, deviations, applies, is_alike = (
        over_cases(dataset, quantity)
        for quantity in (
            *(f"{role}_{name}" for role in (Role.REFERENCE, Role.DEVIATION)),
            reference.applies(conditions),
            reference.has_criterion(conditions),
        )
    )
    other = f" {reference.criterion_name}"
    texts = [
        _bracketed(_with_deviation(value, deviation) + ("" if is_same else other), holds)
        if holds or np.isfinite(value)
        else "[outside]"
        for value, deviation, holds, is_same in zip(
            values, deviations, applies, is_alike, strict=True
        )
    ]
    apart = (
        column(name, (number_text(value, ".2f") for value in values)),
        column(f"{name}_deviation", (number_text(it, "+z.1%") for it in deviations)),
        column(f"{name}_applies", ("yes" if holds else "no" for holds in applies)),
    )
    return Column(name, texts, apart)


def _envelope_columns(dataset: xr.Dataset) -> Iterable[Column]:
    """The place in the envelope; none where no case has two references of its criterion."""
    conditions = conditions_of(dataset)
    quantities = (COMPARED, *envelope(conditions), envelope_applies(conditions))
    rows = [*zip(*(over_cases(dataset, quantity) for quantity in quantities), strict=True)]
    if any(np.isfinite(lower) for _, lower, _, _ in rows):
        texts = [_bracketed(_place(*numbers), applies) for *numbers, applies in rows]
        yield column("in the_envelope", texts)


def _with_deviation(value: float, deviation: float) -> str:
    return f"{number_text(value, '.2f')} {number_text(deviation, '+z.1%'):>6}"


def _bracketed(text: str, inside: bool) -> str:
    # A blank instead of the bracket keeps the numbers of a column aligned.
    return f"{text} " if inside else f"[{text}]"


def _place(value: float, lower: float, upper: float) -> str:
    if not np.isfinite(value) or not np.isfinite(lower):
        return MISSING
    return "below" if value < lower else "above" if value > upper else "yes"


def reason_notes(dataset: xr.Dataset) -> list[str]:
    """Why cases have no uncertainty: a line for each reason, with the cases it applies to.

    Reasons of u2 follow where they differ from that of the cone factor.
    """
    of_u2 = _lines_of(dataset, "no uncertainty of u2", own_reasons_of_pressure(dataset))
    return [*_lines_of(dataset, "no uncertainty", reasons_of(dataset)), *of_u2]


def own_reasons_of_pressure(dataset: xr.Dataset) -> list[str]:
    """Why u2 of each case has no uncertainty; "" where the cone factor has the same reason."""
    pairs = zip(_reasons_of_pressure(dataset), reasons_of(dataset), strict=True)
    return [own if own != reason else "" for own, reason in pairs]


def _reasons_of_pressure(dataset: xr.Dataset) -> list[str]:
    reasons = over_cases(dataset, f"{PRESSURE}_why_no_uncertainty")
    return [reason if isinstance(reason, str) else "" for reason in reasons]


def _lines_of(dataset: xr.Dataset, what: str, texts: list[str]) -> list[str]:
    """A line for each different text, with the cases that have it."""
    labels, lines = labels_of(dataset), []
    for text in dict.fromkeys(filter(None, texts)):
        cases = [label for label, own in zip(labels, texts, strict=True) if own == text]
        counted = f"{len(cases)} of {len(texts)} cases"
        suffix = f" of {'; '.join(cases) if len(cases) <= MOST_CASES else counted}"
        lines.append(f"{what}{'' if len(cases) == len(texts) else suffix}: {text}")
    return lines


def _largest_part_notes(dataset: xr.Dataset) -> list[str]:
    """A line for each part of U that is the largest of a case: what makes U smaller there."""
    told = [re.sub(", [^,:]* of U[^:]*", "", text) for text in largest_parts_of(dataset)]
    return _lines_of(dataset, "largest part of U", told)


def _resolution_notes(dataset: xr.Dataset) -> list[str]:
    computed = cone_factor_of(dataset)
    if RESOLUTION not in computed.dims or computed.sizes[RESOLUTION] < 2:
        return []
    finest = computed.sortby(RESOLUTION).isel({RESOLUTION: slice(-2, None)})
    coarse, fine = finest[RESOLUTION].values
    changes = (finest.isel({RESOLUTION: 1}) / finest.isel({RESOLUTION: 0}, drop=True) - 1).values
    texts = [f"{change:+z.2%}" if np.isfinite(change) else "failed" for change in changes.flat]
    return [f"finest two ({RESOLUTION} {coarse:g} to {fine:g}): cone factor {', '.join(texts)}"]


def _notes(dataset: xr.Dataset, references: Sequence[Reference]) -> list[str]:
    notes = [f"cone factor: +- {HALF_WIDTH}; without +- the error is not known"]
    if "cone_factor_simulated" in dataset:
        notes.append("as simulated: before the correction for mesh, speed and window")
    if {"cone_factor_normal", "cone_factor_shear"} <= {*dataset.data_vars}:
        notes.append("normal part, shear part: of the tractions on the face; their sum is Nc")
    notes.append(f"computed: {which_strength(dataset)}")
    members, conditions = ", ".join(it.id for it in ENVELOPE), conditions_of(dataset)
    if bool(envelope(conditions)[0].notnull().any()):
        of_them = f"least to greatest of those of {members} that have the criterion of the case"
        notes.append(f"envelope: {of_them}; it is no confidence interval")
    if not references:
        return notes
    known = dict.fromkeys(reference.how_known for reference in references)
    outside = "[outside the validity of the reference, or of another criterion, which is named]"
    return [
        *notes,
        f"literature: over su of the case, computed / literature - 1; {outside}",
        *(
            f"  {reference.id}: {reference.source}; {reference.definition}"
            f"{_ratio(dataset, reference, conditions)}; {reference.validity}"
            for reference in references
        ),
        f"how known: {'; '.join(known)}",
    ]


def _ratio(dataset: xr.Dataset, reference: Reference, conditions: Conditions) -> str:
    """The su of a reference over that of the cases, in words; "" where it is the same."""
    ratios = over_cases(dataset, in_test(conditions, reference.su_mode))
    known = np.unique(ratios[np.isfinite(ratios)])
    if np.all(known == 1.0):
        return ""
    return f", which is {' or '.join(f'{ratio:.3g}' for ratio in known)} times su here"


def which_strength(dataset: xr.Dataset) -> str:
    """Which strength su the cone factors are divided by, in words."""
    named = str(cone_factor_of(dataset).attrs.get("long_name", ""))
    factors, strengths = (
        over_cases(dataset, name).astype(float) for name in (COMPARED, "strength_by_compression")
    )
    has_own = np.isfinite(strengths[np.isfinite(factors)])
    in_shear = "su is the strength in pure shear, for von_mises too (sqrt(J2) = su)"
    if not has_own.any():
        return in_shear
    if not has_own.all():
        main = "that of the law's main test, unless su is given"
        return f"{in_shear}; for a law with several strengths it is {main}"
    if named.endswith(BY_GIVEN):
        return f"{named}, N_ke too; other columns: by other su"
    in_test = "that test" if ", " in named else "the main test of each law, unless su is given"
    return f"{named}: by su in {in_test}, N_ke too; other columns: by other su"


def _exact_table(dataset: xr.Dataset, form: str) -> str:
    """The table of headlines, their exact values, and errors."""
    dims, error = set(dataset["status"].dims), error_name(dataset)
    one_a_case = {
        str(name) for name, variable in dataset.data_vars.items() if set(variable.dims) <= dims
    }
    headlines = [name for name in headlines_of(dataset) if name in one_a_case - {error}]
    if not headlines and error is None:
        why = f"no case of {dataset['status'].size} completed"
        if (dataset["status"] == COMPLETED).any():
            why = "the scene has neither a headline nor an error"
        raise NothingToCompareError(f"nothing to compare: {why}")
    columns, notes = [], []
    for name in headlines:
        if f"{name}_uncertainty" in with_role(dataset, Role.UNCERTAINTY):
            columns.append(half_width_column(dataset, name, name))
        else:
            columns.append(numbers_column(dataset, name, ".4g", name))
        columns += [
            numbers_column(dataset, by_mode, "#.3g", heading)
            for mode, heading in BY_MODE.items()
            if (by_mode := f"{name}_by_{mode}") in dataset
        ]
        notes.append(_note(dataset, name))
        if (exact := f"{name}_exact") in one_a_case:
            columns.append(numbers_column(dataset, exact, ".4g", exact))
            notes.append(_note(dataset, exact))
    if error is not None:
        columns.append(numbers_column(dataset, error, ".2%", error))
        notes.append(_note(dataset, error))
    for name, limit in limits_of(dataset).items():
        if name in one_a_case - {error, *headlines}:
            columns.append(numbers_column(dataset, name, ".2%", name))
            notes.append(f"{_note(dataset, name)}; at most {limit:g}")
    if with_role(dataset, Role.UNCERTAINTY):
        notes.append(f"+-: {HALF_WIDTH}")
    notes += [*_largest_part_notes(dataset), *reason_notes(dataset)]
    return table(with_runs(dataset, columns), notes, form)


def _note(dataset: xr.Dataset, name: str) -> str:
    """The long name, unit and description of a variable."""
    attributes = dataset[name].attrs
    unit = "" if attributes.get("units", "1") == "1" else f" [{attributes['units']}]"
    description = f"; {attributes['description']}" if "description" in attributes else ""
    return f"{name}: {attributes.get('long_name', spoken(name))}{unit}{description}"
