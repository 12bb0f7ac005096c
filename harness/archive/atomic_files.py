"""Files that are written whole or not at all: under another name first, then renamed."""

import contextlib
import os
import platform
import secrets
from pathlib import Path
from typing import BinaryIO

from harness.errors import HarnessError

PARTIAL = ".part"
"""Ending of a file that is being written; such a file is nobody's result."""


class ArchiveError(HarnessError):
    """A result cannot be read or written; the message is one line and names the file."""


def prepare(folder: Path) -> None:
    """Make the folder, and check by writing a small file that it can be written to.

    Raises:
        ArchiveError: it cannot be made, or not be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be made: {error.strerror}") from None
    probe = _partial(folder)
    try:
        with _created(probe) as file:
            file.write(b"probe")
    except OSError as error:
        raise ArchiveError(f"{folder}: cannot be written to: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            probe.unlink()


def write_whole(content: bytes | memoryview, path: Path) -> None:
    """Write a file that is either complete under its name or not there.

    Raises:
        ArchiveError: it cannot be written; an earlier file of that name is as it was.
    """
    partial = _partial(path.parent)
    try:
        with _created(partial) as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be written: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()


def discard_partial(folder: Path, process_id: int) -> None:
    """Remove what a process of this machine that was killed has left half-written."""
    for partial in folder.glob(f".*{partial_ending(process_id)}"):
        remove_file(partial)


def abandoned(folder: Path) -> list[Path]:
    """Half-written files whose processes, on this machine, are no more."""
    ending = partial_ending("*")
    before, after = ending.split("*")
    found = []
    for partial in sorted(folder.glob(f".*{ending}")):
        process_id = partial.name.rpartition(before)[2].removesuffix(after)
        if process_id.isdecimal() and not _is_alive(int(process_id)) and not is_folder(partial):
            found.append(partial)
    return found


def is_folder(path: Path) -> bool:
    """Whether a path is a folder itself; a link to one is not, it can be removed like a file."""
    return path.is_dir() and not path.is_symlink()


def remove_file(path: Path) -> None:
    """Remove a file, or a link and not what it leads to; it may be gone already.

    Raises:
        ArchiveError: it is a folder, or may not be removed.
    """
    if is_folder(path):
        raise ArchiveError(f"{path}: is a folder, where only files belong; move it away")
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be removed: {error.strerror}") from None


def _partial(folder: Path) -> Path:
    """What a file is called while this process writes it: nobody can know the name before."""
    return folder / f".{secrets.token_hex(8)}{partial_ending(os.getpid())}"


def _created(path: Path) -> BinaryIO:
    """A new file, open for writing, with the rights that the user's files have by default.

    What is there already, a link among it, is neither followed nor overwritten.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
    return open(path, "wb", opener=lambda name, _: os.open(name, flags, 0o666))


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
