"""The interface of a material law; each law is one file.

A law maps the stress of a point, its strain in a step, the time step, its properties and its state
to the new stress and state. It defines its elasticity, the initial state of a point, its plastic
change of volume, a bound of its wave speed and a check of its stress. Features that a law lacks are
not compiled. Most laws are subclasses of `Isotropic`, which has constant elastic moduli.
"""

import functools
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.arguments import POSITIVE, Checked, as_array, check_array, check_kind, checked
from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import real, vec4, vector
from mpm_warp.materials.variation import Variation
from mpm_warp.parameters import check_own

PROPERTIES = "particle.properties"
"""The array of the properties of each point of a material that varies, shape [slot_count]."""
ADHESION_RATIO = "particle.adhesion_ratio"
"""The array of the adhesion ratio of each point, where it varies; shape [slot_count]."""

ALWAYS = ("update", "moduli")
TAKEN = {"update": 5, "moduli": 3, "yield_function": 3, "strength_function": 3, "turn": 2}
"""Methods of a material that give the functions of its `Law`, those that no law is without, and how
many arguments each function takes."""

EFFECTIVE_STRESS, PORE_PRESSURE = "effective_mean_stress", "excess_pore_pressure"
"""Two numbers of the state of a law with effective stress [Pa], compression positive."""


@dataclass(frozen=True)
class Law:
    """The functions of a material on the device.

    Stresses and strains are (rr, zz, rz, tt), tension positive, rz that of the tensor. `properties`
    holds the material's `properties`, `state` what the point remembers, both as vectors.
    """

    # (stress, strain, time step, properties, state) -> (stress, state) after a step; the stress has
    # been turned by the spin already
    update: Any
    moduli: Any  # (stress, properties, state) -> (G, K), the elastic moduli [Pa] at that stress
    # (stress, properties, state) -> (f, k): the material yields where the measure f of the stress
    # [Pa] reaches k [Pa]; None where it never does
    yield_function: Any
    # (stress, properties, state) -> undrained shear strength [Pa], which the adhesion of a surface
    # beside the point follows; None where nothing changes it
    strength: Any
    # (state, motion) -> state, of a law whose ground has an axis that turns with the soil; the
    # motion is what `motion_of` gives. None where there is no axis
    turn: Any
    properties_type: Any  # type of the vector of properties
    state_type: Any  # type of the vector that a point remembers
    remembers: bool  # whether points do; otherwise `state` is of length 1 and is not kept
    varies: bool  # whether each point has properties of its own
    of_point: Any  # (properties, states, number of a point) -> (properties, state) of that point

    @property
    def properties_argument(self) -> Any:
        """Type of the argument of a kernel that holds the properties: one for all, or an array."""
        return wp.array(dtype=self.properties_type) if self.varies else self.properties_type


