"""Types and constants of all kernels, in double precision. The import starts Warp.

Warp converts no literals to double precision, so constants have names here.
"""

import functools
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import warp as wp

from mpm_warp.errors import KernelCacheError, SceneError


def _start_warp_in_silence() -> None:
    """Start Warp without its greeting, and without its remark on a machine without a GPU.

    A log level that the user has changed from the default is kept.
    """
    if wp.config.log_level == wp.LOG_INFO:
        wp.config.log_level = wp.LOG_WARNING
    if sys.stderr is None:  # there is no standard error to keep clean
        wp.init()
        return
    kept = os.dup(2)
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), 2)  # the remark does not come from Python
        try:
            wp.init()
        finally:
            os.dup2(kept, 2)
            os.close(kept)


@contextmanager
def kernels_kept() -> Iterator[None]:
    """Raise `KernelCacheError`, with a remedy, if Warp cannot store compiled kernels."""
    try:
        yield
    except KernelCacheError:
        raise
    except OSError as error:
        folder = wp.config.kernel_cache_dir or error.filename
        raise KernelCacheError(
            f"compiled kernels cannot be kept in {folder}: {error.strerror}; set WARP_CACHE_PATH "
            "to a folder that can be written to"
        ) from None


NOT_UNDERSTOOD = re.compile(
    r'(?s:.*)Error while parsing function "(.*?)" at (.*):\d+:\n(.*)\n;((?s:.*))'
)
"""How Warp says which function it cannot make a kernel of; those that call it come before.

Named are the function, its file, the line of code and what is wrong.
"""


@contextmanager
def functions_understood() -> Iterator[None]:
    """Raise `SceneError`, of one line, where Warp cannot make a kernel of a function of a law."""
    try:
        yield
    except Exception as error:  # of any class: what Warp met there, with the place put before it
        found = NOT_UNDERSTOOD.fullmatch(str(error.args[0]) if error.args else "")
        if found is None:
            raise
        function, file, line, problem = (" ".join(part.split()) for part in found.groups())
        raise SceneError(
            f"no kernel can be made of the function {function} in {file}: {problem}, in: {line}"
        ) from None


with kernels_kept():
    _start_warp_in_silence()


kernel = functools.partial(wp.kernel, module="unique", enable_backward=False)
"""Decorator of a kernel. Each is a module of its own, named by its code and what it captures."""


def vector(length: int) -> Any:
    """The type of vectors of a length."""
    return wp.types.vector(length, real)


def maybe(dtype: Any, ndim: int = 1) -> Any:
    """The type of an array that a plan may lack; a kernel must not read it then."""
    kind = wp.array(dtype=dtype, ndim=ndim)
    kind.may_be_absent = True
    return kind


real = wp.float64
vec1, vec2, vec3, vec4, vec5, vec7, vec10 = (vector(length) for length in (1, 2, 3, 4, 5, 7, 10))
mat22 = wp.types.matrix((2, 2), real)
zero, quarter, third, half, one, two = (
    wp.constant(real(number)) for number in (0.0, 0.25, 1.0 / 3.0, 0.5, 1.0, 2.0)
)
