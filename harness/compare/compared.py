"""Setting references, experience and tolerances of [compare] beside a result."""

import json
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    COMPLETED,
    GIVEN_BY,
    TOLERANCES,
    Role,
    case_dims,
    labels_of,
    over_cases,
    parameter_names,
    scenes_of,
    with_role,
)
from harness.errors import HarnessError
from harness.references.band import Band
from harness.references.reference import COMPARED, NEEDED, Conditions, Reference
from harness.references.registry import REFERENCES, band_of, reference_of
from harness.study.compared import OWN_LABEL, own_attributes, stored_own_reference
from mpm_warp.fields.names import did_you_mean
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.clay_law import PARAMETER


class NothingToCompareError(HarnessError):
    """The dataset lacks what a comparison needs."""


def conditions_of(dataset: xr.Dataset) -> Conditions:
    """The quantities that formulas of the literature depend on, from the parameters of a result.

    A quantity without a parameter in the scene is taken as absent, such as friction 0. If the shaft
    has no adhesion of its own it has that of the face. Values as built are used where they differ
    from the parameters, because friction may make a cone rougher.
    """
    for name in NEEDED:
        if name not in dataset:
            raise NothingToCompareError(f"nothing to compare: the dataset has no {name}")

    def as_built(name: str, default: xr.DataArray) -> xr.DataArray:
        given = dataset.get(name, default).astype(float)
        built = dataset.get(f"{name}_built", given)
        return built.where(built.notnull(), given)

    face = as_built("adhesion_factor", dataset["adhesion_factor"])
    shaft = as_built("shaft_adhesion_factor", face)
    constant_su = (
        (dataset.get("rate_factor", xr.DataArray(0.0)) == 0.0)
        & (dataset.get("remoulded_strength_ratio", xr.DataArray(1.0)) == 1.0)
        & dataset.get(PARAMETER, xr.DataArray("tresca")).isin(list(CRITERIA))
    )
    return {
        **{name: dataset[stored] for name, stored in parameter_names(dataset).items()},
        "Ir": dataset["rigidity_index"],
        "alpha_c": face,
        "alpha_s": shaft.where(shaft.notnull(), face),
        "Delta": dataset.get("stress_anisotropy", xr.DataArray(0.0)),
        "apex_angle": dataset.get("apex_angle", xr.DataArray(60.0)),
        "friction": as_built("friction_coefficient", xr.DataArray(0.0)),
        "constant_su": constant_su.astype(float),
    }


def with_references(dataset: xr.Dataset, references: Sequence[Reference]) -> xr.Dataset:
    """Add `reference_<id>` and `deviation_<id>` = computed / reference - 1 of each reference.

    Their dims are those of `cone_factor`. The attribute `validity` states the range, outside which
    some references have a value too.
    """
    if not references:
        return dataset
    computed, conditions = cone_factor_of(dataset), conditions_of(dataset)
    fields = ("source", "criterion", "su_mode", "method", "how_known", "validity")
    added = {}
    for reference in references:
        # Plain values, because arithmetic on arrays would pass on the attributes of a parameter.
        value = reference.evaluate(conditions).broadcast_like(computed)
        values = value.transpose(*computed.dims).values
        known = {"units": "1", **{name: str(getattr(reference, name)) for name in fields}}
        known |= {"formula": reference.text} if reference.formula is not None else {}
        known |= own_attributes(reference) if reference.id not in REFERENCES else {}
        label = f"cone factor of {reference.label}"
        with np.errstate(divide="ignore"):  # a formula of a study's own may be 0
            deviations = computed.values / values - 1
        for role, numbers, meaning in (
            (Role.REFERENCE, values, label),
            (Role.DEVIATION, deviations, f"deviation from the {label}"),
        ):
            attributes = known | {"long_name": meaning, "role": role}
            added[f"{role}_{reference.id}"] = computed.dims, numbers, attributes
    return dataset.assign(added)


def stored_references(dataset: xr.Dataset) -> tuple[Reference, ...]:
    """The references that :func:`with_references` has added to `dataset`."""
    return tuple(_stored(dataset, name) for name in with_role(dataset, Role.REFERENCE))


def _stored(dataset: xr.Dataset, name: str) -> Reference:
    reference_id = name.removeprefix(f"{Role.REFERENCE}_")
    if OWN_LABEL in dataset[name].attrs:
        return stored_own_reference(reference_id, dataset[name].attrs)
    return reference_of(reference_id)


def where_it_applies(dataset: xr.Dataset, reference_id: str) -> xr.DataArray:
    """Whether a reference stored in `dataset` is valid for each of its cases."""
    reference = _stored(dataset, f"{Role.REFERENCE}_{reference_id}")
    return reference.applies(conditions_of(dataset))


