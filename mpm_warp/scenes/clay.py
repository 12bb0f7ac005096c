"""Scenes in undrained clay: perfectly plastic, or of a strength that strain and its rate change."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.parameters import parameter
from mpm_warp.scenes.catalogue import CatalogueScene

NEEDED = (
    ("rate_factor", 0.0, "reference_strain_rate", "in 1/s"),
    ("remoulded_strength_ratio", 1.0, "ductility", "the plastic shear strain of 95 % of the loss"),
)
"""Where the first is not the second, the third must be given, which is the fourth."""


@dataclass(frozen=True, kw_only=True)
class Clay:
    """Parameters of clay of one stiffness, over its strength."""

    rigidity_index: float = parameter(100.0, "rigidity index G/su", minimum=2, maximum=5000)
    material: str = parameter(
        "tresca",
        "yield criterion; von_mises: sqrt(J2) = su, as Tresca in pure shear",
        choices=tuple(CRITERIA),
    )
    poissons_ratio: float = parameter(0.49, "Poisson's ratio", minimum=0, maximum=0.4999)


@dataclass(frozen=True, kw_only=True)
class ChangingStrength:
    """Parameters of strength that plastic strain and its rate change."""

    rate_factor: float = parameter(
        0.0,
        "rate factor mu: what a log cycle of strain rate above the reference adds to su, "
        "over it; usual: 0.05 to 0.2",
        minimum=0,
        maximum=1,
    )
    reference_strain_rate: float | None = parameter(
        None,
        "shear strain rate at which su holds, in real time; to be given with a rate_factor",
        unit="s-1",
        minimum=1e-12,
        maximum=1e6,
    )
    remoulded_strength_ratio: float = parameter(
        1.0,
        "strength of remoulded over that of intact clay, 1 / sensitivity; 1: no softening",
        above=0,
        maximum=1,
    )
    ductility: float | None = parameter(
        None,
        "plastic shear strain xi_95 at which 95 % of the loss of strength is done, usual: "
        "10 to 50; to be given with a remoulded_strength_ratio",
        above=0,
        maximum=1e6,
    )

    @property
    def strength_changes(self) -> bool:
        """Whether strain or its rate changes the strength of the clay."""
        return self.rate_factor > 0.0 or self.remoulded_strength_ratio < 1.0


@dataclass(frozen=True, kw_only=True)
class ClayScene(ChangingStrength, Clay, CatalogueScene):
    """A scene in clay of one stiffness and one strength.

    Raises:
        mpm_warp.errors.ParameterError: on construction, also for a rate factor without a reference
            strain rate, a remoulded strength without a ductility, or a strength that falls too
            steeply.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, without, needed, what in NEEDED:
            value = getattr(self, name)
            if value != without and getattr(self, needed) is None:
                raise ParameterError(
                    needed, f"{name} = {value:g} needs {needed}, {what}: give both"
                )
        try:
            _ = self.clay
        except SceneError as refusal:
            raise ParameterError("ductility", str(refusal)) from None

    @property
    @abstractmethod
    def clay(self) -> UndrainedClay:
        """The clay of the run, made by `clay_with`."""

    def clay_with(
        self,
        *,
        strength: float,
        density: float,
        speed_up: float,
        greatest_poissons_ratio: float = 0.5,
    ) -> UndrainedClay:
        """The clay; perfectly plastic where neither strain nor rate changes its strength.

        Args:
            strength: su, of intact clay at the reference strain rate [Pa], > 0.
            density: rho [kg/m3], > 0.
            speed_up: speed of the run over that in reality, > 0: strain rates count as in reality.
            greatest_poissons_ratio: what Poisson's ratio is simulated as at most.
        """
        criterion = CRITERIA[self.material]
        intact = criterion(
            shear_modulus=self.rigidity_index * strength,
            poissons_ratio=min(self.poissons_ratio, greatest_poissons_ratio),
            density=density,
            strength=strength,
        )
        if not self.strength_changes:
            return intact
        return EinavRandolph(
            shear_modulus=intact.shear_modulus,
            poissons_ratio=intact.poissons_ratio,
            density=density,
            strength=strength,
            criterion=criterion,
            rate_factor=self.rate_factor,
            reference_strain_rate=(self.reference_strain_rate or 1.0) * speed_up,
            remoulded_strength_ratio=self.remoulded_strength_ratio,
            ductility=self.ductility or 1.0,
        )


@dataclass(frozen=True, kw_only=True)
class FieldClayScene(ClayScene):
    """A scene in clay whose strength is given in pascals, penetrated at a real speed."""

    undrained_shear_strength: float = parameter(
        20e3, "undrained shear strength su in pure shear", unit="Pa", minimum=1e-3, maximum=1e9
    )
    density: float = parameter(
        1700.0, "density of the clay", unit="kg m-3", minimum=1e-3, maximum=1e9
    )
    penetration_speed: float = parameter(
        0.02,
        "speed of the real penetration, which strain rates are of; the run has its own, "
        "speed_ratio",
        unit="m s-1",
        minimum=1e-9,
        maximum=1e3,
    )
