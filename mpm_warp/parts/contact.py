"""Contact of the soil with a rigid body whose surface goes through nodes of the grid.

Adhesive contact after Ceccato, Beuth & Simonini (2017, Procedia Engineering 175:182-188) and
Bardenhagen et al. (2001, CMES 2:509-522): it corrects the velocities predicted without contact.

Symbols: m mass of the soil at the node, d its predicted velocity less that of the combined system
(of a rigid body: the prescribed one), n unit normal, outward from the soil, P impulse that presses
the two together, mu friction coefficient, a A adhesion times contact area, p A in-situ pressure
times contact area, which the simulated stress leaves out.

    J_n = m d.n, at least -p A dt, where soil and body part
    J_t = m |w|, w = d - d.n n,     at most mu P + a A dt      (stick, slip)  while P > 0, else 0
    P   = m d.n + K + p A dt        for a surface through the nodes, as here

The friction of a surface in the grid is limited in two ways. First, the shear stress is at most the
strength k of the soil, whatever the pressure. Without this limit a rougher surface shears the cells
beside it, whose stress acts half a cell farther out; the shear was 1.28 k on five rows of cells
beside a cone. Second, friction that follows the pressure at once makes sliding on elastic soil
unstable, the shortest waves most (Adams 1995, J. Appl. Mech. 62:867-872): along a shaft waves of
six cells ran at the speed of shear waves, with a third of the speed of the cone. So friction
follows the pressure over a sliding distance L, as experiments show (Prakash & Clifton 1993; Ranjith
& Rice 2001, J. Mech. Phys. Solids 49:341-361). L is the shortest path of a wave across a cell, some
0.7 of its side beside a cone of 60 degrees. V is the speed of the body, R the normal force that
friction follows, which starts as p A:

    R   <- R + min(|V| dt / L, 1) (P / dt - R)     where the body has a speed, else P / dt
    J_t at most (mu R + a A) dt, R at least 0, and at most k A dt

The least mass M limits the acceleration of a node with little soil, which could be thrown off. The
part of the force that then does not act on the soil acts on the body. With u and v the velocities
before and after the force, the impulse on the body is J_n + K, at least -p A dt,

    K   = s (max(m, M) - m) (v - u) . n

s is 1 without a free surface, else the least share of the stress that acts in the cells around the
node (`mpm_warp.step.cells`): the part of the force of a full cell that the cell can bear. A node
above a surface that cuts its cells has hardly any soil that could press. With s = 1 there, a cone
that enters the ground bears 2.6 times its exact load where soil rises into the second row of cells,
and on 16 cells a radius the exponent of the depth in its load is 1.92; with s it is 1.98, exactly
2. In the first two rows the momentum of the soil changes by more than either, since the tip pushes
a whole cell.
"""

import functools
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.checks import (
    FROM_ONE,
    NOT_NEGATIVE,
    Range,
    check_array,
    check_nodes,
    check_number,
    check_whole,
)
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.kernel_types import kernel, maybe, one, real, vec2, vec3, vec4, zero
from mpm_warp.materials.material import Material
from mpm_warp.parts.strength_beside import add_strength_beside, strength_changes
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Part, Scene, refuse_together

