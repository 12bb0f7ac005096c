"""The declaration of a field: meaning, unit, allowed values and default, each said once.

The fields of a frozen dataclass are made by :func:`parameter`: parameters of a scene or a law,
numbers and arrays of a part, keys of a file. Conversion, the error of one line, help, the JSON
schema and the lines of a new file all follow from the declaration.

Parameters that belong together are a dataclass, a group, and a scene has it as a field, made by
:func:`group`. Outside they are as flat as if they were its own. :func:`redefined` declares a
parameter again with changes.
"""

import dataclasses
import functools
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, Field, dataclass
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import FINITE, Range, shown
from mpm_warp.fields.names import did_you_mean

Value = float | int | str | bool
Schema = dict[str, Any]
TYPES = {float: "number", int: "integer", bool: "boolean", str: "string"}
WORDS = {float: "a number", int: "an integer", bool: "true or false", str: "a text"}
LARGEST = {float: 1e300, int: 2**63}
"""Sizes that no number may reach; files of results hold integers of 64 bits."""


class Derived(float):
    """The value of a parameter that was not given, derived from other parameters.

    ``dataclasses.replace`` derives it again, so that it agrees with the parameters that were
    changed. To keep the value, give it as a plain number: ``float(value)``. As the default of a
    parameter it is the value if neither the user nor another parameter gives one.
    """


class Refused(ValueError):
    """A value is not allowed; the message says what it must be."""


@dataclass(frozen=True)
class Form:
    """How a file writes a value that is neither a number nor a word, such as an uncertain input."""

    words: str  # what is allowed; the bounds of its numbers follow
    read: Callable[[Any, "Parameter"], Any]  # the value from what is written; may raise `Refused`
    schemas: Callable[["Parameter"], list[Schema]]  # JSON schemas, of which one must hold


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
    """The declaration of one field."""

    name: str  # of the field, or its key in a file
    kind: type  # ``float``, ``int``, ``bool`` or ``str``; another one if it has a `form`
    # None: there may be no value, or it is derived from others; `meaning` says which.
    # MISSING: it must be given
    default: Any
    unit: str = "1"  # SI unit, "1" for a dimensionless number
    meaning: str  # one phrase for help, documentation and the long names of datasets
    bounds: Range = FINITE  # allowed range of a number, or of all numbers of an array
    choices: tuple[Value, ...] | None = None  # all allowed values; None: any value within `bounds`
    # range in which nearly all random cases of the scene complete (studies/stability.md); None: the
    # allowed range
    sane: tuple[float, float] | None = None
    # of an array: its lengths; a name stands for the length of that field, None for any length
    shape: tuple[int | str | None, ...] | None = None
    form: Form | None = None  # None: a plain value
    optional: bool = False  # whether there may be no value: the type is ``float | None``
    variants: Variants | None = None  # of a parameter whose value has own parameters

    @property
    def is_required(self) -> bool:
        """Whether it must be given."""
        return self.default is MISSING

    @property
    def allowed(self) -> str:
        """The allowed values as a text."""
        words = ", ".join(map(repr, self.choices or ()))
        if self.form is None and words:
            return f"one of {words}"
        what = WORDS[self.kind] if self.form is None else self.form.words
        return f"{what} {self.bounds.allowed}".strip() + (words and f", or {words}")

    @property
    def explanation(self) -> str:
        """Meaning, unit and allowed values."""
        return f"{self.meaning}{self.in_unit}; {self.allowed}"

    @property
    def in_unit(self) -> str:
        """The unit in brackets after a blank; "" if it has none."""
        return "" if self.unit == "1" else f" [{self.unit}]"

    @property
    def schema(self) -> Schema:
        """The JSON schema of a value."""
        choices = None if self.choices is None else {"enum": list(self.choices)}
        if self.form is None:
            forms = {"type": TYPES[self.kind], **bounds_schema(self.bounds), **(choices or {})}
        else:
            forms = {"anyOf": [*self.form.schemas(self), *([choices] if choices else [])]}
        default = None if self.is_required else self.default
        schema = {"description": self.explanation, **forms, "default": default}
        return {key: value for key, value in schema.items() if value is not None}

    def checked(self, value: object) -> Any:
        """`value` in the field's own type; `ParameterError` if it is not allowed."""
        if value is None and self.default is None:
            return None
        try:
            return self._read(value)
        except Refused as refusal:
            unit = "" if self.unit == "1" else f", in {self.unit}"
            meaning = "" if self.choices else f"; meaning: {self.meaning}{unit}"
            raise ParameterError(
                self.name, f"{self.name} = {shown(value)} is not allowed: {refusal}{meaning}"
            ) from None

    def _read(self, value: object) -> Any:
        if self.form is not None:
            return self.form.read(value, self)
        converted = _converted(value, self.kind)
        if converted is None or not self._contains(converted):
            near = (
                did_you_mean(value, map(str, self.choices or ())) if isinstance(value, str) else ""
            )
            is_open = self.choices is None and math.isinf(
                min(self.bounds.maximum, self.bounds.below)
            )
            limit = _size_limit(value, self.kind) if is_open else ""
            raise Refused(f"must be {self.allowed}{limit}{near}")
        return converted

    def _contains(self, value: Value) -> bool:
        if self.choices is not None:
            return value in self.choices
        return isinstance(value, str) or self.bounds.holds(value, value)


