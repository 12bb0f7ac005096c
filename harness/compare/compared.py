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
from harness.references.reference import COMPARED, NEEDED, Reference
from harness.references.registry import REFERENCES, band_of, reference_of, without_mode
from harness.references.strength import (
    CRITERION,
    STATED,
    Conditions,
    Criterion,
    StrengthMode,
    in_test_of,
)
from harness.study.compared import OWN_LABEL, own_attributes, stored_own_reference
from mpm_warp.fields.names import did_you_mean
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.clay_law import PARAMETER

STRENGTH_BY = {
    StrengthMode.PURE_SHEAR: "strength_by_simple_shear",
    StrengthMode.TRIAXIAL_COMPRESSION: "strength_by_compression",
}
"""Results with the su of a law that has its own."""
BY_COMPRESSION = f"{COMPARED}_by_compression"
"""Result with the cone factor over su in triaxial compression."""


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
    law = dataset.get(PARAMETER, xr.DataArray(Criterion.TRESCA.value))
    constant_su = (
        (dataset.get("rate_factor", xr.DataArray(0.0)) == 0.0)
        & (dataset.get("remoulded_strength_ratio", xr.DataArray(1.0)) == 1.0)
        & law.isin([*CRITERIA])
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
        CRITERION: law,
        **{mode: _in_test(dataset, law, mode) for mode in STATED},
    }


def _in_test(dataset: xr.Dataset, law: xr.DataArray, mode: StrengthMode) -> xr.DataArray:
    """The su of a test over that of each case; NaN where the law is not known to have one."""
    by_law: xr.DataArray = xr.apply_ufunc(
        lambda name: in_test_of(str(name), mode), law, vectorize=True, output_dtypes=[float]
    )
    own = dataset.get(STRENGTH_BY.get(mode, ""), xr.DataArray(np.nan))
    return by_law.fillna(own / dataset.get("undrained_shear_strength", np.nan))


def with_references(dataset: xr.Dataset, references: Sequence[Reference]) -> xr.Dataset:
    """Add `reference_<id>` and `deviation_<id>` = computed / reference - 1 of each reference.

    Their dims are those of `cone_factor`. A reference is evaluated by its own su, and given over
    that of the case. One that does not state its test is there by each test that it may mean, where
    this matters: `reference_<id>_<test>`. The attribute `validity` states the range, outside which
    some references have a value too.
    """
    if not references:
        return dataset
    computed, conditions = cone_factor_of(dataset), conditions_of(dataset)
    fields = ("source", "criterion", "su_mode", "method", "how_known", "validity")
    added = {}
    for reference in (it for given in references for it in given.readings(conditions)):
        # Plain values, because arithmetic on arrays would pass on the attributes of a parameter.
        value = reference.evaluate(conditions).broadcast_like(computed)
        values = value.transpose(*computed.dims).values
        known = {"units": "1", **{name: str(getattr(reference, name)) for name in fields}}
        known |= {"formula": reference.text} if reference.formula is not None else {}
        is_own = without_mode(reference.id) not in REFERENCES
        known |= own_attributes(reference) if is_own else {}
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
    """A reference, or a reading of it, from the variable that holds its values."""
    reading_id, attributes = name.removeprefix(f"{Role.REFERENCE}_"), dataset[name].attrs
    if OWN_LABEL in attributes:
        return stored_own_reference(reading_id, attributes)
    reference = reference_of(without_mode(reading_id))
    is_read = reading_id != reference.id
    return reference.read_as(StrengthMode(attributes["su_mode"])) if is_read else reference


def where_it_applies(dataset: xr.Dataset, reference_id: str) -> xr.DataArray:
    """Whether a reference stored in `dataset` is valid for each of its cases."""
    reference = _stored(dataset, f"{Role.REFERENCE}_{reference_id}")
    return reference.applies(conditions_of(dataset))


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
    """Add bands of experience to a result: `experience_<id>`, least and greatest over `bound`.

    They are over su in triaxial compression. Where that is not the su of the cases, the cone factor
    by it is added too.
    """
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
    return _with_factor_by_compression(dataset).assign_coords({BOUND: ends}).assign(bands)


def _with_factor_by_compression(dataset: xr.Dataset) -> xr.Dataset:
    if BY_COMPRESSION in dataset or not all(name in dataset for name in (COMPARED, *NEEDED)):
        return dataset
    ratio = conditions_of(dataset)[StrengthMode.TRIAXIAL_COMPRESSION]
    if over_cases(dataset, ratio == 1.0).all():
        return dataset
    factor = dataset[COMPARED]
    attributes = {
        "units": "1",
        "long_name": "cone factor, compression",
        "description": "over su in triaxial compression",
    }
    return dataset.assign({BY_COMPRESSION: (factor / ratio).assign_attrs(attributes)})


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
    deviations = [
        it
        for it in with_role(dataset, Role.DEVIATION)
        if name in (bare := it.removeprefix(f"{Role.DEVIATION}_"), without_mode(bare))
    ]
    numbers = [str(name) for name in dataset.data_vars if dataset[name].dtype.kind in "iuf"]
    if not deviations and name not in numbers:
        return [f"{name}: is neither a reference nor a result here{did_you_mean(name, numbers)}"]
    lines, applied = [], False
    for variable in deviations or [name]:
        value, held = dataset[variable], over_cases(dataset, True)
        if deviations:
            applies = where_it_applies(dataset, variable.removeprefix(f"{Role.DEVIATION}_"))
            held = over_cases(dataset, applies)
        size = abs(value).max([dim for dim in value.dims if dim not in case_dims(dataset)])
        size = size.where(dataset["status"] == COMPLETED)  # others may have incomplete curves
        # In a study of several scenes, leave out a scene whose completed cases lack the variable.
        scenes, done = np.array(scenes_of(dataset)), over_cases(dataset, "status") == COMPLETED
        given = dataset[COMPARED] if deviations else value
        having = given.attrs.get(GIVEN_BY, " ".join(scenes)).split()
        held = held & ~np.isin(scenes, [*({*scenes[done]} - {*having})])
        applied = applied or bool(held.any())
        rows = zip(labels_of(dataset), over_cases(dataset, size), held, strict=True)
        lines += [
            f"{variable.removeprefix(f'{Role.DEVIATION}_')}: {label}: {size:.3g} is beyond the "
            f"tolerance {limit:g}"
            for label, size, is_held in rows
            if is_held and not size <= limit
        ]
    return lines if applied else [f"{name}: applies to no case"]
