"""The dataset of a study, collected from the results of its cases."""

from collections.abc import Hashable, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError, DamagedError
from harness.archive.case_files import read_case
from harness.archive.conventions import (
    CASE,
    CHANGED,
    COMPLETED,
    DAMAGED,
    DERIVED_BY,
    DISTRIBUTION,
    DRAWS,
    GIVEN_BY,
    MISSING,
    ORDER,
    UNREADABLE,
    Role,
    parameter_attributes,
    spoken,
    with_role,
)
from harness.archive.provenance import OF_CASE
from harness.study.cases import Case
from harness.study.designs import ONE_AT_A_TIME
from harness.study.distributions import Input
from harness.study.study import STABILITY_MAP, Study
from mpm_warp.errors import ParameterError
from mpm_warp.fields.declaration import Derived, Parameter, Value
from mpm_warp.results import material_as_built, stored_name
from mpm_warp.scenes import scene_class

Variables = dict[Hashable, xr.Variable]


def collect(study: Study, folder: Path) -> xr.Dataset:
    """Collect the results of a study's cases in one dataset.

    Dims. The dims of a full design are the varied parameters in the study's order. A study with
    another design, several scenes or exclusions has the dim `case`; varied parameters, and `scene`,
    are coordinates along it. The scene's own dims follow; each is the union over all cases.

    Parameters. Each is a variable: a coordinate if the study varies it, a scalar if it is the same
    in all cases, and a variable over the cases if the scene derives it from varied ones. It is NaN
    for a scene without it. A parameter that shares its name with a result is called
    ``<name>_parameter``. If two scenes have a result of one name over different dims, the second
    is called ``<scene>_<name>``.

    Attributes. If a variable has different long names in the cases, their common beginning is kept;
    up to three different descriptions are joined.

    Failed cases. Scalars of a case that did not complete are NaN; its curves end where the run
    ended. `status` and `message` say why, also if its file cannot be used.

    Provenance. Where, when and with what the cases were computed are attributes if all agree, and
    otherwise variables over the cases, "" if a case file does not say.
    """
    results = [_result(folder, case) for case in study.cases]
    gathered = _gathered(results)
    definitions = {
        name: definition
        for part in study.parts
        for name, definition in part.parameters.items()
        if any(name in case.parameters for case in study.cases)
    }
    names = {name: stored_name(name, {*gathered.variables, *gathered.dims}) for name in definitions}
    axes: dict[str, Sequence[Value]] = {CASE: range(len(study.cases))}
    if study.is_grid:
        varied = study.parts[0].varied
        axes = {names[name]: v for name, v in varied.items() if isinstance(v, tuple)}

    of_scenes = {name: variable for name, variable in gathered.variables.items() if name != CASE}
    differing_origins, common_origins = _origins(results)
    inputs, coordinates = _parameters(study, definitions, names, axes)
    inputs |= _as_built(inputs, of_scenes)
    variables = of_scenes | _records(study, results, names) | differing_origins | inputs
    coordinates |= _case_coordinates(study, axes)
    sizes = {name: len(values) for name, values in axes.items()}
    order = " ".join(names[name] for name in study.parts[0].varied)
    return xr.Dataset(
        {name: _over_grid(variable, sizes) for name, variable in variables.items()},
        {name: _over_grid(variable, sizes) for name, variable in coordinates.items()},
        {
            "title": study.title,
            "study": study.name,
            "design": study.design.kind,
            "scene": " ".join(part.name for part in study.parts),
            "scene_version": study.cases[0].scene_version,
            ORDER: " ".join(map(str, coordinates)),
            **({STABILITY_MAP: order} if study.stability_map else {}),
            "source": "; ".join(sorted({*_attributes(results, "source")} - {""})),
            **common_origins,
        },
    )


def _over_grid(variable: xr.Variable, sizes: Mapping[str, int]) -> xr.Variable:
    """A variable over the dims of the study instead of the dim `case`."""
    if variable.dims[:1] != (CASE,):
        return variable
    values = variable.values.reshape((*sizes.values(), *variable.shape[1:]))
    return xr.Variable((*sizes, *variable.dims[1:]), values, variable.attrs)


