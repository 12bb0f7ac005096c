"""Modified Cam clay as rate equations, for an integrator that shares nothing with the law.

Symbols, compression positive: s deviator as three principal values, p effective mean stress, p_c
size of the yield surface, e rate of strain (its volume stays), L rate of the plastic multiplier.

    n_p = 2 p - p_c,   n_s = 3 s / M^2                          normal of the yield surface
    L = (n_s : 2 G e) / (n_s : 2 G n_s + K' n_p^2 + b p p_c n_p)     where f = 0 and n_s : e > 0
    ds = 2 G (e - L n_s),   dp = -K' L n_p,   dp_c = b p_c L n_p
"""

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.modified_cam_clay import ModifiedCamClay

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
