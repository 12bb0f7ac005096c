"""What a netCDF file holds, as it is stored: its outline, and its numbers on demand."""

import math
import os
from collections.abc import Callable, Mapping
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


def _kind(variable: "netCDF4.Variable[Any]") -> str:
    if variable.dtype is str:
        return TEXT
    # Those of an enumeration or of lists have the type of their elements.
    return variable.dtype.kind if isinstance(variable.datatype, np.dtype) else "V"


def memory_of_machine() -> int:
    """Bytes of memory that this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
