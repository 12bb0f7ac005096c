"""The netCDF files of the archive: the one place where they are written, opened and read.

Every file ends with a digest of itself: after the netCDF come the word ``sha256`` and the SHA-256
of all bytes before it. The attribute `digest` of the file says so; a file that has the attribute
and not the digest was changed by another program. Files from before there were digests have
neither, and are read with what the libraries notice.

The digest is over bytes, because it is then checked before any library sees the file. What is
damaged makes these libraries raise whatever they like, ask for gigabytes, or end the process.
HDF5's own checksum (Fletcher32) knows neither attributes, names nor dims. A digest over contents
needs every variable and attribute to be read first: 23 ms a case file, where this one takes 0.1 ms
and spares ``status`` the reading of all variables. Programs that read netCDF do not see it: HDF5
ends a file where its superblock says. A file that another program has written again is refused
even where its numbers are the same.
"""

from __future__ import annotations

import hashlib
import math
import os
import stat
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError, write_whole
from harness.archive.conventions import FORMAT_VERSION
from harness.archive.structure import TEXT, Form, Outline, malformed

DIGEST = "digest"
"""Attribute of a file that ends with its digest."""
COORDINATES = "coordinates"
"""Attribute, of a variable or of the file, that names coordinates which are no dims (CF, 5)."""

_SAID = "SHA-256 of all bytes before it, in the last 72 bytes of the file"
_MARK = b"sha256: "
_LENGTH = len(_MARK) + 64

_UNREADABLE = (
    *(OSError, RuntimeError, ValueError, TypeError, AttributeError),
    *(LookupError, ArithmeticError, MemoryError, AssertionError),
)
"""What netCDF4, HDF5 and xarray raise where a file is not what they expect."""

_LARGEST_RATIO = 1032
"""Bytes that one byte compressed by deflate stands for at most (zlib's technical details)."""
_STRING_SIZE = 64
"""Bytes that a text takes in memory at least."""


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file, whole or not at all, and its digest.

    Raises:
        ArchiveError: it cannot be written; an earlier file of that name is as it was.
    """
    # The file is made in memory, because on a full disk the netCDF library only says "HDF error"
    # and keeps the broken file open, so that its space is not freed until the process ends.
    image = _image(dataset.assign_attrs({DIGEST: _SAID}))
    write_whole(b"".join((image, _digest(image))), path)


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a result into memory.

    Raises:
        ArchiveError: it is damaged, of another format version, or not built as results are.
    """
    with opened_result(path) as (_, found):
        return _loaded(found)


def read_fields_netcdf(path: Path) -> xr.Dataset:
    """Read snapshots into memory: their dims are points and nodes, and they have no headline.

    Raises:
        ArchiveError: the file is damaged, or of another format version.
    """
    with opened(path) as file:
        found = _outline(file)
        check_version(path, found.attributes)
        return _loaded(found)


def _loaded(found: Outline) -> xr.Dataset:
    """All of a file, as xarray reads it, which takes twice as long for a case file.

    Numbers stand for themselves; dates, which no result has, would stay numbers.
    """
    variables: dict[str, xr.Variable] = {}
    coordinates = set(str(found.attributes.get(COORDINATES, "")).split())
    for name, form in found.forms.items():
        attributes = dict(form.attributes)
        attributes.pop("_FillValue", None)
        coordinates.update(str(attributes.pop(COORDINATES, "")).split())
        if name in form.dims:
            coordinates.add(name)
        values = found.values(name)
        if form.kind == TEXT:
            values = values.astype(str)
        elif attributes.pop("dtype", None) == "bool":
            values = values.astype(bool)
        variables[name] = xr.Variable(form.dims, values, attributes)
    return xr.Dataset(
        {name: it for name, it in variables.items() if name not in coordinates},
        {name: it for name, it in variables.items() if name in coordinates},
        # The digest is of the file, not of what was computed.
        {name: it for name, it in found.attributes.items() if name not in (DIGEST, COORDINATES)},
    )


def read_attributes(path: Path) -> dict[str, Any]:
    """Read the attributes of a file of the archive alone.

    Raises:
        ArchiveError: it is damaged.
    """
    with opened(path) as file:
        return dict(file.__dict__)


@contextmanager
def opened_result(path: Path) -> Iterator[tuple[netCDF4.Dataset, Outline]]:
    """A result, checked, and open for reading as `opened` does it, and its outline.

    Raises:
        ArchiveError: it is damaged, of another format version, or not built as results are.
    """
    with opened(path) as file:
        found = _outline(file)
        check_version(path, found.attributes)
        if (fault := malformed(found)) is not None:
            raise ArchiveError(f"{path}: is no whole result: {fault}")
        yield file, found


