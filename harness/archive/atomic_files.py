"""Files that are written whole or not at all: under another name first, then renamed."""

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

from harness.errors import HarnessError, printable

PARTIAL = ".part"
"""Ending of a file that is being written; such a file is nobody's result."""

FORMULA = ("=", "+", "-", "@")
"""What a cell begins with that a spreadsheet takes for a formula."""
SIGNED_NUMBER = r"[-+]\d+(\.\d+)?(e[-+]\d+)?%?"
"""A number that begins as a formula, as a pattern."""


class ArchiveError(HarnessError):
    """A file of the archive cannot be read, written or removed; one line, which names it."""


class DamagedError(ArchiveError):
    """A file is not as the harness wrote it, or was cut."""


def prepare(folder: Path) -> None:
    """Make the folder, and check by writing a small file that it can be written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be made: {error.strerror}") from None
    try:
        with _partial(folder) as (_, file):
            file.write(b"probe")
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be written to: {error.strerror}") from None


def write_whole(content: bytes | memoryview, path: Path) -> None:
    """Write a file that is either complete under its name or, with an `ArchiveError`, as it was."""
    try:
        with _partial(path.parent) as (partial, file):
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
            partial.replace(path)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be written: {error.strerror}") from None


def write_csv(rows: Iterable[Iterable[str]], path: Path) -> None:
    """Write a table as CSV, whole or not at all."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(_as_text, row) for row in rows)
    write_whole(text.getvalue().encode(), path)


def _as_text(cell: str) -> str:
    """A cell of one line that is no formula: a spreadsheet would run what a file is called."""
    is_formula = cell.startswith(FORMULA) and not re.fullmatch(SIGNED_NUMBER, cell)
    return f"'{printable(cell)}" if is_formula else printable(cell)


def discard_partial(folder: Path, process_id: int) -> None:
    """Remove what a process of this machine that was killed has left half-written."""
    for partial in folder.glob(f".*{partial_ending(process_id)}"):
        remove_file(partial)


def abandoned(folder: Path) -> list[Path]:
    """Half-written files whose processes, on this machine, are no more."""
    before, after = partial_ending("*").split("*")
    number = re.compile(rf"{re.escape(before)}(\d+){re.escape(after)}$", re.ASCII)
    return [
        partial
        for partial in sorted(folder.glob(".*"))
        if (process := number.search(partial.name))
        and not _is_alive(int(process[1]))
        and not is_folder(partial)
    ]


def is_folder(path: Path) -> bool:
    """Whether a path is a folder itself; a link to one is not, it can be removed like a file."""
    return path.is_dir() and not path.is_symlink()


def remove_file(path: Path) -> None:
    """Remove a file, or a link and not what it leads to; it may be gone already."""
    if is_folder(path):
        raise ArchiveError(f"{path}: is a folder, where only files belong; move it away")
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be removed: {error.strerror}") from None


@contextlib.contextmanager
def _partial(folder: Path) -> Iterator[tuple[Path, BinaryIO]]:
    """A new file, open for writing, with the rights that the user's files have by default.

    Nobody can know its name before, and what is there already, a link among it, is neither followed
    nor overwritten. It is removed at the end if it still has that name.
    """
    path = folder / f".{secrets.token_hex(8)}{partial_ending(os.getpid())}"
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
    with open(path, "wb", opener=lambda name, _: os.open(name, flags, 0o666)) as file:
        try:
            yield path, file
        finally:
            with contextlib.suppress(OSError):
                path.unlink()


def partial_ending(process_id: int | str) -> str:
    """Ending of the names of files that a process of this machine is writing."""
    return f".{platform.node()}-{process_id}{PARTIAL}"


def _is_alive(process_id: int) -> bool:
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # alive, and another user's
        return True
    return True
