"""Clay that softens as it is sheared, and is the stronger the faster it is sheared.

After Einav & Randolph (2005, Int. J. Numer. Meth. Eng. 63:1991-2016). Symbols: f the measure of the
yield criterion, of a stress and of a strain alike; k strength, su that of intact clay at the
reference strain rate; xi plastic shear strain so far, S share of the loss of strength that is still
to come; gd shear strain rate; G shear modulus.

    k  = su R [delta + (1 - delta) S]
    S  = exp(-3 xi / xi_95),   R = 1 + mu log10(max(gd / gd_ref, 1))
    gd = 2 f(e) / dt                           Tresca: e_1 - e_3, von Mises: sqrt(2 dev e : dev e)
    f(trial) - G dxi = k(xi + dxi, gd)         the return, implicit in the plastic shear strain

A point remembers 1 - S, the share that is lost, not xi: a return multiplies S by exp(-3 dxi /
xi_95), and no exponential is taken of a point that stays elastic.

Both criteria take G dxi off their measure as they return, Tresca on sides and in corners alike. So
in proportional shear f + G xi = G gamma to rounding, whatever the size of the steps.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import NOT_NEGATIVE, POSITIVE, Range, checked
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import one, real, two, vec2, vec4, zero
from mpm_warp.materials.elasticity import elastic_increment
from mpm_warp.materials.perfectly_plastic import (
    STRENGTH,
    PerfectlyPlastic,
    UndrainedClay,
    limit_pressure,
    make_shape,
)

STEEPEST = 0.5
"""Greatest slope of the strength over G; at 1 the stress would fall without any strain."""
LARGEST_RATE = 1e6
"""Shear strain rate over that of reference which slope and limit pressure count with."""


@dataclass(frozen=True, kw_only=True)
class EinavRandolph(UndrainedClay):
    """Softening by accumulated plastic shear strain, and a logarithmic effect of its rate.

    Attributes:
        strength: su, that of intact clay at the reference strain rate [Pa], > 0.
        criterion: the perfectly plastic material that it is at any moment: Tresca, VonMises.
        rate_factor: mu, what a log cycle of strain rate adds to the strength, over it; >= 0.
        reference_strain_rate: gd_ref, in the time of the run [1/s], > 0.
        remoulded_strength_ratio: delta, strength when remoulded over that when intact, > 0, <= 1.
        ductility: xi_95, plastic shear strain at which 95 % of the loss is done, > 0.
        shape: that of the criterion, where it has one.

    Raises:
        SceneError: a value is not allowed, or the strength falls too steeply to be followed.
    """

    criterion: type[PerfectlyPlastic]
    rate_factor: float = checked(NOT_NEGATIVE)
    reference_strain_rate: float = checked(POSITIVE, unit="1/s")
    remoulded_strength_ratio: float = checked(Range(above=0.0, maximum=1.0))
    ductility: float = checked(POSITIVE)
    shape: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.slope > STEEPEST:
            least = self.ductility * self.slope / STEEPEST
            raise SceneError(
                f"EinavRandolph: ductility = {self.ductility:g} is too brittle, must be >= "
                f"{least:.2g}: its strength falls by {self.slope:.2g} G, {STEEPEST:g} G can be "
                "followed"
            )

    @property
    def softens(self) -> bool:
        """Whether plastic shear strain changes the strength."""
        return self.remoulded_strength_ratio < 1.0

    @property
    def depends_on_rate(self) -> bool:
        """Whether the strain rate changes the strength."""
        return self.rate_factor > 0.0

    @property
    def slope(self) -> float:
        """Greatest fall of the strength per plastic shear strain, over G: that of intact clay."""
        fall = 3.0 * (1.0 - self.remoulded_strength_ratio) / self.ductility
        ground, over_stiffness = self.variation, 1.0
        if ground is not None:
            over_stiffness = float((ground.strength_ratio / ground.stiffness_ratio).max())
        return over_stiffness * fall * self._greatest_strength / self.shear_modulus

    @property
    def state(self) -> tuple[str, ...]:
        """1 - S, and R - 1 when last near yield: what changes the strength."""
        softening = ("lost_share",) if self.softens else ()
        rate = ("rate_effect",) if self.depends_on_rate else ()
        return (*softening, *rate, *self.criterion.axis)

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """See `Material`: intact, slow, its axis vertical."""
        state = super().state_at(stress, place)
        start = tuple(self.criterion.axis.values())
        state[..., state.shape[-1] - len(start) :] = start
        return state

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K, su, delta, 3 / xi_95, mu / ln 10, 1 / gd_ref), and the shape."""
        return (
            *super().properties,
            self.remoulded_strength_ratio,
            3.0 / self.ductility,
            self.rate_factor / math.log(10.0),
            1.0 / self.reference_strain_rate,
            *self.shape,
        )

    @property
    def limit_pressure(self) -> float:
        """Of intact clay at the largest rate that counts [Pa]."""
        return limit_pressure(self.shear_modulus, self._greatest_strength)

    def update(self) -> Any:
        """Return to the surface of the criterion, as large as strain and rate leave it."""
        return self._functions[0]

    def yield_function(self) -> Any:
        """The measure of the criterion, and the strength k."""
        return self._functions[1]

    def turn(self) -> Any | None:
        """That of the criterion."""
        return self.criterion.turn(self)

    @property
    def _functions(self) -> tuple[Any, Any]:
        return _make_functions(self.criterion, self.softens, self.depends_on_rate)

    @property
    def _greatest_strength(self) -> float:
        return self.strength * (1.0 + self.rate_factor * math.log10(LARGEST_RATE))