def _records(
    study: Study, results: Sequence[xr.Dataset | None], names: Mapping[str, str]
) -> Variables:
    """Status, message and key of each case; in a one-at-a-time study also the changed parameter."""
    texts = {
        "status": ("outcome of the case", _attributes(results, "status", MISSING)),
        "message": ("why the case did not complete", _attributes(results, "message")),
        "case_key": ("name of the case's file", [case.key for case in study.cases]),
    }
    if study.design.kind == ONE_AT_A_TIME:
        changed = [" ".join(names[name] for name in case.changed) for case in study.cases]
        texts[CHANGED] = "parameter that the study changes in the case", changed
    records: Variables = {
        name: _over_cases(meaning, values) for name, (meaning, values) in texts.items()
    }
    if any(case.draws > 1 for case in study.cases):
        draws = [case.draws for case in study.cases]
        records[DRAWS] = _over_cases("samples of the Latin hypercube that are the case", draws)
    return records


def _over_cases(meaning: str, values: Sequence[object]) -> xr.Variable:
    return xr.Variable(CASE, np.array(values), {"long_name": meaning})


def _origins(results: Sequence[xr.Dataset | None]) -> tuple[Variables, dict[str, str]]:
    """Provenance of the cases: as variables if it differs, as attributes if it is common to all."""
    differing: Variables = {}
    common: dict[str, str] = {}
    for name in OF_CASE:
        values = _attributes(results, name)
        known = set(values) - {""}
        if len(known) > 1:
            differing[name] = _over_cases(spoken(name), values)
        elif known:
            common[name] = known.pop()
    return differing, common


def _parameters(
    study: Study,
    definitions: Mapping[str, Parameter],
    names: Mapping[str, str],
    axes: Mapping[str, Sequence[Value]],
) -> tuple[Variables, Variables]:
    """The parameters as variables, and those that the study varies as coordinates."""
    variables: Variables = {}
    coordinates: Variables = {}
    assigned = {name for part in study.parts for name in part.assigned}
    varied = [pair for part in study.parts for pair in part.varied.items()]
    distributions = {name: drawn.text for name, drawn in varied if isinstance(drawn, Input)}
    derived = {name: it.text for part in study.parts for name, it in part.derived.items()}
    for part in study.parts:  # what one scene is given is no function of others in all cases
        for name in part.assigned - part.derived.keys():
            derived.pop(name, None)
    given = [_without_replaced(case) for case in study.cases]
    for name, definition in definitions.items():
        stored, labels = names[name], parameter_attributes(definition)
        labels |= {DISTRIBUTION: distributions[name]} if name in distributions else {}
        labels |= {DERIVED_BY: derived[name]} if name in derived else {}
        values = [of_case.get(name) for of_case in given]
        missing = "" if definition.kind is str else np.nan
        filled = np.array([missing if value is None else value for value in values])
        if stored in axes:
            coordinates[stored] = xr.Variable(stored, list(axes[stored]), labels)
        elif len(set(values)) == 1:
            variables[stored] = xr.Variable((), filled[0], labels)
        else:
            can_follow = definition.default is None or isinstance(definition.default, Derived)
            is_derived = can_follow and name not in assigned
            place = variables if is_derived else coordinates
            place[stored] = xr.Variable(CASE, filled, labels)
    return variables, coordinates


def _without_replaced(case: Case) -> Mapping[str, Value | None]:
    """The parameters of a case; None for those that others replace, such as a profile."""
    try:
        replaced = scene_class(case.scene).replaced(case.parameters)
    except ParameterError:  # a random case that its scene refuses
        return case.parameters
    return {**case.parameters, **dict.fromkeys(replaced)}


def _as_built(inputs: Variables, of_scenes: Variables) -> Variables:
    """`material` as it was built, if a scene built another law than its parameter names."""
    if "material" not in inputs or "built_law" not in of_scenes:
        return {}
    given, law = inputs["material"], of_scenes["built_law"]
    built = np.vectorize(material_as_built)(given.values, law.values)
    if np.all(built == given.values):
        return {}
    if len(set(built.flat)) == 1:
        return {"material": xr.Variable((), built.flat[0], given.attrs)}
    return {"material": xr.Variable(law.dims, built, given.attrs)}