PRESSURE_ROUNDING = 1e-3
"""Mean pressure over the in-situ stress that counts as rounding, not as contact."""
UNIT_ROUNDING = 1e-6
"""Allowed difference of the length of a unit normal from 1."""
AXIS_ROUNDING = 1e-12
"""Distance from the axis, over the radius of the grid, that counts as rounding."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceContact(Part):
    """Contact of nodes of the grid with a rigid body whose surface goes through them.

    Areas are per radian: integrals of the shape functions of the nodes, times r, over the surface.
    In plane strain they are lengths, without the r.

    Attributes:
        nodes: flat indices of the nodes in contact, each once, shape [node_count].

    Example:
        >>> contact = StripFooting(adhesion_factor=1.0).build().find(SurfaceContact)
        >>> contact.normals.shape, contact.friction
        ((9, 2), 0.0)
    """

    nodes: Integers
    normals: Floats = parameter(meaning="unit normals, outward from the soil", shape=("nodes", 2))
    normal_areas: Floats = parameter(
        meaning="areas on which the normal traction acts", unit="m2", shape=("nodes",), minimum=0
    )
    # where the strength varies or changes, that beside soil of the material's initial strength
    adhesion_forces: Floats = parameter(
        meaning="greatest adhesive force, adhesion times area",
        unit="N",
        shape=("nodes",),
        minimum=0,
    )
    friction: float = parameter(0.0, "Coulomb coefficient", minimum=0)
    # for the same strength as `adhesion_forces`
    strength_forces: Floats | None = parameter(
        None,
        "greatest shear force of the soil, strength times area; None: no such limit",
        unit="N",
        shape=("nodes",),
        minimum=0,
    )
    # soil and surface part where the simulated traction pulls by more
    in_situ_stress: float = parameter(
        meaning="pressure that the simulated stress leaves out", unit="Pa", minimum=0
    )
    # a travelling grid has the speed of its window
    speed: float = parameter(
        0.0, "speed at which the body sinks into a grid that rests", unit="m/s"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        count = np.size(self.nodes)
        check_whole("SurfaceContact: number of nodes", count, FROM_ONE)
        lengths = np.hypot(self.normals[:, 0], self.normals[:, 1])
        if not np.allclose(lengths, 1.0, rtol=0.0, atol=UNIT_ROUNDING):
            worst = int(np.argmax(np.abs(lengths - 1.0)))
            raise SceneError(
                f"SurfaceContact: normals[{worst}] is {lengths[worst]:g} long, must be a "
                "unit normal"
            )
        if not self.normal_areas.any():
            raise SceneError(
                "SurfaceContact: normal_areas are all 0, must be > 0 at one node at least"
            )

    @classmethod
    def on(
        cls,
        grid: Grid,
        rows: Integers,
        *,
        adhesion: float = 0.0,
        in_situ_stress: float,
        speed: float = 0.0,
    ) -> Self:
        """Contact of the surface that a grid is fitted to, on some of its rows of nodes.

        Normals are those of the consistent area vectors, the integrals of N n over the surface, so
        that no net flow passes through it. Soil on the axis moves along it alone: there they are
        vertical.

        Args:
            grid: its first column of nodes is on the surface.
            rows: the rows in contact, shape [node_count].
            adhesion: largest adhesion [Pa], >= 0.
            in_situ_stress: pressure that the simulated stress leaves out [Pa], >= 0.
            speed: speed at which the body sinks into a grid that rests [m/s].
        """
        within = Range(minimum=0, maximum=grid.row_count)
        check_array("SurfaceContact.on: rows", rows, (None,), within, kinds="iu")
        nodes = grid.node(0, rows)
        vectors = -grid.wall_vectors[rows]
        from_axis = np.abs(grid.node_positions[nodes, 0])
        vectors[from_axis <= AXIS_ROUNDING * grid.outer_radius, 0] = 0.0
        areas = np.linalg.norm(vectors, axis=1)
        if not areas.all():
            row = rows[np.argmin(areas)]
            raise SceneError(
                f"SurfaceContact.on: row {row} has no surface: there and in the rows beside it the "
                "grid begins on the axis"
            )
        check_number("SurfaceContact.on: adhesion", adhesion, NOT_NEGATIVE, unit="Pa")
        return cls(
            nodes=nodes,
            normals=vectors / areas[:, None],
            normal_areas=areas,
            adhesion_forces=adhesion * areas,
            in_situ_stress=in_situ_stress,
            speed=speed,
        )

    def check(self, scene: Scene) -> None:
        """Check the speed, and that the nodes are in the grid, where they have to be."""
        refuse_together(
            "SurfaceContact: speed",
            self.speed != 0.0 and scene.find(MovingGrid),
            "a window, which has the speed of the body",
        )
        check_nodes("SurfaceContact: nodes", self.nodes, scene.grid.node_count)
        inside = np.flatnonzero(np.asarray(self.nodes) % (scene.grid.column_count + 1))
        if inside.size and strength_changes(scene):
            raise SceneError(
                f"SurfaceContact: nodes[{inside[0]}] is not in the first column of the grid, must "
                "be where the strength beside it changes: with a state, or a variation and a window"
            )

    def add_contact(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over the nodes in contact.

        The array "contact.impulse" adds up the normal and the tangential impulse of each node on
        the body, shape [node_count, 2], since it was last cleared.
        """
        plan.add_array("contact.nodes", "int", self.nodes, (scene.grid.node_count,))
        plan.add_array("contact.normals", "vec2", self.normals)
        place = scene.grid.node_positions[self.nodes]
        strength = scene.material.ratio_at(place, "strength_ratio")
        relative = strength * scene.material.ratio_at(place, "adhesion_ratio")
        plan.add_array("contact.adhesion", "real", self.adhesion_forces * relative)
        plan.add_array("contact.pressure", "real", self.in_situ_stress * self.normal_areas)
        plan.add_zeros("contact.impulse", "vec2", len(self.nodes))
        has_friction, bound = bool(self.friction > 0.0), self.bound_of_friction
        travels = "window.motion" in plan.arrays
        moves = travels or bool(self.speed != 0.0)  # numbers may be those of numpy
        enclosed, cut = (
            f"cell.{name}" in plan.arrays for name in ("enclosed_modulus", "stress_share")
        )
        if has_friction:
            plan.add_array("contact.normal_force", "real", self.in_situ_stress * self.normal_areas)
        if bound is not None:
            plan.add_array("contact.strength", "real", bound * strength)
        plan.add_launch(
            _make_surface_contact(travels, has_friction, bound is not None, moves, enclosed, cut),
            len(self.nodes),
            friction=self.friction,
            friction_distance=float(scene.grid.cell_lengths.min()),
            speed=self.speed,
        )

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add the launches that update the adhesion if the strength of the soil changes."""
        forces = {"contact.adhesion": self.adhesion_forces}
        if (bound := self.bound_of_friction) is not None:
            forces["contact.strength"] = bound
        add_strength_beside(plan, scene, len(self.nodes), forces)

    @property
    def bound_of_friction(self) -> Floats | None:
        """Greatest shear forces with friction [N], shape [node_count]; None: no bound."""
        return self.strength_forces if self.friction > 0.0 else None

    def upward_force(self, forces: Floats) -> float:
        """Upward part [N] of normal and tangential `forces` of the soil [N], [node_count, 2].

        It acts on a radian of a round body, or on half of a symmetric one in plane strain.
        """
        normals = self.normals
        return float(np.sum(forces[:, 0] * normals[:, 1] - forces[:, 1] * normals[:, 0]))

    def share_in_touch(self, forces: Floats) -> float:
        """Share of the area in contact, from mean normal `forces` [N], shape [node_count]."""
        touching = forces > (PRESSURE_ROUNDING - 1.0) * self.in_situ_stress * self.normal_areas
        # Both areas are summed in the same order, so that full contact gives exactly 1.
        area = float(self.normal_areas @ np.ones_like(touching))
        return float(self.normal_areas @ touching) / area

    def can_part(self, material: Material, speed: float) -> bool:
        """Whether soil can pull at a body of this speed [m/s] by more than the in-situ stress.

        The pull is at most the limit pressure of a cavity plus rho v^2; twice this is assumed.
        """
        pull = material.limit_pressure + material.density * speed**2
        return self.in_situ_stress < 2.0 * pull


@wp.func
def contact_law(
    m: real, d: vec2, n: vec2, pressing: real, most_shear: real, pressure: real
) -> vec3:
    """(J_n, J_t w/|w|), the impulse from the body, of (m, d, n, P, mu P + a A dt, p A dt)."""
    normal_speed = wp.dot(d, n)
    J_n = wp.max(m * normal_speed, -pressure)
    if pressing <= zero:
        return vec3(J_n, zero, zero)
    w = d - normal_speed * n
    slip = m * wp.length(w)
    transmitted = m * w
    if slip > most_shear:
        transmitted = (most_shear / slip) * transmitted
    return vec3(J_n, transmitted[0], transmitted[1])


@wp.func
def least_share(share: wp.array[real], node: int, column_count: int, row_count: int) -> real:
    """The least share of the stress that acts in the cells around a node."""
    j, i = node / (column_count + 1), node % (column_count + 1)
    least = real(1.0)
    for row in range(wp.max(j - 1, 0), wp.min(j + 1, row_count)):
        for column in range(wp.max(i - 1, 0), wp.min(i + 1, column_count)):
            least = wp.min(least, share[row * column_count + column])
    return least


@functools.cache
def _make_surface_contact(
    travelling: bool, has_friction: bool, bounded: bool, moves: bool, enclosed: bool, cut: bool
) -> Any:
    """The kernel, launched over the surface's nodes.

    `travelling`: the grid travels with the body. `bounded`: the strength of the soil limits shear.
    `moves`: the body has a speed. `enclosed`: the scene has `EnclosedSoil`; `cut`: a `FreeSurface`.
    """

    @kernel
    def surface_contact(
        offset: int,
        contact_nodes: wp.array[int],
        contact_normals: wp.array[vec2],
        friction: real,
        friction_distance: real,
        contact_normal_force: maybe(real),
        contact_strength: maybe(real),
        contact_adhesion: wp.array[real],
        contact_pressure: wp.array[real],
        node_mass: wp.array[real],
        node_least_mass: wp.array[real],
        cell_stress_share: maybe(real),
        column_count: int,
        row_count: int,
        time_step: real,
        speed: real,
        window_motion: maybe(real),
        node_velocities: wp.array[vec4],
        contact_impulse: wp.array[vec2],
    ):
        k = offset + wp.tid()
        node = contact_nodes[k]
        m = node_mass[node]
        n = contact_normals[k]
        # In a travelling grid the body sinks at the speed at which the soil passes the grid.
        sinking = window_motion[1] if wp.static(travelling) else speed
        if m <= zero:
            if wp.static(enclosed):
                along_normal = -(sinking * n[1]) * n
                node_velocities[node] = vec4(along_normal[0], along_normal[1], zero, zero)
            return
        v = node_velocities[node]
        d = vec2(v[0], v[1]) + vec2(zero, sinking)
        in_situ = contact_pressure[k] * time_step
        by_force = vec2(v[0] - v[2], v[1] - v[3])
        K = wp.max(node_least_mass[node] - m, zero) * wp.dot(by_force, n)
        if wp.static(cut):
            K *= least_share(cell_stress_share, node, column_count, row_count)
        pressing = m * wp.dot(d, n) + K + in_situ
        most_shear = contact_adhesion[k] * time_step
        if wp.static(has_friction):
            passed = one
            if wp.static(moves):
                passed = wp.min(wp.abs(sinking) * time_step / friction_distance, one)
            R = contact_normal_force[k] + passed * (pressing / time_step - contact_normal_force[k])
            contact_normal_force[k] = R
            most_shear += friction * wp.max(R, zero) * time_step
        if wp.static(bounded):
            most_shear = wp.min(most_shear, contact_strength[k] * time_step)
        J = contact_law(m, d, n, pressing, most_shear, in_situ)
        tangential = vec2(J[1], J[2])
        change = -(J[0] * n + tangential) / m
        node_velocities[node] = vec4(v[0] + change[0], v[1] + change[1], v[2], v[3])
        along = wp.dot(tangential, vec2(n[1], -n[0]))
        contact_impulse[k] += vec2(wp.max(J[0] + K, -in_situ), along)

    return surface_contact
