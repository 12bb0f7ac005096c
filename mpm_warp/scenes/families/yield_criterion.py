"""The parameter by which scenes choose how the soil yields."""

from __future__ import annotations

from typing import Any

from mpm_warp.materials.materials import CRITERIA
from mpm_warp.parameters import parameter


def yield_criterion() -> Any:
    """The field `material` of a scene, a name of `mpm_warp.materials.materials.CRITERIA`."""
    return parameter(
        "tresca",
        unit="1",
        meaning="yield criterion; von_mises: sqrt(J2) = su, as Tresca in pure shear",
        choices=tuple(CRITERIA),
    )
