"""Which parameters of a result differ from the defaults of its scenes."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from harness.archive.conventions import is_there, over_cases, parameter_names, scenes_of
from mpm_warp.errors import ParameterError
from mpm_warp.fields.declaration import Value, own_parameters_of
from mpm_warp.fields.flat import flat_values, parameters_of
from mpm_warp.materials.clay_law import PARAMETER, ClayLaw, laws
from mpm_warp.scenes import CatalogueScene, scene_class, scene_names


def not_by_default(dataset: xr.Dataset) -> dict[str, str]:
    """Parameters that are the same in all cases and differ from the defaults of their scenes.

    The values are their names in the dataset. A default that the scene derives from other
    parameters is that of the first case.
    """
    stored = parameter_names(dataset)
    defaults: dict[str, Value | None] = {}
    for scene in sorted(set(scenes_of(dataset)) & set(scene_names())):
        defaults |= _defaults(dataset, scene_class(scene), stored)
    return {
        name: variable
        for name, variable in stored.items()
        if name in defaults
        and dataset[variable].ndim == 0
        and is_there(value := dataset[variable].item())
        and not _same(value, defaults[name])
    }


def _defaults(
    dataset: xr.Dataset, scene: type[CatalogueScene], stored: Mapping[str, str]
) -> dict[str, Value | None]:
    """The defaults of a scene; derived ones are those of the first case."""
    definitions = parameters_of(scene)
    derivable: Mapping[str, Value] = scene().derived()
    defaults = {
        name: definition.default
        for name, definition in own_parameters_of(scene).items()
        if name not in derivable
    }
    defaults |= defaults_of_law(dataset)
    given = {
        name: definitions[name].kind(value)
        for name in defaults.keys() & stored.keys()
        if is_there(value := over_cases(dataset, stored[name])[0])
    }
    try:
        own = flat_values(scene.of(given))
        return {name: value for name, (_, value) in own.items()} | defaults
    except ParameterError:  # the scene refuses the case, so it derives nothing
        return defaults


def defaults_of_law(dataset: xr.Dataset) -> dict[str, Value | None]:
    """Defaults of the own parameters of the first case's law, by name."""
    name = str(over_cases(dataset, PARAMETER)[0]) if PARAMETER in dataset else ""
    if name not in laws():
        return {}
    try:
        law = ClayLaw.of(name)
    except ParameterError:  # a package that cannot be loaded any more
        return {}
    return {f"{PARAMETER}.{own}": it.default for own, it in law.parameters.items()}


def _same(value: Value, default: Value | None) -> bool:
    return bool(np.isclose(value, default)) if isinstance(default, float) else value == default
