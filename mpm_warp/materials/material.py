"""The interface of a material law; each law is one file.

A law maps the stress of a point, its strain in a step, the time step, its properties and its state
to the new stress and state. It also defines its elasticity, the initial state of a point, its
plastic change of volume, a bound of its wave speed and a check of its stress. What a law does not
have is not compiled. Most laws are subclasses of `Isotropic`, which has constant elastic moduli.
"""

import functools
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.checks import POSITIVE, as_array, check_array, check_kind, check_number
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import real, vec4, vector
from mpm_warp.materials.variation import Variation

PROPERTIES = "particle.properties"
"""Array of the properties of each point, where they vary by place; shape [slot_count]."""
ADHESION_RATIO = "particle.adhesion_ratio"
"""Array of the adhesion ratio of each point, where it varies by place; shape [slot_count]."""

REQUIRED = ("update", "moduli")
OF_PROPERTIES = ("stress", "properties", "state")
ARGUMENTS = {
    "update": ("stress", "strain", "time_step", "properties", "state"),
    "moduli": OF_PROPERTIES,
    "yield_function": OF_PROPERTIES,
    "strength_function": OF_PROPERTIES,
    "turn": ("state", "motion"),
}
"""Methods of a material that return the functions of its `Law`: those that every law must have, and
the arguments of each function."""

EFFECTIVE_STRESS, PORE_PRESSURE = "effective_mean_stress", "excess_pore_pressure"
"""Names of two state variables of laws with effective stress [Pa], compression positive."""


@dataclass(frozen=True)
class Law:
    """The functions of a material on the device.

    Stresses and strains are (rr, zz, rz, tt), tension positive; rz is the tensor component.
    `properties` and `state` are vectors.
    """

    # (stress, strain, time step, properties, state) -> (stress, state) after a step; the stress
    # given has already been turned by the spin
    update: Any
    moduli: Any  # (stress, properties, state) -> (G, K), the elastic moduli [Pa] at that stress
    # (stress, properties, state) -> (f, k): the material yields where the measure f of the stress
    # [Pa] reaches k [Pa]. None: it never yields
    yield_function: Any
    # (stress, properties, state) -> undrained shear strength [Pa]; the adhesion of a surface beside
    # the point follows it. None: the strength never changes
    strength: Any
    # (state, motion) -> state: turns the axis of the ground with the soil, by the result of
    # `motion_of`. None: the law has no axis
    turn: Any
    properties_type: Any  # type of the vector of properties
    state_type: Any  # type of the state vector
    remembers: bool  # whether points have a state; if not, `state` has length 1 and is not stored
    varies: bool  # whether each point has properties of its own
    of_point: Any  # (properties, states, number of a point) -> (properties, state) of that point

    @property
    def properties_argument(self) -> Any:
        """Type of the kernel argument `properties`: one vector for all points, or an array."""
        return wp.array(dtype=self.properties_type) if self.varies else self.properties_type


