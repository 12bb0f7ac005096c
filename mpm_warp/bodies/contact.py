"""Contact between the fields of two bodies: one impulse at each node, which serves both.

Symbols: A the body, B its base; m mass, v velocity predicted for each alone, v_S that of both
together, d = v_A - v_S; n unit normal, outward from A, A_k contact area of node k, and the gap, all
found from the particles; mu friction coefficient, a adhesion.

    P = A_k sum_j (max(m_A d . n, 0)_j / sum_i A_i)    j near k, i near j: within two cells
    J = law(m_A, d, n, P, mu, a A_k dt)     while the gap is closed
    v_A <- v_A - J / m_A,    v_B <- v_B + J / m_B

The nodes on either side of an interface share its normal force in a way that stresses leave open.
So what presses a node is its share, by area, of the normal impulses around it; their sum stays.

With v_S = (m_A v_A + m_B v_B) / (m_A + m_B) the law's m_A (v_A - v_S) is the reduced mass
m_A m_B / (m_A + m_B) times v_A - v_B, the same for either body but for its sign. So one impulse
serves both, and a held body is one without inverse mass.
"""

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import NOT_NEGATIVE, check_number, check_whole
from mpm_warp.bodies.body import Body
from mpm_warp.bodies.contact_detection import add_contact_detection
from mpm_warp.bodies.grid import UniformGrid
from mpm_warp.parts.contact.contact_law import make_contact_law
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision

NEIGHBOURHOOD = 2
"""Cells around a node over which pressure is averaged: all nodes that an interface reaches."""
CLOSED_GAP = 0.05
"""Gap below which bodies touch, over cell size: a block at rest must not chatter on its base."""


@dataclass(frozen=True, kw_only=True)
class BodyContact:
    """Contact between two bodies.

    The normal is that of the base, whose surface should go on where the body's ends: at its edges
    a body's own normal turns away. The area is the body's own along that normal.

    Attributes:
        body: index of one body in the scene.
        base: index of the other.
        friction: Coulomb coefficient, dimensionless, >= 0.
        adhesion: shear stress transmitted without normal stress [Pa], >= 0.

    Raises:
        SceneError: a value is not allowed.
    """

    body: int
    base: int
    friction: float = 0.0
    adhesion: float = 0.0

    def __post_init__(self) -> None:
        check_whole("contact: body", self.body, NOT_NEGATIVE)
        check_whole("contact: base", self.base, NOT_NEGATIVE)
        check_number("contact: friction", self.friction, NOT_NEGATIVE)
        check_number("contact: adhesion", self.adhesion, NOT_NEGATIVE, unit="Pa")

    def add_to(self, plan: Plan, index: int, bodies: Sequence[Body], grid: UniformGrid) -> None:
        """Add contact number `index` of a scene, after the velocities that each body has alone."""
        contact = f"contact{index}"
        over_nodes, node_counts = grid.node_counts[::-1], wp.vec2i(*grid.node_counts)
        normal, area, extent = add_contact_detection(
            plan, contact, (self.body, self.base), bodies, grid
        )
        pressing = plan.add_zeros(f"{contact}.pressing", "vec2", grid.node_count)
        pressure = plan.add_zeros(f"{contact}.pressure", "real", grid.node_count)
        plan.add_launch(
            make_pressing(plan.precision),
            grid.node_count,
            body=self.body,
            base=self.base,
            closed=CLOSED_GAP * grid.cell_size,
            normal=normal,
            area=area,
            extent=extent,
            pressing=pressing,
        )
        plan.add_launch(
            make_shared_pressure(plan.precision),
            over_nodes,
            node_counts=node_counts,
            pressing=pressing,
            pressure=pressure,
        )
        plan.add_launch(
            make_body_contact(plan.precision),
            over_nodes,
            body=self.body,
            base=self.base,
            friction=self.friction,
            adhesion=self.adhesion,
            node_counts=node_counts,
            normal=normal,
            pressing=pressing,
            pressure=pressure,
            total=plan.add_zeros(f"{contact}.total", "vec3", 1),
        )


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
        field_inverse_mass: wp.array2d(dtype=real),
        field_velocity: wp.array2d(dtype=vec2),
        pressing: wp.array(dtype=vec2),
    ):
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
        field_inverse_mass: wp.array2d(dtype=real),
        field_velocity: wp.array2d(dtype=vec2),
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
        jump = field_velocity[body, k] - field_velocity[base, k]
        mobility = field_inverse_mass[body, k] + field_inverse_mass[base, k]
        J = contact_law(one / mobility, jump, n, P, friction, adhesion * area * time_step, zero)
        impulse = J[0] * n + vec2(J[1], J[2])
        field_velocity[body, k] = field_velocity[body, k] - field_inverse_mass[body, k] * impulse
        field_velocity[base, k] = field_velocity[base, k] + field_inverse_mass[base, k] * impulse
        slip = jump - mobility * impulse
        wp.atomic_add(total, 0, vec3(impulse[0], impulse[1], wp.dot(impulse, slip)))

    return body_contact
