"""Study files: finding them by name or path, reading TOML, and merging a study with its bases.

The ground of a study, [profile], is given as columns over depth or as a CSV file beside the study.
Both become the parameter `profile` of the scene, a text of one line. harness/README.md has
examples.
"""

import re
import stat
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.study.designs import VARY_REPLACES_FIXED
from harness.study.laws import ASSIGNING_TABLES, without_replaced
from harness.study.scene_part import SCENE_KEYS
from harness.study.tables import StudyError, Table, is_number, text_key
from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import shown
from mpm_warp.fields.names import nearest_name
from mpm_warp.materials.clay_law import LAW, PARAMETER
from mpm_warp.scenes import scene_names
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.table import PROFILE, columns_of, text_of

BASE = text_key("base", "study from which keys are taken that this one lacks", None)
FILE = text_key("file", "a CSV file with the ground")
STUDY_NAME = r"(?!(?i:con|prn|aux|nul|com\d|lpt\d)(\.|$))\w([\w.-]*[\w-])?"
"""Pattern of the name of a study; Windows reserves some names, and drops a dot at the end."""
NAME_RULE = (
    "letters, digits, '_', '-' and '.', with neither '-' nor '.' first, no '.' last, and no device "
    "of Windows, as con or nul"
)
LARGEST_FILE = 1_000_000
"""Bytes that a study file or a profile may have; a larger file is a mistake."""
WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
"""Beginnings of .xlsx and .ods, and of .xls."""
LONGEST_LINEAGE = 8
"""Studies that may be chained by ``base``."""
MOST_KEY_PARTS = 20
"""Parts that a dotted key may have; keys of a study have five at most."""
# Possessive quantifiers (++, *+) never backtrack, so that even a megabyte is searched in no time.
LONG_KEY = re.compile(
    rf"(?<![\w-])(?:(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{MOST_KEY_PARTS}}}"
)


def studies_folder() -> Path:
    """Folder of the studies that ship: inside the installed package, or beside it in a checkout."""
    package = Path(__file__).parents[1]
    packaged = package / "studies"
    return packaged if packaged.is_dir() else package.parent / "studies"


def study_names() -> tuple[str, ...]:
    """Names of the studies that ship, sorted."""
    return tuple(sorted(path.stem for path in studies_folder().glob("*.toml")))


def find_study(study: str, beside: Path | None = None) -> Path:
    """The file of a study.

    Args:
        study: name of a study that ships, or path of a file.
        beside: folder that a relative path starts from; by default the current one.

    Raises:
        StudyError: there is no such file, with the nearest known name; or the file has a name by
            which no results can be named.
    """
    path, here = Path(study), beside or Path()
    is_name = path.suffix != ".toml" and path.name == study
    path = studies_folder() / f"{study}.toml" if is_name else here / path
    try:
        found = path.is_file()
    except (OSError, ValueError) as error:  # too long a name; a null character in it
        raise StudyError(f"{study}: {getattr(error, 'strerror', error)}") from None
    if not found:
        problem = "no such study" if is_name else "not a file" if path.exists() else "no such file"
        if is_name and (here / path.name).is_file():
            raise StudyError(f"{study}: {problem}; a file here is called {path.name}")
        near = nearest_name(path.stem, [*study_names(), *scene_names()])
        raise StudyError(f"{study}: {problem}{near}")
    if path.suffix != ".toml" or not re.fullmatch(STUDY_NAME, path.stem):
        raise StudyError(f"{study}: a study's file is called NAME.toml, NAME of {NAME_RULE}")
    return path


def read_bounded(path: Path, most: int, what: str) -> bytes:
    """The content of a regular file.

    Args:
        path: the file.
        most: bytes that it may have.
        what: kind of file, for the error message: "a study".
    """
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):  # opening a FIFO would block, a device may be endless
            raise StudyError(f"{path}: is not a regular file")
        content = path.read_bytes() if about.st_size <= most else b""
    except (OSError, ValueError) as error:  # a null character in its name
        raise StudyError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from None
    if about.st_size > most:
        raise StudyError(f"{path}: has {about.st_size} bytes; {what} has at most {most}")
    if content.startswith(WORKBOOKS):
        raise StudyError(f"{path}: is a workbook; save the sheet as CSV")
    return content


