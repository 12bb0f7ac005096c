"""Computed cone factors against the literature and against exact statics."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness import HarnessError
from harness.references import cone_factor_reference
from harness.references.cone_factors import (
    ENVELOPE,
    Conditions,
    ConeFactor,
    envelope,
    envelope_applies,
)

RESOLUTION = "cells_per_radius"
"""The parameter that refines the mesh: its finest two values tell the discretisation's share."""

MISSING = "-"


class NothingToCompareError(HarnessError):
    """The dataset lacks what a comparison needs; the message is one line."""


def conditions_of(dataset: xr.Dataset) -> Conditions:
    """What the literature's formulas depend on, out of the parameters stored in `dataset`.

    A shaft adhesion that is not a number means the face's; a stress anisotropy that the scene
    does not have means isotropic.

    Raises:
        NothingToCompareError: the dataset has no rigidity index or no adhesion factor.
    """
    for name in ("rigidity_index", "adhesion_factor"):
        if name not in dataset:
            raise NothingToCompareError(f"nothing to compare: the dataset has no {name}")
    face = dataset["adhesion_factor"]
    shaft = dataset.get("shaft_adhesion_factor", face).astype(float)
    return Conditions(
        rigidity_index=dataset["rigidity_index"],
        face_adhesion=face,
        shaft_adhesion=shaft.where(shaft.notnull(), face),
        stress_anisotropy=dataset.get("stress_anisotropy", xr.DataArray(0.0)),
        apex_angle=dataset.get("apex_angle", xr.DataArray(60.0)),
    )


def with_references(dataset: xr.Dataset, reference_ids: Sequence[str]) -> xr.Dataset:
    """Set the literature's cone factors beside the computed ones.

    Args:
        dataset: result of a study: `cone_factor` and all parameters of the scene, by name.
        reference_ids: ids out of :func:`harness.references.reference_ids`.

    Returns:
        The dataset with `reference_<id>` and `deviation_<id>` = computed / reference - 1 for
        each id, over the dims of `cone_factor`. Values are given outside the range of a
        reference too; its attribute `validity` tells that range.

    Raises:
        harness.references.UnknownReferenceError: an id is unknown.
        NothingToCompareError: the dataset has no cone factor, or not its parameters.
    """
    references = [cone_factor_reference(reference_id) for reference_id in reference_ids]
    if not references:
        return dataset
    computed, conditions = _cone_factor(dataset), conditions_of(dataset)
    added: dict[Hashable, xr.DataArray] = {}
    for reference in references:
        value = _over(computed, reference.evaluate(conditions))
        known = {
            "units": "1",
            "source": reference.source,
            "formula": reference.formula,
            "criterion": reference.criterion,
            "method": reference.method,
            "how_known": reference.how_known,
            "validity": reference.validity,
        }
        label = f"cone factor of {reference.label}"
        added[f"reference_{reference.id}"] = value.assign_attrs(known, long_name=label)
        added[f"deviation_{reference.id}"] = (computed / value - 1).assign_attrs(
            known, long_name=f"deviation from the {label}"
        )
    return dataset.assign(added)


def stored_references(dataset: xr.Dataset) -> tuple[ConeFactor, ...]:
    """The references that :func:`with_references` has set into `dataset`."""
    prefix = "reference_"
    return tuple(
        cone_factor_reference(str(name).removeprefix(prefix))
        for name in dataset.data_vars
        if str(name).startswith(prefix)
    )


def varied_names(dataset: xr.Dataset) -> list[str]:
    """The parameters that vary: dims of the cone factor, or coordinates along the dim `case`."""
    return varied_along(dataset, _cone_factor(dataset).dims)


def varied_along(dataset: xr.Dataset, dims: Sequence[Hashable]) -> list[str]:
    """The parameters that vary along the dims of cases."""
    if tuple(dims) != ("case",):
        return [str(dim) for dim in dims]
    along = (str(name) for name, array in dataset.coords.items() if array.dims == ("case",))
    return [name for name in along if name not in ("case", "scene_version")]


def exact_shear(dataset: xr.Dataset) -> xr.DataArray:
    """Shear part of the cone factor by statics: adhesion factor / tan(half the apex angle).

    Exact where the whole face slips and adhesion alone resists; not a number where there is
    friction beside it.
    """
    conditions = conditions_of(dataset)
    exact = conditions.face_adhesion / np.tan(np.radians(conditions.apex_angle) / 2)
    friction = dataset.get("friction_coefficient", xr.DataArray(0.0))
    return xr.DataArray(exact).where(friction == 0)


@dataclass(frozen=True)
class _Column:
    """One column of the table: a heading of two lines and a text for each case."""

    heading: tuple[str, str]
    texts: list[str]

    @property
    def width(self) -> int:
        return max(len(text) for text in (*self.heading, *self.texts))


def table(dataset: xr.Dataset) -> str:
    """A text table for a terminal: one row a case, and how to read it below.

    Raises:
        NothingToCompareError: the dataset has no cone factor, or not its parameters.
    """
    references = stored_references(dataset)
    columns = [
        *_parameter_columns(dataset),
        *_cone_factor_columns(dataset),
        *(_reference_column(dataset, reference) for reference in references),
        _envelope_column(dataset),
        *_run_columns(dataset),
    ]
    rows = [
        [column.heading[0] for column in columns],
        [column.heading[1] for column in columns],
        ["-" * column.width for column in columns],
        *zip(*(column.texts for column in columns), strict=True),
    ]
    lines = ["  ".join(_justified(row, columns)).rstrip() for row in rows]
    return "\n".join([*lines, "", *_resolution_notes(dataset), *_notes(references)])


