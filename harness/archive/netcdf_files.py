"""The netCDF files of the archive: the one place where they are written, opened and read.

Every file ends with a digest of itself: after the netCDF come the mark ``sha256: `` and the SHA-256
of all bytes before it. No library sees a file of the archive that is not as it was written: one
that says of itself that it has a digest and has none, one whose mark is damaged, and one that was
cut are refused before. What is damaged makes HDF5 raise whatever it likes, loop for ever, ask for
gigabytes, or end the process. A file of another program has no such word, and is read as it is.

HDF5's own checksum (Fletcher32) knows neither attributes, names nor dims. A digest over contents
needs every variable and attribute to be read first: 23 ms a case file, where this one takes 0.1 ms
and spares ``status`` the reading of all variables. Programs that read netCDF do not see it: HDF5
ends a file where its superblock says. A file that another program has written again is refused
even where its numbers are the same.
"""

import hashlib
import os
import stat
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends import NetCDF4DataStore

from harness.archive.atomic_files import ArchiveError, DamagedError, write_whole
from harness.archive.conventions import FORMAT_VERSION
from harness.archive.structure import TEXT, Stored, malformed

DIGEST = "digest"
"""Attribute of a file that ends with its digest."""
UNREADABLE = (
    *(OSError, RuntimeError, ValueError, TypeError, AttributeError),
    *(LookupError, ArithmeticError, MemoryError, AssertionError),
)
"""What netCDF4 and HDF5 raise where a file is not what they expect."""

_STATEMENT = "SHA-256 of all bytes before it, in the last 72 bytes of the file"
_MARK = b"sha256: "
_LENGTH = len(_MARK) + 64
_HDF5 = b"\x89HDF\r\n\x1a\n"
"""How a file of HDF5 begins."""
_SUPERBLOCK = 48
"""Bytes that such a file has at the least."""
_LARGEST_RATIO = 1032
"""Bytes that one byte compressed by deflate stands for at most (zlib's technical details)."""
_STRING_SIZE = 64
"""Bytes that a text takes in memory at least."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file and its digest; with an `ArchiveError` an earlier file is as it was."""
    # The file is made in memory, because on a full disk the netCDF library only says "HDF error"
    # and keeps the broken file open, so that its space is not freed until the process ends.
    image = _image(dataset.assign_attrs({DIGEST: _STATEMENT}))
    write_whole(b"".join((image, _digest(image))), path)


def read_netcdf(path: Path, *, as_result: bool = True) -> xr.Dataset:
    """Read a file of the archive into memory, checked as `opened` does it; dates stay numbers."""
    with opened(path, as_result=as_result) as stored:
        encoded = xr.Dataset(stored.variables, attrs=stored.attributes)
        found = xr.decode_cf(encoded, concat_characters=False, decode_times=False).load()
    found.attrs.pop(DIGEST, None)  # it is of the file, not of what was computed
    return found[[*found.data_vars, *found.coords]].drop_encoding()


def read_attributes(path: Path, *, any_version: bool = True) -> dict[str, Any]:
    """Read the attributes of a file alone, by default of whatever format version."""
    with opened(path, as_result=False, any_version=any_version) as stored:
        return dict(stored.attributes)


@contextmanager
def opened(path: Path, *, as_result: bool, any_version: bool = False) -> Iterator[Stored]:
    """What is in a file of the archive as it is stored, which is checked and open for its values.

    Args:
        path: the file.
        as_result: whether it has to be built as results are; snapshots are not, whose dims are
            points and nodes, and which have no headline.
        any_version: whether a file of another format version may be opened.

    Raises:
        ArchiveError: it is no file, damaged, of another format version, not built as results are,
            or says that it holds more than its bytes or this machine's memory can.
    """
    try:
        content = _content(path)
        _check_digest(path, content)
        # What was checked is what is read, whatever becomes of the file meanwhile.
        with netCDF4.Dataset(path.name, memory=content) as file:
            _check_kinds(file)
            variables, attributes = NetCDF4DataStore(file).load()
            stored = Stored(attributes, variables)
            _check_size(stored, len(content))
            version = attributes.get("format_version")
            is_ours = isinstance(version, int | np.integer) and version == FORMAT_VERSION
            if not (is_ours or any_version):
                raise ArchiveError(
                    f"{path}: has format version {version}, where {FORMAT_VERSION} can be read"
                )
            if as_result and (fault := malformed(stored)) is not None:
                raise ArchiveError(f"{path}: is no whole result: {fault}")
            yield stored
    except UNREADABLE as error:
        told = getattr(error, "strerror", None) or error
        reason = " ".join(str(told).split()) or type(error).__name__
        raise ArchiveError(f"{path}: cannot be read: {reason}") from None


