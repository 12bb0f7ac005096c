"""Tables of a study file, asked for their keys; what is wrong is reported in one line.

The line names the place, the key, the value, what is allowed, and the nearest valid name.
"""

import re
import tomllib
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeGuard

from harness.errors import HarnessError, shortened
from mpm_warp.errors import ParameterError
from mpm_warp.parameters import Parameter, Value, did_you_mean, nearest_name, nearest_parameter

LONGEST_MESSAGE = 400
LONGEST_TEXT = 1000
"""Characters that a text may have; a title of more is a mistake, and would be printed whole."""


class StudyError(HarnessError):
    """What is read of a study or a setting is wrong; one printable line of bounded length."""

    def __init__(self, message: str) -> None:
        super().__init__(shortened(message, LONGEST_MESSAGE))


@dataclass(frozen=True)
class Table:
    """A TOML table: for messages its file and name, its keys and values, and known parameters."""

    where: str
    values: Mapping[str, Any]
    known: Mapping[str, Parameter] = field(default_factory=dict)

    def place(self, key: str) -> str:
        """Where a key stands, with its value, for messages."""
        return f"{self.where} {key} = {shown(self.values.get(key))}"

    def refuse(self, key: str, problem: str) -> StudyError:
        """The error for a key of this table."""
        return StudyError(f"{self.place(key)}: {problem}")

    def allow(self, *keys: str) -> None:
        """Refuse every key that is not among `keys`."""
        for key in self.values:
            if key not in keys:
                raise self.refuse(key, f"unknown key{nearest_name(key, keys)}")

    def table(self, key: str) -> "Table":
        """The table [key], empty where there is none."""
        value = self.values.get(key, {})
        if not isinstance(value, dict):
            raise self.refuse(key, f"must be a table [{key}]")
        return Table(f"{self.where} [{key}]", value, self.known)

    def given(self, key: str, remedy: str) -> Any:
        """The value of a key that must be there; `remedy` says what to do where it is not."""
        if key not in self.values:
            raise StudyError(f"{self.where} {key}: is missing{remedy}")
        return self.values[key]

    def text(self, key: str, remedy: str = "") -> str:
        """A text of one line that must be there; `remedy` as in :meth:`given`."""
        value = self.given(key, remedy)
        if not (isinstance(value, str) and value.strip() and value.isprintable()):
            raise self.refuse(key, "must be a text of one line")
        if len(value) > LONGEST_TEXT:
            problem = f"has {len(value)} characters; a text has at most {LONGEST_TEXT}"
            raise self.refuse(key, problem)
        return value

    def word(self, key: str, choices: Collection[str]) -> str:
        """One of `choices`; the first where the key is not there."""
        value = self.values.get(key, next(iter(choices)))
        if not isinstance(value, str) or value not in choices:
            near = did_you_mean(value, choices) if isinstance(value, str) else ""
            raise self.refuse(key, f"must be one of {', '.join(choices)}{near}")
        return value

    def integer(self, key: str, least: int, most: int) -> int:
        """An integer that must be there."""
        value = self.given(key, f"; an integer, {least} to {most}")
        if type(value) is not int or not least <= value <= most:
            raise self.refuse(key, f"must be an integer, {least} to {most}")
        return value

    def positive(self, key: str) -> float:
        """A finite number above 0; the key is there."""
        value = self.values[key]
        if not (is_number(value) and value > 0):
            raise self.refuse(key, "must be a number > 0")
        return float(value)

    def list(self, key: str) -> list[Any]:
        """A list, empty where there is none."""
        value = self.values.get(key, [])
        if not isinstance(value, list):
            raise self.refuse(key, "must be a list")
        return value

    def definition(self, key: str) -> Parameter:
        """The parameter called `key`."""
        if key not in self.known:
            nearest = nearest_parameter(key, self.known)
            raise self.refuse(key, f"unknown parameter {key!r}{nearest}")
        return self.known[key]

    def value(self, key: str) -> Value:
        """The value of a parameter, in the parameter's own type."""
        return self._checked(key, self.values[key])

    def all_values(self) -> dict[str, Value]:
        """The values of all parameters that stand in the table."""
        return {key: self.value(key) for key in self.values}

    def several(self, key: str) -> tuple[Value, ...]:
        """The elements of a list, which are all different."""
        self.definition(key)
        values = self.values[key]
        if not isinstance(values, list) or not values:
            remedy = "; one value belongs under [fixed]" if isinstance(values, Value) else ""
            raise self.refuse(key, f"must be a list of one value or more, or a range{remedy}")
        checked = tuple(self._checked(key, value) for value in values)
        if len(set(checked)) < len(checked):
            (twice, _), *_ = Counter(checked).most_common(1)
            raise self.refuse(key, f"{twice!r} is there twice")
        return checked

    def _checked(self, key: str, value: object) -> Value:
        definition = self.definition(key)
        if not isinstance(value, Value) or (isinstance(value, int) and abs(value) >= 2**63):
            raise StudyError(
                f"{self.where} {key} = {shown(value)} is not allowed: must be {definition.allowed}"
            )
        try:
            checked = definition.checked(value)
        except ParameterError as error:
            unit = "" if definition.unit == "1" else f", in {definition.unit}"
            what = "" if definition.choices else f"; it is the {definition.meaning}{unit}"
            raise StudyError(f"{self.where} {error}{what}") from None
        assert checked is not None  # only None itself is checked to None
        return checked


def parse_setting(setting: str) -> tuple[str, Any]:
    """Key and TOML value of a ``key=value`` from the command line; a bare word is a text."""
    key, equals, text = (part.strip() for part in setting.partition("="))
    if not (key and equals and text):
        raise StudyError(f"--set {setting}: must be key=value, without blanks around the =")
    if re.fullmatch(r"[A-Za-z_]\w*", text) and text not in ("true", "false", "inf", "nan"):
        return key, text
    return key, parse_value(f"--set {setting}", key, text)


def parse_value(option: str, key: str, text: str) -> Any:
    """The TOML value of a key, given with an option of the command line."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    if parsed.keys() != {"value"}:
        raise StudyError(f"{option}: {text} is not a TOML value: {_meant(key, text)}")
    return parsed["value"]


def _meant(key: str, text: str) -> str:
    """What may be meant by the text of a setting that is no value."""
    if number := re.fullmatch(r"([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([A-Za-z%°][\w/%°]*)", text):
        return f"give the number alone, in the unit of the parameter instead of {number[2]}"
    if re.fullmatch(r"\d[\d.]*(,\s*[\d.]+)+", text):
        return f"several values stand in brackets: '{key}=[{text}]'"
    if re.fullmatch(r"[A-Za-z][\w .-]*", text):
        return f"a text of more than one word needs two kinds of quotes: '{key}=\"{text}\"'"
    return "a number, a text or a list"


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value of a table is a finite number."""
    return isinstance(value, (int, float)) and type(value) is not bool and abs(value) < 1e300


def shown(value: object) -> str:
    """A value for a message; huge integers and deeply dotted tables have no text."""
    try:
        return repr(value)
    except (ValueError, RecursionError):
        return "(too long to show)"
