"""The su that factors are over: its test, its size in a law of clay, and factors by another su.

The cone factor is over su, and so are rigidity index, adhesion factor and Delta. In the same clay,
the su' of another test changes all four:

    r = su' / su,  Ir' = Ir / r,  alpha' = alpha / r,  Delta' = Delta / r,  Nc = r Nc'
"""

import functools
import math
from collections.abc import Mapping
from enum import StrEnum
from typing import TypeAlias

import numpy as np
import xarray as xr

from mpm_warp.materials import CRITERIA

Quantity: TypeAlias = float | str | np.ndarray | xr.DataArray
Conditions: TypeAlias = Mapping[str, Quantity]
"""By name: symbols of formulas, parameters of the scene in SI units, `CRITERION`, and the su of
each `StrengthMode` over the su of the case."""
CRITERION = "criterion"


class Criterion(StrEnum):
    """Yield criterion of an analysis."""

    NOT_STATED = "not_stated"
    TRESCA = "tresca"
    VON_MISES = "von_mises"
    MODIFIED_CAM_CLAY = "modified_cam_clay"


class StrengthMode(StrEnum):
    """The test that su is the strength in."""

    NOT_STATED = "not_stated"
    PURE_SHEAR = "pure_shear"
    TRIAXIAL_COMPRESSION = "triaxial_compression"
    PLANE_STRAIN = "plane_strain"


STATED = tuple(mode for mode in StrengthMode if mode is not StrengthMode.NOT_STATED)
MAY_MEAN = StrengthMode.PURE_SHEAR, StrengthMode.TRIAXIAL_COMPRESSION
"""What su may be where its test is not stated."""
OVER_SU = (
    *("Ir", "alpha_c", "alpha_s", "Delta"),
    *("rigidity_index", "adhesion_factor", "shaft_adhesion_factor", "stress_anisotropy"),
)
"""Conditions that are over su, by symbol and by parameter."""


@functools.cache
def in_test_of(law: str, mode: StrengthMode) -> float:
    """The su of a law in a test over that which it is given; NaN for a law with its own su."""
    if law not in CRITERIA:
        return math.nan
    clay = CRITERIA[law](density=1.0, shear_modulus=1.0, poissons_ratio=0.0, strength=1.0)
    strength = clay.undrained_strength(mode)
    return math.nan if strength is None else strength


def of_law(law: str) -> dict[str, Quantity]:
    """The criterion of a law, and its su in each test over the one that it is given."""
    return {CRITERION: law, **{mode: in_test_of(law, mode) for mode in STATED}}


def in_test(conditions: Conditions, mode: StrengthMode) -> xr.DataArray:
    """The su of a test over that of the case; 1 if the test is not stated."""
    return xr.DataArray(conditions.get(mode, 1.0))


def by_su_in(conditions: Conditions, mode: StrengthMode) -> Conditions:
    """The conditions over the su of a test in place of that of the case."""
    ratio = in_test(conditions, mode)
    over = {name: xr.DataArray(conditions[name]) / ratio for name in OVER_SU if name in conditions}
    return {**conditions, **over}
