"""Parameters that several scenes have, so that they are the same in each."""

from __future__ import annotations

from typing import Any

from mpm_warp.materials import CRITERIA
from mpm_warp.parameters import parameter
from mpm_warp.precision import PRECISIONS


def yield_criterion() -> Any:
    """The field `material` of a scene: how its soil yields, a name of `CRITERIA`."""
    return parameter(
        "tresca",
        unit="1",
        meaning="yield criterion; von_mises: sqrt(J2) = su, as Tresca in pure shear",
        choices=tuple(CRITERIA),
    )


def floating_point() -> Any:
    """The field `precision` of a scene: its floating point numbers, a name of `PRECISIONS`."""
    return parameter(
        "float64",
        unit="1",
        meaning="floating point numbers of the simulation",
        choices=tuple(PRECISIONS),
    )