def _case_coordinates(study: Study, axes: Mapping[str, Sequence[Value]]) -> Variables:
    """Case numbers if `case` is a dim, and the scene of each case if there are several."""
    coordinates: Variables = {}
    if CASE in axes:
        coordinates[CASE] = _over_cases(CASE, range(len(study.cases)))
    for name in ("scene", "scene_version") if len(study.parts) > 1 else ():
        coordinates[name] = _over_cases(spoken(name), [getattr(case, name) for case in study.cases])
    return coordinates


def _result(folder: Path, case: Case) -> xr.Dataset | None:
    """The result of a case; None without a file; of no use, only status and message."""
    try:
        return read_case(folder, case)
    except ArchiveError as error:
        status = DAMAGED if isinstance(error, DamagedError) else UNREADABLE
        return xr.Dataset(attrs={"status": status, "message": str(error)})


def _gathered(results: Sequence[xr.Dataset | None]) -> xr.Dataset:
    """The results of the scenes over the dim `case`, padded with NaN."""
    usable = {
        case: result if result.attrs["status"] == COMPLETED else _curves(result)
        for case, result in enumerate(results)
        if result is not None
    }
    usable = {case: result for case, result in usable.items() if result.variables}
    if not usable:
        return xr.Dataset()
    dims: dict[Hashable, tuple[Hashable, ...]] = {}
    own = []
    for result in usable.values():
        variables = result.drop_vars(with_role(result, Role.PARAMETER)).reset_coords()
        others = {
            name: f"{result.attrs['scene']}_{name}"
            for name, array in variables.variables.items()
            if dims.setdefault(name, array.dims) != array.dims
        }
        own.append(variables.rename(others))
    joined = xr.concat(
        own,
        dim=CASE,
        data_vars="all",
        coords="minimal",
        compat="override",
        join="outer",
        combine_attrs="override",
    )
    numbered = joined.assign_coords({CASE: list(usable)})
    of_all = numbered.reindex({CASE: range(len(results))}).transpose(CASE, ...)
    texts = [name for name, variable in of_all.data_vars.items() if variable.dtype.kind == "O"]
    gathered = of_all.assign({name: of_all[name].fillna("").astype(str) for name in texts})
    for name, variable in gathered.data_vars.items():
        having = [result for result in own if name in result]
        variable.attrs |= _common_attributes(name, [result[name].attrs for result in having])
        if len({result.attrs["scene"] for result in own}) > 1:
            scenes = dict.fromkeys(result.attrs["scene"] for result in having)
            variable.attrs[GIVEN_BY] = " ".join(scenes)
    return gathered


MOST_DESCRIPTIONS = 3
"""Number of different descriptions of one result that are joined; of more none is kept."""


def _common_attributes(name: Hashable, of_cases: Sequence[Mapping[str, str]]) -> dict[str, str]:
    """Long name and description that hold for all cases, if the cases have different ones."""
    names, descriptions = (
        list(dict.fromkeys(attributes.get(key, "") for attributes in of_cases))
        for key in ("long_name", "description")
    )
    common = {}
    if len(names) > 1:
        heads = {long_name.partition(", ")[0] for long_name in names}
        common["long_name"] = heads.pop() if len(heads) == 1 else spoken(name)
    if len(descriptions) > 1:
        few = filter(None, descriptions if len(descriptions) <= MOST_DESCRIPTIONS else [])
        common["description"] = " / ".join(few) or "by the scene or law of the case"
    return common


def _curves(result: xr.Dataset) -> xr.Dataset:
    """The curves of a case that did not complete, up to where it ended."""
    return result.drop_vars([name for name, array in result.data_vars.items() if not array.dims])


def _attributes(results: Sequence[xr.Dataset | None], name: str, otherwise: str = "") -> list[str]:
    """An attribute of the files of all cases, with a default."""
    return [
        otherwise if result is None else str(result.attrs.get(name, otherwise))
        for result in results
    ]
