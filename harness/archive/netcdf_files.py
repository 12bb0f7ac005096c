"""The netCDF files of the archive; all are written, opened and read here.

Every file ends with a digest: after the netCDF data come the mark ``sha256: `` and the SHA-256 of
all bytes before it. Both are checked before the netCDF library opens the file, because a damaged
file can make HDF5 raise any exception, loop forever, request gigabytes, or end the process. So what
the library opens is as this program wrote it, and its content is not checked again. A file without
the mark, such as one that xarray has written anew, is never opened.

HDF5's own checksum (Fletcher32) does not cover attributes, names and dims. A digest of the contents
would need all variables to be read first, 23 ms a case file; this one takes 0.1 ms. Programs that
read netCDF do not notice it, because HDF5 stops at the end that the superblock states.
"""

import hashlib
import os
import stat
from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np
import xarray as xr
from xarray.backends import NetCDF4DataStore

from harness.archive.atomic_files import ArchiveError, DamagedError, NoFileError, write_whole

FORMAT_VERSION = 1
"""Version of the layout of result files, of cases and of studies."""

FIRST = (
    *("title", "study", "site", "scene", "scene_version", "status", "message", "case_key"),
    *("source", "history"),
)
"""Attributes that a reader looks for, in order; a file made in memory does not keep one."""

_MARK = b"sha256: "
_LENGTH = len(_MARK) + 64


class Stored(NamedTuple):
    """The attributes and variables of a file; values of variables are read on demand."""

    attributes: Mapping[str, Any]
    variables: Mapping[str, xr.Variable]


def write_netcdf(dataset: xr.Dataset, path: Path) -> None:
    """Write a netCDF file with its digest, whole or not at all."""
    # The file is made in memory. On a full disk the netCDF library only says "HDF error" and keeps
    # the broken file open, so that its space is not freed until the process ends.
    image = netcdf_image(dataset.assign_attrs(format_version=FORMAT_VERSION))
    write_whole(b"".join((image, _digest(image))), path)


def read_netcdf(path: Path) -> xr.Dataset:
    """Read a file of the archive into memory; dates stay numbers."""
    with opened(path) as stored:
        encoded = xr.Dataset(stored.variables, attrs=stored.attributes)
        found = xr.decode_cf(encoded, concat_characters=False, decode_times=False).load()
    others = sorted(found.attrs.keys() - {*FIRST, "format_version"})  # it belongs to the file
    found.attrs = {name: found.attrs[name] for name in (*FIRST, *others) if name in found.attrs}
    return found[[*found.data_vars, *found.coords]].drop_encoding()


def read_attributes(path: Path) -> dict[str, Any]:
    """Read only the attributes of a file."""
    with opened(path) as stored:
        return dict(stored.attributes)


@contextmanager
def opened(path: Path) -> Iterator[Stored]:
    """Open a file of the archive, undamaged and of this format.

    Raises:
        NoFileError: there is no file.
        DamagedError: it has the mark of the harness and a wrong digest.
        ArchiveError: it cannot be read for another reason: no mark, another format, not allowed, an
            error of disk or memory.
    """
    try:
        # The checked bytes are read from memory, so a change of the file meanwhile has no effect.
        with netCDF4.Dataset(path.name, memory=_content(path)) as file:
            variables, attributes = NetCDF4DataStore(file).load()
            version = attributes["format_version"]
            if version != FORMAT_VERSION:
                raise ArchiveError(
                    f"{path}: cannot be read: it has format {version}, this program reads "
                    f"{FORMAT_VERSION}; use the program that wrote it, or run the study anew"
                )
            yield Stored(attributes, variables)
    except FileNotFoundError:
        raise NoFileError(f"{path}: no such file") from None
    except (OSError, RuntimeError, MemoryError) as error:
        reason = getattr(error, "strerror", None) or str(error) or "not enough memory"
        raise ArchiveError(f"{path}: cannot be read: {reason}") from None


def _content(path: Path) -> bytes:
    """The bytes of a file whose mark and digest are right."""
    if not stat.S_ISREG(path.stat().st_mode):  # a FIFO would wait, and a device may be endless
        raise ArchiveError(f"{path}: cannot be read: it is no file but a folder or a device")
    with path.open("rb") as file:
        size = file.seek(0, os.SEEK_END)
        file.seek(max(0, size - _LENGTH))
        digest = file.read()
        if not digest.startswith(_MARK):
            raise ArchiveError(f"{path}: cannot be read: {_foreign(path)}")
        file.seek(0)
        content = file.read(size - _LENGTH)
    if digest != _digest(content):
        raise DamagedError(
            f"{path}: cannot be read: it was damaged or changed after it was written (its digest "
            "does not match)"
        )
    return content


def _foreign(path: Path) -> str:
    if path.suffix == ".toml":
        return "it is no result; give the .nc file that `harness run` wrote"
    return (
        "the mark of this program is missing at its end: it was cut, or written by another "
        "program, as by xarray (`xarray.open_dataset` reads it then)"
    )


def _digest(content: bytes | memoryview) -> bytes:
    return _MARK + hashlib.sha256(content).hexdigest().encode()


def netcdf_image(dataset: xr.Dataset) -> memoryview:
    """The content of a netCDF file, without its digest."""
    # Not `to_netcdf`, which first loads Dask where it is installed: as long as all else here takes.
    file = netCDF4.Dataset("in memory", "w", memory=0)
    dataset.dump_to_store(NetCDF4DataStore(file, mode="w"), encoding=_encoding(dataset))
    image: memoryview = file.close()
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
