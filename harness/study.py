"""A study definition: read from TOML, changed by ``--set``, validated before anything runs.

A definition is data, nothing in it is executed::

    title = "Cone factor against the adhesion of the cone face"
    scene = "cone_penetration"

    [fixed]
    rigidity_index = 100

    [vary]
    adhesion_factor = [0, 0.5, 1]

    [compare]
    references = ["lu_2004"]

    [timing]
    repeats = 5
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from harness import HarnessError
from harness.references import reference_ids
from mpm_warp.parameters import Parameter, ParameterError, Value, nearest_name, parameters_of
from mpm_warp.scenes import UnknownSceneError, scene_class, scene_names

LARGEST_FILE = 1_000_000
"""Bytes that a definition may have; what is larger is not a study but a mistake."""
LONGEST_MESSAGE = 400
MOST_REPEATS = 1000
"""Timed runs that a study may ask for; more is a slip."""


class StudyError(HarnessError):
    """A study definition is wrong; the message is one printable line of bounded length."""

    def __init__(self, message: str) -> None:
        line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in message[:10_000])
        half = LONGEST_MESSAGE // 2
        # The end names the remedy, so what is cut from a long message is its middle.
        super().__init__(line if len(line) <= 2 * half else f"{line[:half]} ... {line[-half:]}")


@dataclass(frozen=True, kw_only=True)
class Study:
    """What to run and what to compare it with; every name and value is valid.

    Attributes:
        name: stem of the definition's file; names the results.
        title: one line on what the study shows.
        scene: name of the scene.
        fixed: parameters that are the same in every case.
        varied: values of the parameters that vary; all combinations are run.
        references: literature references to compare with.
        timing_repeats: times to run each case again, alone on the machine, to measure its run
            time; 0 where a study does not ask for it.
        source: the definition's file.
    """

    name: str
    title: str
    scene: str
    fixed: Mapping[str, Value]
    varied: Mapping[str, tuple[Value, ...]]
    references: tuple[str, ...]
    timing_repeats: int
    source: Path


def studies_folder() -> Path:
    """Folder of the studies that ship: inside an installed package, or beside it in a checkout."""
    package = Path(__file__).parent
    packaged = package / "studies"
    return packaged if packaged.is_dir() else package.parent / "studies"


def study_names() -> tuple[str, ...]:
    """Names of the studies that ship, sorted."""
    return tuple(sorted(path.stem for path in studies_folder().glob("*.toml")))


def load_study(study: str, settings: Iterable[str] = ()) -> Study:
    """Read the study called `study`, or in the file `study`, and apply ``key=value`` settings.

    A setting's value is a TOML value, or a bare word for a text. A list varies the parameter, a
    scalar fixes it, whatever the file says; of two settings of one key the last holds.

    Raises:
        StudyError: the file is missing or not a study, or a setting is malformed.
    """
    path = _path_of(study)
    document = _Table(f"{path}:", _read(path))
    document.allow("title", "scene", "fixed", "vary", "compare", "timing")
    scene = document.text("scene", nearest_name("", scene_names()))
    try:
        known = parameters_of(scene_class(scene))
    except UnknownSceneError as error:
        raise StudyError(f"{path}: scene = {scene!r}: {error}") from None

    fixed: dict[str, Value] = {}
    varied: dict[str, tuple[Value, ...]] = {}
    for key, value in document.table("fixed").items():
        fixed[key] = _checked(known, f"{path}: [fixed]", key, value)
    for key, value in document.table("vary").items():
        if key in fixed:
            raise StudyError(f"{path}: [vary] {key}: is under [fixed] as well; keep one of them")
        varied[key] = _checked_list(known, f"{path}: [vary]", key, value)
    for setting in settings:
        key, value = _parse_setting(setting)
        if isinstance(value, list):
            varied[key] = _checked_list(known, "--set", key, value)
            fixed.pop(key, None)
        else:
            fixed[key] = _checked(known, "--set", key, value)
            varied.pop(key, None)

    return Study(
        name=path.stem,
        title=document.text("title", "; one line on what the study shows"),
        scene=scene,
        fixed=fixed,
        varied=varied,
        references=_references(document),
        timing_repeats=_timing_repeats(document),
        source=path,
    )


def _path_of(study: str) -> Path:
    path = Path(study)
    is_name = path.suffix != ".toml" and path.name == study
    if is_name:
        path = studies_folder() / f"{study}.toml"
    try:
        found = path.is_file()
    except OSError as error:
        raise StudyError(f"{study}: {error.strerror}") from None
    if not found:
        problem = "no such study" if is_name else "not a file" if path.exists() else "no such file"
        raise StudyError(f"{study}: {problem}{nearest_name(path.stem, study_names())}")
    if path.suffix != ".toml" or not re.fullmatch(r"\w[\w.-]*", path.stem):
        raise StudyError(
            f"{study}: a study's file is called NAME.toml, NAME of letters, digits, '_', '-', '.'"
        )
    return path


def _read(path: Path) -> dict[str, Any]:
    try:
        size = path.stat().st_size
        content = path.read_bytes() if size <= LARGEST_FILE else b""
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror}") from None
    if size > LARGEST_FILE:
        raise StudyError(f"{path}: has {size} bytes; a study has at most {LARGEST_FILE}")
    try:
        return tomllib.loads(content.decode())
    except UnicodeDecodeError as error:
        raise StudyError(f"{path}: not UTF-8 at byte {error.start}") from None
    except RecursionError:
        raise StudyError(f"{path}: not valid TOML: nested too deeply") from None
    except ValueError as error:  # not only TOMLDecodeError: an integer may have too many digits
        raise StudyError(f"{path}: not valid TOML: {error}") from None


class _Table:
    """A TOML table with the place it stands at, for messages."""

    def __init__(self, where: str, values: dict[str, Any]) -> None:
        self.where = where
        self.values = values

    def items(self) -> Iterable[tuple[str, Any]]:
        return self.values.items()

    def allow(self, *keys: str) -> None:
        for key, value in self.values.items():
            if key not in keys:
                raise StudyError(
                    f"{self.where} {key} = {_shown(value)}: unknown key{nearest_name(key, keys)}"
                )

    def table(self, key: str) -> _Table:
        value = self.values.get(key, {})
        if not isinstance(value, dict):
            raise StudyError(f"{self.where} {key} = {_shown(value)}: must be a table [{key}]")
        return _Table(f"{self.where} [{key}]", value)

    def text(self, key: str, remedy: str) -> str:
        if key not in self.values:
            raise StudyError(f"{self.where} {key}: is missing{remedy}")
        value = self.values[key]
        if not (isinstance(value, str) and value.strip() and value.isprintable()):
            raise StudyError(f"{self.where} {key} = {_shown(value)}: must be a text of one line")
        return value


def _references(document: _Table) -> tuple[str, ...]:
    table = document.table("compare")
    table.allow("references")
    ids = table.values.get("references", [])
    where = f"{table.where} references = {_shown(ids)}:"
    if not isinstance(ids, list):
        raise StudyError(f"{where} must be a list")
    for reference in ids:
        if reference not in reference_ids():
            nearest = nearest_name(str(reference), reference_ids())
            raise StudyError(f"{where} unknown reference {_shown(reference)}{nearest}")
    if len(set(ids)) < len(ids):
        raise StudyError(f"{where} names a reference twice")
    return tuple(ids)


def _timing_repeats(document: _Table) -> int:
    table = document.table("timing")
    table.allow("repeats")
    if "repeats" not in table.values:
        return 0
    repeats = table.values["repeats"]
    if type(repeats) is not int or not 1 <= repeats <= MOST_REPEATS:
        raise StudyError(
            f"{table.where} repeats = {_shown(repeats)}: must be an integer, 1 to {MOST_REPEATS}"
        )
    return repeats


def _parse_setting(setting: str) -> tuple[str, Any]:
    key, equals, text = (part.strip() for part in setting.partition("="))
    if not (key and equals and text):
        raise StudyError(f"--set {setting}: must be key=value")
    if re.fullmatch(r"[A-Za-z_]\w*", text) and text not in ("true", "false", "inf", "nan"):
        return key, text
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        parsed = {}
    if parsed.keys() != {"value"}:
        raise StudyError(f"--set {setting}: {text} is not a TOML value: a number, a text or a list")
    return key, parsed["value"]


def _checked(known: Mapping[str, Parameter], where: str, key: str, value: object) -> Value:
    definition = _definition(known, where, key, value)
    shown = f"{where} {key} = {_shown(value)}"
    if isinstance(value, list):
        raise StudyError(f"{shown}: is a list; what varies belongs under [vary]")
    if not isinstance(value, Value) or (isinstance(value, int) and abs(value) >= 2**63):
        raise StudyError(f"{shown} is not allowed: must be {definition.allowed}")
    try:
        checked = definition.checked(value)
    except ParameterError as error:
        raise StudyError(f"{where} {error}") from None
    assert checked is not None  # only None itself is checked to None
    return checked


def _checked_list(
    known: Mapping[str, Parameter], where: str, key: str, values: object
) -> tuple[Value, ...]:
    _definition(known, where, key, values)
    if not isinstance(values, list) or not values:
        raise StudyError(f"{where} {key} = {_shown(values)}: must be a list of one value or more")
    checked = tuple(_checked(known, where, key, value) for value in values)
    if len(set(checked)) < len(checked):
        twice = next(value for value in checked if checked.count(value) > 1)
        raise StudyError(f"{where} {key} = {_shown(values)}: {twice!r} is there twice")
    return checked


def _definition(known: Mapping[str, Parameter], where: str, key: str, value: object) -> Parameter:
    if key not in known:
        nearest = nearest_name(key, known)
        raise StudyError(f"{where} {key} = {_shown(value)}: unknown parameter {key!r}{nearest}")
    return known[key]


def _shown(value: object) -> str:
    """A value for a message; huge integers and deeply dotted tables have no text."""
    try:
        return repr(value)
    except (ValueError, RecursionError):
        return "(too long to show)"
