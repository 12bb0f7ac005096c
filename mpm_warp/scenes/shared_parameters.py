"""Groups of parameters that several scenes have; a scene takes them by inheriting a group.

Where a scene differs in a default, a range or a meaning, it declares that parameter again by
`mpm_warp.parameters.redefined`.
"""

from __future__ import annotations

from dataclasses import dataclass

from mpm_warp.parameters import parameter
from mpm_warp.precision import PRECISIONS


@dataclass(frozen=True, kw_only=True)
class ConeInGround:
    """A cone penetrometer and the stress of the ground around it."""

    adhesion_factor: float = parameter(
        0.0, "adhesion factor of the cone face", minimum=0, maximum=1
    )
    shaft_adhesion_factor: float = parameter(
        None, "adhesion factor of the shaft (default: the face's)", minimum=0, maximum=1
    )
    # A standard cone has a base of 10 cm2.
    cone_radius: float = parameter(
        0.01785, "radius of the cone's base", unit="m", minimum=1e-6, maximum=1e3
    )
    stress_anisotropy: float = parameter(
        0.0,
        "stress anisotropy Delta in the ground before: vertical less horizontal stress over 2 su",
        above=-1,
        below=1,
    )


@dataclass(frozen=True, kw_only=True)
class ConeGrid:
    """The grid around a cone penetrometer, its time step and its numbers."""

    cell_growth: float = parameter(
        0.4, "growth of the cells' width per distance from the penetrometer", minimum=0.1, maximum=2
    )
    time_step_fraction: float = parameter(
        0.85, "time step over the critical one", minimum=0.01, maximum=1.2
    )
    domain_radius: float = parameter(
        None,
        "radius of the grid over cone radius, to the nearest cell "
        "(default: 4 sqrt(Ir), 40 at least)",
        minimum=5,
        maximum=1000,
    )
    domain_above: float = parameter(
        None,
        "extent of the grid above the shoulder over cone radius "
        "(default: 1.3 sqrt(Ir), 13 at least)",
        minimum=2,
        maximum=500,
    )
    domain_below: float = parameter(
        None,
        "extent of the grid below the tip over cone radius (default: sqrt(Ir), 14 at least)",
        minimum=2,
        maximum=500,
    )
    precision: str = parameter(
        "float64", "floating point numbers of the simulation", choices=tuple(PRECISIONS)
    )
