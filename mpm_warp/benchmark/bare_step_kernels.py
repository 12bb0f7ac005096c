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

from mpm_warp.precision import FLOAT64
from mpm_warp.materials.yielding import make_yielding
from mpm_warp.materials.materials import VonMises

real, vec2, vec3, vec4 = FLOAT64.real, FLOAT64.vec2, FLOAT64.vec3, FLOAT64.vec4
mat22 = FLOAT64.mat22
ONE = wp.constant(real(1.0))


@wp.func
def cell_at(place: vec2, cell_count: int) -> wp.vec2i:
    """Column and row of the cell that a place, over the cell size, is in, or of the nearest."""
    last = cell_count - 1
    return wp.vec2i(wp.clamp(int(place[0]), 0, last), wp.clamp(int(place[1]), 0, last))


@wp.func
def shape(a: int, b: int, xi: real, eta: real) -> vec3:
    """N and h dN of the node in the column a and the row b of a cell's four, each 0 or 1."""
    along_r, along_z = wp.where(a == 0, ONE - xi, xi), wp.where(b == 0, ONE - eta, eta)
    return vec3(along_r * along_z, real(2 * a - 1) * along_z, real(2 * b - 1) * along_r)


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
        cell = cell_at(place, cell_count)
        xi, eta = place[0] - real(cell[0]), place[1] - real(cell[1])
        first = cell[1] * (cell_count + 1) + cell[0]
        m, v, C, s = mass[p], velocity[p], affine[p], stress[p]
        pull = time_step * volume[p]
        hoop = s[3] / x[0]
        for b in range(2):
            for a in range(2):
                at = shape(a, b, xi, eta)
                N, dN = at[0], vec2(at[1], at[2]) / h
                d = h * vec2(wp.where(a == 0, -xi, ONE - xi), wp.where(b == 0, -eta, ONE - eta))
                force = vec2(s[0] * dN[0] + s[2] * dN[1] + hoop * N, s[2] * dN[0] + s[1] * dN[1])
                q = (m * N) * (v + C * d) - pull * force
                momentum[first + b * (cell_count + 1) + a] += vec4(m * N, q[0], q[1], real(0.0))

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
        cell = cell_at(place, cell_count)
        xi, eta = place[0] - real(cell[0]), place[1] - real(cell[1])
        first = cell[1] * (cell_count + 1) + cell[0]
        v, L = vec2(), mat22()
        for b in range(2):
            for a in range(2):
                at = shape(a, b, xi, eta)
                u = node_velocity[first + b * (cell_count + 1) + a]
                v += at[0] * u
                L += wp.outer(u, vec2(at[1], at[2]) / h)
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
