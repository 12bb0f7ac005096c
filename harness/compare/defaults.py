"""Which parameters of a result are not as its scenes have them by default."""

import dataclasses
from collections.abc import Mapping

import numpy as np
import xarray as xr

from harness.archive.conventions import is_there, over_cases, parameter_names, scenes_of
from mpm_warp.errors import ParameterError
from mpm_warp.materials.other_laws import loaded_laws, other_law
from mpm_warp.parameters import Value, parameters_of
from mpm_warp.scenes import scene_class, scene_names


def not_by_default(dataset: xr.Dataset) -> dict[str, str]:
    """The parameters that are the same in all cases and are not the defaults of their scenes.

    A default may be worked out from other parameters: then those of the first case are taken.

    Returns:
        What they are called in the dataset, by name.
    """
    stored = parameter_names(dataset)
    defaults: dict[str, Value | None] = {}
    for scene in sorted(set(scenes_of(dataset)) & set(scene_names())):
        defaults |= _defaults(dataset, scene_class(scene), stored)
    return {
        name: own
        for name, own in stored.items()
        if name in defaults
        and dataset[own].ndim == 0
        and is_there(value := dataset[own].item())
        and not _same(value, defaults[name])
    }


def _defaults(
    dataset: xr.Dataset, scene: type, stored: Mapping[str, str]
) -> dict[str, Value | None]:
    """The defaults of a scene, and what it derives from the parameters of the first case."""
    definitions = parameters_of(scene)
    derivable: Mapping[str, Value] = scene().derived()
    defaults = {
        name: definition.default
        for name, definition in definitions.items()
        if name not in derivable
    }
    defaults |= defaults_of_law(dataset)
    given = {
        name: definitions[name].kind(value)
        for name in defaults.keys() & stored.keys()
        if is_there(value := over_cases(dataset, stored[name])[0])
    }
    try:
        return dataclasses.asdict(scene(**given)) | defaults
    except ParameterError:  # a case that the scene refuses has nothing derived
        return defaults


def defaults_of_law(dataset: xr.Dataset) -> dict[str, Value | None]:
    """Defaults of the parameters that the law of the first case has of its own, by name."""
    name = str(over_cases(dataset, "material")[0]) if "material" in dataset else ""
    if name not in loaded_laws():
        return {}
    return {name: definition.default for name, definition in other_law(name).parameters.items()}


def _same(value: Value, default: Value | None) -> bool:
    return bool(np.isclose(value, default)) if isinstance(default, float) else value == default
