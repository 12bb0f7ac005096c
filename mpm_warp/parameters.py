"""The one place where a parameter is defined: meaning, unit, default and allowed range.

A scene is a frozen dataclass whose fields are made by :func:`parameter`. Validation, error
messages, help texts, documentation and the metadata of result files all come from there.

Parameters that several scenes share stand in a dataclass of their own, a group, which the scenes
inherit; :func:`redefined` changes what differs in one of them.
"""

import dataclasses
import difflib
import functools
import types
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mpm_warp.aliases import SCENES, what_to_give
from mpm_warp.arguments import FINITE, Range
from mpm_warp.errors import ParameterError

Value = float | int | str | bool


class Derived(float):
    """The value of a parameter that was not given, worked out from the others.

    It is a number like any other, but is worked out anew wherever a scene is made from another by
    ``dataclasses.replace``, so that it goes with the parameters that were changed. To keep it as it
    is, give it as a plain number: ``float(value)``. As the default of a parameter it is the value
    where neither the user gives one nor another parameter says one.
    """


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """Definition of one parameter."""

    name: str  # field name in the scene
    kind: type  # ``float``, ``int``, ``bool`` or ``str``
    # value where none is given; None where the scene derives it from the others, or where there may
    # be none, as `meaning` says
    default: Value | None
    unit: str  # SI unit, "1" for a dimensionless number
    meaning: str  # one phrase for help, documentation and the long names of datasets
    bounds: Range = FINITE  # within which a number is allowed
    choices: tuple[Value, ...] | None = None  # all the values that are allowed, where there are few
    # least and greatest value between which nearly all random cases of the scene complete
    # (studies/stability.md); None where that is all that is allowed
    sane: tuple[float, float] | None = None
    optional: bool = False  # whether there may be no value, so that its type is ``float | None``

    @property
    def allowed(self) -> str:
        """What values are allowed, in words."""
        if self.choices is not None:
            return "one of " + ", ".join(repr(choice) for choice in self.choices)
        kind = {float: "a number", int: "an integer", bool: "true or false", str: "a text"}
        return f"{kind[self.kind]} {self.bounds.allowed}".strip()

    @property
    def explanation(self) -> str:
        """Its meaning, with the unit where there is one, and what values are allowed."""
        unit = "" if self.unit == "1" else f" [{self.unit}]"
        return f"{self.meaning}{unit}; {self.allowed}"

    def checked(self, value: object) -> Value | None:
        """`value` in the parameter's own type; `ParameterError` where it is not allowed."""
        if value is None and self.default is None:
            return None
        converted = self._converted(value)
        if converted is None or not self._contains(converted):
            is_near = isinstance(value, str) and self.choices is not None
            nearest = did_you_mean(str(value), map(str, self.choices or ())) if is_near else ""
            raise ParameterError(
                self.name,
                f"{self.name} = {value!r} is not allowed: must be {self.allowed}{nearest}",
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
    **bounds: float,
) -> Any:
    """Declare a parameter, as a field of a dataclass; the arguments are those of `Parameter`.

    The `bounds` are those of `Range`: minimum, maximum, above, below. The default is None where the
    scene derives the value from others: the parameter then always has a value, and its type is
    ``float``. It is None, too, where there may be no value: the type is then ``float | None``.
    `meaning` has to say which.
    """
    definition = {"unit": unit, "meaning": meaning, "choices": choices, "sane": sane}
    return dataclasses.field(default=default, metadata={**definition, "bounds": Range(**bounds)})


def redefined(group: type, name: str, **changes: Any) -> Any:
    """Declare a parameter of a group again; `changes` are arguments of :func:`parameter`."""
    field = {field.name: field for field in dataclasses.fields(group)}[name]
    definition = {"default": field.default, **field.metadata}
    return parameter(**definition | dataclasses.asdict(definition.pop("bounds")) | changes)


_DEFINITIONS: dict[type, Mapping[str, Parameter]] = {}
"""By scene: type hints take long to work out, and a study has thousands of cases."""


def parameters_of(scene: type) -> Mapping[str, Parameter]:
    """All parameters of a scene class, by name, in the order of their declaration."""
    if scene not in _DEFINITIONS:
        _DEFINITIONS[scene] = {
            field.name: definition_of(scene, field) for field in dataclasses.fields(scene)
        }
    return _DEFINITIONS[scene]


def definition_of(owner: type, field: dataclasses.Field[Any]) -> Parameter:
    """The definition of a field that is made by :func:`parameter`, of a dataclass."""
    hint = _type_hints(owner)[field.name]
    kinds = typing.get_args(hint) or (hint,)  # of ``float | None``, the two
    return Parameter(
        name=field.name,
        kind=next(kind for kind in kinds if kind is not types.NoneType),
        default=typing.cast(Value | None, field.default),
        optional=isinstance(hint, types.UnionType),
        **field.metadata,
    )


def check_own(owner: Any) -> None:
    """Raise `ParameterError` for a field made by :func:`parameter` with a value not allowed."""
    for field in dataclasses.fields(owner):
        if "meaning" in field.metadata:
            definition_of(type(owner), field).checked(getattr(owner, field.name))


_type_hints = functools.cache(typing.get_type_hints)


def check_parameters(scene: object, derived: Callable[[], Mapping[str, float]]) -> None:
    """Validate every field of a scene, in place; to be called from ``__post_init__``.

    Then `derived` is called: it gives the values of parameters for which none was given, by name.

    Raises:
        ParameterError: a value is not allowed.
    """
    definitions = parameters_of(type(scene))
    for name, definition in definitions.items():
        given = getattr(scene, name)
        value = definition.default if isinstance(given, Derived) else given
        if not isinstance(value, Derived):
            value = definition.checked(value)
        object.__setattr__(scene, name, value)
    fill_in(scene, derived())


def fill_in(scene: object, derived: Mapping[str, float]) -> None:
    """Give parameters of a scene values derived from others, checked, where none was given."""
    definitions = parameters_of(type(scene))
    for name, value in derived.items():
        if isinstance(getattr(scene, name), Derived | None):
            checked = definitions[name].checked(value)
            assert isinstance(checked, float | int)
            object.__setattr__(scene, name, Derived(checked))


def check_names(scene: type, names: Iterable[str]) -> None:
    """Raise `ParameterError`, which says what to give, where a scene has no such parameter."""
    known = parameters_of(scene)
    for name in names:
        if name not in known:
            raise ParameterError(
                name, f"unknown parameter {name!r}{nearest_parameter(name, known)}"
            )


def did_you_mean(name: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """A phrase that names the nearest valid name; "" where none is as like, 0 to 1, the same."""
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=likeness)
    return f"; did you mean {close[0]!r}?" if close else ""


def known_names(known: Iterable[str]) -> str:
    """A phrase that names all valid names; "" where there are none."""
    names = ", ".join(known)
    return f"; known: {names}" if names else ""


def nearest_name(name: str, known: Iterable[str]) -> str:
    """A phrase that names the nearest valid name, or all of them where none is near.

    A word of the field for a scene comes first. A name whose first words are given is near, however
    much longer it is.
    """
    names = list(known)
    meant = SCENES.get(name.lower(), "")
    if meant in names:
        return f"; did you mean {meant!r}?"
    begun = [longer for longer in names if longer.startswith(f"{name}_")]
    return did_you_mean(name, names) or did_you_mean(name, begun, 0.0) or known_names(names)


def nearest_parameter(name: str, known: Collection[str]) -> str:
    """A phrase that says what to give instead: what a word of the field means, or the nearest."""
    return what_to_give(name, known) or nearest_name(name, known)
