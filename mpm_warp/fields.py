"""The definition of a parameter: meaning, unit, default and allowed range.

A scene is a frozen dataclass whose fields are made by :func:`parameter`. Validation, error
messages, help, documentation and the metadata of result files all use this definition.

Parameters that several scenes share are in a dataclass, a group, that the scenes inherit;
:func:`redefined` changes a parameter in one scene.
"""

import dataclasses
import functools
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from types import UnionType
from typing import Any, ClassVar, get_args, get_origin

import numpy as np

from mpm_warp.checks import FINITE, Range, check_array, check_kind, check_number, check_whole
from mpm_warp.errors import ParameterError
from mpm_warp.names import did_you_mean, nearest_parameter

Value = float | int | str | bool


class Derived(float):
    """The value of a parameter that was not given, derived from other parameters.

    ``dataclasses.replace`` derives it again, so that it agrees with the parameters that were
    changed. To keep the value, give it as a plain number: ``float(value)``. As the default of a
    parameter it is the value if neither the user nor another parameter gives one.
    """


@dataclass(frozen=True, kw_only=True)
class Variants:
    """Values that have a name and parameters of their own, as laws of clay have.

    The value of a parameter with variants has a `name`, its `own` values and their definitions,
    `parameters`, both by name. In flat form it is the name, and an own value is "parameter.own".
    """

    key: str  # of the name, where name and own parameters are given as a table
    names: Callable[[], Collection[str]]
    parameters: Callable[[str], Mapping[str, "Parameter"]]  # of a name; may raise `ParameterError`
    value: Callable[[object], Any]  # from a name, a table or a value


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """Definition of one parameter."""

    name: str  # field name in the scene
    kind: type  # ``float``, ``int``, ``bool`` or ``str``
    # None: the scene derives the value from others, or there may be none; `meaning` says which
    default: Value | None
    unit: str  # SI unit, "1" for a dimensionless number
    meaning: str  # one phrase for help, documentation and the long names of datasets
    bounds: Range = FINITE  # allowed range of a number
    choices: tuple[Value, ...] | None = None  # all allowed values; None: any value within `bounds`
    # range in which nearly all random cases of the scene complete (studies/stability.md); None: the
    # allowed range
    sane: tuple[float, float] | None = None
    optional: bool = False  # whether there may be no value: the type is ``float | None``
    variants: Variants | None = None  # of a parameter whose value has own parameters

    @property
    def allowed(self) -> str:
        """The allowed values as a text."""
        if self.choices is not None:
            return "one of " + ", ".join(repr(choice) for choice in self.choices)
        kind = {float: "a number", int: "an integer", bool: "true or false", str: "a text"}
        return f"{kind[self.kind]} {self.bounds.allowed}".strip()

    @property
    def explanation(self) -> str:
        """Meaning, unit and allowed values."""
        unit = "" if self.unit == "1" else f" [{self.unit}]"
        return f"{self.meaning}{unit}; {self.allowed}"

    def checked(self, value: object) -> Value | None:
        """`value` in the parameter's own type; `ParameterError` if it is not allowed."""
        if value is None and self.default is None:
            return None
        converted = self._converted(value)
        if converted is None or not self._contains(converted):
            is_near = isinstance(value, str) and self.choices is not None
            nearest = did_you_mean(str(value), map(str, self.choices or ())) if is_near else ""
            given = " ".join(repr(value).split())  # of an array several lines
            raise ParameterError(
                self.name,
                f"{self.name} = {given} is not allowed: must be {self.allowed}{nearest}",
            )
        return converted

    def _converted(self, value: object) -> Value | None:
        if isinstance(value, bool):
            return value if self.kind is bool else None
        if isinstance(value, np.generic):
            value = value.item()
        if self.kind is float and isinstance(value, (int, float)):
            return float(value) if abs(value) < 1e300 else None
        if self.kind is int and isinstance(value, float) and value.is_integer():
            return int(value)
        if self.kind in (int, str) and isinstance(value, self.kind):
            return typing.cast(Value, value)
        return None

    def _contains(self, value: Value) -> bool:
        if self.choices is not None:
            return value in self.choices
        if isinstance(value, str):
            return True
        return self.bounds.holds(value, value)


def parameter(
    default: Value | None,
    meaning: str,
    *,
    unit: str = "1",
    choices: tuple[Value, ...] | None = None,
    sane: tuple[float, float] | None = None,
    variants: Variants | None = None,
    **bounds: float,
) -> Any:
    """Declare a parameter as a field of a dataclass; the arguments are those of `Parameter`.

    The `bounds` are those of `Range`: minimum, maximum, above, below. The default is None if the
    scene derives the value from others, and the type is ``float``. It is None also if there may be
    no value, and the type is ``float | None``. `meaning` must say which.
    """
    choices = choices if variants is None else tuple(variants.names())
    definition: dict[str, Any] = {"unit": unit, "meaning": meaning, "choices": choices}
    definition |= {"sane": sane, "variants": variants}
    return dataclasses.field(default=default, metadata={**definition, "bounds": Range(**bounds)})


