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


def rigidity_index(minimum: float, maximum: float) -> Any:
    """The field `rigidity_index` of a scene, Ir, between these bounds."""
    return parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=minimum, maximum=maximum
    )


def undrained_shear_strength(meaning: str) -> Any:
    """The field `undrained_shear_strength` of a scene, su [Pa]."""
    return parameter(20e3, unit="Pa", meaning=meaning, minimum=1e-3, maximum=1e9)


def poissons_ratio(default: float = 0.49, minimum: float = 0) -> Any:
    """The field `poissons_ratio` of a scene, nu, from this least value on."""
    return parameter(default, unit="1", meaning="Poisson's ratio", minimum=minimum, maximum=0.4999)


def density_of_clay() -> Any:
    """The field `density` of a scene in clay [kg/m3]."""
    return parameter(
        1700.0, unit="kg m-3", meaning="density of the clay", minimum=1e-3, maximum=1e9
    )


def adhesion_factor(surface: str) -> Any:
    """The field `adhesion_factor` of a scene, alpha, of this surface."""
    return parameter(
        0.0, unit="1", meaning=f"adhesion factor of the {surface}", minimum=0, maximum=1
    )


def shaft_adhesion_factor() -> Any:
    """The field `shaft_adhesion_factor` of a penetrometer; the scene derives it."""
    return parameter(
        None,
        unit="1",
        meaning="adhesion factor of the shaft (default: the face's)",
        minimum=0,
        maximum=1,
    )


def cone_radius() -> Any:
    """The field `cone_radius` of a penetrometer, R [m]; a standard one has 10 cm2."""
    return parameter(
        0.01785, unit="m", meaning="radius of the cone's base", minimum=1e-6, maximum=1e3
    )


def apex_angle(maximum: float = 150) -> Any:
    """The field `apex_angle` of a cone [degree], up to this one."""
    return parameter(
        60.0, unit="degree", meaning="apex angle of the cone", minimum=30, maximum=maximum
    )


def stress_anisotropy() -> Any:
    """The field `stress_anisotropy` of a penetrometer's ground, Delta."""
    return parameter(
        0.0,
        unit="1",
        meaning="stress anisotropy Delta in the ground before: vertical less horizontal stress "
        "over 2 su",
        above=-1,
        below=1,
    )


def penetration_speed() -> Any:
    """The field `penetration_speed` of a penetrometer [m/s]; that of a test is 20 mm/s."""
    return parameter(
        0.02,
        unit="m s-1",
        meaning="speed of the real penetration, which strain rates are of; the run has its own, "
        "speed_ratio",
        minimum=1e-9,
        maximum=1e3,
    )


def speed_ratio(maximum: float, default: float | None = 0.03, otherwise: str = "") -> Any:
    """The field `speed_ratio` of a penetrometer, the speed of its run.

    Args:
        maximum: up to which it is allowed.
        default: a number, or None where the scene derives it.
        otherwise: in words, what the scene derives.
    """
    derived = f" (default: {otherwise})" if otherwise else ""
    meaning = f"penetration speed over shear wave speed{derived}"
    return parameter(default, unit="1", meaning=meaning, minimum=1e-4, maximum=maximum)


def cell_growth() -> Any:
    """The field `cell_growth` of a grid around a penetrometer."""
    return parameter(
        0.4,
        unit="1",
        meaning="growth of the cells' width per distance from the penetrometer",
        minimum=0.1,
        maximum=2,
    )


def time_step_fraction() -> Any:
    """The field `time_step_fraction` of a scene."""
    return parameter(
        0.85, unit="1", meaning="time step over the critical one", minimum=0.01, maximum=1.2
    )


def domain_radius(default: str, accuracy: str = "") -> Any:
    """The field `domain_radius` of a grid around a penetrometer; the scene derives it.

    Args:
        default: what it is where none is given, in words.
        accuracy: how exactly a given one is kept, in words.
    """
    meaning = f"radius of the grid over cone radius{accuracy} (default: {default})"
    return parameter(None, unit="1", meaning=meaning, minimum=5, maximum=1000)


def domain_above(default: str) -> Any:
    """The field `domain_above` of a grid around a penetrometer; see `domain_radius`."""
    meaning = f"extent of the grid above the shoulder over cone radius (default: {default})"
    return parameter(None, unit="1", meaning=meaning, minimum=2, maximum=500)


def domain_below(default: str) -> Any:
    """The field `domain_below` of a grid around a penetrometer; see `domain_radius`."""
    meaning = f"extent of the grid below the tip over cone radius (default: {default})"
    return parameter(None, unit="1", meaning=meaning, minimum=2, maximum=500)