def _justified(row: Iterable[str], columns: Iterable[_Column]) -> list[str]:
    return [text.rjust(column.width) for text, column in zip(row, columns, strict=True)]


def _parameter_columns(dataset: xr.Dataset) -> list[_Column]:
    return [
        _Column(_heading(name), [_text(value) for value in _flat(dataset, dataset[name])])
        for name in varied_names(dataset)
    ]


def _cone_factor_columns(dataset: xr.Dataset) -> list[_Column]:
    parts = [
        _Column(heading, [_number(value, ".2f") for value in _flat(dataset, dataset[name])])
        for name, heading in (
            ("cone_factor", ("cone", "factor")),
            ("cone_factor_normal", ("normal", "part")),
        )
        if name in dataset
    ]
    if "cone_factor_shear" not in dataset:
        return parts
    shear, exact = dataset["cone_factor_shear"], exact_shear(dataset)
    statics = [
        _with_deviation(value, deviation, digits=3)
        for value, deviation in zip(
            _flat(dataset, exact), _flat(dataset, shear / exact.where(exact > 0) - 1), strict=True
        )
    ]
    return [
        *parts,
        _Column(("shear", "part"), [_number(value, ".3f") for value in _flat(dataset, shear)]),
        _Column(("exact", "shear"), statics),
    ]


def _reference_column(dataset: xr.Dataset, reference: ConeFactor) -> _Column:
    texts = [
        _bracketed(_with_deviation(value, deviation), inside)
        for value, deviation, inside in zip(
            _flat(dataset, dataset[f"reference_{reference.id}"]),
            _flat(dataset, dataset[f"deviation_{reference.id}"]),
            _flat(dataset, reference.applies(conditions_of(dataset))),
            strict=True,
        )
    ]
    return _Column(_heading(reference.id), texts)


def _envelope_column(dataset: xr.Dataset) -> _Column:
    conditions = conditions_of(dataset)
    bounds = (_flat(dataset, bound) for bound in envelope(conditions))
    inside = _flat(dataset, envelope_applies(conditions))
    texts = [
        _bracketed(_place(value, lower, upper), applies)
        for value, lower, upper, applies in zip(
            _flat(dataset, dataset["cone_factor"]), *bounds, inside, strict=True
        )
    ]
    return _Column(("in the", "envelope"), texts)


def _run_columns(dataset: xr.Dataset) -> list[_Column]:
    columns = []
    if "run_time" in dataset:
        seconds = _flat(dataset, dataset["run_time"])
        columns.append(_Column(("run time", "[s]"), [_number(value, ".1f") for value in seconds]))
    if "status" in dataset:
        status = _flat(dataset, dataset["status"])
        columns.append(_Column(("", "status"), [_text(value) for value in status]))
    return columns


def _resolution_notes(dataset: xr.Dataset) -> list[str]:
    computed = _cone_factor(dataset)
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
        "exact shear: adhesion_factor / tan(apex_angle / 2) by statics; the shear part's deviation",
        f"envelope: least to greatest of {members}; it is no confidence interval",
        "literature: value, computed / literature - 1; [outside the validity of the reference]",
        *(f"  {it.id}: {it.source}; {it.criterion}; {it.validity}" for it in shown),
        f"how known: {'; '.join(dict.fromkeys(it.how_known for it in shown))}",
    ]


def _cone_factor(dataset: xr.Dataset) -> xr.DataArray:
    if "cone_factor" not in dataset:
        raise NothingToCompareError(
            "nothing to compare: no cone_factor; it is another scene's, or no case completed"
        )
    return dataset["cone_factor"]


def _over(computed: xr.DataArray, value: object) -> xr.DataArray:
    """`value` over the dims of `computed`, in their order."""
    return xr.DataArray(value).broadcast_like(computed)


def _flat(dataset: xr.Dataset, value: object) -> np.ndarray:
    """`value` of every case, in the order of the rows."""
    flat: np.ndarray = _over(_cone_factor(dataset), value).values.ravel()
    return flat


def _heading(name: str) -> tuple[str, str]:
    """A name on two lines, to keep its column narrow."""
    head, _, tail = name.rpartition("_")
    return head, tail


def _text(value: object) -> str:
    return _number(value, "g") if isinstance(value, float) else str(value)


def _number(value: float, form: str) -> str:
    return format(value, form) if np.isfinite(value) else MISSING


def _with_deviation(value: float, deviation: float, digits: int = 2) -> str:
    percent = f"{deviation:+z.1%}" if np.isfinite(deviation) else MISSING
    return f"{_number(value, f'.{digits}f')} {percent:>6}"


def _bracketed(text: str, inside: bool) -> str:
    # A blank in the place of the bracket keeps the numbers of a column aligned.
    return f"{text} " if inside else f"[{text}]"


def _place(value: float, lower: float, upper: float) -> str:
    if not np.isfinite(value):
        return MISSING
    return "below" if value < lower else "above" if value > upper else "yes"