def _check_kinds(file: netCDF4.Dataset) -> None:
    """Refuse lists, enumerations and dims that are there twice, which xarray reads half."""
    for name, it in file.variables.items():
        if it.dtype is not str and not isinstance(it.datatype, np.dtype):
            raise ValueError(f"{name} is no array of numbers or texts")
        if len(set(it.dimensions)) < len(it.dimensions):
            raise ValueError(f"{name} has a dim twice")


def _check_size(stored: Stored, byte_count: int) -> None:
    """Refuse a file that says that it holds more than its bytes or this machine's memory can."""
    sizes = [
        it.size * (_STRING_SIZE if it.dtype.kind == TEXT else it.dtype.itemsize)
        for it in stored.variables.values()
    ]
    if sum(sizes) > min(memory_of_machine(), _LARGEST_RATIO * byte_count):
        raise ValueError(f"its variables would take {sum(sizes):.3g} bytes, more than it can hold")


def memory_of_machine() -> int:
    """Bytes of memory that this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _content(path: Path) -> bytes:
    """The bytes of an ordinary file that fits into memory."""
    about = path.stat()
    if not stat.S_ISREG(about.st_mode):
        # Whoever opens a FIFO waits for its writer, and a device may have no end.
        what = "a folder" if stat.S_ISDIR(about.st_mode) else "no ordinary file"
        raise ValueError(f"it is {what}")
    if about.st_size > memory_of_machine():
        raise ValueError("it is larger than the memory here")
    return path.read_bytes()


def _check_digest(path: Path, content: bytes) -> None:
    """Refuse a file that is not as it was written; one of another program has no digest."""
    mark, digits = content[-_LENGTH:-64], content[-64:]
    if mark == _MARK:
        if mark + digits != _digest(memoryview(content)[:-_LENGTH]):
            raise _damage(path, "its digest does not agree")
        return
    # A bit of the mark, or of the statement, may be damaged: then the rest of them is there.
    near = sum(one == other for one, other in zip(mark, _MARK, strict=False)) >= len(_MARK) // 2
    if near or _STATEMENT.encode() in content:
        raise _damage(path, "its digest is missing")
    if not content.startswith(_HDF5):
        remedy = "; give what `harness run` has written of it" if path.suffix == ".toml" else ""
        raise ArchiveError(f"{path}: cannot be read: it is no netCDF-4 file{remedy}")
    if not _SUPERBLOCK <= _end(content) <= len(content):
        raise _damage(path, "its end is missing")


def _digest(content: bytes | memoryview) -> bytes:
    return _MARK + hashlib.sha256(content).hexdigest().encode()


def _damage(path: Path, how: str) -> DamagedError:
    return DamagedError(
        f"{path}: cannot be read: it was damaged or changed after it was written ({how})"
    )


def _image(dataset: xr.Dataset) -> memoryview:
    image: memoryview = dataset.to_netcdf(engine="netcdf4", encoding=_encoding(dataset))
    return image[: _end(image)]  # in memory HDF5 grows a file by 64 KiB at a time


def _end(content: bytes | memoryview) -> int:
    """Where a file of HDF5 ends, as its superblock says (HDF5 File Format Specification, II.A)."""
    start = 28 if int.from_bytes(content[8:9], "little") >= 2 else 40
    return int.from_bytes(content[start : start + 8], "little")


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, Any]]:
    """Compress arrays of numbers; no fill value in coordinates, which CF forbids."""
    encoding: dict[Hashable, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        numeric = np.issubdtype(variable.dtype, np.number)
        encoding[name] = {"zlib": True, "shuffle": True} if numeric and variable.ndim else {}
        if name in dataset.coords:
            encoding[name]["_FillValue"] = None
    return encoding
