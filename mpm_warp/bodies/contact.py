"""Stage 2 for bodies, continued: contact between the fields of two bodies, found from particles.

Symbols: A the body, B its base; m mass, v velocity predicted for each alone, v_S that of both
together, d = v_A - v_S; a_A, a_B integrals of N n over their surfaces, n unit normal, outward from
A, A_k contact area of node k; w weights (1 2 1) x (1 2 1) of a node and its neighbours.

    n = -b / |b|, b = sum w a_B;    A_k = a_A . n
    s_A = max over A's particles near the node of x . n + l/2,    gap = -(s_A + s_B)
    P = A_k sum_j (max(m_A d . n, 0)_j / sum_i A_i)    j near k, i near j: within two cells
    J = law(m_A, d, n, P, mu, a A_k dt)     while the gap is closed
    v_A <- v_A - J / m_A,    v_B <- v_B + J / m_B

A node that few particles reach knows neither its normal nor its pressure: a normal that is off by
degrees acts as friction of that many per cent, and the nodes on either side of an interface share
its normal force in a way that stresses leave open. So normals are those of a neighbourhood, and
what presses a node is its share, by area, of the normal impulses around it; their sum stays.

With v_S = (m_A v_A + m_B v_B) / (m_A + m_B) the law's m_A (v_A - v_S) is the reduced mass
m_A m_B / (m_A + m_B) times v_A - v_B, the same for either body but for its sign. So one impulse
serves both, and a held body is one without inverse mass.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.parts.contact_law import make_contact_law
from mpm_warp.precision import Precision
from mpm_warp.bodies.splines import make_splines

FAR = -1e30
"""Where the surface of a body is that no particle near a node belongs to [m]."""
NEIGHBOURHOOD = 2
"""Cells around a node over which pressure is averaged: all nodes that an interface reaches."""


@functools.cache
def make_interface(precision: Precision) -> Any:
    """Normal and area of the interface of two bodies; launched over nodes. No area: no contact."""
    real, vec2 = precision.real, precision.vec2
    zero, two = (wp.constant(real(x)) for x in (0.0, 2.0))
    far = wp.constant(real(FAR))

    @wp.kernel(module=f"mpm_warp.bodies.interface.{precision.numpy_name}", enable_backward=False)
    def interface(
        body: int,
        base: int,
        node_counts: wp.vec2i,
        surface: wp.array2d(dtype=vec2),
        inverse_mass: wp.array2d(dtype=real),
        normal: wp.array(dtype=vec2),
        area: wp.array(dtype=real),
        extent: wp.array(dtype=vec2),
    ):
        j, i = wp.tid()
        k = j * node_counts[0] + i
        area[k] = zero
        if inverse_mass[body, k] < zero or inverse_mass[base, k] < zero:
            return
        b = vec2()
        for row in range(wp.max(j - 1, 0), wp.min(j + 2, node_counts[1])):
            for column in range(wp.max(i - 1, 0), wp.min(i + 2, node_counts[0])):
                weight = (two - real(wp.abs(row - j))) * (two - real(wp.abs(column - i)))
                b += weight * surface[base, row * node_counts[0] + column]
        length = wp.length(b)
        if length <= zero:
            return
        n = -b / length
        normal[k] = n
        area[k] = wp.max(wp.dot(surface[body, k], n), zero)
        extent[k] = vec2(far, far)

    return interface


@functools.cache
def make_extents(precision: Precision) -> Any:
    """How far two bodies reach towards each other at a node; launched over particles."""
    real, vec2 = precision.real, precision.vec2
    zero = wp.constant(real(0.0))
    first_node = make_splines(precision).first_node

    @wp.kernel(module=f"mpm_warp.extents.{precision.numpy_name}", enable_backward=False)
    def extents(
        body: int,
        base: int,
        particle_body: wp.array(dtype=int),
        position: wp.array(dtype=vec2),
        half_spacing: wp.array(dtype=real),
        lower: vec2,
        h: real,
        node_counts: wp.vec2i,
        normal: wp.array(dtype=vec2),
        area: wp.array(dtype=real),
        extent: wp.array(dtype=vec2),
    ):
        p = wp.tid()
        b = particle_body[p]
        x = position[p]
        where = (x - lower) / h
        i = first_node(where[0], node_counts[0])
        j = first_node(where[1], node_counts[1])
        for row in range(3):
            for column in range(3):
                node = (j + row) * node_counts[0] + i + column
                if area[node] > zero:
                    height = wp.dot(x, normal[node])
                    if b == body:
                        wp.atomic_max(extent, node, vec2(height + half_spacing[b], real(FAR)))
                    elif b == base:
                        wp.atomic_max(extent, node, vec2(real(FAR), half_spacing[b] - height))

    return extents


@functools.cache
def make_pressing(precision: Precision) -> Any:
    """Normal impulse and area of the nodes whose gap is closed; launched over nodes.

    `extent` is where the two bodies reach to; `pressing` holds (max(m_A d . n, 0), A_k).
    """
    real, vec2 = precision.real, precision.vec2
    zero = wp.constant(real(0.0))

    @wp.kernel(module=f"mpm_warp.pressing.{precision.numpy_name}", enable_backward=False)
    def pressing_of_nodes(
        body: int,
        base: int,
        closed: real,
        normal: wp.array(dtype=vec2),
        area: wp.array(dtype=real),
        extent: wp.array(dtype=vec2),
        inverse_mass: wp.array2d(dtype=real),
        velocity: wp.array2d(dtype=vec2),
        pressing: wp.array(dtype=vec2),
    ):
        k = wp.tid()
        pressing[k] = vec2()
        if area[k] <= zero:
            return
        gap = -(extent[k][0] + extent[k][1])
        mobility = inverse_mass[body, k] + inverse_mass[base, k]
        if gap > closed or mobility <= zero:
            return
        jump = velocity[body, k] - velocity[base, k]
        pressing[k] = vec2(wp.max(wp.dot(jump, normal[k]) / mobility, zero), area[k])

    return pressing_of_nodes


@functools.cache
def make_shared_pressure(precision: Precision) -> Any:
    """Normal impulse of a node per area of its neighbourhood; launched over nodes."""
    real, vec2 = precision.real, precision.vec2
    zero = wp.constant(real(0.0))
    reach = wp.constant(NEIGHBOURHOOD)

    @wp.kernel(module=f"mpm_warp.shared_pressure.{precision.numpy_name}", enable_backward=False)
    def shared_pressure(
        node_counts: wp.vec2i, pressing: wp.array(dtype=vec2), pressure: wp.array(dtype=real)
    ):
        j, i = wp.tid()
        k = j * node_counts[0] + i
        pressure[k] = zero
        if pressing[k][0] <= zero:
            return
        area = zero
        for row in range(wp.max(j - reach, 0), wp.min(j + reach + 1, node_counts[1])):
            for column in range(wp.max(i - reach, 0), wp.min(i + reach + 1, node_counts[0])):
                area += pressing[row * node_counts[0] + column][1]
        pressure[k] = pressing[k][0] / area

    return shared_pressure


@functools.cache
def make_body_contact(precision: Precision) -> Any:
    """The corrector; launched over nodes.

    `total` adds up, since it was last cleared, the impulse from the body on its base and the work
    that the slip between them took.
    """
    real, vec2, vec3 = precision.real, precision.vec2, precision.vec3
    zero, one = (wp.constant(real(x)) for x in (0.0, 1.0))
    contact_law = make_contact_law(precision)
    reach = wp.constant(NEIGHBOURHOOD)

    @wp.kernel(module=f"mpm_warp.body_contact.{precision.numpy_name}", enable_backward=False)
    def body_contact(
        body: int,
        base: int,
        friction: real,
        adhesion: real,
        time_step: real,
        node_counts: wp.vec2i,
        normal: wp.array(dtype=vec2),
        pressing: wp.array(dtype=vec2),
        pressure: wp.array(dtype=real),
        inverse_mass: wp.array2d(dtype=real),
        velocity: wp.array2d(dtype=vec2),
        total: wp.array(dtype=vec3),
    ):
        j, i = wp.tid()
        k = j * node_counts[0] + i
        area = pressing[k][1]
        if area <= zero:
            return
        around = zero
        for row in range(wp.max(j - reach, 0), wp.min(j + reach + 1, node_counts[1])):
            for column in range(wp.max(i - reach, 0), wp.min(i + reach + 1, node_counts[0])):
                around += pressure[row * node_counts[0] + column]
        P = area * around
        n = normal[k]
        jump = velocity[body, k] - velocity[base, k]
        mobility = inverse_mass[body, k] + inverse_mass[base, k]
        J = contact_law(one / mobility, jump, n, P, friction, adhesion * area * time_step, zero)
        impulse = J[0] * n + vec2(J[1], J[2])
        velocity[body, k] = velocity[body, k] - inverse_mass[body, k] * impulse
        velocity[base, k] = velocity[base, k] + inverse_mass[base, k] * impulse
        slip = jump - mobility * impulse
        wp.atomic_add(total, 0, vec3(impulse[0], impulse[1], wp.dot(impulse, slip)))

    return body_contact


@functools.cache
def make_clear_surfaces(precision: Precision) -> Any:
    """Clears the surfaces of all bodies for the next step; launched over (bodies, nodes)."""
    vec2 = precision.vec2

    @wp.kernel(module=f"mpm_warp.clear_surfaces.{precision.numpy_name}", enable_backward=False)
    def clear_surfaces(surface: wp.array2d(dtype=vec2)):
        b, node = wp.tid()
        surface[b, node] = vec2()

    return clear_surfaces
