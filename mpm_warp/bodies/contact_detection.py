"""Where two bodies meet, found from their particles: normal, contact area and gap at each node.

Symbols: A the body, B its base; a_A, a_B integrals of N n over their surfaces, n unit normal,
outward from A; A_k contact area of node k; w weights (1 2 1) x (1 2 1) of a node and its
neighbours; l spacing of particles at positions x.

    n = -b / |b|, b = sum w a_B;    A_k = a_A . n
    s_A = max over A's particles near the node of x . n + l/2,    gap = -(s_A + s_B)

The normal of a node that few particles reach is poor, and a normal that is off by degrees acts as
friction of that many per cent. So normals are those of a neighbourhood.
"""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.bodies.body import Body
from mpm_warp.bodies.grid import UniformGrid, make_splines
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision

FAR = -1e30
"""Where the surface of a body is that has no particle near a node [m]."""


def add_contact_detection(
    plan: Plan, contact: str, pair: tuple[int, int], bodies: Sequence[Body], grid: UniformGrid
) -> tuple[str, str, str]:
    """Find where a body touches its base, after the velocities that each has alone are known.

    Args:
        plan: to add to.
        contact: first word of the arrays of this contact.
        pair: indices of the body and its base.
        bodies: all bodies of the scene.
        grid: the background grid.

    Returns:
        Names of the arrays over nodes: normal, contact area, and extent of the two bodies towards
        each other (s_A, s_B). Where there is no contact the area is 0.
    """
    body, base = pair
    normal = plan.add_zeros(f"{contact}.normal", "vec2", grid.node_count)
    area = plan.add_zeros(f"{contact}.area", "real", grid.node_count)
    extent = plan.add_zeros(f"{contact}.extent", "vec2", grid.node_count)
    half_spacing = np.array([0.5 * it.spacing for it in bodies])
    if plan.find("body.half_spacing") is None:  # a contact before this one may have added it
        plan.add_array("body.half_spacing", "real", half_spacing)
    plan.add_launch(
        make_interface(plan.precision),
        grid.node_counts[::-1],
        body=body,
        base=base,
        node_counts=wp.vec2i(*grid.node_counts),
        normal=normal,
        area=area,
        extent=extent,
    )
    plan.add_launch(
        make_extents(plan.precision),
        plan.particle_count,
        body=body,
        base=base,
        **grid.kernel_arguments(plan.precision),
        normal=normal,
        area=area,
        extent=extent,
    )
    return normal, area, extent


def add_clear_surfaces(plan: Plan) -> None:
    """Clear the surfaces of all bodies for the next step, after all contacts."""
    over_fields = plan.arrays["field.surface"].shape
    plan.add_launch(make_clear_surfaces(plan.precision), over_fields)


@functools.cache
def make_interface(precision: Precision) -> Any:
    """Normal and area of the interface of two bodies; launched over nodes. No area, no contact."""
    real, vec2 = precision.real, precision.vec2
    zero, two = (wp.constant(real(x)) for x in (0.0, 2.0))
    far = wp.constant(real(FAR))

    @wp.kernel(module=f"mpm_warp.bodies.interface.{precision.numpy_name}", enable_backward=False)
    def interface(
        body: int,
        base: int,
        node_counts: wp.vec2i,
        field_surface: wp.array2d(dtype=vec2),
        field_inverse_mass: wp.array2d(dtype=real),
        normal: wp.array(dtype=vec2),
        area: wp.array(dtype=real),
        extent: wp.array(dtype=vec2),
    ):
        j, i = wp.tid()
        k = j * node_counts[0] + i
        area[k] = zero
        if field_inverse_mass[body, k] < zero or field_inverse_mass[base, k] < zero:
            return
        b = vec2()
        for row in range(wp.max(j - 1, 0), wp.min(j + 2, node_counts[1])):
            for column in range(wp.max(i - 1, 0), wp.min(i + 2, node_counts[0])):
                weight = (two - real(wp.abs(row - j))) * (two - real(wp.abs(column - i)))
                b += weight * field_surface[base, row * node_counts[0] + column]
        length = wp.length(b)
        if length <= zero:
            return
        n = -b / length
        normal[k] = n
        area[k] = wp.max(wp.dot(field_surface[body, k], n), zero)
        extent[k] = vec2(far, far)

    return interface


@functools.cache
def make_extents(precision: Precision) -> Any:
    """How far two bodies extend towards each other at a node; launched over particles."""
    real, vec2 = precision.real, precision.vec2
    zero = wp.constant(real(0.0))
    first_node = make_splines(precision).first_node

    @wp.kernel(module=f"mpm_warp.extents.{precision.numpy_name}", enable_backward=False)
    def extents(
        body: int,
        base: int,
        particle_body: wp.array(dtype=int),
        particle_position: wp.array(dtype=vec2),
        body_half_spacing: wp.array(dtype=real),
        lower: vec2,
        h: real,
        node_counts: wp.vec2i,
        normal: wp.array(dtype=vec2),
        area: wp.array(dtype=real),
        extent: wp.array(dtype=vec2),
    ):
        p = wp.tid()
        b = particle_body[p]
        x = particle_position[p]
        where = (x - lower) / h
        i = first_node(where[0], node_counts[0])
        j = first_node(where[1], node_counts[1])
        for row in range(3):
            for column in range(3):
                node = (j + row) * node_counts[0] + i + column
                if area[node] > zero:
                    height = wp.dot(x, normal[node])
                    if b == body:
                        wp.atomic_max(extent, node, vec2(height + body_half_spacing[b], real(FAR)))
                    elif b == base:
                        wp.atomic_max(extent, node, vec2(real(FAR), body_half_spacing[b] - height))

    return extents


@functools.cache
def make_clear_surfaces(precision: Precision) -> Any:
    """Clears the surfaces of all bodies; launched over (bodies, nodes)."""
    vec2 = precision.vec2

    @wp.kernel(module=f"mpm_warp.clear_surfaces.{precision.numpy_name}", enable_backward=False)
    def clear_surfaces(field_surface: wp.array2d(dtype=vec2)):
        b, node = wp.tid()
        field_surface[b, node] = vec2()

    return clear_surfaces
