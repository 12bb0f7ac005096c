"""Parameters in flat form, as studies and results have them.

A parameter whose value has a name and parameters of its own, as a law of clay, becomes the name,
"material", and one entry for each of its own, "material.critical_state_ratio".
"""

import dataclasses
import functools
from collections.abc import Iterable, Mapping
from typing import Any

from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import FINITE
from mpm_warp.fields.declaration import Parameter, Value, Variants, own_parameters_of
from mpm_warp.fields.names import nearest_parameter


def parameters_of(scene: type) -> Mapping[str, Parameter]:
    """All parameters of a scene class in flat form: also those that only some variants have."""
    definitions: dict[str, Parameter] = {}
    for name, definition in own_parameters_of(scene).items():
        definitions[name] = definition
        if definition.variants is not None:
            definitions |= own_of_variants(definition.variants)
    return definitions


@functools.cache
def own_of_variants(variants: Variants) -> Mapping[str, Parameter]:
    """The own parameters of all variants that can be loaded; one of several has no bounds here."""
    found: dict[str, Parameter] = {}
    for variant in variants.names():
        try:
            own = variants.parameters(variant)
        except ParameterError:
            continue
        for definition in own.values():
            absent = dataclasses.replace(definition, default=None)
            if found.setdefault(definition.name, absent) != absent:
                found[definition.name] = dataclasses.replace(absent, bounds=FINITE, choices=None)
    return found


def flat_values(scene: object) -> dict[str, tuple[Parameter, Value | None]]:
    """Definitions and values of all parameters of a scene in flat form."""
    values: dict[str, tuple[Parameter, Value | None]] = {}
    for name, definition in own_parameters_of(type(scene)).items():
        value = getattr(scene, name)
        values[name] = definition, (value if definition.variants is None else value.name)
        if definition.variants is not None:
            own = value.parameters.items()
            values |= {f"{name}.{key}": (it, value.own[key]) for key, it in own}
    return values


def values_of(scene: object) -> dict[str, Value | None]:
    """The values of all parameters of a scene in flat form."""
    return {name: value for name, (_, value) in flat_values(scene).items()}


def nested_values(scene: type, flat: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of a scene from values in flat form, the inverse of `flat_values`.

    Raises:
        ParameterError: the scene has no parameter of a name.
    """
    check_names(scene, flat, parameters_of(scene))
    known = own_parameters_of(scene)
    values = {name: value for name, value in flat.items() if name in known}
    for name, definition in known.items():
        own = {
            key.removeprefix(f"{name}."): value
            for key, value in flat.items()
            if key.startswith(f"{name}.")
        }
        if own and definition.variants is not None:
            values[name] = {definition.variants.key: flat.get(name, definition.default), **own}
    return values


def check_names(scene: type, names: Iterable[str], known: Mapping[str, Parameter]) -> None:
    """Check that these parameters of a scene are known; the error says what to give instead."""
    for name in names:
        if name not in known:
            flat = parameters_of(scene)
            remedy = (
                _with_its_variant(scene, name) if name in flat else nearest_parameter(name, flat)
            )
            raise ParameterError(name, f"unknown parameter {name!r}{remedy}")


def _with_its_variant(scene: type, name: str) -> str:
    """How a parameter "material.its_parameter" is given in Python."""
    of_all, _, own = name.partition(".")
    variants = own_parameters_of(scene)[of_all].variants
    assert variants is not None
    return f"; give it with its {variants.key}, {of_all} = {{{variants.key!r}: .., {own!r}: ..}}"
