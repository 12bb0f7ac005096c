"""The ground of a study, [profile]: columns by depth in the study, or a CSV file beside it.

    [profile]
    "depth [m]" = [0, 2, 2, 20]
    "strength [kPa]" = [40, 15, 20, 60]

or ``file = "site.csv"``, the first line of which names the same columns. Either becomes the
parameter `profile` of the scene, a text of one line.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.study.tables import StudyError, Table, shown
from mpm_warp.errors import ParameterError
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.profile_text import PROFILE

LARGEST_PROFILE = 1_000_000
"""Bytes of a file; a table of more than some ten thousand rows is a slip."""


def with_profile(path: Path, values: Mapping[str, Any]) -> dict[str, Any]:
    """A study's definition with its [profile] as a fixed parameter.

    Args:
        path: the study's file; a profile's file is found from its folder.
        values: the definition as it stands there.

    Raises:
        StudyError: the profile is not allowed, or its file cannot be read.
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
        profile = Profile.read(text)
    except ParameterError as error:
        # The place says already whose it is.
        raise StudyError(f"{where}: {str(error).removeprefix(f'{PROFILE}: ')}") from None
    return rest | {"fixed": {**fixed.values, PROFILE: profile.text}}


def _of_file(folder: Path, table: Table) -> str:
    table.allow("file")
    try:
        path = folder / table.text("file", "")
        content = path.read_bytes()[: LARGEST_PROFILE + 1]
        if len(content) > LARGEST_PROFILE:
            raise table.refuse("file", f"has more than {LARGEST_PROFILE} bytes")
        return content.decode("utf-8-sig")
    except OSError as error:
        raise table.refuse("file", f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise table.refuse("file", f"not UTF-8 at byte {error.start}") from None


def _of_columns(table: Table) -> str:
    lengths = {}
    for key, column in table.values.items():
        if not isinstance(column, list) or not all(type(it) in (int, float) for it in column):
            raise table.refuse(key, "must be a list of numbers, or file = a CSV file")
        lengths[key] = len(column)
    if len(set(lengths.values())) > 1:
        raise StudyError(f"{table.where}: columns have different lengths: {shown(lengths)}")
    rows = zip(*table.values.values(), strict=True)
    return "\n".join([",".join(table.values), *(",".join(map(repr, row)) for row in rows)])