def read_text(path: Path, what: str) -> str:
    """The text of a UTF-8 file of at most `LARGEST_FILE` bytes; `what` as in `read_bounded`."""
    try:
        return read_bounded(path, LARGEST_FILE, what).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise StudyError(f"{path}: not UTF-8 at byte {error.start}") from None


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML file."""
    text = read_text(path, "a study")
    try:
        if LONG_KEY.search(text):  # the parser takes a time that grows with the square of the parts
            raise StudyError(f"{path}: a dotted key has more than {MOST_KEY_PARTS} parts")
        return tomllib.loads(text)
    except RecursionError:
        raise StudyError(f"{path}: not valid TOML: nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        raise StudyError(f"{path}: not valid TOML: {error}{_remedy(text, error)}") from None
    except ValueError:  # of Python, which reads no integer of more digits
        most = sys.get_int_max_str_digits()
        line = 1 + re.split(rf"[\d_]{{{most + 1}}}", text, maxsplit=1)[0].count("\n")
        raise StudyError(
            f"{path}: not valid TOML: an integer of more than {most} digits at line {line}"
        ) from None


def _remedy(text: str, error: ValueError) -> str:
    """How to correct the line that a TOML error names, if it is a common mistake; else ""."""
    place = re.search(r"at line (\d+)", str(error))
    lines = text.splitlines() or [""]
    line = lines[int(place[1]) - 1 if place else -1].partition("#")[0].strip()  # else at the end
    key, equals, value = (part.strip() for part in line.partition("="))
    of_all, dot, own = key.partition(".")
    if of_all == PARAMETER and dot and "overwrite" in str(error):
        return f'; give both in one table: {of_all} = {{ {LAW} = "its_name", {own} = {value} }}'
    if equals and re.fullmatch(r"[A-Za-z][\w -]*", value):
        return f'; a text needs quotes: {key} = "{value}"'
    if equals and re.fullmatch(r"[-+]?\d+,\d+", value):
        return f"; a number has a decimal point: {key} = {value.replace(',', '.')}"
    if re.fullmatch(r"[\w.-]+\s*:.*", line):
        return "; write = between a key and its value"
    return ""


def lineage(path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """A study file and its bases, each with its tables; the most distant base comes first."""
    line: list[tuple[Path, dict[str, Any]]] = []
    here: Path | None = path
    while here is not None:
        values = read_toml(here)
        line.insert(0, (here, values))
        base = Table(f"{here}:", values).read(BASE)
        if base is not None and len(line) == LONGEST_LINEAGE:
            raise StudyError(
                f"{here}: base = {base!r}: more than {LONGEST_LINEAGE} studies are chained by "
                "base, or they form a circle"
            )
        try:
            here = None if base is None else find_study(base, here.parent)
        except StudyError as error:
            raise StudyError(f"{here}: base = {base!r}: {error}") from None
    return line


def merged(base: Mapping[str, Any], own: Mapping[str, Any], design: object) -> dict[str, Any]:
    """A study merged with its base.

    Tables are merged key by key, and entries of `own` replace those of `base`. A parameter that
    `own` fixes, varies or derives loses its entries in `base`. One exception: a parameter that
    `own` varies keeps its fixed value where the design uses it (see `VARY_REPLACES_FIXED`). What
    `own` says for all scenes replaces what `base` says for a single scene.

    Args:
        base: tables of the base, or its [scenes.NAME].
        own: tables of the study, or its [scenes.NAME].
        design: name of the design.
    """
    result = dict(base)
    for name in ASSIGNING_TABLES:
        keeps = name == "fixed" and design not in VARY_REPLACES_FIXED
        tables = (own.get(key) for key in ASSIGNING_TABLES if not (keeps and key == "vary"))
        said = {key: it for table in tables if isinstance(table, dict) for key, it in table.items()}
        if isinstance(table := result.get(name), dict):
            kept = without_replaced(table, said)
            result[name] = {key: value for key, value in kept.items() if key not in said}
    if isinstance(scenes := result.get("scenes"), dict):
        of_all = {key: own[key] for key in SCENE_KEYS if key in own}
        result["scenes"] = {
            name: merged(of_scene, of_all, design) if isinstance(of_scene, dict) else of_scene
            for name, of_scene in scenes.items()
        }
    for key, value in own.items():
        inherited = result.get(key)
        if not (isinstance(inherited, dict) and isinstance(value, dict)):
            result[key] = value
        else:
            result[key] = {**inherited, **value}
            for name in inherited.keys() & value.keys() if key == "scenes" else ():
                if isinstance(inherited[name], dict) and isinstance(value[name], dict):
                    result[key][name] = merged(inherited[name], value[name], design)
    return result


def with_profile(path: Path, values: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a study file in which [profile] has become a fixed parameter.

    Args:
        path: the study file; the file of a profile is looked for in its folder.
        values: the tables of the study.
    """
    rest = {key: value for key, value in values.items() if key != PROFILE}
    if PROFILE not in values:
        return rest
    table = Table(f"{path}:", values).table(PROFILE)
    fixed = Table(f"{path}:", values).table("fixed")
    if PROFILE in fixed.values:
        raise fixed.refuse(PROFILE, f"stands under [{PROFILE}] as well; keep one of them")
    text = (
        _profile_from_file(path.parent, table)
        if "file" in table.values
        else _profile_from_columns(table)
    )
    where = table.place("file") if "file" in table.values else table.where
    try:
        columns = columns_of(text)
        # The strength of a law that has its own follows from the parameters of a case.
        ground = Profile.of(columns).text if "strength" in columns else text_of(columns)
    except ParameterError as error:
        # The message begins with the parameter, which the place names already.
        raise StudyError(f"{where}: {str(error).removeprefix(f'{PROFILE}: ')}") from None
    return rest | {"fixed": {**fixed.values, PROFILE: ground}}


def _profile_from_file(folder: Path, table: Table) -> str:
    """The text of the CSV file of a profile, which must be in the study's folder or below it."""
    table.allow("file")
    path = folder / table.read(FILE)
    try:
        if path.resolve().is_relative_to(folder.resolve()):
            return read_text(path, "a profile")
    except (StudyError, OSError, ValueError) as error:
        raise table.refuse("file", str(error).removeprefix(f"{path}: ")) from None
    raise table.refuse("file", "must be in the folder of the study, or below it")


def _profile_from_columns(table: Table) -> str:
    lengths = {}
    for key, column in table.values.items():
        if not isinstance(column, list) or not all(map(is_number, column)):
            raise table.refuse(key, "must be a list of numbers, or file = a CSV file")
        lengths[key] = len(column)
    if len(set(lengths.values())) > 1:
        raise StudyError(f"{table.where}: columns have different lengths: {shown(lengths)}")
    rows = zip(*table.values.values(), strict=True)
    return "\n".join([",".join(table.values), *(",".join(map(repr, row)) for row in rows)])
