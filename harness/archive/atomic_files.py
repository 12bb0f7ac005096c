"""Files that are written whole or not at all: under another name first, then renamed."""

from __future__ import annotations

import contextlib
import os
import platform
from pathlib import Path

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
    probe = _partial(folder / "probe")
    try:
        probe.write_bytes(b"probe")
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
    partial = _partial(path)
    try:
        with partial.open("wb") as file:
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


def _partial(path: Path) -> Path:
    """What `path` is called while this process writes it; no other run in the folder does so."""
    return path.with_name(f".{path.name}{partial_ending(os.getpid())}")


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