@functools.cache
def _make_functions(
    criterion: type[PerfectlyPlastic], softens: bool, depends_on_rate: bool
) -> tuple[Any, Any]:
    """The update and the yield function."""
    measure, within, nearest = criterion.measure, criterion.within, criterion.nearest
    shape_of, shear_measure = make_shape(criterion), criterion.shear_measure
    softened, nonlinear = criterion.softened, criterion.softened is not None

    @wp.func
    def strength(properties: Any, lost: real) -> vec2:
        """(k / R, what of it strain can still take) [Pa]."""
        k, left = properties[wp.static(STRENGTH)], real(0.0)
        if wp.static(softens):
            remoulded = properties[3] * k
            left = (k - remoulded) * (one - lost)
            k = remoulded + left
        return vec2(k, left)

    @wp.func
    def recalled(state: Any) -> vec2:
        """(1 - S, R - 1)."""
        lost = state[0] if wp.static(softens) else zero
        rate_effect = state[wp.static(int(softens))] if wp.static(depends_on_rate) else zero
        return vec2(lost, rate_effect)

    @wp.func
    def remembered(state: Any, lost: real, rate_effect: real):
        if wp.static(softens):
            state[0] = lost
        if wp.static(depends_on_rate):
            state[wp.static(int(softens))] = rate_effect
        return state

    @wp.func
    def measure_and_strength(stress: vec4, properties: Any, state: Any) -> vec2:
        known = recalled(state)
        k = (one + known[1]) * strength(properties, known[0])[0]
        return vec2(measure(stress, shape_of(properties, state)), k)

    @wp.func
    def soften_and_return(stress: vec4, strain: vec4, time_step: real, properties: Any, state: Any):
        G, decay = properties[0], properties[4]
        trial = stress + elastic_increment(strain, G, properties[1])
        lost, rate_effect = recalled(state)[0], real(0.0)
        known = strength(properties, lost)
        k, left = known[0], known[1]
        shape = shape_of(properties, state)
        # No rate takes the strength below this.
        if within(trial, k, shape):
            return trial, state
        if wp.static(depends_on_rate):
            rate = two / time_step * shear_measure(strain, shape)
            rate_effect = properties[5] * wp.log(wp.max(rate * properties[6], one))
            k *= one + rate_effect
            left *= one + rate_effect
            if within(trial, k, shape):
                return trial, remembered(state, lost, rate_effect)
        kept = real(1.0)
        if wp.static(softens and nonlinear):
            kept = softened(trial, k, left, G, decay, shape)
        elif wp.static(softens):
            # Newton's method for f - G dxi = k - left (1 - exp(-3 dxi / xi_95)): in steps of 1e-3
            # its first error is 1e-6, its second 1e-12 of the strain. What is left is a strain, for
            # the stress is put on the surface.
            f = measure(trial, shape)
            plastic = (f - k) / (G - decay * left)
            kept = wp.exp(-decay * plastic)
            missing = f - G * plastic - k + left * (one - kept)
            kept *= one - decay * missing / (G - decay * left * kept)
        if wp.static(softens):
            k -= left * (one - kept)
            lost = one - (one - lost) * kept
        return nearest(trial, k, shape), remembered(state, lost, rate_effect)

    return soften_and_return, measure_and_strength
