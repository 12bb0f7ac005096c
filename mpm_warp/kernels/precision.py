"""The floating point types of a run, chosen once and captured by every kernel."""

from dataclasses import dataclass
from typing import Any

import warp as wp


@dataclass(frozen=True)
class Precision:
    """Scalar and vector types of one width; `numpy_name` is the name of the scalar in numpy."""

    numpy_name: str
    real: Any
    vec2: Any
    vec3: Any
    vec4: Any
    vec5: Any
    vec7: Any
    mat22: Any


FLOAT64 = Precision(
    "float64",
    wp.float64,
    wp.vec2d,
    wp.vec3d,
    wp.vec4d,
    wp.types.vector(5, wp.float64),
    wp.types.vector(7, wp.float64),
    wp.mat22d,
)
