"""Write files whole or not at all: first under a temporary name, then renamed."""

import contextlib
import csv
import io
import os
import platform
import re
import secrets
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

import psutil

from harness.errors import HarnessError, printable

PARTIAL = ".part"
"""Ending of a file that is still being written."""

FORMULA = ("=", "+", "-", "@")
"""A spreadsheet takes a cell for a formula if it begins with one of these."""
SIGNED_NUMBER = r"[-+]\d+(\.\d+)?(e[-+]\d+)?%?"
"""Pattern of numbers with a sign, which are not formulas."""


class ArchiveError(HarnessError):
    """A file of the archive cannot be read, written or removed; the message names it."""


class NoFileError(ArchiveError):
    """There is no such file."""


class DamagedError(ArchiveError):
    """A file with the mark of the harness whose digest is wrong."""


def check_folder(*folders: Path) -> None:
    """Refuse what is no folder, or one that may not be read; it need not exist."""
    for folder in folders:
        try:
            os.scandir(folder).close()
        except FileNotFoundError:
            return
        except NotADirectoryError:
            raise ArchiveError(f"{folder}: is not a folder") from None
        except OSError as error:
            raise ArchiveError(f"{folder}: cannot be read: {error.strerror}") from None


def prepare(folder: Path) -> None:
    """Make the folder, check that a file can be written there, and remove half-written files."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise ArchiveError(f"{folder}: is not a folder") from None
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be made: {error.strerror}") from None
    try:
        with _partial(folder) as (_, file):
            file.write(b"probe")
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be written to: {error.strerror}") from None
    for partial in abandoned(folder):
        with contextlib.suppress(OSError):  # another user's
            partial.unlink()


def write_whole(content: bytes | memoryview, path: Path) -> None:
    """Write a file whole; if that fails, an earlier file of this name is unchanged."""
    try:
        with _partial(path.parent) as (partial, file):
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
            file.close()  # Windows renames no open file
            partial.replace(path)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be written: {error.strerror}") from None


def write_csv(rows: Iterable[Iterable[str]], path: Path) -> None:
    """Write a table as CSV, whole or not at all."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_as_text, row) for row in rows)
    write_whole(text.getvalue().encode(), path)


def _as_text(cell: str) -> str:
    """A cell as one line, with a quote before what a spreadsheet would run as a formula."""
    is_formula = cell.startswith(FORMULA) and not re.fullmatch(SIGNED_NUMBER, cell)
    return f"'{printable(cell)}" if is_formula else printable(cell)


def discard_partial(folder: Path, process_id: int) -> None:
    """Remove half-written files of a killed process of this machine."""
    for partial in folder.glob(f".*{partial_ending(process_id)}"):
        remove_file(partial)


def abandoned(folder: Path) -> list[Path]:
    """Half-written files of processes of this machine that have ended."""
    before, after = partial_ending("*").split("*")
    number = re.compile(rf"{re.escape(before)}(\d+){re.escape(after)}$", re.ASCII)
    return [
        partial
        for partial in sorted(folder.glob(".*"))
        if (process := number.search(partial.name))
        and not _is_alive(int(process[1]))
        and not is_folder(partial)
    ]


def _is_alive(process_id: int) -> bool:
    try:
        return bool(psutil.pid_exists(process_id))
    except OverflowError:  # no process has a number that large
        return False


def is_folder(path: Path) -> bool:
    """Whether a path is a folder. A link to a folder is not: it is removed like a file."""
    return path.is_dir() and not path.is_symlink()


def remove_file(path: Path) -> None:
    """Remove a file if it exists. Of a link only the link itself is removed."""
    if is_folder(path):
        raise ArchiveError(f"{path}: is a folder among result files; move it away")
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be removed: {error.strerror}") from None


@contextlib.contextmanager
def _partial(folder: Path) -> Iterator[tuple[Path, BinaryIO]]:
    """A new file with a random name, open for writing; it is removed if it is not renamed.

    An existing file is never overwritten, and a link is never followed.
    """
    path = folder / f".{secrets.token_hex(8)}{partial_ending(os.getpid())}"
    file = path.open("xb")
    try:
        with file:
            yield path, file
    finally:  # after the file is closed: Windows removes no open one
        with contextlib.suppress(OSError):
            path.unlink()


def partial_ending(process_id: int | str) -> str:
    """Ending of temporary files of a process of this machine."""
    return f".{platform.node()}-{process_id}{PARTIAL}"
