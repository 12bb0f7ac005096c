"""Reading the tables of a study file, with one-line errors.

An error names the place, the key, the value, what is allowed, and the nearest valid name.
"""

import re
import tomllib
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import MISSING, dataclass, field
from typing import Any, TypeGuard, TypeVar

from harness.errors import HarnessError, shortened
from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import shown
from mpm_warp.fields.declaration import Form, Parameter, Refused, Schema, Value
from mpm_warp.fields.flat import parameters_of
from mpm_warp.fields.names import nearest_name, nearest_parameter

LONGEST_MESSAGE = 400
QUOTED = r"\"[^\"]*\"|'[^']*'"
NOT_PLAIN = re.compile(r"[0-9]_[0-9]|\b0[xob]")
"""Numbers that TOML allows, and that are taken for a slip on a command line."""
BARE_WORD = r"(?<![\w\"'.])[A-Za-z_]\w*(?![\w\"'.]|\s*=)"
"""A word outside quotes that is no key."""
LONGEST_TEXT = 1000
"""Characters that a text, such as a title, may have; longer ones are mistakes."""

Made = TypeVar("Made")


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

    def missing(self, declared: Parameter) -> StudyError:
        """The error to raise for a key that must be given."""
        return StudyError(f"{self.where} {declared.name}: is missing; {declared.explanation}")

    def read(self, declared: Parameter) -> Any:
        """The value of a declared key; its default if it is missing."""
        if declared.name in self.values:
            return self._checked(self.values[declared.name], declared)
        if declared.is_required:
            raise self.missing(declared)
        return declared.default

    def made(self, owner: type[Made], **others: Any) -> Made:
        """A dataclass whose declared fields are keys of this table, with `others`."""
        declared = parameters_of(owner)
        for key in declared.values():
            if key.is_required and key.name not in self.values:
                raise self.missing(key)
        given = {name: key.name for name, key in declared.items() if key.name in self.values}
        try:
            return owner(**{name: self.values[key] for name, key in given.items()}, **others)
        except ParameterError as refusal:
            raise StudyError(f"{self.where} {refusal}") from None

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
        value: Value = self.read(self.definition(key))
        return value

    def all_values(self) -> dict[str, Value]:
        """The checked values of all parameters in the table."""
        return {key: self.value(key) for key in self.values}

    def check_variants(self) -> None:
        """Refuse a law that is unknown or cannot be loaded, before parameters that only it has."""
        for key, definition in self.known.items():
            if definition.variants is None:
                continue
            given = self.values.get(key)
            for name in given if isinstance(given, list) else [given]:
                if isinstance(name, str):
                    try:
                        definition.variants.parameters(definition.checked(name))
                    except ParameterError as refusal:
                        raise StudyError(f"{self.where} {refusal}") from None

    def several(self, key: str) -> tuple[Value, ...]:
        """The checked values of a parameter that is given as a list; all must differ."""
        definition, values = self.definition(key), self.values[key]
        if not isinstance(values, list) or not values:
            remedy = "; a single value belongs under [fixed]" if isinstance(values, Value) else ""
            raise self.refuse(key, f"must be a list of values, or a range{remedy}")
        if definition.variants is not None and any(isinstance(value, dict) for value in values):
            one = f"vary what one of them has as {key}.its_parameter = [..]"
            raise self.refuse(key, f"a list has names alone; {one}")
        checked = tuple(self._checked(value, definition) for value in values)
        if len(set(checked)) < len(checked):
            (twice, _), *_ = Counter(checked).most_common(1)
            raise self.refuse(key, f"{twice!r} is listed twice")
        return checked

    def _checked(self, value: object, declared: Parameter) -> Any:
        try:
            return declared.checked(value)
        except ParameterError as refusal:
            raise StudyError(f"{self.where} {refusal}") from None


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
    quoted = re.sub(BARE_WORD, r'"\g<0>"', text)
    if text.startswith(("[", "{")) and _is_toml(quoted):
        return f"a text in it needs quotes: '{key}={quoted}'"
    if re.fullmatch(r"[A-Za-z][\w .-]*", text):
        return f"a text of more than one word needs two kinds of quotes: '{key}=\"{text}\"'"
    return "a number, a text or a list"


def _is_toml(text: str) -> bool:
    try:
        return tomllib.loads(f"value = {text}").keys() == {"value"}
    except (ValueError, RecursionError):
        return False


def is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a finite number, and not true or false."""
    return isinstance(value, (int, float)) and type(value) is not bool and abs(value) < 1e300


def _line(value: object, declared: Parameter) -> str:
    if not (isinstance(value, str) and value.strip() and value.isprintable()):
        raise Refused("must be a text of one line")
    if len(value) > LONGEST_TEXT:
        raise Refused(f"has {len(value)} characters; a text has at most {LONGEST_TEXT}")
    return value


LINE = Form("a text of one line", _line, lambda declared: [{"type": "string", "pattern": "\\S"}])
"""The form of titles and names."""


def text_key(name: str, meaning: str, default: object = MISSING) -> Parameter:
    """The declaration of a key whose value is a text of one line."""
    return Parameter(name=name, kind=str, default=default, meaning=meaning, form=LINE)


def keys_of(owner: type) -> list[str]:
    """The keys of the declared fields of a dataclass."""
    return [declared.name for declared in parameters_of(owner).values()]


def table_schema(properties: Schema, **more: object) -> Schema:
    """The schema of a table that may have these keys and no others."""
    return {"type": "object", "properties": properties, "additionalProperties": False, **more}


def schema_of(declared: Collection[Parameter], **more: Schema) -> Schema:
    """The schema of a table whose keys are declared fields, and of `more` keys."""
    properties = {it.name: it.schema for it in declared} | more
    return table_schema(properties, required=[it.name for it in declared if it.is_required])
