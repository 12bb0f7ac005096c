"""Computed cone factors against the literature and against exact statics."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
import xarray as xr

from harness.errors import HarnessError
from harness.references import cone_factor_reference
from harness.references.cone_factors import Conditions, ConeFactor


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
        friction=dataset.get("friction_coefficient", xr.DataArray(0.0)),
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
        UnknownReferenceError: an id is unknown.
        NothingToCompareError: the dataset has no cone factor, or not its parameters.
    """
    references = [cone_factor_reference(reference_id) for reference_id in reference_ids]
    if not references:
        return dataset
    computed, conditions = cone_factor_of(dataset), conditions_of(dataset)
    added: dict[Hashable, xr.DataArray] = {}
    for reference in references:
        value = over_cases(computed, reference.evaluate(conditions))
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
    return varied_along(dataset, cone_factor_of(dataset).dims)


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
    return xr.DataArray(exact).where(xr.DataArray(conditions.friction) == 0)


def cone_factor_of(dataset: xr.Dataset) -> xr.DataArray:
    """The computed cone factors.

    Raises:
        NothingToCompareError: there are none.
    """
    if "cone_factor" not in dataset:
        raise NothingToCompareError(
            "nothing to compare: no cone_factor; it is another scene's, or no case completed"
        )
    return dataset["cone_factor"]


def over_cases(computed: xr.DataArray, value: object) -> xr.DataArray:
    """`value` over the dims of `computed`, in their order."""
    return xr.DataArray(value).broadcast_like(computed)