@dataclass(frozen=True, kw_only=True)
class Material(Checked, ABC):
    """A law with its parameters. A new law is a subclass, here or in a package of one's own.

    Attributes:
        variation: how strength, stiffness and adhesion vary by place; None: they are uniform.

    Example:
        >>> clay = Tresca(strength=10e3, shear_modulus=1e6, poissons_ratio=0.49, density=1700.0)
        >>> isinstance(clay, Material), round(clay.shear_wave_speed, 1)  # [m/s]
        (True, 24.3)
    """

    density: float = parameter(None, "density rho", unit="kg/m3", above=0)
    variation: Variation | None = None

    reference_test: ClassVar[str] = "simple_shear"
    """Where a law has its own strength, scenes take that in this element test as su."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.variation is None:
            return
        name, rows = type(self).__name__, self.variation.rows
        if rows is None and type(self).properties_at is Material.properties_at:
            raise SceneError(f"{name} has no properties that vary by place")
        for number, row in enumerate(rows or ()):
            check_kind(f"{name}: variation.rows[{number}]", row, type(self))

    def check_complete(self, name: str) -> None:
        """Raise a `SceneError` for a number that only a scene of the catalogue would have given.

        `name` is that of the owner and its field, for the message.
        """
        for own in fields(self):
            if own.type is float and getattr(self, own.name) is None:
                raise SceneError(f"{name}: {type(self).__name__}: {own.name} is missing")

    # The law on the device.

    @abstractmethod
    def update(self) -> Any:
        """The stress update, see `Law`."""

    @abstractmethod
    def moduli(self) -> Any:
        """The elastic moduli, see `Law`."""

    def yield_function(self) -> Any | None:
        """Measure and limit of the stress, see `Law`; None: the material never yields."""
        return None

    def strength_function(self) -> Any | None:
        """The undrained shear strength, see `Law`; by default the k of `yield_function`."""
        yield_function = self.yield_function()
        return None if yield_function is None else _make_strength(yield_function)

    def turn(self) -> Any | None:
        """The turn of the ground's axis, see `Law`; None: the law has no axis."""
        return None

    # Properties and state.

    @property
    @abstractmethod
    def properties(self) -> tuple[float, ...]:
        """Numbers that the update takes beside stress, strain and state; at least one."""

    @property
    def state(self) -> tuple[str, ...]:
        """Names of the state variables of a material point."""
        return ()

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """Initial state variables of points, shape [..., state_count]; 0 by default.

        The stress is (rr, zz, rz, tt) [Pa], shape [..., 4]; the place in the ground is (r, z) [m],
        shape [..., 2], see `Variation`.
        """
        return np.zeros((*place.shape[:-1], len(self.state)))

    def check_stress_at_rest(self, stress: Floats) -> None:
        """Raise a `SceneError` if undisturbed ground cannot have this stress; it can by default.

        The stress is (rr, zz, rz, tt) in excess of the in-situ pressure [Pa], shape [4].
        """
        return

    def properties_at(self, place: Floats) -> Floats:
        """`properties` at places (r, z) in the ground [m], shape [..., property_count]."""
        return self.by_depth(place, lambda material: material.properties)

    def by_depth(self, place: Floats, numbers: Callable[[Any], Sequence[float] | Floats]) -> Floats:
        """A vector of a material at places (r, z) in the ground; linear between rows by depth."""
        if self.variation is None or self.variation.rows is None:
            return np.tile(numbers(self), (*place.shape[:-1], 1))
        rows = self.variation.rows
        by_row = np.array([numbers(row) for row in rows])
        return np.stack([self.variation.at(place, number) for number in by_row.T], axis=-1)

    # What a run needs to know.

    @property
    @abstractmethod
    def ground_shear_modulus(self) -> float:
        """G of the stiffest undisturbed ground [Pa], > 0."""

    @property
    @abstractmethod
    def pressure_wave_speed(self) -> float:
        """A bound on the speed of pressure waves [m/s], > 0; the time step follows from it."""

    @property
    def shear_wave_speed(self) -> float:
        """sqrt(G / rho) of undisturbed ground [m/s]."""
        return float((self.ground_shear_modulus / self.density) ** 0.5)

    @property
    def limit_pressure(self) -> float:
        """Greatest pressure of a cavity in an infinite body of the material [Pa]."""
        return math.inf

    def undrained_strength(self, test: str) -> float | None:
        """Strength [Pa] in an element test: half the difference of the extreme principal stresses.

        The tests, triaxial_compression and others, are those of the scene `element_test`. None, the
        default: unknown.
        """
        return None

    @property
    def deviator_at_rest(self) -> float | None:
        """Vertical less horizontal in-situ stress [Pa]; None, the default: given by the scene."""
        return None

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats | None:
        """Change of the mean stress of n points in a step [Pa], shape [n]; the watch checks it.

        The volume strain is that of the step, expansion positive, shape [n]; the state is that
        before and after it, or None. A law that returns None, the default, is not checked.
        """
        return None

    def ratio_at(self, place: Floats, name: str) -> Floats:
        """The ratio of `Variation` with this name at places (r, z) in the ground; 1 if uniform."""
        ratio = getattr(self.variation, name, None)
        if self.variation is None or ratio is None:
            return np.ones(place.shape[:-1])
        return self.variation.at(place, ratio)

    def law(self) -> Law:
        """The material's functions on the device; `SceneError` if one or a number is not allowed.

        Warp would report a wrong function only when it compiles a kernel that calls it.
        """
        name = type(self).__name__
        check_array(f"{name}.properties", as_array(self.properties), (None,))
        if len(self.properties) == 0:
            raise SceneError(f"{name}.properties is empty, must have a number at least")
        for quantity, unit in (("ground_shear_modulus", "Pa"), ("pressure_wave_speed", "m/s")):
            check_number(f"{name}.{quantity}", getattr(self, quantity), POSITIVE, unit=unit)
        check_kind(f"{name}.state", self.state, (tuple, list))
        for method, arguments in ARGUMENTS.items():
            function = getattr(self, method)()
            if function is None and method not in REQUIRED:
                continue
            check_kind(f"{name}.{method}()", function, wp.Function)
            given = tuple(function.input_types)
            if len(given) != len(arguments):
                raise SceneError(
                    f"{name}.{method}() = {function.key} takes ({', '.join(given)}), must take "
                    f"({', '.join(arguments)})"
                )
        varies, remembers = self.variation is not None, len(self.state) > 0
        state_type = vector(max(1, len(self.state)))  # Warp has no vectors of length 0
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
    """Give a law of another package the name of its entry point."""
    _REGISTERED[kind] = name


def built_name(part: object) -> str:
    """The name of the class of a material or part, as results record it."""
    return class_name(type(part))


def class_name(kind: type) -> str:
    """The name of the class of a material or part.

    It is the class name in snake case, `penetrometer_contact`. A law of another package has the
    name of its entry point, or else its full path, `their_package.clay.HardeningClay`.
    """
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
