"""Files of measured tests: the choice of the reader by the format."""

import csv
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from harness.interpret.reading.ags import read_ags
from harness.interpret.reading.bro import read_bro
from harness.interpret.reading.contents import TestFile
from harness.interpret.reading.gef import read_gef
from harness.interpret.reading.sgf import read_sgf
from harness.interpret.reading.text_table import read_table
from harness.study.files import read_bounded
from harness.study.tables import StudyError

LARGEST_FILE = 20_000_000
"""Size of a file [byte]; a sounding of 100 m in steps of 5 mm has some two million bytes."""
READERS: Mapping[str, Callable[[Path, str, str | None], TestFile]] = {
    ".gef": read_gef,
    ".xml": read_bro,
    ".ags": read_ags,
}


def read_file(path: Path, sounding: str | None = None) -> TestFile:
    """A test from its file; GEF, XML and AGS are recognised by the ending.

    Any other file is SGF if its first line is $, or else CSV. `sounding` names the test in a file
    that has several.

    Raises:
        StudyError: the file cannot be read or is damaged.
        NotNamedError: the file has several tests, and `sounding` is None.
    """
    content = read_bounded(path, LARGEST_FILE, "a test")
    if b"\0" in content:
        raise StudyError(f"{path}: has null bytes: it is binary, or UTF-16; save it as UTF-8 text")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # matters for names only; numbers and keys are ASCII
    other = read_sgf if re.match(r"\s*\$\s*$", text, re.MULTILINE) else read_table
    reader = READERS.get(path.suffix.lower(), other)
    if sounding is not None and reader in (read_table, read_gef):
        raise StudyError(f"{path}: sounding = {sounding!r}: the file has one test, without a name")
    try:
        found = reader(path, text, sounding)
    except csv.Error as error:
        raise StudyError(f"{path}: is no table: {error}") from None
    if not found.rows:
        raise StudyError(f"{path}: has no rows below its header")
    return found
