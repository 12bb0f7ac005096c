"""Contact between the fields of two bodies: one impulse at each node, which serves both.

The particles determine where the bodies touch. Symbols: A the body, B its base; a_A, a_B integrals
of N n over their surfaces, n unit normal, outward from A; A_k contact area of node k; w weights
(1 2 1) x (1 2 1) of a node and its neighbours; l spacing of particles at positions x.

    n = -b / |b|, b = sum w a_B;    A_k = a_A . n
    s_A = max over A's particles near the node of x . n + l/2,    gap = -(s_A + s_B)

The normal of a node near few particles is inaccurate, and an error of some degrees acts as friction
of some per cent. So normals are averaged over a neighbourhood.

With m mass, v velocity predicted for each body alone, v_S velocity of both together,
d = v_A - v_S, mu friction coefficient, a adhesion:

    P = A_k sum_j (max(m_A d . n, 0)_j / sum_i A_i)    j near k, i near j: within two cells
    J = law(m_A, d, n, P, mu P + a A_k dt)     while the gap is closed
    v_A <- v_A - J / m_A,    v_B <- v_B + J / m_B

The stresses do not determine how nodes on both sides of an interface share its normal force. So P
is the node's share, by area, of the normal impulses around it; their sum does not change.

With v_S = (m_A v_A + m_B v_B) / (m_A + m_B), m_A (v_A - v_S) is the reduced mass
m_A m_B / (m_A + m_B) times v_A - v_B, for the other body with opposite sign. So one impulse serves
both, and a held body has an inverse mass of 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from mpm_warp.bodies.body import Body, UniformGrid, first_node
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.declaration import parameter
from mpm_warp.kernel_types import kernel, one, real, two, vec2, vec3, zero
from mpm_warp.parts.contact import contact_law
from mpm_warp.plan.plan import Plan

NEIGHBOURHOOD = 2
"""Cells around a node over which pressure is averaged, all nodes that an interface reaches."""
CLOSED_GAP = 0.05
"""Gap below which bodies touch, over cell size, so that a block at rest does not chatter."""
FAR = wp.constant(real(-1e30))
"""Extent of a body without particles near a node [m]."""
A, B = wp.constant(0), wp.constant(1)
"""Rows of the body and its base in arrays over fields."""
reach = wp.constant(NEIGHBOURHOOD)


@dataclass(frozen=True, kw_only=True)
class BodyContact(Checked):
    """Contact between the two bodies of a scene; the second is the base of the first.

    The normal is that of the base, because the normal of a body turns at its edges. So the base
    should extend beyond the body. The area is that of the body along this normal.

    Example:
        >>> BodyContact(friction=0.3, adhesion=500.0)
        BodyContact(friction=0.3, adhesion=500.0)
    """

    friction: float = parameter(0.0, "Coulomb coefficient", minimum=0)
    adhesion: float = parameter(
        0.0, "shear strength of the interface without normal stress", unit="Pa", minimum=0
    )


def add_contact(
    plan: Plan, contact: BodyContact, bodies: Sequence[Body], grid: UniformGrid
) -> None:
    """Add the contact of two bodies, after the velocities of each alone."""
    over_nodes = grid.node_counts[::-1]
    plan.add_array("body.half_spacing", "real", np.array([0.5 * body.spacing for body in bodies]))
    for name, kind in (
        ("normal", "vec2"),
        ("area", "real"),
        ("extent", "vec2"),
        ("pressing", "vec2"),
        ("pressure", "real"),
    ):
        plan.add_zeros(f"contact.{name}", kind, grid.node_count)
    plan.add_zeros("contact.total", "vec3", 1)
    plan.add_launch(interface, over_nodes)
    plan.add_launch(extents, plan.particle_count)
    plan.add_launch(pressing_of_nodes, grid.node_count, closed=CLOSED_GAP * grid.cell_size)
    plan.add_launch(shared_pressure, over_nodes)
    plan.add_launch(body_contact, over_nodes, friction=contact.friction, adhesion=contact.adhesion)


@kernel
def interface(
    node_counts: wp.vec2i,
    field_surface: wp.array2d[vec2],
    field_inverse_mass: wp.array2d[real],
    contact_normal: wp.array[vec2],
    contact_area: wp.array[real],
    contact_extent: wp.array[vec2],
):
    """Normal and area of the interface of two bodies; launched over nodes. No area, no contact."""
    j, i = wp.tid()
    k = j * node_counts[0] + i
    contact_area[k] = zero
    if field_inverse_mass[A, k] < zero or field_inverse_mass[B, k] < zero:
        return
    b = vec2()
    for row in range(wp.max(j - 1, 0), wp.min(j + 2, node_counts[1])):
        for column in range(wp.max(i - 1, 0), wp.min(i + 2, node_counts[0])):
            weight = (two - real(wp.abs(row - j))) * (two - real(wp.abs(column - i)))
            b += weight * field_surface[B, row * node_counts[0] + column]
    length = wp.length(b)
    if length <= zero:
        return
    n = -b / length
    contact_normal[k] = n
    contact_area[k] = wp.max(wp.dot(field_surface[A, k], n), zero)
    contact_extent[k] = vec2(FAR, FAR)


@kernel
def extents(
    particle_body: wp.array[int],
    particle_position: wp.array[vec2],
    body_half_spacing: wp.array[real],
    lower: vec2,
    h: real,
    node_counts: wp.vec2i,
    contact_normal: wp.array[vec2],
    contact_area: wp.array[real],
    contact_extent: wp.array[vec2],
):
    """Extents s_A and s_B of two bodies at a node; launched over particles."""
    p = wp.tid()
    b = particle_body[p]
    x = particle_position[p]
    where = (x - lower) / h
    i = first_node(where[0], node_counts[0])
    j = first_node(where[1], node_counts[1])
    for row in range(3):
        for column in range(3):
            node = (j + row) * node_counts[0] + i + column
            if contact_area[node] > zero:
                height = wp.dot(x, contact_normal[node])
                if b == A:
                    wp.atomic_max(contact_extent, node, vec2(height + body_half_spacing[b], FAR))
                elif b == B:
                    wp.atomic_max(contact_extent, node, vec2(FAR, body_half_spacing[b] - height))


@kernel
def pressing_of_nodes(
    closed: real,
    contact_normal: wp.array[vec2],
    contact_area: wp.array[real],
    contact_extent: wp.array[vec2],
    field_inverse_mass: wp.array2d[real],
    field_velocity: wp.array2d[vec2],
    field_surface: wp.array2d[vec2],
    contact_pressing: wp.array[vec2],
):
    """Normal impulse and area of the nodes whose gap is closed; launched over nodes.

    `contact_extent` holds (s_A, s_B), `contact_pressing` (max(m_A d . n, 0), A_k). The surfaces of
    both bodies are cleared for the next step.
    """
    k = wp.tid()
    field_surface[A, k] = vec2()
    field_surface[B, k] = vec2()
    contact_pressing[k] = vec2()
    if contact_area[k] <= zero:
        return
    gap = -(contact_extent[k][0] + contact_extent[k][1])
    mobility = field_inverse_mass[A, k] + field_inverse_mass[B, k]
    if gap > closed or mobility <= zero:
        return
    jump = field_velocity[A, k] - field_velocity[B, k]
    contact_pressing[k] = vec2(
        wp.max(wp.dot(jump, contact_normal[k]) / mobility, zero), contact_area[k]
    )


@kernel
def shared_pressure(
    node_counts: wp.vec2i, contact_pressing: wp.array[vec2], contact_pressure: wp.array[real]
):
    """Normal impulse of a node per area of its neighbourhood; launched over nodes."""
    j, i = wp.tid()
    k = j * node_counts[0] + i
    contact_pressure[k] = zero
    if contact_pressing[k][0] <= zero:
        return
    area = zero
    for row in range(wp.max(j - reach, 0), wp.min(j + reach + 1, node_counts[1])):
        for column in range(wp.max(i - reach, 0), wp.min(i + reach + 1, node_counts[0])):
            area += contact_pressing[row * node_counts[0] + column][1]
    contact_pressure[k] = contact_pressing[k][0] / area


@kernel
def body_contact(
    friction: real,
    adhesion: real,
    time_step: real,
    node_counts: wp.vec2i,
    contact_normal: wp.array[vec2],
    contact_pressing: wp.array[vec2],
    contact_pressure: wp.array[real],
    field_inverse_mass: wp.array2d[real],
    field_velocity: wp.array2d[vec2],
    contact_total: wp.array[vec3],
):
    """The impulses of contact; launched over nodes.

    `contact_total` adds up the impulse of the body on its base and the work of slip since it was
    last cleared.
    """
    j, i = wp.tid()
    k = j * node_counts[0] + i
    area = contact_pressing[k][1]
    if area <= zero:
        return
    around = zero
    for row in range(wp.max(j - reach, 0), wp.min(j + reach + 1, node_counts[1])):
        for column in range(wp.max(i - reach, 0), wp.min(i + reach + 1, node_counts[0])):
            around += contact_pressure[row * node_counts[0] + column]
    P = area * around
    n = contact_normal[k]
    jump = field_velocity[A, k] - field_velocity[B, k]
    mobility = field_inverse_mass[A, k] + field_inverse_mass[B, k]
    most_shear = friction * P + adhesion * area * time_step
    J = contact_law(one / mobility, jump, n, P, most_shear, zero)
    impulse = J[0] * n + vec2(J[1], J[2])
    field_velocity[A, k] = field_velocity[A, k] - field_inverse_mass[A, k] * impulse
    field_velocity[B, k] = field_velocity[B, k] + field_inverse_mass[B, k] * impulse
    slip = jump - mobility * impulse
    wp.atomic_add(contact_total, 0, vec3(impulse[0], impulse[1], wp.dot(impulse, slip)))
