"""Computed cone factors against the literature and against exact statics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from harness.archive.conventions import Role, with_role
from harness.errors import HarnessError
from harness.references.cone_factors import (
    COMPARED,
    NEEDED,
    Conditions,
    ConeFactor,
    cone_factor_reference,
)


class NothingToCompareError(HarnessError):
    """The dataset lacks what a comparison needs; the message is one line."""


def conditions_of(dataset: xr.Dataset) -> Conditions:
    """What the literature's formulas depend on, out of the parameters stored in `dataset`.

    A shaft adhesion that is not a number, as older results have it, means the face's; a stress
    anisotropy that the scene does not have means isotropic; clay without parameters of softening
    and of a rate effect has neither.

    Raises:
        NothingToCompareError: the dataset has no rigidity index or no adhesion factor.
    """
    for name in NEEDED:
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
        strength_stays=_strength_stays(dataset),
    )


def _strength_stays(dataset: xr.Dataset) -> xr.DataArray:
    """Whether neither strain nor its rate changes the strength of the clay."""
    rate_factor = dataset.get("rate_factor", xr.DataArray(0.0))
    remoulded = dataset.get("remoulded_strength_ratio", xr.DataArray(1.0))
    return (rate_factor == 0.0) & (remoulded == 1.0)


def with_references(dataset: xr.Dataset, reference_ids: Sequence[str]) -> xr.Dataset:
    """Set the literature's cone factors beside the computed ones.

    Args:
        dataset: result of a study: `cone_factor` and all parameters of the scene, by name.
        reference_ids: ids out of :func:`harness.references.cone_factors.reference_ids`.

    Returns:
        The dataset with `reference_<id>` and `deviation_<id>` = computed / reference - 1 for
        each id, over the dims of `cone_factor`. Values are given outside the range of a
        reference too; its attribute `validity` gives that range.

    Raises:
        UnknownReferenceError: an id is unknown.
        NothingToCompareError: the dataset has no cone factor, or not its parameters.
    """
    references = [cone_factor_reference(reference_id) for reference_id in reference_ids]
    if not references:
        return dataset
    computed, conditions = cone_factor_of(dataset), conditions_of(dataset)
    for reference in references:
        # Values alone: arithmetic would hand on the attributes of a parameter.
        value = xr.DataArray(reference.evaluate(conditions)).broadcast_like(computed)
        values = value.transpose(*computed.dims).values
        label = f"cone factor of {reference.label}"
        known = {
            "units": "1",
            "source": reference.source,
            "formula": reference.formula,
            "criterion": reference.criterion,
            "method": reference.method,
            "how_known": reference.how_known,
            "validity": reference.validity,
        }
        dataset = dataset.assign(
            {
                f"{Role.REFERENCE}_{reference.id}": (
                    computed.dims,
                    values,
                    known | {"long_name": label, "role": Role.REFERENCE},
                ),
                f"{Role.DEVIATION}_{reference.id}": (
                    computed.dims,
                    computed.values / values - 1,
                    known | {"long_name": f"deviation from the {label}", "role": Role.DEVIATION},
                ),
            }
        )
    return dataset


def stored_references(dataset: xr.Dataset) -> tuple[ConeFactor, ...]:
    """The references that :func:`with_references` has set into `dataset`."""
    names = with_role(dataset, Role.REFERENCE)
    return tuple(cone_factor_reference(name.removeprefix(f"{Role.REFERENCE}_")) for name in names)


def exact_shear(dataset: xr.Dataset) -> xr.DataArray:
    """Shear part of the cone factor by statics: adhesion factor / tan(half the apex angle).

    Exact where the whole face slips and adhesion alone resists; not a number where there is
    friction beside it, or where the strength of the clay, and its adhesion with it, changes.
    """
    conditions = conditions_of(dataset)
    exact = conditions.face_adhesion / np.tan(np.radians(conditions.apex_angle) / 2)
    return xr.DataArray(exact).where(conditions.strength_stays & (conditions.friction == 0))


def cone_factor_of(dataset: xr.Dataset) -> xr.DataArray:
    """The computed cone factors.

    Raises:
        NothingToCompareError: there are none.
    """
    if COMPARED not in dataset:
        raise NothingToCompareError(
            f"nothing to compare: no {COMPARED}; it is another scene's, or no case completed"
        )
    return dataset[COMPARED]
