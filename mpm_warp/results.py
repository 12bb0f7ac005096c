"""Labelled variables: what a run leaves behind as a dataset, and the part that each plays in it."""

from collections.abc import Collection
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from mpm_warp.parameters import Parameter, Value, parameters_of

ROLES = {
    "headline": "the scalar that the scene is run for; one in each dataset",
    "uncertainty": "half width of the interval that holds the true headline with 95 %, or NaN",
    "reason": 'why U is not known, each reason as "word: sentence"; "" where it is',
    "settled": "whether the headline has settled; 0 where the run was too short for it",
    "exact": "an exact value or curve of the variable that the attribute `exact_of` names",
    "error": "a scalar error against an exact solution",
    "measured": "a time, a speed or a size in memory, which is another in every run",
    "built": "what the scene was built of, whatever its parameters are called",
    "parameter": "what was put in",
}
"""The parts that a variable can play in a dataset, its `role`; an ordinary result has none."""

SHARED_NAMES = ("displacement", "expansion", "penetration", "step_count", "stretch")
"""Parameters that have the name of a result: the axis of its curves, or what it took."""
PARAMETER_SUFFIX = "_parameter"
CHANGING_STRENGTH = "einav_randolph"
"""The law of clay that softens or has a rate effect, by a yield criterion."""


def variable(
    value: ArrayLike,
    *,
    unit: str | None = "1",
    meaning: str,
    description: str | None = None,
    dims: tuple[str, ...] = (),
    role: str | None = None,
    exact_of: str | None = None,
    limit: float | None = None,
) -> xr.Variable:
    """A labelled variable.

    Args:
        value: a number or a text, or numbers over `dims`.
        unit: SI unit; "1" for a dimensionless number; None for a text.
        meaning: a few words, fit for the axis of a picture.
        description: how the value came about, where that needs saying.
        dims: names of the dimensions.
        role: the part that it plays in the dataset, one of `ROLES`; None for an ordinary result.
        exact_of: name of the variable that this is the exact value of; its role is then "exact".
        limit: what the size of the value must not exceed, > 0; beyond it the run is inaccurate.
    """
    labels: dict[str, str | float] = {} if unit is None else {"units": unit}
    labels["long_name"] = meaning
    if description is not None:
        labels["description"] = description
    if exact_of is not None:
        role, labels["exact_of"] = "exact", exact_of
    if role is not None:
        assert role in ROLES, role
        labels["role"] = role
    if limit is not None:
        labels["limit"] = limit
    return xr.Variable(dims, np.asarray(value), labels)


Quantity = tuple[ArrayLike, str, str] | tuple[ArrayLike, str, str, str]
"""Value or values, unit, meaning and, where it needs one, a description."""


def labelled(
    *, dims: tuple[str, ...] = (), role: str | None = None, **quantities: Quantity
) -> dict[str, xr.Variable]:
    """Variables by name, over the same dimensions and of the same role.

    What is called ``x_exact`` is the exact value of ``x`` and has that role.
    """
    return {
        name: variable(
            value,
            unit=unit,
            meaning=meaning,
            description=description[0] if description else None,
            dims=dims,
            role=role,
            exact_of=name.removesuffix("_exact") if name.endswith("_exact") else None,
        )
        for name, (value, unit, meaning, *description) in quantities.items()
    }


def curves(axis: str, places: Quantity, **quantities: Quantity) -> xr.Dataset:
    """Curves over one axis, which is called `axis` and has the `places`."""
    coords = labelled(dims=(axis,), role=None, **{axis: places})
    return xr.Dataset(labelled(dims=(axis,), role=None, **quantities), coords=coords)


def stored_name(parameter: str, results: Collection[object]) -> str:
    """What a parameter is called in a dataset, where a result may have its name.

    One of `SHARED_NAMES` is called ``<name>_parameter`` whatever a run has left behind, so that a
    run which failed says the same by its names as one that did not. Dimensions are results too.
    """
    is_shared = parameter in SHARED_NAMES or parameter in results
    return f"{parameter}{PARAMETER_SUFFIX}" if is_shared else parameter


def material_as_built(material: str, law: str) -> str:
    """What the parameter `material` is stored as: the law built, where that is another.

    The law is "" where nothing was built. In clay whose strength changes it is the law of that
    change, and the criterion is the parameter's.
    """
    return material if law in ("", material, CHANGING_STRENGTH) else law


def parameter_variables(scene: Any, results: Collection[object]) -> dict[str, xr.Variable]:
    """All parameters of a scene as variables of its dataset, with the role "parameter".

    They are called as :func:`stored_name` says. A number that is not given is not a number, a text
    that is not given is empty; so is what others take the place of.
    """
    definitions = parameters_of(type(scene))
    given = {name: getattr(scene, name) for name in definitions}
    given |= dict.fromkeys(scene.replaced(given))
    return {
        stored_name(name, results): variable(
            _stored(given[name], definition),
            unit=None if definition.kind is str else definition.unit,
            meaning=name.replace("_", " "),
            description=f"{definition.meaning}; {definition.allowed}",
            role="parameter",
        )
        for name, definition in definitions.items()
    }


def _stored(value: Value | None, definition: Parameter) -> Value:
    if value is None:
        return "" if definition.kind is str else np.nan
    return value
