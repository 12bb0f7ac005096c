"""The files of studies: found by name or path, read from TOML, joined with those they build on.

The ground of a study, [profile], is columns by depth, or a CSV file beside it. Either becomes the
parameter `profile` of the scene, a text of one line. harness/README.md has examples.
"""

import re
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.study.designs import EITHER_FIXED_OR_VARIED
from harness.study.scene_part import OF_SCENE
from harness.study.tables import StudyError, Table, is_number, shown
from mpm_warp.errors import ParameterError
from mpm_warp.parameters import nearest_name
from mpm_warp.scenes import scene_names
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.table import PROFILE, columns_of, text_of

STUDY_NAME = r"\w[\w.-]*"
"""What the name of a study looks like, as a pattern."""
LARGEST_FILE = 1_000_000
"""Bytes of a definition, or of a profile; what is larger is not a study but a mistake."""
LONGEST_LINEAGE = 8
"""Studies that may stand one on the other by ``base``."""
MOST_PARTS = 20
"""Parts of a dotted key; those of a study have five at most."""
# Without going back (++, *+): a megabyte of anything is searched at once.
LONG_KEY = re.compile(
    rf"(?<![\w-])(?:(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+\.[ \t]*+){{{MOST_PARTS}}}"
)
ASSIGNING = ("fixed", "vary", "derived")
"""Tables that say what a parameter is; what a study says takes the place of what its base says."""


def studies_folder() -> Path:
    """Folder of the studies that ship: inside an installed package, or beside it in a checkout."""
    package = Path(__file__).parents[1]
    packaged = package / "studies"
    return packaged if packaged.is_dir() else package.parent / "studies"


def study_names() -> tuple[str, ...]:
    """Names of the studies that ship, sorted."""
    return tuple(sorted(path.stem for path in studies_folder().glob("*.toml")))


def find_study(study: str, beside: Path | None = None) -> Path:
    """The file of the study called `study`, or the file `study` itself, in a folder or here.

    Raises:
        StudyError: there is none (the nearest name is given), or its name names no results.
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
        raise StudyError(
            f"{study}: a study's file is called NAME.toml, NAME of letters, digits, '_', '-', '.'"
        )
    return path


def read_bounded(path: Path, most: int, what: str) -> bytes:
    """The content of an ordinary file of at most so many bytes; `what` it is, for the message."""
    try:
        about = path.stat()
        if not stat.S_ISREG(about.st_mode):  # whoever opens a FIFO waits, a device may have no end
            raise StudyError(f"{path}: is no ordinary file")
        content = path.read_bytes() if about.st_size <= most else b""
    except (OSError, ValueError) as error:  # a null character in its name
        raise StudyError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from None
    if about.st_size > most:
        raise StudyError(f"{path}: has {about.st_size} bytes; {what} has at most {most}")
    return content


def read_text(path: Path, what: str) -> str:
    """The text of an ordinary file of UTF-8 of at most `LARGEST_FILE` bytes."""
    try:
        return read_bounded(path, LARGEST_FILE, what).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise StudyError(f"{path}: not UTF-8 at byte {error.start}") from None


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a file as they stand there."""
    text = read_text(path, "a study")
    try:
        if LONG_KEY.search(text):  # the time that it takes grows with the square of its parts
            raise StudyError(f"{path}: a key has more than {MOST_PARTS} parts with dots between")
        return tomllib.loads(text)
    except RecursionError:
        raise StudyError(f"{path}: not valid TOML: nested too deeply") from None
    except ValueError as error:  # not only TOMLDecodeError: an integer may have too many digits
        raise StudyError(f"{path}: not valid TOML: {error}{_remedy(text, error)}") from None


def _remedy(text: str, error: ValueError) -> str:
    """What is wrong in the line that an error of TOML names, where it is a slip of beginners."""
    place = re.search(r"at line (\d+)", str(error))
    if place is None:
        return ""
    line = text.splitlines()[int(place[1]) - 1].partition("#")[0].strip()
    key, equals, value = (part.strip() for part in line.partition("="))
    if equals and re.fullmatch(r"[A-Za-z][\w -]*", value):
        return f'; a text needs quotes: {key} = "{value}"'
    if equals and re.fullmatch(r"[-+]?\d+,\d+", value):
        return f"; a number has a point: {key} = {value.replace(',', '.')}"
    if re.fullmatch(r"[\w.-]+\s*:.*", line):
        return "; a key and its value are parted by ="
    return ""