def redefined(group: type, name: str, **changes: Any) -> Any:
    """Declare a parameter of a group again with changed arguments of :func:`parameter`."""
    field = {field.name: field for field in dataclasses.fields(group)}[name]
    definition = {"default": field.default, **field.metadata}
    return parameter(**definition | dataclasses.asdict(definition.pop("bounds")) | changes)


_DEFINITIONS: dict[type, Mapping[str, Parameter]] = {}
"""Definitions by scene class: resolving type hints is slow, and a study has thousands of cases."""


def own_parameters_of(scene: type) -> Mapping[str, Parameter]:
    """The parameters of a scene class, by name, in the order of their declaration."""
    if scene not in _DEFINITIONS:
        _DEFINITIONS[scene] = {
            field.name: definition_of(scene, field) for field in dataclasses.fields(scene)
        }
    return _DEFINITIONS[scene]


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


def definition_of(owner: type, field: dataclasses.Field[Any]) -> Parameter:
    """The definition of a dataclass field made by :func:`parameter`."""
    hint = _type_hints(owner)[field.name]
    kinds = typing.get_args(hint) or (hint,)  # of ``float | None``, the two
    return Parameter(
        name=field.name,
        kind=str
        if field.metadata["variants"] is not None
        else next(kind for kind in kinds if kind is not types.NoneType),
        default=typing.cast(Value | None, field.default),
        optional=isinstance(hint, types.UnionType),
        **field.metadata,
    )


def check_own(owner: Any) -> None:
    """Check all fields made by :func:`parameter`; raises `ParameterError`."""
    for own in fields(owner):
        if "meaning" in own.metadata:
            definition_of(type(owner), own).checked(getattr(owner, own.name))


_type_hints = functools.cache(typing.get_type_hints)


def check_parameters(scene: object, derived: Callable[[], Mapping[str, float]]) -> None:
    """Check and convert every field of a scene in its ``__post_init__``; raises `ParameterError`.

    Then `derived` gives values, by name, for parameters that were not given.
    """
    for name, definition in own_parameters_of(type(scene)).items():
        given = getattr(scene, name)
        value = definition.default if isinstance(given, Derived) else given
        if definition.variants is not None:
            value = definition.variants.value(value)
        elif not isinstance(value, Derived):
            value = definition.checked(value)
        object.__setattr__(scene, name, value)
    fill_in(scene, derived())


def fill_in(scene: object, derived: Mapping[str, float]) -> None:
    """Check derived values and set the parameters of a scene that were not given."""
    definitions = own_parameters_of(type(scene))
    for name, value in derived.items():
        if isinstance(getattr(scene, name), Derived | None):
            checked = definitions[name].checked(value)
            assert isinstance(checked, float | int)
            object.__setattr__(scene, name, Derived(checked))


def check_names(scene: type, names: Iterable[str], known: Mapping[str, Parameter]) -> None:
    """Check that these parameters of a scene are known; the error says what to give instead."""
    for name in names:
        if name not in known:
            nearest = nearest_parameter(name, parameters_of(scene))
            raise ParameterError(name, f"unknown parameter {name!r}{nearest}")


def checked(allowed: Range = FINITE, *, unit: str = "", default: Any = MISSING) -> Any:
    """Declare a number as a field of a `Checked`; with the type `int` an integer."""
    return field(default=default, metadata={"allowed": allowed, "unit": unit})


def by_scene(allowed: Range, *, unit: str = "") -> Any:
    """Declare a number of a material that a scene of the catalogue gives; None until it does."""
    return checked(allowed, unit=unit, default=None)


def array_of(*shape: int | str | None, allowed: Range = FINITE) -> dict[str, Any]:
    """Metadata of an array field of a `Checked`.

    A name in the shape stands for the length of that field, None for any length.
    """
    return {"allowed": allowed, "shape": shape}


class Checked:
    """The base of dataclasses that check their fields.

    Numbers and arrays must be as `checked` and `array_of` declare them. A field of the type `bool`,
    of a `Checked`, or of a tuple of these must have this type. A field whose default is None may be
    None. A subclass with further checks calls `super().__post_init__()` first.

    Raises:
        SceneError: a value is not allowed; the message names class, field, value and range.
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __post_init__(self) -> None:
        for own in fields(self):
            name, value = f"{type(self).__name__}: {own.name}", getattr(self, own.name)
            if value is None and own.default is None:
                continue
            if "shape" in own.metadata:
                lengths = [
                    np.size(getattr(self, it)) if isinstance(it, str) else it
                    for it in own.metadata["shape"]
                ]
                check_array(name, value, lengths, own.metadata["allowed"])
            elif "allowed" in own.metadata and own.type is int:
                check_whole(name, value, own.metadata["allowed"])
            elif "allowed" in own.metadata:
                check_number(name, value, **own.metadata)
            elif not own.metadata:
                _check_declared(name, value, own.type)


def _check_declared(name: str, value: Any, declared: Any) -> None:
    if get_origin(declared) is tuple:
        check_kind(name, value, tuple)
        for number, item in enumerate(value):
            _check_declared(f"{name}[{number}]", item, get_args(declared)[0])
    kinds = get_args(declared) if isinstance(declared, UnionType) else (declared,)
    if all(
        isinstance(kind, type) and issubclass(kind, (Checked, bool, type(None))) for kind in kinds
    ):
        check_kind(name, value, kinds)