@dataclass(frozen=True, kw_only=True)
class Material(Checked, ABC):
    """A law with its numbers. A new one is a subclass in a file of its own, which may be a user's.

    Attributes:
        density: rho [kg/m3], > 0.
        variation: strength, stiffness and adhesion from place to place, over those of the material;
            None: they are the same everywhere.
    """

    density: float = checked(POSITIVE, unit="kg/m3")
    variation: Variation | None = None

    reference_test: ClassVar[str] = "simple_shear"
    """The element test whose strength is what scenes call su, of a law that has its own."""

    def __post_init__(self) -> None:
        super().__post_init__()
        try:
            check_own(self)
        except ParameterError as refusal:
            raise SceneError(f"{type(self).__name__}: {refusal}") from None
        if self.variation is None:
            return
        name, rows = type(self).__name__, self.variation.rows
        if rows is None and type(self).properties_at is Material.properties_at:
            raise SceneError(f"{name} has no properties that vary by place")
        for number, row in enumerate(rows or ()):
            check_kind(f"{name}: variation.rows[{number}]", row, type(self))

    # The law on the device.

    @abstractmethod
    def update(self) -> Any:
        """The function of a step; what it takes and gives is said in `Law`."""

    @abstractmethod
    def moduli(self) -> Any:
        """The function of the elastic moduli, see `Law`."""

    def yield_function(self) -> Any | None:
        """The check of the stress, see `Law`; None: there is none."""
        return None

    def strength_function(self) -> Any | None:
        """The undrained shear strength, see `Law`; by default the second of `yield_function`."""
        yield_function = self.yield_function()
        if yield_function is None:
            return None
        return _make_strength(yield_function)

    def turn(self) -> Any | None:
        """How the axis of the ground turns, see `Law`; None: there is none."""
        return None

    # Its numbers.

    @property
    @abstractmethod
    def properties(self) -> tuple[float, ...]:
        """The numbers that the law takes beside stress, strain and state; at least one."""

    @property
    def state(self) -> tuple[str, ...]:
        """Names of the numbers that a material point remembers."""
        return ()

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """State of points that start, or enter, with a stress at a place; 0 by default.

        It has the numbers that `state` names, shape [..., state_count]. The stress is (rr, zz, rz,
        tt) [Pa], shape [..., 4], the place (r, z) in the ground [m], [..., 2]; see `Variation`.
        """
        return np.zeros((*place.shape[:-1], len(self.state)))

    def check_stress_at_rest(self, stress: Floats) -> None:
        """Raise a `SceneError` where the ground may not have a stress before anything moves.

        By default it may have any; (rr, zz, rz, tt) over the ground's pressure [Pa], shape [4].
        """
        return

    def properties_at(self, place: Floats) -> Floats:
        """`properties` of points that come from places in ground that varies, [..., count]."""
        return self.by_depth(place, lambda material: material.properties)

    def by_depth(self, place: Floats, numbers: Callable[[Any], Sequence[float] | Floats]) -> Floats:
        """Numbers of a material, a vector, at places; linear between rows of its ground."""
        if self.variation is None or self.variation.rows is None:
            return np.tile(numbers(self), (*place.shape[:-1], 1))
        rows = self.variation.rows
        by_row = np.array([numbers(row) for row in rows])
        return np.stack([self.variation.at(place, number) for number in by_row.T], axis=-1)

    # What the run asks of it.

    @property
    @abstractmethod
    def ground_shear_modulus(self) -> float:
        """G of undisturbed ground [Pa], of the stiffest where it varies."""

    @property
    @abstractmethod
    def pressure_wave_speed(self) -> float:
        """A bound on the speed of pressure waves [m/s], which the time step follows."""

    @property
    def shear_wave_speed(self) -> float:
        """sqrt(G / rho) of undisturbed ground [m/s]."""
        return float((self.ground_shear_modulus / self.density) ** 0.5)

    @property
    def limit_pressure(self) -> float:
        """Pressure [Pa] that a cavity in an endless body of the material cannot exceed."""
        return math.inf

    def undrained_strength(self, test: str) -> float | None:
        """Strength in an element test [Pa]: half of the extreme principal stresses' difference.

        The mode is as triaxial_compression, see the scene `element_test`. None where the law does
        not tell, as by default.
        """
        return None

    @property
    def deviator_at_rest(self) -> float | None:
        """Vertical less horizontal stress in the ground before [Pa]; by default the scene's."""
        return None

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats | None:
        """By what a step changes the mean stress [Pa], for the watch to compare, shape [n].

        Of points are given the volume strain in the step, expansion positive, [n], properties [n,
        count], and, where they have one, the state before and after, [n, count]. None where the law
        does not tell, as by default: the watch compares nothing then.
        """
        return None

    def ratio_at(self, place: Floats, name: str) -> Floats:
        """A ratio of `Variation`, "stiffness_ratio" say, at places in the ground; 1 without one."""
        ratio = getattr(self.variation, name, None)
        if self.variation is None or ratio is None:
            return np.ones(place.shape[:-1])
        return self.variation.at(place, ratio)

    def law(self) -> Law:
        """The material's functions on the device; `SceneError` where they or its numbers are none.

        Warp would say so only where they are compiled, by kernels that the law is called in.
        """
        name = type(self).__name__
        check_array(f"{name}.properties", as_array(self.properties), (None,))
        if len(self.properties) == 0:
            raise SceneError(f"{name}.properties is empty, must have a number at least")
        check_kind(f"{name}.state", self.state, (tuple, list))
        for method, taken in TAKEN.items():
            function = getattr(self, method)()
            if function is None and method not in ALWAYS:
                continue
            check_kind(f"{name}.{method}()", function, wp.Function)
            given = len(function.input_types)
            if given != taken:
                raise SceneError(
                    f"{name}.{method}() = {function.key} takes {given} arguments, must take {taken}"
                )
        varies, remembers = self.variation is not None, len(self.state) > 0
        state_type = vector(max(1, len(self.state)))
        return Law(
            update=self.update(),
            moduli=self.moduli(),
            yield_function=self.yield_function(),
            strength=self.strength_function(),
            turn=self.turn(),
            properties_type=vector(len(self.properties)),
            state_type=state_type,
            remembers=remembers,
            varies=varies,
            of_point=_make_of_point(varies, remembers, state_type),
        )


@functools.cache
def _make_strength(yield_function: Any) -> Any:
    @wp.func
    def strength(stress: vec4, properties: Any, state: Any) -> real:
        return yield_function(stress, properties, state)[1]

    return strength


def principal_stresses(stress: Floats) -> Floats:
    """Principal stresses [Pa], shape [..., 3], of (rr, zz, rz, tt), [..., 4]; the last is tt."""
    rr, zz, rz, tt = np.moveaxis(stress, -1, 0)
    centre, radius = 0.5 * (rr + zz), np.hypot(0.5 * (rr - zz), rz)
    return np.stack([centre + radius, centre - radius, tt], axis=-1)


_REGISTERED: dict[type, str] = {}
"""Names of laws of other packages, by class."""


def register_name(kind: type[Material], name: str) -> None:
    """Say by what name a law of another package is known."""
    _REGISTERED[kind] = name


def built_name(part: object) -> str:
    """What a part of a scene is, whatever its parameters are called.

    `tresca`, `penetrometer_contact`: the class in small letters; that of another package by the
    name of its entry point, or by its place, as `their_package.clay.HardeningClay`.
    """
    kind = type(part)
    if kind in _REGISTERED:
        return _REGISTERED[kind]
    if kind.__module__.partition(".")[0] == __package__.partition(".")[0]:
        return re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower()
    return f"{kind.__module__}.{kind.__qualname__}".replace("<locals>.", "")


@functools.cache
def _make_of_point(varies: bool, remembers: bool, state_type: Any) -> Any:
    @wp.func
    def of_point(properties: Any, states: wp.array[state_type], point: int):
        own = properties[point] if wp.static(varies) else properties
        state = states[point] if wp.static(remembers) else state_type()
        return own, state

    return of_point