def lineage(path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """A study's file and those that it stands on by ``base``, the farthest first."""
    line: list[tuple[Path, dict[str, Any]]] = []
    here: Path | None = path
    while here is not None:
        values = read_toml(here)
        line.insert(0, (here, values))
        base = Table(f"{here}:", values).text("base") if "base" in values else None
        if base is not None and len(line) == LONGEST_LINEAGE:
            raise StudyError(
                f"{here}: base = {base!r}: more than {LONGEST_LINEAGE} studies stand one on the "
                "other, or in a circle"
            )
        try:
            here = None if base is None else find_study(base, here.parent)
        except StudyError as error:
            raise StudyError(f"{here}: base = {base!r}: {error}") from None
    return line


def joined(base: Mapping[str, Any], own: Mapping[str, Any], design: object) -> dict[str, Any]:
    """What `own` says, and what `base` says where `own` says nothing.

    Both are definitions, or what stands in them under [scenes.NAME]. Tables are joined key by key.
    A parameter that `own` fixes, varies or derives is no longer what `base` makes of it; but one
    that `own` varies keeps its fixed value where a case of the design has that. What `own` says for
    all scenes takes the place of what `base` says for one.
    """
    result = dict(base)
    for name in ASSIGNING:
        keeps = name == "fixed" and design not in EITHER_FIXED_OR_VARIED
        tables = (own.get(key) for key in ASSIGNING if not (keeps and key == "vary"))
        said = {key for table in tables if isinstance(table, dict) for key in table}
        if isinstance(table := result.get(name), dict):
            result[name] = {key: value for key, value in table.items() if key not in said}
    if isinstance(scenes := result.get("scenes"), dict):
        of_all = {key: own[key] for key in OF_SCENE if key in own}
        result["scenes"] = {
            name: joined(of_scene, of_all, design) if isinstance(of_scene, dict) else of_scene
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
                    result[key][name] = joined(inherited[name], value[name], design)
    return result


def with_profile(path: Path, values: Mapping[str, Any]) -> dict[str, Any]:
    """A study's definition with its [profile] as a fixed parameter.

    The file of a profile is found from the folder of the study.
    """
    rest = {key: value for key, value in values.items() if key != PROFILE}
    if PROFILE not in values:
        return rest
    table = Table(f"{path}:", values).table(PROFILE)
    fixed = Table(f"{path}:", values).table("fixed")
    if PROFILE in fixed.values:
        raise fixed.refuse(PROFILE, f"stands under [{PROFILE}] as well; keep one of them")
    text = _of_file(path.parent, table) if "file" in table.values else _of_columns(table)
    where = table.place("file") if "file" in table.values else table.where
    try:
        columns = columns_of(text)
        # The strength of a law that has its own follows from the parameters of a case.
        ground = Profile.of(columns).text if "strength" in columns else text_of(columns)
    except ParameterError as error:
        # The place says already whose it is.
        raise StudyError(f"{where}: {str(error).removeprefix(f'{PROFILE}: ')}") from None
    return rest | {"fixed": {**fixed.values, PROFILE: ground}}


def _of_file(folder: Path, table: Table) -> str:
    """The text of a profile's file: a regular one beside the study, or in a folder below."""
    table.allow("file")
    path = folder / table.text("file")
    try:
        if path.resolve().is_relative_to(folder.resolve()):
            return read_text(path, "a profile")
    except (StudyError, OSError, ValueError) as error:
        raise table.refuse("file", str(error).removeprefix(f"{path}: ")) from None
    raise table.refuse("file", "must be beside the study, or in a folder below")


def _of_columns(table: Table) -> str:
    lengths = {}
    for key, column in table.values.items():
        if not isinstance(column, list) or not all(map(is_number, column)):
            raise table.refuse(key, "must be a list of numbers, or file = a CSV file")
        lengths[key] = len(column)
    if len(set(lengths.values())) > 1:
        raise StudyError(f"{table.where}: columns have different lengths: {shown(lengths)}")
    rows = zip(*table.values.values(), strict=True)
    return "\n".join([",".join(table.values), *(",".join(map(repr, row)) for row in rows)])