def _converted(value: object, kind: type) -> Value | None:
    """A value in one of the plain types; None if it has another."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return value if kind is bool else None
    if _size_limit(value, kind):
        return None
    if kind is float and isinstance(value, float | int):
        return float(value) if math.isfinite(value) else None
    if kind is int and isinstance(value, float) and value.is_integer():
        return int(value)
    return value if kind in (int, str) and isinstance(value, kind) else None


def _size_limit(value: object, kind: type) -> str:
    """The end of a message on a number that is too large; "" for any other value."""
    most = LARGEST.get(kind)
    if most is None or not isinstance(value, float | int) or not abs(value) >= most:
        return ""
    return f", smaller than {most:g}"


def parameter(
    default: Any = MISSING,
    meaning: str = "",
    *,
    unit: str = "1",
    choices: tuple[Value, ...] | None = None,
    sane: tuple[float, float] | None = None,
    variants: Variants | None = None,
    shape: tuple[int | str | None, ...] | None = None,
    form: Form | None = None,
    key: str = "",
    **bounds: float,
) -> Any:
    """Declare a field of a dataclass; the arguments are those of `Parameter`.

    Without a default it must be given. The `bounds` are those of `Range`: minimum, maximum, above,
    below. The default is None if the scene derives the value from others, and the type is
    ``float``. It is None also if there may be no value, and the type is ``float | None``. `meaning`
    must say which. `key` is the name in files, if it differs from that of the field.

    Example:
        >>> @dataclass(frozen=True, kw_only=True)
        ... class Ageing(Group):
        ...     rest: float = parameter(1.0, "time at rest", unit="d", minimum=1)
        >>> Ageing().rest
        1.0
    """
    choices = choices if variants is None else tuple(variants.names())
    definition = {"default": default, "unit": unit, "meaning": meaning, "choices": choices}
    definition |= {"sane": sane, "variants": variants, "shape": shape, "form": form, "key": key}
    definition["bounds"] = Range(**bounds)
    if isinstance(default, list | dict | np.ndarray):
        return dataclasses.field(default_factory=default.copy, metadata=definition)
    return dataclasses.field(default=default, metadata=definition)


def group() -> Any:
    """Declare a field that is a group of parameters; its type, a dataclass, says which.

    Example:
        >>> @dataclass(frozen=True, kw_only=True)
        ... class Ageing(Group):
        ...     rest: float = parameter(1.0, "time at rest", unit="d", minimum=1)
        >>> @dataclass(frozen=True, kw_only=True)
        ... class ConeInAgedClay(ConePenetration):
        ...     ageing: Ageing = group()
        >>> ConeInAgedClay(rest=30, rigidity_index=80).ageing
        Ageing(rest=30.0)
    """
    return dataclasses.field(metadata={"group": True})


def redefined(owner: type, name: str, **changes: Any) -> Any:
    """Declare a parameter of a dataclass again with changed arguments of :func:`parameter`.

    Example:
        >>> @dataclass(frozen=True, kw_only=True)
        ... class LongFlight(FlyingBlock):
        ...     travel: float = redefined(FlyingBlock, "travel", default=2.0)
        >>> LongFlight().travel
        2.0
    """
    declared = dict({field.name: field for field in dataclasses.fields(owner)}[name].metadata)
    return parameter(**declared | dataclasses.asdict(declared.pop("bounds")) | changes)


_type_hints = functools.cache(get_type_hints)


_DECLARED: dict[type, Mapping[str, Parameter]] = {}
_GROUPS: dict[type, Mapping[str, Any]] = {}
_HOLDERS: dict[type, Mapping[str, str]] = {}
"""Declared fields and groups by class: resolving types is slow, and a study has thousands of cases.
"""


def own_parameters_of(owner: type) -> Mapping[str, Parameter]:
    """The declared fields of a dataclass and of its groups, by name, in their order.

    Raises:
        TypeError: two groups have a parameter of one name, or a class with fields is no dataclass.
    """
    if owner not in _DECLARED:
        for kind in owner.__mro__:
            for name, it in vars(kind).items():
                if isinstance(it, dataclasses.Field):  # which `dataclass` would have taken away
                    raise TypeError(
                        f"{kind.__name__}.{name} is no field yet: put @dataclass(frozen=True, "
                        f"kw_only=True) above class {kind.__name__}"
                    )
        declared: dict[str, Parameter] = {}
        for field in dataclasses.fields(owner):
            own: Mapping[str, Parameter] = {}
            if field.metadata.get("group"):
                own = own_parameters_of(_hint(owner, field))
            elif "meaning" in field.metadata:
                own = {field.name: definition_of(owner, field)}
            if twice := own.keys() & declared.keys():
                raise TypeError(f"{owner.__name__} has two parameters {min(twice)!r}")
            declared |= own
        _DECLARED[owner] = declared
    return _DECLARED[owner]


def groups_of(owner: type) -> Mapping[str, Any]:
    """The classes of the groups of a dataclass, by the names of their fields."""
    if owner not in _GROUPS:
        declared = (it for it in dataclasses.fields(owner) if it.metadata.get("group"))
        _GROUPS[owner] = {field.name: _hint(owner, field) for field in declared}
    return _GROUPS[owner]


def holders_of(owner: type) -> Mapping[str, str]:
    """The fields of the groups of a dataclass, by the names of the parameters that they have."""
    if owner not in _HOLDERS:
        groups = groups_of(owner).items()
        _HOLDERS[owner] = {name: it for it, kind in groups for name in own_parameters_of(kind)}
    return _HOLDERS[owner]


def definition_of(owner: type, field: Field[Any]) -> Parameter:
    """The declaration of a field made by :func:`parameter`."""
    hint = _hint(owner, field)
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    declared = dict(field.metadata)
    return Parameter(
        name=declared.pop("key") or field.name,
        kind=str if declared["variants"] else next(it for it in kinds if it is not NoneType),
        optional=NoneType in kinds,
        **declared,
    )


def _hint(owner: type, field: Field[Any]) -> Any:
    return _type_hints(owner)[field.name] if isinstance(field.type, str) else field.type


def bounds_schema(allowed: Range) -> Schema:
    """The JSON schema keywords for the bounds of a number."""
    bounds = {
        "minimum": allowed.minimum,
        "maximum": allowed.maximum,
        "exclusiveMinimum": allowed.above,
        "exclusiveMaximum": allowed.below,
    }
    return {name: bound for name, bound in bounds.items() if math.isfinite(bound)}
