"""The netCDF files of the archive; all are written, opened and read here.

Every file ends with a digest: after the netCDF data come the mark ``sha256: `` and the SHA-256 of
all bytes before it. It is checked before the netCDF library opens the file, because a damaged file
can make HDF5 raise any exception, loop forever, request gigabytes, or end the process. A file is
refused if its digest is wrong, if its digest is missing although an attribute announces one, or if
it was cut. A file of another program announces no digest and is read without this check; a file
that another program has rewritten is refused even if its numbers are the same.

HDF5's own checksum (Fletcher32) does not cover attributes, names and dims. A digest of the contents
would need all variables to be read first, 23 ms a case file; this one takes 0.1 ms. Programs that
read netCDF do not notice it, because HDF5 stops at the end that the superblock states.
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
"""Exceptions of netCDF4 and HDF5 for a file that they cannot read."""

_STATEMENT = "SHA-256 of all bytes before it, in the last 72 bytes of the file"
_MARK = b"sha256: "
_LENGTH = len(_MARK) + 64
_HDF5 = b"\x89HDF\r\n\x1a\n"
"""First bytes of an HDF5 file."""
_SUPERBLOCK = 48
"""Smallest size of an HDF5 file [byte]."""
_LARGEST_RATIO = 1032
"""Largest compression ratio of deflate (zlib's technical details)."""
_STRING_SIZE = 64
"""Smallest size of a text in memory [byte]."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file with its digest, whole or not at all."""
    # The file is made in memory. On a full disk the netCDF library only says "HDF error" and keeps
    # the broken file open, so that its space is not freed until the process ends.
    image = _image(dataset.assign_attrs({DIGEST: _STATEMENT}))
    write_whole(b"".join((image, _digest(image))), path)


def read_netcdf(path: Path, *, as_result: bool = True) -> xr.Dataset:
    """Read a file of the archive into memory, with the checks of `opened`; dates stay numbers."""
    with opened(path, as_result=as_result) as stored:
        encoded = xr.Dataset(stored.variables, attrs=stored.attributes)
        found = xr.decode_cf(encoded, concat_characters=False, decode_times=False).load()
    found.attrs.pop(DIGEST, None)  # it belongs to the file, not to the result
    return found[[*found.data_vars, *found.coords]].drop_encoding()


def read_attributes(path: Path, *, any_version: bool = True) -> dict[str, Any]:
    """Read only the attributes of a file; by default of any format version."""
    with opened(path, as_result=False, any_version=any_version) as stored:
        return dict(stored.attributes)


@contextmanager
def opened(path: Path, *, as_result: bool, any_version: bool = False) -> Iterator[Stored]:
    """Check a file of the archive and open it; values of variables are read on demand.

    It must be undamaged, of this format version unless `any_version` is set, and of a size that its
    bytes and this machine's memory allow. With `as_result` it must have the structure of a result;
    files of snapshots have none: their dims are points and nodes, and they have no headline.
    """
    try:
        content = _content(path)
        _check_digest(path, content)
        # The checked bytes are read from memory, so a change of the file meanwhile has no effect.
        with netCDF4.Dataset(path.name, memory=content) as file:
            _check_kinds(file)
            variables, attributes = NetCDF4DataStore(file).load()
            stored = Stored(attributes, variables)
            _check_size(stored, len(content))
            version = attributes.get("format_version")
            is_ours = isinstance(version, int | np.integer) and version == FORMAT_VERSION
            if not (is_ours or any_version):
                raise ArchiveError(
                    f"{path}: has format version {version}; only {FORMAT_VERSION} can be read"
                )
            if as_result and (fault := malformed(stored)) is not None:
                raise ArchiveError(f"{path}: is not a complete result: {fault}")
            yield stored
    except UNREADABLE as error:
        message = str(getattr(error, "strerror", None) or error)
        reason = " ".join(message.split()) or type(error).__name__
        raise ArchiveError(f"{path}: cannot be read: {reason}") from None


def _check_kinds(file: netCDF4.Dataset) -> None:
    """Refuse lists, enumerations and repeated dims, which xarray reads only in part."""
    for name, variable in file.variables.items():
        if variable.dtype is not str and not isinstance(variable.datatype, np.dtype):
            raise ValueError(f"{name} is not an array of numbers or texts")
        if len(set(variable.dimensions)) < len(variable.dimensions):
            raise ValueError(f"{name} has a dim twice")


def _check_size(stored: Stored, byte_count: int) -> None:
    """Refuse a file that claims to hold more than its bytes or this machine's memory allow."""
    sizes = [
        values.size * (_STRING_SIZE if values.dtype.kind == TEXT else values.dtype.itemsize)
        for values in stored.variables.values()
    ]
    if sum(sizes) > min(memory_of_machine(), _LARGEST_RATIO * byte_count):
        raise ValueError(f"its variables would take {sum(sizes):.3g} bytes, more than it can hold")


def memory_of_machine() -> int:
    """Bytes of memory that this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _content(path: Path) -> bytes:
    """The bytes of a regular file that fits into memory."""
    status = path.stat()
    if not stat.S_ISREG(status.st_mode):
        # Opening a FIFO would wait for its writer, and a device may be endless.
        what = "a folder" if stat.S_ISDIR(status.st_mode) else "not a regular file"
        raise ValueError(f"it is {what}")
    if status.st_size > memory_of_machine():
        raise ValueError("it is larger than the memory of this machine")
    return path.read_bytes()


def _check_digest(path: Path, content: bytes) -> None:
    """Refuse a file that has changed since it was written; files of other programs pass."""
    mark, digits = content[-_LENGTH:-64], content[-64:]
    if mark == _MARK:
        if mark + digits != _digest(memoryview(content)[:-_LENGTH]):
            raise _damage(path, "its digest does not match")
        return
    # If a few bits of the mark or of the attribute are damaged, the other of the two still shows
    # that the file had a digest.
    near = sum(one == other for one, other in zip(mark, _MARK, strict=False)) >= len(_MARK) // 2
    if near or _STATEMENT.encode() in content:
        raise _damage(path, "its digest is missing")
    if not content.startswith(_HDF5):
        remedy = "; give the .nc file that `harness run` wrote" if path.suffix == ".toml" else ""
        raise ArchiveError(f"{path}: cannot be read: it is not a netCDF-4 file{remedy}")
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
    return image[: _end(image)]  # HDF5 enlarges a file in memory in steps of 64 KiB


def _end(content: bytes | memoryview) -> int:
    """Size of an HDF5 file [byte], from its superblock (HDF5 File Format Specification, II.A)."""
    start = 28 if int.from_bytes(content[8:9], "little") >= 2 else 40
    return int.from_bytes(content[start : start + 8], "little")


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, Any]]:
    """Compress numeric arrays; give coordinates no fill value, because CF forbids it."""
    encoding: dict[Hashable, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        numeric = np.issubdtype(variable.dtype, np.number)
        encoding[name] = {"zlib": True, "shuffle": True} if numeric and variable.ndim else {}
        if name in dataset.coords:
            encoding[name]["_FillValue"] = None
    return encoding
