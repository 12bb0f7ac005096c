"""Values that a study gives to parameters, held against what these allow."""

from __future__ import annotations

from collections.abc import Mapping

from harness.study.definition import StudyError, shown
from mpm_warp.parameters import Parameter, ParameterError, Value, nearest_name


class KnownParameters:
    """The parameters that values are given to, and the place where, for messages."""

    def __init__(self, known: Mapping[str, Parameter], where: str) -> None:
        self.known = known
        self.where = where

    def definition(self, key: str, value: object) -> Parameter:
        """The parameter called `key`."""
        if key not in self.known:
            nearest = nearest_name(key, self.known)
            raise StudyError(
                f"{self.where} {key} = {shown(value)}: unknown parameter {key!r}{nearest}"
            )
        return self.known[key]

    def value(self, key: str, value: object) -> Value:
        """`value` in the parameter's own type."""
        definition = self.definition(key, value)
        place = f"{self.where} {key} = {shown(value)}"
        if not isinstance(value, Value) or (isinstance(value, int) and abs(value) >= 2**63):
            raise StudyError(f"{place} is not allowed: must be {definition.allowed}")
        try:
            checked = definition.checked(value)
        except ParameterError as error:
            raise StudyError(f"{self.where} {error}") from None
        assert checked is not None  # only None itself is checked to None
        return checked

    def values(self, key: str, values: object) -> tuple[Value, ...]:
        """The elements of a list, each once."""
        self.definition(key, values)
        place = f"{self.where} {key} = {shown(values)}"
        if not isinstance(values, list) or not values:
            raise StudyError(f"{place}: must be a list of one value or more, or a range")
        checked = tuple(self.value(key, value) for value in values)
        if len(set(checked)) < len(checked):
            twice = next(value for value in checked if checked.count(value) > 1)
            raise StudyError(f"{place}: {twice!r} is there twice")
        return checked
