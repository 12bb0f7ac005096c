"""Dataclasses that check and convert their declared fields, and their groups of such fields."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import Field
from types import UnionType
from typing import Any, ClassVar, NoReturn, Self, get_args, get_origin

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.fields.checks import check_array, check_kind, in_words
from mpm_warp.fields.declaration import (
    Derived,
    Parameter,
    Refused,
    groups_of,
    holders_of,
    own_parameters_of,
)


class Checked:
    """The base of dataclasses of a scene that check their fields.

    Declared fields are checked and converted. Another field of the type `bool`, of a `Checked`, or
    of a tuple of these must have this type. A field whose default is None may be None. A subclass
    with further checks calls `super().__post_init__()` first.

    Raises:
        SceneError: a value is not allowed; the message names class, field, value and range.
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __post_init__(self) -> None:
        try:
            check_fields(self)
        except (ParameterError, SceneError) as refusal:
            raise SceneError(f"{type(self).__name__}: {refusal}") from None


class Group:
    """The base of frozen dataclasses of parameters that belong together.

    A scene is composed of groups. Each checks its own parameters. A value that was not given, or is
    `Derived`, becomes the default, or that of `derived`.

    Raises:
        mpm_warp.errors.ParameterError: a value is not allowed.

    Example:
        >>> @dataclass(frozen=True, kw_only=True)
        ... class Ageing(Group):
        ...     rest: float = parameter(1.0, "time at rest", unit="d", minimum=1)
        >>> Ageing(rest=0)
        Traceback (most recent call last):
            ...
        mpm_warp.errors.ParameterError: rest = 0 is not allowed: must be a number >= 1; ...
    """

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __post_init__(self) -> None:
        check_fields(self, dict)
        self.check()
        fill_in(self, self.derived())

    def check(self) -> None:
        """Refuse values that do not go together."""

    def derived(self) -> Mapping[str, float]:
        """Default values of parameters that depend on others of the group."""
        return {}

    @property
    def kept(self) -> Self:
        """The group with its derived values as if they were given, to be handed to a scene."""
        values = ((field.name, getattr(self, field.name)) for field in dataclasses.fields(self))
        derived = {name: float(value) for name, value in values if isinstance(value, Derived)}
        return dataclasses.replace(self, **derived)


def refuse(owner: object, name: str, why: str) -> NoReturn:
    """Raise `ParameterError` with "name = value is not allowed", followed by `why`."""
    value = in_words(getattr(owner, name))
    raise ParameterError(name, f"{name} = {value} is not allowed{why}")


def compose(owner: Any, given: Mapping[str, Any]) -> None:
    """Set all fields of a dataclass from values of parameters, by their flat names, and groups.

    A group that is given takes the values that are given beside it.

    Raises:
        ParameterError: a value of a group is not allowed, or there is no value.
    """
    for field in dataclasses.fields(owner):
        name, kind = field.name, groups_of(type(owner)).get(field.name)
        if kind is None:
            value = given.get(name, field.default)
            if value is dataclasses.MISSING:
                raise ParameterError(name, f"{name}: must be given")
        else:
            own = {key: given[key] for key in own_parameters_of(kind) if key in given}
            if name in given:
                check_kind(name, given[name], kind)
            value = dataclasses.replace(given[name], **own) if name in given else kind(**own)
        complete(owner, **{name: value})


def check_fields(owner: Any, derived: Callable[[], Mapping[str, float]] | None = None) -> None:
    """Check and convert all fields of a dataclass, in its ``__post_init__``.

    With `derived` a value that was not given, or is `Derived`, becomes the default, and then
    `derived` gives values, by name, for those that have none.

    Raises:
        ParameterError: the value of a declared field is not allowed.
        SceneError: another field has a wrong type.
    """
    declared, groups = own_parameters_of(type(owner)), groups_of(type(owner))
    for field in dataclasses.fields(owner):
        name, value = field.name, getattr(owner, field.name)
        if name in groups:
            continue  # it has checked itself
        if name not in declared:
            if derived is not None:
                raise TypeError(f"{type(owner).__name__}.{name} is not made by `parameter`")
            if value is not None or field.default is not None:
                _check_type(name, value, field.type)
            continue
        definition = declared[name]
        if derived is not None and isinstance(value, Derived):
            value = definition.default
        if definition.variants is not None:
            value = definition.variants.value(value)
        elif definition.shape is not None:
            _check_shape(owner, definition, value)
        elif derived is None or not isinstance(value, Derived):
            value = definition.checked(value)
        complete(owner, **{name: value})
    if derived is not None:
        fill_in(owner, derived())


def complete(owner: object, **values: object) -> None:
    """Set fields of a frozen dataclass in its ``__post_init__``."""
    for name, value in values.items():
        object.__setattr__(owner, name, value)


def fill_in(owner: object, derived: Mapping[str, float]) -> None:
    """Check derived values and set the parameters that were not given, in their groups."""
    definitions = own_parameters_of(type(owner))
    holders = holders_of(type(owner))
    for name, value in derived.items():
        holder = getattr(owner, holders[name]) if name in holders else owner
        if isinstance(getattr(holder, name), Derived | None):
            complete(holder, **{name: Derived(definitions[name].checked(value))})


def _check_shape(owner: object, definition: Parameter, values: object) -> None:
    if values is None and definition.default is None:
        return
    lengths = [
        np.size(getattr(owner, it)) if isinstance(it, str) else it for it in definition.shape or ()
    ]
    try:
        check_array(definition.name, values, lengths, definition.bounds, error=Refused)
    except Refused as refusal:
        raise ParameterError(definition.name, str(refusal)) from None


def _check_type(name: str, value: Any, declared: Any) -> None:
    """Check a field that is not declared by :func:`parameter`."""
    if get_origin(declared) is tuple:
        check_kind(name, value, tuple)
        for number, item in enumerate(value):
            _check_type(f"{name}[{number}]", item, get_args(declared)[0])
    kinds = get_args(declared) if isinstance(declared, UnionType) else (declared,)
    if all(isinstance(kind, type) and issubclass(kind, Checked | bool | None) for kind in kinds):
        check_kind(name, value, kinds)
