"""Reading the tables of a study file, with one-line errors.

An error names the place, the key, the value, what is allowed, and the nearest valid name.
"""

import re
import tomllib
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeGuard

from harness.errors import HarnessError, shortened
from mpm_warp.errors import ParameterError
from mpm_warp.fields import Parameter, Value
from mpm_warp.names import did_you_mean, nearest_name, nearest_parameter

LONGEST_MESSAGE = 400
QUOTED = r"\"[^\"]*\"|'[^']*'"
NOT_PLAIN = re.compile(r"[0-9]_[0-9]|\b0[xob]")
"""Numbers that TOML allows, and that are taken for a slip on a command line."""
LONGEST_TEXT = 1000
"""Characters that a text, such as a title, may have; longer ones are mistakes."""


class StudyError(HarnessError):
    """A study file or a setting is wrong. The message is one printable line of limited length.

    `whole` is the message before it is shortened.
    """

    def __init__(self, message: str) -> None:
        self.whole = message
        super().__init__(shortened(message, LONGEST_MESSAGE))


@dataclass(frozen=True)
class Table:
    """A table of a TOML file."""

    where: str  # file and name of the table, as messages begin with them
    values: Mapping[str, Any]
    known: Mapping[str, Parameter] = field(default_factory=dict)  # parameters that may be keys

    def place(self, key: str) -> str:
        """The place of a key and its value, for messages."""
        return f"{self.where} {key} = {shown(self.values.get(key))}"

    def refuse(self, key: str, problem: str) -> StudyError:
        """The error to raise for a key of this table."""
        return StudyError(f"{self.place(key)}: {problem}")

    def allow(self, *keys: str) -> None:
        """Refuse every key that is not among `keys`."""
        for key in self.values:
            if key not in keys:
                raise self.refuse(key, f"unknown key{nearest_name(key, keys)}")

    def table(self, key: str) -> "Table":
        """The table [key]; an empty one if the key is missing."""
        value = self.values.get(key, {})
        if not isinstance(value, dict):
            raise self.refuse(key, f"must be a table [{key}]")
        return Table(f"{self.where} [{key}]", value, self.known)

    def given(self, key: str, remedy: str) -> Any:
        """The value of a required key; if it is missing, `remedy` ends the error message."""
        if key not in self.values:
            raise StudyError(f"{self.where} {key}: is missing{remedy}")
        return self.values[key]

    def text(self, key: str, remedy: str = "") -> str:
        """A required text of one line; `remedy` as in :meth:`given`."""
        value = self.given(key, remedy)
        if not (isinstance(value, str) and value.strip() and value.isprintable()):
            raise self.refuse(key, "must be a text of one line")
        if len(value) > LONGEST_TEXT:
            problem = f"has {len(value)} characters; a text has at most {LONGEST_TEXT}"
            raise self.refuse(key, problem)
        return value

    def word(self, key: str, choices: Collection[str]) -> str:
        """One of `choices`; the first of them if the key is missing."""
        value = self.values.get(key, next(iter(choices)))
        if not isinstance(value, str) or value not in choices:
            near = did_you_mean(value, choices) if isinstance(value, str) else ""
            raise self.refuse(key, f"must be one of {', '.join(choices)}{near}")
        return value

    def integer(self, key: str, least: int, most: int) -> int:
        """A required integer from `least` to `most`."""
        value = self.given(key, f"; an integer, {least} to {most}")
        if type(value) is not int or not least <= value <= most:
            raise self.refuse(key, f"must be an integer, {least} to {most}")
        return value

    def positive(self, key: str) -> float:
        """A finite number above 0 under a key that is known to be there."""
        value = self.values[key]
        if not (is_number(value) and value > 0):
            raise self.refuse(key, "must be a number > 0")
        return float(value)

    def list(self, key: str) -> list[Any]:
        """A list; an empty one if the key is missing."""
        value = self.values.get(key, [])
        if not isinstance(value, list):
            raise self.refuse(key, "must be a list")
        return value

    def definition(self, key: str) -> Parameter:
        """The definition of the parameter called `key`."""
        if key not in self.known:
            nearest = nearest_parameter(key, self.known)
            raise self.refuse(key, f"unknown parameter {key!r}{nearest}")
        return self.known[key]

    def value(self, key: str) -> Value:
        """The checked value of a parameter, converted to the parameter's type."""
        return self._checked(key, self.values[key])

    def all_values(self) -> dict[str, Value]:
        """The checked values of all parameters in the table."""
        return {key: self.value(key) for key in self.values}

    def several(self, key: str) -> tuple[Value, ...]:
        """The checked values of a parameter that is given as a list; all must differ."""
        self.definition(key)
        values = self.values[key]
        if not isinstance(values, list) or not values:
            remedy = "; a single value belongs under [fixed]" if isinstance(values, Value) else ""
            raise self.refuse(key, f"must be a list of values, or a range{remedy}")
        checked = tuple(self._checked(key, value) for value in values)
        if len(set(checked)) < len(checked):
            (twice, _), *_ = Counter(checked).most_common(1)
            raise self.refuse(key, f"{twice!r} is listed twice")
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
            what = "" if definition.choices else f"; meaning: {definition.meaning}{unit}"
            raise StudyError(f"{self.where} {error}{what}") from None
        assert checked is not None  # only None itself is checked to None
        return checked


def parse_setting(setting: str) -> tuple[str, Any]:
    """Key and value of a ``key=value`` from the command line; a bare word is a text."""
    key, equals, text = (part.strip() for part in setting.partition("="))
    if not (key and equals and text):
        raise StudyError(f"--set {setting}: must be key=value, without blanks around the =")
    if re.fullmatch(r"[A-Za-z_]\w*", text) and text not in ("true", "false", "inf", "nan"):
        return key, text
    return key, parse_value(f"--set {setting}", key, text)


def parse_value(option: str, key: str, text: str) -> Any:
    """The TOML value that an option of the command line gives to a key."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    if NOT_PLAIN.search(re.sub(QUOTED, "", text)):
        raise StudyError(f"{option}: {text} is not allowed: a number is written as 10 or 1.5e-3")
    if parsed.keys() != {"value"}:
        raise StudyError(f"{option}: {text} is not a TOML value: {_remedy(key, text)}")
    return parsed["value"]


def _remedy(key: str, text: str) -> str:
    """How to correct a setting whose text is not a TOML value."""
    if re.search(r"\d{1000}", text):
        return "a number has too many digits"
    if number := re.fullmatch(r"([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([A-Za-z%°][\w/%°]*)", text):
        return f"give the number without {number[2]}, in the unit of the parameter"
    if re.fullmatch(r"\d[\d.]*(,\s*[\d.]+)+", text):
        return f"put several values in brackets: '{key}=[{text}]'"
    if re.fullmatch(r"[A-Za-z][\w .-]*", text):
        return f"a text of more than one word needs two kinds of quotes: '{key}=\"{text}\"'"
    return "a number, a text or a list"


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a finite number, and not true or false."""
    return isinstance(value, (int, float)) and type(value) is not bool and abs(value) < 1e300


def shown(value: object) -> str:
    """A value as text for a message. Huge integers and deeply nested tables cannot be shown."""
    try:
        return repr(value)
    except (ValueError, RecursionError):
        return "(too long to show)"
