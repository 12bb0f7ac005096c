"""Contact between the fields of two bodies: one impulse at each node, which serves both.

Where the bodies meet is found from their particles. Symbols: A the body, B its base; a_A, a_B
integrals of N n over their surfaces, n unit normal, outward from A; A_k contact area of node k; w
weights (1 2 1) x (1 2 1) of a node and its neighbours; l spacing of particles at positions x.

    n = -b / |b|, b = sum w a_B;    A_k = a_A . n
    s_A = max over A's particles near the node of x . n + l/2,    gap = -(s_A + s_B)

The normal of a node that few particles reach is poor, and a normal that is off by degrees acts as
friction of that many per cent. So normals are those of a neighbourhood.

Then m mass, v velocity predicted for each alone, v_S that of both together, d = v_A - v_S; mu
friction coefficient, a adhesion:

    P = A_k sum_j (max(m_A d . n, 0)_j / sum_i A_i)    j near k, i near j: within two cells
    J = law(m_A, d, n, P, mu, a A_k dt)     while the gap is closed
    v_A <- v_A - J / m_A,    v_B <- v_B + J / m_B

The nodes on either side of an interface share its normal force in a way that stresses leave open.
So what presses a node is its share, by area, of the normal impulses around it; their sum stays.

With v_S = (m_A v_A + m_B v_B) / (m_A + m_B) the law's m_A (v_A - v_S) is the reduced mass
m_A m_B / (m_A + m_B) times v_A - v_B, the same for either body but for its sign. So one impulse
serves both, and a held body is one without inverse mass.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from mpm_warp.arguments import NOT_NEGATIVE, Checked, check_whole, checked
from mpm_warp.bodies.body import Body
from mpm_warp.bodies.grid import UniformGrid, first_node, one, real, two, vec2, vec3, zero
from mpm_warp.parts.contact import make_contact_law
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import FLOAT64

NEIGHBOURHOOD = 2
"""Cells around a node over which pressure is averaged: all nodes that an interface reaches."""
CLOSED_GAP = 0.05
"""Gap below which bodies touch, over cell size: a block at rest must not chatter on its base."""
FAR = wp.constant(real(-1e30))
"""Where the surface of a body is that has no particle near a node [m]."""
reach = wp.constant(NEIGHBOURHOOD)
contact_law = make_contact_law(FLOAT64)


@dataclass(frozen=True, kw_only=True)
class BodyContact(Checked):
    """Contact between two bodies.

    The normal is that of the base, whose surface should go on where the body's ends: at its edges
    a body's own normal turns away. The area is the body's own along that normal.

    Attributes:
        body: index of one body in the scene.
        base: index of the other.
        friction: Coulomb coefficient, dimensionless, >= 0.
        adhesion: shear stress transmitted without normal stress [Pa], >= 0.
    """

    body: int
    base: int
    friction: float = checked(NOT_NEGATIVE, default=0.0)
    adhesion: float = checked(NOT_NEGATIVE, unit="Pa", default=0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_whole("BodyContact: body", self.body, NOT_NEGATIVE)
        check_whole("BodyContact: base", self.base, NOT_NEGATIVE)

    def add_to(self, plan: Plan, index: int, bodies: Sequence[Body], grid: UniformGrid) -> None:
        """Add contact number `index` of a scene, after the velocities that each body has alone."""
        contact, pair = f"contact{index}", {"body": self.body, "base": self.base}
        over_nodes, node_counts = grid.node_counts[::-1], wp.vec2i(*grid.node_counts)
        normal = plan.add_zeros(f"{contact}.normal", "vec2", grid.node_count)
        area = plan.add_zeros(f"{contact}.area", "real", grid.node_count)
        extent = plan.add_zeros(f"{contact}.extent", "vec2", grid.node_count)
        if plan.find("body.half_spacing") is None:  # a contact before this one may have added it
            half_spacing = np.array([0.5 * body.spacing for body in bodies])
            plan.add_array("body.half_spacing", "real", half_spacing)
        meeting = {"normal": normal, "area": area, "extent": extent}
        plan.add_launch(interface, over_nodes, **pair, node_counts=node_counts, **meeting)
        plan.add_launch(extents, plan.particle_count, **pair, **grid.kernel_arguments, **meeting)
        pressing = plan.add_zeros(f"{contact}.pressing", "vec2", grid.node_count)
        pressure = plan.add_zeros(f"{contact}.pressure", "real", grid.node_count)
        plan.add_launch(
            pressing_of_nodes,
            grid.node_count,
            **pair,
            closed=CLOSED_GAP * grid.cell_size,
            **meeting,
            pressing=pressing,
        )
        plan.add_launch(
            shared_pressure,
            over_nodes,
            node_counts=node_counts,
            pressing=pressing,
            pressure=pressure,
        )
        plan.add_launch(
            body_contact,
            over_nodes,
            **pair,
            friction=self.friction,
            adhesion=self.adhesion,
            node_counts=node_counts,
            normal=normal,
            pressing=pressing,
            pressure=pressure,
            total=plan.add_zeros(f"{contact}.total", "vec3", 1),
        )


def add_clear_surfaces(plan: Plan) -> None:
    """Clear the surfaces of all bodies for the next step, after all contacts."""
    over_fields = plan.arrays["field.surface"].shape
    plan.add_launch(clear_surfaces, over_fields)


@wp.kernel(module="mpm_warp.bodies.interface", enable_backward=False)
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
    """Normal and area of the interface of two bodies; launched over nodes. No area, no contact."""
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
    extent[k] = vec2(FAR, FAR)


@wp.kernel(module="mpm_warp.extents", enable_backward=False)
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
    """How far two bodies extend towards each other at a node; launched over particles."""
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
                    wp.atomic_max(extent, node, vec2(height + body_half_spacing[b], FAR))
                elif b == base:
                    wp.atomic_max(extent, node, vec2(FAR, body_half_spacing[b] - height))


@wp.kernel(module="mpm_warp.clear_surfaces", enable_backward=False)
def clear_surfaces(field_surface: wp.array2d(dtype=vec2)):
    """Clears the surfaces of all bodies; launched over (bodies, nodes)."""
    b, node = wp.tid()
    field_surface[b, node] = vec2()


@wp.kernel(module="mpm_warp.pressing", enable_backward=False)
def pressing_of_nodes(
    body: int,
    base: int,
    closed: real,
    normal: wp.array(dtype=vec2),
    area: wp.array(dtype=real),
    extent: wp.array(dtype=vec2),
    field_inverse_mass: wp.array2d(dtype=real),
    field_velocity: wp.array2d(dtype=vec2),
    pressing: wp.array(dtype=vec2),
):
    """Normal impulse and area of the nodes whose gap is closed; launched over nodes.

    `extent` is where the two bodies reach to; `pressing` holds (max(m_A d . n, 0), A_k).
    """
    k = wp.tid()
    pressing[k] = vec2()
    if area[k] <= zero:
        return
    gap = -(extent[k][0] + extent[k][1])
    mobility = field_inverse_mass[body, k] + field_inverse_mass[base, k]
    if gap > closed or mobility <= zero:
        return
    jump = field_velocity[body, k] - field_velocity[base, k]
    pressing[k] = vec2(wp.max(wp.dot(jump, normal[k]) / mobility, zero), area[k])


@wp.kernel(module="mpm_warp.shared_pressure", enable_backward=False)
def shared_pressure(
    node_counts: wp.vec2i, pressing: wp.array(dtype=vec2), pressure: wp.array(dtype=real)
):
    """Normal impulse of a node per area of its neighbourhood; launched over nodes."""
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


@wp.kernel(module="mpm_warp.body_contact", enable_backward=False)
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
    field_inverse_mass: wp.array2d(dtype=real),
    field_velocity: wp.array2d(dtype=vec2),
    total: wp.array(dtype=vec3),
):
    """The corrector; launched over nodes.

    `total` adds up, since it was last cleared, the impulse from the body on its base and the work
    that the slip between them took.
    """
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
    jump = field_velocity[body, k] - field_velocity[base, k]
    mobility = field_inverse_mass[body, k] + field_inverse_mass[base, k]
    J = contact_law(one / mobility, jump, n, P, friction, adhesion * area * time_step, zero)
    impulse = J[0] * n + vec2(J[1], J[2])
    field_velocity[body, k] = field_velocity[body, k] - field_inverse_mass[body, k] * impulse
    field_velocity[base, k] = field_velocity[base, k] + field_inverse_mass[base, k] * impulse
    slip = jump - mobility * impulse
    wp.atomic_add(total, 0, vec3(impulse[0], impulse[1], wp.dot(impulse, slip)))
