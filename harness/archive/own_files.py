"""Files that the harness writes over again, but only its own: pictures, tables and pages."""

from pathlib import Path

from harness.archive.atomic_files import write_whole
from harness.errors import HarnessError

MAKER = "mpm_warp harness"
"""A text in every picture and page, by which the harness recognises its own files."""
SEARCHED = 1 << 20
"""Number of bytes at the beginning and at the end of a file that are searched for it."""


class NotOwnFileError(HarnessError):
    """A file of that name exists which the harness has not written."""


def not_own(path: Path) -> NotOwnFileError:
    """The error for a file of another program that would be overwritten."""
    return NotOwnFileError(
        f"{path}: was not written by this program and will not be overwritten; move it away, or "
        "write to another place"
    )


def check_replaceable(path: Path, mark: str = MAKER) -> None:
    """Refuse to replace a file without `mark`, a text in every file of this kind by the harness."""
    if not path.exists() and not path.is_symlink():
        return
    if not path.is_file():
        raise NotOwnFileError(f"{path}: is in the way and is no file; move it away")
    with path.open("rb") as file:
        content = file.read(SEARCHED)
        file.seek(max(0, path.stat().st_size - SEARCHED))
        content += file.read()
    if mark.encode() not in content:
        raise not_own(path)


def write_own(content: bytes, path: Path) -> None:
    """Write a file that holds `MAKER`, whole or not at all."""
    assert MAKER.encode() in content, "the file would not be recognised"
    check_replaceable(path)
    write_whole(content, path)
