"""The clay of a scene: perfectly plastic, softening or with a rate effect, or of any law."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.fields.checked import Group, refuse
from mpm_warp.fields.declaration import Derived, parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.clay_law import LAWS, ClayLaw
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic

NEEDED = (
    ("rate_factor", 0.0, "reference_strain_rate", "in 1/s"),
    ("remoulded_strength_ratio", 1.0, "ductility", "the plastic shear strain of 95 % of the loss"),
)
"""A parameter and its neutral value; a parameter needed for any other value, and its meaning."""
STRAIN_RATE: dict[str, Any] = {"unit": "s-1", "minimum": 1e-12, "maximum": 1e6}
"""Unit and limits of all parameters that are strain rates."""


@dataclass(frozen=True, kw_only=True)
class Clay(Group):
    """Clay of one stiffness and one strength, or of a law with parameters of its own.

    Raises:
        mpm_warp.errors.ParameterError: on construction, also for a rate factor without a reference
            strain rate, a remoulded strength without a ductility, or a law that is not allowed.
    """

    rigidity_index: float = parameter(
        Derived(100.0), "rigidity index G/su", minimum=2, maximum=5000
    )
    material: ClayLaw = parameter(
        "tresca",
        "law of the clay: a yield criterion, or a law with parameters of its own, see `harness "
        "describe LAW`; von_mises: sqrt(J2) = su, as Tresca in pure shear",
        variants=LAWS,
    )
    poissons_ratio: float = parameter(0.49, "Poisson's ratio", minimum=0, maximum=0.4999)
    rate_factor: float = parameter(
        0.0,
        "rate factor mu: relative increase of su per log cycle of strain rate above the reference; "
        "usual: 0.05 to 0.2",
        minimum=0,
        maximum=1,
    )
    reference_strain_rate: float | None = parameter(
        None,
        "shear strain rate at which su holds, in real time; to be given with a rate_factor",
        **STRAIN_RATE,
    )
    remoulded_strength_ratio: float = parameter(
        1.0,
        "strength of remoulded over that of intact clay, 1 / sensitivity; 1: no softening",
        above=0,
        maximum=1,
    )
    ductility: float | None = parameter(
        None,
        "plastic shear strain xi_95 to 95 % of the loss of strength, usual: 10 to 50; to be given "
        "with a remoulded_strength_ratio",
        above=0,
        maximum=1e6,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_stiffness()

    def check(self) -> None:
        """Refuse a law, a rate effect or softening without what belongs to it."""
        law = self.material
        of_criterion = issubclass(law.kind, PerfectlyPlastic) and law.kind.returns_to_criterion()
        if self.strength_changes and not of_criterion:
            raise ParameterError(
                "material",
                f"material = {law.name!r} has a strength, update or state of its own: rate_factor "
                "and remoulded_strength_ratio are of other clay",
            )
        for name, without, needed, what in NEEDED:
            value = getattr(self, name)
            if value != without and getattr(self, needed) is None:
                raise ParameterError(
                    needed, f"{name} = {value:g} needs {needed}, {what}: give both"
                )

    @property
    @abstractmethod
    def undrained_shear_strength(self) -> float:
        """Su of intact clay at the reference strain rate [Pa]."""

    @property
    def is_criterion(self) -> bool:
        """Whether the law is a yield criterion, without parameters of its own."""
        return self.material.name in CRITERIA

    @property
    def strength_changes(self) -> bool:
        """Whether the clay softens or has a rate effect."""
        return self.rate_factor > 0.0 or self.remoulded_strength_ratio < 1.0

    @property
    def own_strength(self) -> float | None:
        """Strength [Pa] in the `reference_test` of a law that has its own; None for other laws.

        It is su of the clay where this is not given.
        """
        if not self.material.has_own_strength:
            return None
        return self.by_law.undrained_strength(self.by_law.reference_test)

    @property
    def by_law(self) -> Material:
        """The intact clay, for the strength, stiffness and stress that the law itself gives."""
        strength = 1.0 if self.material.has_own_strength else self.undrained_shear_strength
        try:
            return self.material.material(
                density=1.0,
                shear_modulus=self.rigidity_index,
                poissons_ratio=self.poissons_ratio,
                strength=strength,
            )
        except SceneError as refusal:
            raise ParameterError("material", str(refusal)) from None

    @property
    def own_anisotropy(self) -> float | None:
        """Stress anisotropy Delta of the ground that the law gives, by K0; None for other laws."""
        if not (self.material.has_own_strength or self.material.has_own_stiffness):
            return None
        deviator = self.by_law.deviator_at_rest
        return None if deviator is None else deviator / (2.0 * self.undrained_shear_strength)

    def derived(self) -> Mapping[str, float]:
        """Strength and rigidity index of a law that has them."""
        found: dict[str, float] = {}
        strength, own = self.undrained_shear_strength, self.own_strength
        if own is not None and isinstance(strength, Derived):
            found["undrained_shear_strength"] = strength = own
        if self.material.has_own_stiffness:
            found["rigidity_index"] = self.by_law.ground_shear_modulus / strength
        return found

    def check_stiffness(self) -> None:
        """Refuse a rigidity index beside a law with another stiffness of its own."""
        if not self.material.has_own_stiffness:
            return
        own = self.by_law.ground_shear_modulus / self.undrained_shear_strength
        if not math.isclose(self.rigidity_index, own):
            has_own = f" with material = {self.material.name!r}, whose stiffness is its own"
            refuse(self, "rigidity_index", f"{has_own}: {own:.6g} su; leave it out")

    def built(
        self,
        *,
        density: float,
        speed_up: float,
        stress_at_rest: Floats,
        greatest_poissons_ratio: float = 0.5,
    ) -> Material:
        """The clay as it is simulated.

        Args:
            density: [kg/m3].
            speed_up: speed of the run over the real one. It scales the reference strain rate, so
                that the rate effect is that of the real test.
            stress_at_rest: of the ground, as of a `Scene` [Pa], shape [4].
            greatest_poissons_ratio: bound of Poisson's ratio.

        Raises:
            ParameterError: the stress at rest is beyond the strength.
            SceneError: the law does not allow a value.
        """
        strength = self.undrained_shear_strength
        given: dict[str, Any] = {
            "shear_modulus": self.rigidity_index * strength,
            "poissons_ratio": min(self.poissons_ratio, greatest_poissons_ratio),
            "density": density,
            "strength": strength,
        }
        intact = self.material.material(**given)
        try:
            intact.check_stress_at_rest(stress_at_rest)
        except SceneError as refusal:
            raise ParameterError("stress_anisotropy", f"stress_anisotropy: {refusal}") from None
        if not (self.strength_changes and isinstance(intact, PerfectlyPlastic)):
            return intact
        return EinavRandolph(
            **given | {"strength": intact.strength},
            criterion=type(intact),
            shape=intact.shape,
            rate_factor=self.rate_factor,
            reference_strain_rate=(self.reference_strain_rate or 1.0) * speed_up,
            remoulded_strength_ratio=self.remoulded_strength_ratio,
            ductility=self.ductility or 1.0,
        )


@dataclass(frozen=True, kw_only=True)
class FieldClay(Clay):
    """Clay of a given strength, which something penetrates at a given real speed."""

    undrained_shear_strength: float = parameter(
        Derived(20e3),
        "undrained shear strength su in pure shear",
        unit="Pa",
        minimum=1e-3,
        maximum=1e9,
    )
    density: float = parameter(
        1700.0, "density of the clay", unit="kg m-3", minimum=1e-3, maximum=1e9
    )
    penetration_speed: float = parameter(
        0.02,
        "speed of the real penetration, for the rate effect; the speed of the run is speed_ratio",
        unit="m s-1",
        minimum=1e-9,
        maximum=1e3,
    )

    def at_speed(
        self, speed_ratio: float, stress_at_rest: Floats, greatest_poissons_ratio: float = 0.5
    ) -> Material:
        """The clay in a run at a speed over that of shear waves, see `built`."""
        shear_modulus = self.rigidity_index * self.undrained_shear_strength
        speed = speed_ratio * math.sqrt(shear_modulus / self.density)
        return self.built(
            density=self.density,
            speed_up=speed / self.penetration_speed,
            stress_at_rest=stress_at_rest,
            greatest_poissons_ratio=greatest_poissons_ratio,
        )