def exact_shear(dataset: xr.Dataset) -> xr.DataArray:
    """Shear part of the cone factor by statics: adhesion factor / tan(half the apex angle).

    It is exact if the whole face slips and only adhesion resists. It is NaN with friction, and in
    clay whose strength, and so its adhesion, changes.
    """
    conditions = conditions_of(dataset)
    exact = conditions["alpha_c"] / np.tan(np.radians(conditions["apex_angle"]) / 2)
    slips = (conditions["constant_su"] == 1.0) & (conditions["friction"] == 0.0)
    return xr.DataArray(exact).where(slips)


def cone_factor_of(dataset: xr.Dataset) -> xr.DataArray:
    """The computed cone factors."""
    if COMPARED not in dataset:
        done = np.any(dataset.status == COMPLETED)
        why = f"the scene has no {COMPARED}" if done else "no case completed"
        raise NothingToCompareError(f"nothing to compare: {why}")
    return dataset[COMPARED]


BOUND = "bound"
"""Dim over the lower and the upper end of a band."""


def with_experience(dataset: xr.Dataset, entry_ids: Sequence[str]) -> xr.Dataset:
    """Add bands of experience to a result: `experience_<id>`, least and greatest over `bound`."""
    if not entry_ids:
        return dataset
    bands = {}
    for entry in map(band_of, entry_ids):
        attributes = {
            "units": "1",
            "long_name": f"{entry.factor} by {entry.label}",
            "role": Role.EXPERIENCE,
            "factor": entry.factor.definition,
            "formula": entry.formula.text,
            "validity": f"{entry.clays}; {entry.spans}",
            "su_mode": str(entry.su_mode),
            "strength": entry.strength,
            "holds": entry.holds,
            "source": entry.source,
            "how_known": entry.how_known,
        }
        bands[f"{Role.EXPERIENCE}_{entry.id}"] = (BOUND, list(entry.bounds), attributes)
    ends = (BOUND, ["least", "greatest"], {"long_name": "end of a band"})
    return dataset.assign_coords({BOUND: ends}).assign(bands)


def stored_experience(dataset: xr.Dataset) -> tuple[Band, ...]:
    """The bands that :func:`with_experience` has added to `dataset`."""
    names = with_role(dataset, Role.EXPERIENCE)
    return tuple(band_of(name.removeprefix(f"{Role.EXPERIENCE}_")) for name in names)


def experience_notes(dataset: xr.Dataset) -> list[str]:
    """One line on the bands beside a result; an empty list if it has none."""
    entries = stored_experience(dataset)
    if not entries:
        return []
    bands = ", ".join(f"{entry.id} {entry.band}" for entry in entries)
    strengths = " or ".join(dict.fromkeys(entry.strength for entry in entries))
    return [f"experience (bands measured in the field): {bands}; su: {strengths}"]


def with_tolerances(dataset: xr.Dataset, tolerances: Mapping[str, float]) -> xr.Dataset:
    """Add the tolerances of the study to its result, so that the file can be checked by itself."""
    return dataset.assign_attrs({TOLERANCES: json.dumps(dict(tolerances))} if tolerances else {})


def misses(dataset: xr.Dataset) -> dict[str, list[str]]:
    """The tolerances that a result misses, each with a line per case.

    The tolerance of a reference limits the absolute deviation from it, in the cases for which it is
    valid. The tolerance of a variable limits its absolute value, in the scenes that have it. A
    value that is NaN or missing also misses its tolerance, because it could not be checked.
    """
    tolerances: dict[str, float] = json.loads(dataset.attrs.get(TOLERANCES, "{}"))
    found = {name: _misses_of(dataset, name, limit) for name, limit in tolerances.items()}
    return {name: lines for name, lines in found.items() if lines}


def _misses_of(dataset: xr.Dataset, name: str, limit: float) -> list[str]:
    numbers = [str(name) for name in dataset.data_vars if dataset[name].dtype.kind in "iuf"]
    applies: object = True
    if (deviation := f"{Role.DEVIATION}_{name}") in dataset:
        value, given = dataset[deviation], dataset[COMPARED]
        applies = where_it_applies(dataset, name)
    elif name in numbers:
        value = given = dataset[name]
    else:
        return [f"{name}: is neither a reference nor a result here{did_you_mean(name, numbers)}"]
    size = abs(value).max([dim for dim in value.dims if dim not in case_dims(dataset)])
    size = size.where(dataset["status"] == COMPLETED)  # other cases may have incomplete curves
    sizes, held = over_cases(dataset, size), over_cases(dataset, applies)
    # In a study of several scenes, leave out a scene whose completed cases lack the variable.
    scenes, done = np.array(scenes_of(dataset)), over_cases(dataset, "status") == COMPLETED
    having = given.attrs.get(GIVEN_BY, " ".join(scenes)).split()
    held = held & ~np.isin(scenes, [*({*scenes[done]} - {*having})])
    if not held.any():
        return [f"{name}: applies to no case"]
    return [
        f"{name}: {label}: {size:.3g} is beyond the tolerance {limit:g}"
        for label, size, is_held in zip(labels_of(dataset), sizes, held, strict=True)
        if is_held and not size <= limit
    ]
