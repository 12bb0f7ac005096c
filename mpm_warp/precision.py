"""The floating point types of a run, chosen once and captured by every kernel."""

from dataclasses import dataclass
from typing import Any

import warp as wp


@dataclass(frozen=True)
class Precision:
    """Scalar and vector types of one width; `numpy_name` is the name of the scalar in numpy.

    `double` is the same in each: for what a step adds so little to that it would be rounded away.
    """

    numpy_name: str
    real: Any
    vec2: Any
    vec3: Any
    vec4: Any
    vec5: Any
    vec7: Any
    vec10: Any
    vec11: Any
    mat22: Any
    double: Any = wp.float64


def _precision(numpy_name: str, real: Any) -> Precision:
    vectors = (wp.types.vector(length, real) for length in (2, 3, 4, 5, 7, 10, 11))
    return Precision(numpy_name, real, *vectors, wp.types.matrix((2, 2), real))


FLOAT64 = _precision("float64", wp.float64)
PRECISIONS = {"float64": FLOAT64, "float32": _precision("float32", wp.float32)}
"""By the name of the scalar."""
