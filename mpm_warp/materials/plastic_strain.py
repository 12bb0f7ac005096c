"""Any material, whose points also add up the plastic shear strain that its law makes.

Symbols: G shear modulus, tau trial stress, sigma stress after the law, dev the deviator. A law
changes stress by plastic strain, and the deviator of that is

    de = dev(tau - sigma) / (2 G),    gamma <- gamma + sqrt(2 de:de)

so gamma, in pure shear, is the plastic part of the engineering shear strain.
"""

import functools
from dataclasses import dataclass, replace
from typing import Any, Self

import warp as wp

from mpm_warp.materials.material import Law, Material
from mpm_warp.materials.von_mises import make_j2
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True)
class PlasticStrain(Material):
    """A material as it is, with one more number of state, the last: the plastic shear strain.

    Stresses are those of the material alone, to the last bit.

    Attributes:
        of: the material.
    """

    of: Material

    @classmethod
    def added_up_of(cls, material: Material) -> Self:
        """The material, with its plastic shear strain added up."""
        return cls(
            shear_modulus=material.shear_modulus,
            poissons_ratio=material.poissons_ratio,
            density=material.density,
            of=material,
        )

    @property
    def state(self) -> tuple[str, ...]:  # type: ignore[override]
        """What the material remembers, and the plastic shear strain."""
        return (*self.of.state, "plastic_shear_strain")

    @property
    def properties(self) -> tuple[float, ...]:
        """Those of the material, and its shear modulus [Pa]."""
        return (*self.of.properties, self.shear_modulus)

    @property
    def limit_pressure(self) -> float:
        """That of the material [Pa]."""
        return self.of.limit_pressure

    def update(self, precision: Precision) -> Any:
        """The update of the material; the plastic shear strain is added up."""
        return _make_update(self.of.law(precision), self._counts, precision)

    def yield_function(self, precision: Precision) -> Any | None:
        """That of the material."""
        law = self.of.law(precision)
        if law.yield_function is None:
            return None
        return _make_yield_function(law, self._counts, precision)

    def law(self, precision: Precision) -> Law:
        """The functions on the device, told from those of another material."""
        own = self.of.law(precision)
        return replace(super().law(precision), key=f"plastic_strain.{own.key}")

    @property
    def _counts(self) -> tuple[int, int]:
        """How many properties and numbers of state the material itself has."""
        return len(self.of.properties), len(self.of.state)


@functools.cache
def _make_parts(counts: tuple[int, int], law: Law, precision: Precision) -> tuple[Any, Any]:
    """The functions that give a material its own properties, and its own state."""
    property_count, state_count = counts
    own_properties_type, own_state_type = law.properties_type, law.state_type
    properties_type = precision.vector(property_count + 1)
    state_type = precision.vector(state_count + 1)

    @wp.func
    def own_properties(properties: properties_type) -> own_properties_type:
        own = own_properties_type()
        for i in range(wp.static(property_count)):
            own[i] = properties[i]
        return own

    @wp.func
    def own_state(state: state_type) -> own_state_type:
        own = own_state_type()
        for i in range(wp.static(state_count)):
            own[i] = state[i]
        return own

    return own_properties, own_state


@functools.cache
def _make_yield_function(law: Law, counts: tuple[int, int], precision: Precision) -> Any:
    own_properties, own_state = _make_parts(counts, law, precision)
    vec2, vec4 = precision.vec2, precision.vec4
    properties_type, state_type = (precision.vector(count + 1) for count in counts)
    yield_function: Any = law.yield_function

    @wp.func
    def yields_as_it_does(stress: vec4, properties: properties_type, state: state_type) -> vec2:
        return yield_function(stress, own_properties(properties), own_state(state))

    return yields_as_it_does


@functools.cache
def _make_update(law: Law, counts: tuple[int, int], precision: Precision) -> Any:
    property_count, state_count = counts
    own_properties, own_state = _make_parts(counts, law, precision)
    real, vec4 = precision.real, precision.vec4
    properties_type, state_type = (precision.vector(count + 1) for count in counts)
    own_update, j2 = law.update, make_j2(precision)

    @wp.func
    def update_and_add_up(
        trial: vec4, strain: vec4, time_step: real, properties: properties_type, state: state_type
    ):
        sigma, own = own_update(
            trial, strain, time_step, own_properties(properties), own_state(state)
        )
        remembered = state
        for i in range(wp.static(state_count)):
            remembered[i] = own[i]
        square = j2(trial - sigma)
        if square > real(0.0):
            remembered[wp.static(state_count)] += wp.sqrt(square) / properties[property_count]
        return sigma, remembered

    return update_and_add_up
