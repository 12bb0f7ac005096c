"""What a netCDF file holds, as it is stored: its outline, and its numbers on demand.

A file of another program may make HDF5 loop, ask for gigabytes or end the process. So it is read by
a process of its own, which runs this module as a script: it imports nothing that takes long.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import resource
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np

NUMBERS, TEXT = "biuf", "T"
"""Kinds of variables: those of numbers as NumPy calls them, and texts."""
UNREADABLE = (
    *(OSError, RuntimeError, ValueError, TypeError, AttributeError),
    *(LookupError, ArithmeticError, MemoryError, AssertionError),
)
"""What netCDF4 and HDF5 raise where a file is not what they expect."""

TIME_LIMIT = 10
"""Seconds that a file of another program may take to be read."""
MEMORY, MEMORY_OF_BYTE = 2 << 30, 30
"""Bytes of memory that such a file may take in any case, and for each byte that it has."""
_LARGEST_RATIO = 1032
"""Bytes that one byte compressed by deflate stands for at most (zlib's technical details)."""
_STRING_SIZE = 64
"""Bytes that a text takes in memory at least."""


class Form(NamedTuple):
    """What a variable is, without its values; kind: one of `NUMBERS`, `TEXT`, or another letter."""

    shape: tuple[int, ...]
    dims: tuple[str, ...]
    kind: str
    attributes: Mapping[str, Any]


class Outline(NamedTuple):
    """What a file holds: attributes, the forms of its variables, and what reads their values."""

    attributes: Mapping[str, Any]
    forms: Mapping[str, Form]
    values: Callable[[str], np.ndarray]


def outline(file: netCDF4.Dataset, byte_count: int) -> Outline:
    """What is in an open file of so many bytes; its numbers are as they are stored.

    Raises:
        ValueError: it says that it holds more than its bytes or this machine's memory can.
    """
    file.set_auto_maskandscale(False)
    sizes = [
        math.prod(variable.shape)
        * (_STRING_SIZE if variable.dtype is str else np.dtype(variable.dtype).itemsize)
        for variable in file.variables.values()
    ]
    if sum(sizes) > min(memory_of_machine(), _LARGEST_RATIO * byte_count):
        raise ValueError(f"its variables would take {sum(sizes):.3g} bytes, more than it can hold")
    forms = {
        name: Form(variable.shape, variable.dimensions, _kind(variable), variable.__dict__)
        for name, variable in file.variables.items()
    }
    return Outline(file.__dict__, forms, lambda name: np.asarray(file.variables[name][...]))


def _kind(variable: netCDF4.Variable[Any]) -> str:
    if variable.dtype is str:
        return TEXT
    # Those of an enumeration or of lists have the type of their elements.
    return variable.dtype.kind if isinstance(variable.datatype, np.dtype) else "V"


def memory_of_machine() -> int:
    """Bytes of memory that this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def foreign_outline(path: Path) -> Outline:
    """What another program's file holds, read by a process that may be lost; or a `ValueError`."""
    command = [sys.executable, "-P", __file__, os.fspath(path.absolute())]
    try:
        done = subprocess.run(command, capture_output=True, check=False, timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        raise ValueError(f"the netCDF library is not done with it in {TIME_LIMIT} s") from None
    if done.returncode:
        raise ValueError(f"the netCDF library ends by it (code {done.returncode})")
    answer = pickle.loads(done.stdout)
    if isinstance(answer, str):
        raise ValueError(answer)
    attributes, variables = answer
    forms = {name: Form(*form) for name, (form, _) in variables.items()}
    return Outline(attributes, forms, lambda name: variables[name][1])


def _answer(path: Path) -> object:
    """All that a file holds in plain types, or in words why it cannot be read."""
    try:
        with netCDF4.Dataset(path) as file:
            found = outline(file, path.stat().st_size)
            variables = {
                name: (tuple(form), found.values(name)) for name, form in found.forms.items()
            }
            return found.attributes, variables
    except UNREADABLE as error:
        return " ".join(str(error).split()) or type(error).__name__


def _limit_this_process(path: Path) -> None:
    """Let this process take no more time and memory than a file of another program may take."""
    resource.setrlimit(resource.RLIMIT_CPU, (TIME_LIMIT, TIME_LIMIT))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with contextlib.suppress(OSError):  # only Linux says what the libraries have taken already
        taken = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
        most = taken + MEMORY + MEMORY_OF_BYTE * path.stat().st_size
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


if __name__ == "__main__":
    foreign = Path(sys.argv[1])
    _limit_this_process(foreign)
    sys.stdout.buffer.write(pickle.dumps(_answer(foreign)))