def _outline(file: netCDF4.Dataset) -> Outline:
    """What is in a file, without its numbers."""
    forms = {
        name: Form(it.shape, it.dimensions, _kind(it), it.__dict__)
        for name, it in file.variables.items()
    }
    return Outline(file.__dict__, forms, lambda name: np.asarray(file.variables[name][...]))


def _kind(variable: netCDF4.Variable[Any]) -> str:
    if variable.dtype is str:
        return TEXT
    # Those of an enumeration or of lists have the type of their elements.
    return variable.dtype.kind if isinstance(variable.datatype, np.dtype) else "V"


@contextmanager
def opened(path: Path) -> Iterator[netCDF4.Dataset]:
    """A file of the archive, checked and open for reading; its numbers are as they are stored.

    What cannot be read of it inside the ``with`` becomes an `ArchiveError` too.

    Raises:
        ArchiveError: it is no file, damaged, or says that it holds more than its bytes or this
            machine's memory can.
    """
    try:
        has_digest = _check_digest(path)
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            if DIGEST in file.ncattrs() and not has_digest:
                raise ArchiveError(_damaged(path, "its digest is missing"))
            _check_size(path, file)
            yield file
    except _UNREADABLE as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ArchiveError(f"{path}: cannot be read: {reason}") from None


def _digest(content: bytes | memoryview) -> bytes:
    return _MARK + hashlib.sha256(content).hexdigest().encode()


def _check_digest(path: Path) -> bool:
    """Whether a file ends with a digest, which is then the right one."""
    about = path.stat()
    if not stat.S_ISREG(about.st_mode):
        # Whoever opens a FIFO waits for its writer, and a device may have no end.
        kind = "a folder" if stat.S_ISDIR(about.st_mode) else "no ordinary file"
        raise ArchiveError(f"{path}: cannot be read: it is {kind}")
    if about.st_size > _memory():
        raise ArchiveError(f"{path}: cannot be read: it is larger than the memory here")
    content = memoryview(path.read_bytes())
    before, digest = content[:-_LENGTH], content[-_LENGTH:]
    if digest[: len(_MARK)] != _MARK:
        return False
    if digest != _digest(before):
        raise ArchiveError(_damaged(path, "its digest does not agree"))
    return True


def _damaged(path: Path, how: str) -> str:
    return f"{path}: cannot be read: it was damaged or changed after it was written ({how})"


def check_version(path: Path, attributes: Mapping[str, Any]) -> None:
    """Refuse a file of another format version.

    Raises:
        ArchiveError: it has one.
    """
    version = attributes.get("format_version")
    if not isinstance(version, int | np.integer) or version != FORMAT_VERSION:
        raise ArchiveError(
            f"{path}: has format version {version}, where {FORMAT_VERSION} can be read"
        )


def _check_size(path: Path, file: netCDF4.Dataset) -> None:
    """Refuse what would take more memory than there is, or than the file can have numbers for."""
    sizes = [
        math.prod(variable.shape)
        * (_STRING_SIZE if variable.dtype is str else np.dtype(variable.dtype).itemsize)
        for variable in file.variables.values()
    ]
    if sum(sizes) > min(_memory(), _LARGEST_RATIO * path.stat().st_size):
        raise ArchiveError(
            f"{path}: cannot be read: its variables would take {sum(sizes):.3g} bytes, "
            "more than it can hold"
        )


def _memory() -> int:
    """Bytes of memory that this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _image(dataset: xr.Dataset) -> memoryview:
    """The bytes of the netCDF file."""
    image: memoryview = dataset.to_netcdf(engine="netcdf4", encoding=_encoding(dataset))
    # In memory HDF5 grows a file by 64 KiB at a time. Where it ends stands in its superblock, from
    # version 2 on in bytes 28 to 35 (HDF5 File Format Specification, III.A).
    has_end = image[8] >= 2
    return image[: int.from_bytes(image[28:36], "little")] if has_end else image


def _encoding(dataset: xr.Dataset) -> dict[Hashable, dict[str, Any]]:
    """Compress arrays of numbers; no fill value in coordinates, which CF forbids."""
    encoding: dict[Hashable, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        numeric = np.issubdtype(variable.dtype, np.number)
        encoding[name] = {"zlib": True, "shuffle": True} if numeric and variable.ndim else {}
        if name in dataset.coords:
            encoding[name]["_FillValue"] = None
    return encoding
