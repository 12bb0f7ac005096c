"""Nodes that body and axis hold together: the body bears what their least mass keeps from them.

The least mass of a node limits what the force does to one that has little soil, for it could be
thrown. A node that is held cannot, and before a blunt nose it always has little. The force that it
does not get is one on the body.

Symbols: m mass of the node, M its least mass, u and v its velocities before and after the force, n
the normal of the body outward from the soil.

    J_n += (max(m, M) - m) (v - u) . n
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.grid.fitted import Integers
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


def add_held_nodes(plan: Plan, held: Integers) -> None:
    """Add the launch, before that of the contact.

    Args:
        plan: has the arrays of the contact.
        held: numbers of the nodes among those of the contact, shape [held_count].
    """
    plan.add_array("contact.held", "int", held, plan.arrays["contact.nodes"].shape)
    plan.add_launch(_make_bear_what_is_kept(plan.precision), len(held))


@functools.cache
def _make_bear_what_is_kept(precision: Precision) -> Any:
    """The kernel, launched over the nodes that are held."""
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4

    @wp.kernel(module=f"mpm_warp.bear_what_is_kept.{precision.numpy_name}", enable_backward=False)
    def bear_what_is_kept(
        offset: int,
        contact_held: wp.array(dtype=int),
        contact_nodes: wp.array(dtype=int),
        contact_normals: wp.array(dtype=vec2),
        node_mass: wp.array(dtype=real),
        node_least_mass: wp.array(dtype=real),
        node_velocities: wp.array(dtype=vec4),
        contact_impulse: wp.array(dtype=vec2),
    ):
        k = contact_held[offset + wp.tid()]
        node, n = contact_nodes[k], contact_normals[k]
        m, M, v = node_mass[node], node_least_mass[node], node_velocities[node]
        if m <= real(0.0):
            return
        kept = wp.max(m, M) - m
        J_n = kept * wp.dot(vec2(v[0] - v[2], v[1] - v[3]), n)
        contact_impulse[k] += vec2(J_n, real(0.0))

    return bear_what_is_kept
