"""Laws as rate equations, for an integrator that shares nothing with their return.

Clay with strength by direction. Symbols: s stress, L velocity gradient, D its symmetric and W its
skew part, n axis of the ground, f yield function, N its gradient, xi plastic shear strain,
k = su_C R(xi).

    ds/dt = W s - s W + 2 G (dev D - D_p),   dn/dt = W n
    D_p = N <2 G N:D> / (2 G N:N + h)   where f = 0,   dxi/dt = sqrt(2 D_p:D_p)

with h from df/dt = 0, df/dk dk/dxi dxi/dt being its part of softening.

Modified Cam clay. Symbols, compression positive: s deviator as three principal values, p effective
mean stress, p_c size of the yield surface, e rate of strain (its volume stays), L rate of the
plastic multiplier.

    n_p = 2 p - p_c,   n_s = 3 s / M^2                          normal of the yield surface
    L = (n_s : 2 G e) / (n_s : 2 G n_s + K' n_p^2 + b p p_c n_p)     where f = 0 and n_s : e > 0
    ds = 2 G (e - L n_s),   dp = -K' L n_p,   dp_c = b p_c L n_p
"""

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from mpm_warp import Anisotropic, ModifiedCamClay
from mpm_warp.grid.fitted import Floats

Path = Callable[[float], Floats]


def elastic_then_plastic(
    rates: tuple[Callable[[float, Floats], Floats], Callable[[float, Floats], Floats]],
    outside: Callable[[float, Floats], float],
    state: Floats,
    end: float,
    *,
    rounding: float,
    atol: float,
) -> Path:
    """The path of a state by its (elastic, plastic) rates, from a time of 0 to an end.

    It is elastic until `outside` has risen to zero, but for rounding.
    """

    def yields(time: float, state: Floats) -> float:
        return outside(time, state)

    yields.terminal, yields.direction = True, 1.0  # type: ignore[attr-defined]
    options: dict[str, Any] = {"method": "LSODA", "rtol": 1e-10, "atol": atol, "dense_output": True}
    begin, first = 0.0, None
    if outside(0.0, state) < -rounding:
        first = scipy.integrate.solve_ivp(rates[0], (0.0, end), state, events=yields, **options)
        begin, state = float(first.t[-1]), first.y[:, -1]
    then = scipy.integrate.solve_ivp(rates[1], (begin, max(end, begin + 1e-9)), state, **options)

    def at(time: float) -> Floats:
        return first.sol(time) if first is not None and time < begin else then.sol(time)

    return at


SMALL = 1e-6
"""Step of central differences of f, over the strength: errors of 1e-10 of its gradient."""


@dataclass(frozen=True, kw_only=True)
class Softening:
    """R = delta + (1 - delta) exp(-3 xi / xi_95)."""

    remoulded: float = 1.0
    ductility: float = 1.0

    def ratio(self, plastic: float) -> float:
        return self.remoulded + (1.0 - self.remoulded) * np.exp(-3.0 * plastic / self.ductility)

    def slope(self, plastic: float) -> float:
        return -3.0 / self.ductility * (self.ratio(plastic) - self.remoulded)


INTACT = Softening()


def yield_function(clay: Anisotropic, stress: Floats, axis: Floats, ratio: float = 1.0) -> float:
    """f of a stress [3, 3] in the order r, theta, z, tension positive; ratio of the strengths."""
    C, E, D, H = ratio * np.array(
        [
            clay.strength_compression,
            clay.strength_extension,
            clay.strength_simple_shear,
            clay.strength_horizontal,
        ]
    )
    V = np.sqrt(D**2 - 0.25 * (C - E) ** 2)
    around = np.array([0.0, 1.0, 0.0])
    across = np.cross(around, axis)
    s_a, s_b, s_t = (-(it @ stress @ it) for it in (axis, across, around))
    eta, zeta, t = s_a - 0.5 * (s_b + s_t), 0.5 * (s_b - s_t), axis @ stress @ across
    return float(((eta - (C - E)) / (C + E)) ** 2 + (zeta / H) ** 2 + (t / V) ** 2 - 1.0)


