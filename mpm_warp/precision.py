"""The floating point types of a run, chosen once and captured by every kernel."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import warp as wp

from mpm_warp.errors import KernelCacheError


def _start_warp_in_silence() -> None:
    """Start Warp without its greeting, and without its remark where there is no GPU.

    What a user has set `warp.config.log_level` to other than its default is kept.
    """
    if wp.config.log_level == wp.LOG_INFO:
        wp.config.log_level = wp.LOG_WARNING
    if sys.stderr is None:  # there is no standard error to keep clean
        wp.init()
        return
    kept = os.dup(2)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 2)  # the remark does not come from Python
        try:
            wp.init()
        finally:
            os.dup2(kept, 2)
            os.close(kept)


@contextmanager
def kernels_kept() -> Iterator[None]:
    """Tells what is to be done where Warp cannot keep compiled kernels inside the ``with``.

    Raises:
        KernelCacheError: it cannot.
    """
    try:
        yield
    except OSError as error:
        folder = wp.config.kernel_cache_dir or error.filename
        raise KernelCacheError(
            f"compiled kernels cannot be kept in {folder}: {error.strerror}; set WARP_CACHE_PATH "
            "to a folder that can be written to"
        ) from None


with kernels_kept():
    _start_warp_in_silence()  # whatever is simulated needs the types below: all come by here


@dataclass(frozen=True)
class Precision:
    """Scalar, vector and matrix types of one width.

    Attributes:
        numpy_name: name of the scalar in numpy.
        real: the scalar.
        mat22: matrices of 2 x 2.
        double: 64 bits in every precision: for what a step adds so little to that it would be
            rounded away.
    """

    numpy_name: str
    real: Any
    mat22: Any
    vec2: Any
    vec3: Any
    vec4: Any
    vec5: Any
    vec7: Any
    double: Any = wp.float64

    def vector(self, length: int) -> Any:
        """The type of vectors of that length."""
        return wp.types.vector(length, self.real)

    def type_of(self, kind: str) -> Any:
        """The type of that name: "real", "double", "mat22", or "vec" and a length."""
        if kind.startswith("vec"):
            return self.vector(int(kind.removeprefix("vec")))
        return getattr(self, kind)


def _precision(numpy_name: str, real: Any) -> Precision:
    vectors = (wp.types.vector(length, real) for length in (2, 3, 4, 5, 7))
    return Precision(numpy_name, real, wp.types.matrix((2, 2), real), *vectors)


FLOAT64 = _precision("float64", wp.float64)
PRECISIONS = {"float64": FLOAT64, "float32": _precision("float32", wp.float32)}
"""By the name of the scalar."""
