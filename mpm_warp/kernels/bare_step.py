"""A bare step of the method, without anything that a scene adds: what a run is measured beside.

Each material point has an affine velocity and a stress of its own, on a grid of square cells with
four nodes each, in axisymmetry (affine transfers: Jiang et al. 2015, ACM Trans. Graph. 34(4):51).

Symbols: xi, eta natural coordinates in the cell, N shape function of a node, dN its gradient, d
from the material point to the node; m mass, v velocity, C before the step and L after it its
gradient, s stress (rr, zz, rz, tt), q momentum, h cell size.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.kernels.precision import FLOAT64
from mpm_warp.kernels.yielding import make_yielding
from mpm_warp.materials import VonMises

real, vec2, vec4, mat22 = FLOAT64.real, FLOAT64.vec2, FLOAT64.vec4, FLOAT64.mat22
ONE = wp.constant(real(1.0))


@wp.func
def cell_of(place: real, cell_count: int) -> int:
    """The cell that a coordinate over the cell size is in, or the nearest."""
    return wp.clamp(int(place), 0, cell_count - 1)


@functools.cache
def make_scatter() -> Any:
    """Mass and momentum at the end of the step, added up at the nodes; over material points."""

    @wp.kernel(module="mpm_warp.bare_scatter", enable_backward=False)
    def bare_scatter(
        position: wp.array(dtype=vec2),
        velocity: wp.array(dtype=vec2),
        affine: wp.array(dtype=mat22),
        stress: wp.array(dtype=vec4),
        mass: wp.array(dtype=real),
        volume: wp.array(dtype=real),
        h: real,
        cell_count: int,
        time_step: real,
        momentum: wp.array(dtype=vec4),
    ):
        p = wp.tid()
        x = position[p]
        place = x / h
        i = cell_of(place[0], cell_count)
        j = cell_of(place[1], cell_count)
        xi, eta = place[0] - real(i), place[1] - real(j)
        m, v, C, s = mass[p], velocity[p], affine[p], stress[p]
        pull = time_step * volume[p]
        hoop = s[3] / x[0]
        for b in range(2):
            for a in range(2):
                along_r, along_z = wp.where(a == 0, ONE - xi, xi), wp.where(b == 0, ONE - eta, eta)
                N = along_r * along_z
                dN = vec2(real(2 * a - 1) * along_z, real(2 * b - 1) * along_r) / h
                d = h * vec2(wp.where(a == 0, -xi, ONE - xi), wp.where(b == 0, -eta, ONE - eta))
                force = vec2(s[0] * dN[0] + s[2] * dN[1] + hoop * N, s[2] * dN[0] + s[1] * dN[1])
                q = (m * N) * (v + C * d) - pull * force
                node = (j + b) * (cell_count + 1) + i + a
                momentum[node] += vec4(m * N, q[0], q[1], real(0.0))

    return bare_scatter


@functools.cache
def make_nodes() -> Any:
    """Velocity of the nodes, whose sums are cleared; over nodes."""

    @wp.kernel(module="mpm_warp.bare_nodes", enable_backward=False)
    def bare_nodes(momentum: wp.array(dtype=vec4), node_velocity: wp.array(dtype=vec2)):
        k = wp.tid()
        sums = momentum[k]
        if sums[0] > real(0.0):
            node_velocity[k] = vec2(sums[1], sums[2]) / sums[0]
        momentum[k] = vec4()

    return bare_nodes


@functools.cache
def make_gather(material: VonMises) -> Any:
    """Velocity, its gradient, stress, volume and place after the step; over material points."""
    yielding = make_yielding(material, FLOAT64)

    @wp.kernel(module="mpm_warp.bare_gather", enable_backward=False)
    def bare_gather(
        node_velocity: wp.array(dtype=vec2),
        h: real,
        cell_count: int,
        time_step: real,
        lame: real,
        shear: real,
        strength: real,
        position: wp.array(dtype=vec2),
        velocity: wp.array(dtype=vec2),
        affine: wp.array(dtype=mat22),
        stress: wp.array(dtype=vec4),
        volume: wp.array(dtype=real),
    ):
        p = wp.tid()
        x = position[p]
        place = x / h
        i = cell_of(place[0], cell_count)
        j = cell_of(place[1], cell_count)
        xi, eta = place[0] - real(i), place[1] - real(j)
        v, L = vec2(), mat22()
        for b in range(2):
            for a in range(2):
                along_r, along_z = wp.where(a == 0, ONE - xi, xi), wp.where(b == 0, ONE - eta, eta)
                dN = vec2(real(2 * a - 1) * along_z, real(2 * b - 1) * along_r) / h
                u = node_velocity[(j + b) * (cell_count + 1) + i + a]
                v += (along_r * along_z) * u
                L += wp.outer(u, dN)
        rr, zz, tt = time_step * L[0, 0], time_step * L[1, 1], time_step * v[0] / x[0]
        rz = time_step * real(0.5) * (L[0, 1] + L[1, 0])
        pressed = lame * (rr + zz + tt)
        change = vec4(pressed, pressed, real(0.0), pressed)
        trial = stress[p] + change + real(2.0) * shear * vec4(rr, zz, rz, tt)
        stress[p] = yielding(trial, strength)
        volume[p] *= ONE + rr + zz + tt
        velocity[p] = v
        affine[p] = L
        position[p] = x + time_step * v

    return bare_gather
