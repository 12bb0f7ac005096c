"""Rate equations of clay with strength by direction, for an integrator that knows no return.

Symbols: s stress, L velocity gradient, D its symmetric and W its skew part, n axis of the ground, f
yield function, N its gradient, xi plastic shear strain, k = su_C R(xi).

    ds/dt = W s - s W + 2 G (dev D - D_p),   dn/dt = W n
    D_p = N <2 G N:D> / (2 G N:N + h)   where f = 0,   dxi/dt = sqrt(2 D_p:D_p)

with h from df/dt = 0, df/dk dk/dxi dxi/dt being its part of softening.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.anisotropic import Anisotropic
from tests.mpm_warp.materials.cam_clay_rates import elastic_then_plastic

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


def stress_after(
    clay: Anisotropic,
    gradient: tuple[float, ...],
    *,
    start: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    softening: Softening = INTACT,
) -> Floats:
    """Stress (rr, zz, rz, tt) after a second at a velocity gradient (rr, rz, zr, zz, tt)."""
    return stress_along(clay, gradient, np.ones(1), start=start, softening=softening)[0]


def stress_along(
    clay: Anisotropic,
    gradient: tuple[float, ...],
    times: Floats,
    *,
    start: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    softening: Softening = INTACT,
) -> Floats:
    """Stresses at times [s], up to one second, shape [n, 4]; the others as in `stress_after`."""
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
