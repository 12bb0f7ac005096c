"""Clay that softens with plastic shear strain and is stronger at a higher strain rate.

After Einav & Randolph (2005, Int. J. Numer. Meth. Eng. 63:1991-2016). Symbols: f measure of the
yield criterion, of a stress or a strain, k strength, su strength of intact clay at the reference
strain rate, xi accumulated plastic shear strain, S remaining share of the strength that can be
lost, gd shear strain rate, G shear modulus.

    k  = su R [delta + (1 - delta) S]
    S  = exp(-3 xi / xi_95),   R = 1 + mu log10(max(gd / gd_ref, 1))
    gd = 2 f(e) / dt                           Tresca: e_1 - e_3, von Mises: sqrt(2 dev e : dev e)
    f(trial) - G dxi = k(xi + dxi, gd)         the return, implicit in the plastic shear strain

The state of a point is 1 - S, the lost share, not xi. A return multiplies S by exp(-3 dxi / xi_95),
so a point that stays elastic needs no exponential.

The return of both criteria reduces f by G dxi, in Tresca's corners too. So in proportional shear
f + G xi = G gamma to rounding, in steps of any size.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.declaration import parameter
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
"""Greatest slope of the strength over G; at 1 the stress would fall without strain."""
LARGEST_RATE = 1e6
"""Shear strain rate over the reference rate, assumed in the slope and the limit pressure."""


@dataclass(frozen=True, kw_only=True)
class EinavRandolph(UndrainedClay):
    """A yield criterion whose strength softens and depends on the strain rate.

    Attributes:
        strength: su of intact clay at the reference strain rate [Pa], > 0.
        criterion: class of the yield criterion, as Tresca or VonMises.
        shape: `shape` of the criterion.

    Raises:
        SceneError: a value is not allowed, or the strength falls too steeply.

    Example:
        >>> clay = EinavRandolph(
        ...     strength=10e3,
        ...     criterion=Tresca,
        ...     shear_modulus=1e6,
        ...     poissons_ratio=0.49,
        ...     density=1700.0,
        ...     rate_factor=0.1,
        ...     reference_strain_rate=1e-5,
        ...     remoulded_strength_ratio=0.2,
        ...     ductility=10.0,
        ... )
        >>> clay.softens, clay.depends_on_rate
        (True, True)
    """

    criterion: type[PerfectlyPlastic]
    rate_factor: float = parameter(
        meaning="mu, gain of strength per log cycle of strain rate, over su", minimum=0
    )
    reference_strain_rate: float = parameter(
        meaning="gd_ref, in the time of the run", unit="1/s", above=0
    )
    remoulded_strength_ratio: float = parameter(
        meaning="delta, remoulded over intact strength", above=0, maximum=1
    )
    ductility: float = parameter(
        meaning="xi_95, plastic shear strain at 95 % of the loss of strength", above=0
    )
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
        """Greatest fall of the strength per plastic shear strain, that of intact clay, over G."""
        fall = 3.0 * (1.0 - self.remoulded_strength_ratio) / self.ductility
        ground, over_stiffness = self.variation, 1.0
        if ground is not None:
            over_stiffness = float((ground.strength_ratio / ground.stiffness_ratio).max())
        return over_stiffness * fall * self._greatest_strength / self.shear_modulus

    @property
    def state(self) -> tuple[str, ...]:
        """1 - S, and R - 1 when the point last was near yield; then the axis."""
        softening = ("lost_share",) if self.softens else ()
        rate = ("rate_effect",) if self.depends_on_rate else ()
        return (*softening, *rate, *self.criterion.axis)

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """See `Material`; intact, without rate effect, with a vertical axis."""
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
        """See `Material`; of intact clay at the largest rate [Pa]."""
        return limit_pressure(self.shear_modulus, self._greatest_strength)

    def update(self) -> Any:
        """See `Material`; return to the surface of the present size."""
        return self._functions[0]

    def yield_function(self) -> Any:
        """(f, k)."""
        return self._functions[1]

    def turn(self) -> Any | None:
        """See `Material`; the turn of the criterion."""
        return self.criterion.turn(self)

    @property
    def _functions(self) -> tuple[Any, Any]:
        return _make_functions(self.criterion, len(self.shape), self.softens, self.depends_on_rate)

    @property
    def _greatest_strength(self) -> float:
        return self.strength * (1.0 + self.rate_factor * math.log10(LARGEST_RATE))


@functools.cache
def _make_functions(
    criterion: type[PerfectlyPlastic], shapes: int, softens: bool, depends_on_rate: bool
) -> tuple[Any, Any]:
    measure, within, nearest = criterion.functions()
    shape_of, shear_measure = make_shape(criterion, shapes), criterion.shear_measure
    softened, nonlinear = criterion.softened, criterion.softened is not None

    @wp.func
    def strength(properties: Any, lost: real) -> vec2:
        """(k / R, its part that softening can still take) [Pa]."""
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
        # The strength is never less than this.
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
            # Newton's method for f - G dxi = k - left (1 - exp(-3 dxi / xi_95)). In steps of 1e-3
            # its first error is 1e-6 of the strain, its second 1e-12. The error is one of strain:
            # the stress is returned to the surface.
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
