"""Files that are written again: only what the harness itself has written is replaced."""

from __future__ import annotations

from pathlib import Path

from harness.archive.atomic_files import write_whole
from harness.errors import HarnessError

MAKER = "mpm_warp harness"
"""Stands in every picture and page: by it a file is known to be one of the harness."""
SEARCHED = 1 << 20
"""Bytes at the beginning and at the end of a file in which it is looked for."""


class NotOwnFileError(HarnessError):
    """A file is in the way that the harness has not written; the message is one line."""


def check_replaceable(path: Path) -> None:
    """Check that nothing is lost by writing a file: it is not there, or was written by the harness.

    Raises:
        NotOwnFileError: it was written by another program, or is a folder.
    """
    if not path.exists() and not path.is_symlink():
        return
    if not path.is_file():
        raise NotOwnFileError(f"{path}: is in the way and is no file; move it away")
    if MAKER.encode() not in _ends(path):
        raise NotOwnFileError(
            f"{path}: was not written by this program, and is not overwritten; move it away, or "
            "write to another place"
        )


def write_own(content: bytes, path: Path) -> None:
    """Write a file that holds `MAKER`, whole or not at all.

    Raises:
        NotOwnFileError: a file is in the way that the harness has not written.
        ArchiveError: it cannot be written.
    """
    assert MAKER.encode() in content, "the file would not be known again"
    check_replaceable(path)
    write_whole(content, path)


def _ends(path: Path) -> bytes:
    with path.open("rb") as file:
        first = file.read(SEARCHED)
        file.seek(max(0, path.stat().st_size - SEARCHED))
        return first + file.read()
