"""Clay of a scene: perfectly plastic, or one whose strength changes with strain and its rate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.parameters import parameter

NEEDED = (
    ("rate_factor", 0.0, "reference_strain_rate", "in 1/s"),
    ("remoulded_strength_ratio", 1.0, "ductility", "the plastic shear strain of 95 % of the loss"),
)
"""Where the first is not the second, the third must be given, which is the fourth."""


class ChangingClay(Protocol):
    """A scene with these parameters, of its clay."""

    @property
    def material(self) -> str:
        """Yield criterion, a name of `CRITERIA`."""

    @property
    def rate_factor(self) -> float:
        """See `rate_factor`."""

    @property
    def reference_strain_rate(self) -> float | None:
        """See `reference_strain_rate`."""

    @property
    def remoulded_strength_ratio(self) -> float:
        """See `remoulded_strength_ratio`."""

    @property
    def ductility(self) -> float | None:
        """See `ductility`."""


def rate_factor() -> Any:
    """The field `rate_factor` of a scene, mu."""
    return parameter(
        0.0,
        unit="1",
        meaning="rate factor mu: what a log cycle of strain rate above the reference adds to su, "
        "over it; usual: 0.05 to 0.2",
        minimum=0,
        maximum=1,
    )


def reference_strain_rate() -> Any:
    """The field `reference_strain_rate` of a scene [1/s], in real time."""
    return parameter(
        None,
        unit="s-1",
        meaning="shear strain rate at which su holds, in real time; to be given with a rate_factor",
        minimum=1e-12,
        maximum=1e6,
    )


def remoulded_strength_ratio() -> Any:
    """The field `remoulded_strength_ratio` of a scene, delta_rem."""
    return parameter(
        1.0,
        unit="1",
        meaning="strength of remoulded over that of intact clay, 1 / sensitivity; 1: no softening",
        above=0,
        maximum=1,
    )


def ductility() -> Any:
    """The field `ductility` of a scene, xi_95."""
    return parameter(
        None,
        unit="1",
        meaning="plastic shear strain xi_95 at which 95 % of the loss of strength is done, usual: "
        "10 to 50; to be given with a remoulded_strength_ratio",
        above=0,
        maximum=1e6,
    )


def clay_of(
    scene: ChangingClay,
    *,
    shear_modulus: float,
    poissons_ratio: float,
    density: float,
    strength: float,
    speed_up: float,
) -> PerfectlyPlastic:
    """The clay of a scene; perfectly plastic where neither strain nor rate changes its strength.

    Args:
        scene: whose parameters say how the strength changes.
        shear_modulus: G [Pa], > 0.
        poissons_ratio: nu, 0 <= nu < 0.5.
        density: rho [kg/m3], > 0.
        strength: su, of intact clay at the reference strain rate [Pa], > 0.
        speed_up: speed of the run over that in reality, > 0: strain rates count as in reality.
    """
    intact = CRITERIA[scene.material](
        shear_modulus=shear_modulus,
        poissons_ratio=poissons_ratio,
        density=density,
        strength=strength,
    )
    if scene.rate_factor == 0.0 and scene.remoulded_strength_ratio == 1.0:
        return intact
    return EinavRandolph(
        shear_modulus=shear_modulus,
        poissons_ratio=poissons_ratio,
        density=density,
        strength=strength,
        criterion=type(intact),
        rate_factor=scene.rate_factor,
        reference_strain_rate=(scene.reference_strain_rate or 1.0) * speed_up,
        remoulded_strength_ratio=scene.remoulded_strength_ratio,
        ductility=scene.ductility or 1.0,
    )


def check_clay(scene: ChangingClay, clay: Callable[[], PerfectlyPlastic]) -> None:
    """Check what the parameters of a clay must be together; for `__post_init__`.

    Args:
        scene: whose parameters are valid, each by itself.
        clay: makes its clay.

    Raises:
        ParameterError: a rate factor without a reference strain rate, a remoulded strength without
            a ductility, or a strength that falls too steeply.
    """
    for name, without, needed, what in NEEDED:
        value = getattr(scene, name)
        if value != without and getattr(scene, needed) is None:
            raise ParameterError(needed, f"{name} = {value:g} needs {needed}, {what}: give both")
    try:
        clay()
    except SceneError as refusal:
        raise ParameterError("ductility", str(refusal)) from None