def stress_along(
    clay: Anisotropic,
    gradient: tuple[float, ...],
    times: Iterable[float] = (1.0,),
    *,
    start: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    softening: Softening = INTACT,
) -> Floats:
    """Stresses (rr, zz, rz, tt) at times [s], up to one second, shape [n, 4].

    The velocity gradient is (rr, rz, zr, zz, tt).
    """
    rr, rz, zr, zz, tt = gradient
    L = np.array([[rr, 0.0, rz], [0.0, tt, 0.0], [zr, 0.0, zz]])
    D, W = 0.5 * (L + L.T), 0.5 * (L - L.T)
    G, K = clay.shear_modulus, clay.bulk_modulus
    elastic = 2.0 * G * (D - np.trace(D) / 3.0 * np.eye(3)) + K * np.trace(D) * np.eye(3)

    def parts(state: Floats) -> tuple[Floats, Floats, float]:
        return state[:9].reshape(3, 3), state[9:12], float(state[12])

    def outside(_time: float, state: Floats) -> float:
        stress, axis, plastic = parts(state)
        return yield_function(clay, stress, axis, softening.ratio(plastic))

    def elastic_rates(_time: float, state: Floats) -> Floats:
        stress, axis, _ = parts(state)
        rate = W @ stress - stress @ W + elastic
        return np.concatenate([rate.ravel(), W @ axis, [0.0]])

    def plastic_rates(time: float, state: Floats) -> Floats:
        stress, axis, plastic = parts(state)
        ratio = softening.ratio(plastic)
        N = _gradient(lambda it: yield_function(clay, it, axis, ratio), stress, clay.strength)
        step = SMALL
        by_ratio = (
            yield_function(clay, stress, axis, ratio + step)
            - yield_function(clay, stress, axis, ratio - step)
        ) / (2.0 * step)
        # dot f = N : (elastic - 2 G N rate) + by_ratio slope sqrt(2 N:N) rate = 0
        NN = float(np.sum(N * N))
        stiffness = 2.0 * G * NN - by_ratio * softening.slope(plastic) * np.sqrt(2.0 * NN)
        rate = max(0.0, float(np.sum(N * elastic)) / stiffness)
        change = elastic_rates(time, state)
        change[:9] -= (2.0 * G * rate * N).ravel()
        change[12] = np.sqrt(2.0 * NN) * rate
        return change

    rr, zz, rz, tt = start
    first = np.array([[rr, 0.0, rz], [0.0, tt, 0.0], [rz, 0.0, zz]])
    state: NDArray[np.float64] = np.concatenate([first.ravel(), [0.0, 0.0, 1.0, 0.0]])
    rates, atol = (elastic_rates, plastic_rates), 1e-11 * clay.strength
    path = elastic_then_plastic(rates, outside, state, 1.0, rounding=1e-12, atol=atol)
    return np.array([path(time)[[0, 8, 2, 4]] for time in times])


def _gradient(function: Callable[[Floats], float], stress: Floats, strength: float) -> Floats:
    """df/ds of a symmetric stress [3, 3]; f is quadratic, so central differences are exact."""
    found = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            change = np.zeros((3, 3))
            change[i, j] += 0.5 * strength
            change[j, i] += 0.5 * strength
            found[i, j] = (function(stress + change) - function(stress - change)) / (2 * strength)
    return found


def integrated(
    clay: ModifiedCamClay, direction: Floats, strain: float, *, deviator: Floats
) -> Path:
    """(s, p, p_c) by shear strain, at constant volume [Pa], shape [5].

    Args:
        clay: with the same M in all directions.
        direction: principal strains per shear strain, compression positive, shape [3].
        strain: shear strain at the end.
        deviator: principal values of the deviator at the start [Pa], shape [3].
    """
    M, a = clay.critical_state_ratio, clay.specific_volume / clay.swelling_slope
    b = clay.specific_volume / (clay.compression_slope - clay.swelling_slope)
    nu = clay.effective_poissons_ratio
    r = 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu)

    def surface(_strain: float, state: Floats) -> float:
        s, p, pc = state[:3], state[3], state[4]
        return 1.5 * float(s @ s) / M**2 + p * (p - pc)

    def elastic(_strain: float, state: Floats) -> Floats:
        return np.append(2.0 * r * a * state[3] * direction, [0.0, 0.0])

    def plastic(_strain: float, state: Floats) -> Floats:
        s, p, pc = state[:3], state[3], state[4]
        K = a * p
        G = r * K
        n_p, n_s = 2.0 * p - pc, 3.0 * s / M**2
        hardening = 2.0 * G * float(n_s @ n_s) + K * n_p**2 + b * p * pc * n_p
        L = max(0.0, 2.0 * G * float(n_s @ direction) / hardening)
        return np.array([*(2.0 * G * (direction - L * n_s)), -K * L * n_p, b * pc * L * n_p])

    start = clay.mean_effective_stress
    state = np.array([*deviator, start, start * clay.size_ratio])
    return elastic_then_plastic(
        (elastic, plastic), surface, state, strain, rounding=1e-9 * start**2, atol=1e-9 * start
    )


def cavity_wall(
    clay: ModifiedCamClay, path: Path, strain: float, *, factor: float
) -> tuple[float, float]:
    """Total radial stress and pore pressure over those at first, where the strain is `strain` [Pa].

    Equilibrium, from afar inward: d(stress) = 2 k tau dr / r, in terms of the strain of points.

    Args:
        clay: the clay.
        path: its state by shear strain, the radius first among the directions, the hoop second.
        strain: shear strain there, m ln(r / r0).
        factor: k, 1 for the cylinder and 4/3 for the sphere.
    """

    def grown(log_strain: float) -> float:
        gamma = math.exp(log_strain)
        s = path(gamma)
        return 0.5 * float(s[0] - s[1]) * gamma / math.expm1(gamma)

    begin = path(0.0)
    pieces = np.linspace(math.log(1e-9), math.log(strain), 60)
    total = sum(
        scipy.integrate.quad(grown, one, other, epsabs=0.0, epsrel=1e-9)[0]
        for one, other in itertools.pairwise(pieces.tolist())
    )
    end = path(strain)
    effective = end[3] + end[0] - begin[3] - begin[0]
    return factor * total, factor * total - effective
