"""Energy: what the transfers change, and where the work of a body on the soil goes.

Every 16th step records both. The audit of the transfers records before a step, for the velocities v
that the last one has left, and after its momentum equation, for the velocities u before it: only
the transfer to particles and back lies between. Over a row of nodes,

    E <- E + sum m u.u / 2        before the step
    E <- E - sum m v.v / 2        after the one before it

Symbols of the balance: m mass of a node, M the greater of it and its least mass, u velocity before
the step, w by the stress of the soil alone, g with what the ground around does beside it, v after
the step, x = (u + v) / 2, B velocity of the body; V volume, b viscosity, d rate of dilation of a
cell; tau trial stress, sigma stress after the law of the material, e elastic energy per volume, dev
the deviator, G and K moduli. Added up are, of each node, cell and point,

    by the body     m (v - g).B, of it to the soil m (v - g).x: the rest is sliding
    by the ground   m (g - w).x
    kinetic         m (v.v - u.u) / 2
    least mass      (m - M) (w - u).x: what it keeps from the work of stress
    viscous         V b d^2 dt
    plastic         V sigma:dev(tau - sigma) / 2G
    elastic         V (e(sigma) - e(before)),   e = dev sigma:dev sigma / 4G + (tr sigma)^2 / 18K

The velocity x makes the works of a node those of its kinetic energy, exactly. What is left of them
is the work of stress; that in cells and points is the same, found in another way. Points have the
volume that the step gives them: together they fill their cell.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.arguments import check_kind
from mpm_warp.errors import SceneError
from mpm_warp.kernel_types import half, kernel, maybe, real, vec2, vec4, vec5, vec7, zero
from mpm_warp.materials.elasticity import Isotropic, make_plastic_step
from mpm_warp.materials.material import Law
from mpm_warp.materials.von_mises import j2
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Part, Scene

OF_NODES, OF_CELLS, OF_POINTS = "balance.nodes", "balance.cells", "balance.points"
"""The arrays of work [J] per radian: of nodes (by the body, of it to the soil, by the ground,
kinetic, least mass), of cells (viscous), of slots (plastic, elastic)."""


class EnergyAudit(Part):
    """Samples what energy the transfers create or dissipate."""

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add an audited step.

        The array "transfer.energy" adds up what each row of nodes has gained in these steps [J].
        """
        rows = scene.grid.row_count + 1
        plan.add_zeros("transfer.energy", "real", rows)
        of = functools.partial(plan.launch, kinetic_energy, rows)
        plan.audit(of(first=0, sign=-1.0), before=plan.step[0].name)
        plan.audit(of(first=2, sign=1.0), after="momentum")


class EnergyBalance(Part):
    """Samples where the work of the body goes; the soil has a bulk viscosity then."""

    needs = (MovingGrid, SurfaceContact, EnergyAudit)
    cell_bytes, point_bytes = 88.0, 16.0

    def check(self, scene: Scene) -> None:
        """Check that there is a bulk viscosity, and an elastic energy: constant moduli."""
        if scene.bulk_viscosity is None:
            raise SceneError("EnergyBalance: not without a bulk_viscosity")
        check_kind("EnergyBalance: material", scene.material, Isotropic)

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add the records to the audited step."""
        grid = scene.grid
        slots = plan.arrays["particle.mass"].shape
        plan.add_zeros("balance.by_stress", "vec2", grid.node_count)
        plan.add_zeros("balance.by_ground", "vec2", grid.node_count)
        plan.add_zeros("balance.specific_volume", "real", grid.cell_count)
        plan.add_zeros(OF_NODES, "vec5", grid.node_count)
        plan.add_zeros(OF_CELLS, "real", grid.cell_count)
        plan.add_zeros(OF_POINTS, "vec2", slots)
        keep = functools.partial(plan.launch, keep_velocity, grid.node_count)
        of_points = plan.launch(_make_work_of_points(scene.material.law()), slots)
        # Cells still have the mass of their points, and the rates of the step before.
        plan.audit(plan.launch(work_of_cells, grid.cell_count), before="cell_stress")
        plan.audit(keep(kept="balance.by_stress"), after="momentum")
        plan.audit(keep(kept="balance.by_ground"), before="surface_contact")
        plan.audit(plan.launch(work_of_nodes, grid.node_count), after="surface_contact")
        # The rates of cells are known, and points still have the stress before the law.
        plan.audit(of_points, before="grid_to_particles")


@kernel
def kinetic_energy(
    column_count: int,
    first: int,
    sign: real,
    node_mass: wp.array[real],
    node_velocities: wp.array[vec4],
    transfer_energy: wp.array[real],
):
    """Launched over rows of nodes, each of which keeps its own sum.

    The velocity begins at component `first`: at 0 after a step, at 2 before it.
    """
    j = wp.tid()
    total = real(0.0)
    for i in range(column_count + 1):
        node = j * (column_count + 1) + i
        v = node_velocities[node]
        total += node_mass[node] * (v[first] * v[first] + v[first + 1] * v[first + 1])
    transfer_energy[j] = transfer_energy[j] + half * sign * total


@kernel
def keep_velocity(offset: int, node_velocities: wp.array[vec4], kept: wp.array[vec2]):
    """Launched over nodes."""
    node = offset + wp.tid()
    v = node_velocities[node]
    kept[node] = vec2(v[0], v[1])


@kernel
def work_of_nodes(
    offset: int,
    node_velocities: wp.array[vec4],
    node_mass: wp.array[real],
    node_least_mass: wp.array[real],
    window_motion: wp.array[real],
    balance_by_stress: wp.array[vec2],
    balance_by_ground: wp.array[vec2],
    balance_nodes: wp.array[vec5],
):
    """Launched over nodes."""
    node = offset + wp.tid()
    m, velocities = node_mass[node], node_velocities[node]
    M = wp.max(m, node_least_mass[node])
    u, v = vec2(velocities[2], velocities[3]), vec2(velocities[0], velocities[1])
    w, g = balance_by_stress[node], balance_by_ground[node]
    x = half * (u + v)
    # The body sinks at the speed at which the soil passes the grid.
    B = vec2(zero, -window_motion[1])
    balance_nodes[node] = balance_nodes[node] + vec5(
        m * wp.dot(v - g, B),
        m * wp.dot(v - g, x),
        m * wp.dot(g - w, x),
        half * m * (wp.dot(v, v) - wp.dot(u, u)),
        (m - M) * wp.dot(w - u, x),
    )


@kernel
def work_of_cells(
    offset: int,
    cell_mass: wp.array2d[real],
    cell_volume: wp.array[real],
    cell_viscosity: wp.array[real],
    cell_dilation_rate: wp.array[real],
    time_step: real,
    balance_specific_volume: wp.array[real],
    balance_cells: wp.array[real],
):
    """Launched over cells; it leaves their volume over the mass of their points too."""
    c = offset + wp.tid()
    V, d = cell_volume[c], cell_dilation_rate[c]
    m = real(0.0)
    for share in range(cell_mass.shape[0]):
        m += cell_mass[share, c]
    if m > zero:
        balance_specific_volume[c] = V / m
    balance_cells[c] = balance_cells[c] + V * cell_viscosity[c] * d * d * time_step


@functools.cache
def _make_work_of_points(law: Law) -> Any:
    """The kernel, launched over slots of particles."""
    plastic_step = make_plastic_step(law)
    two, three, eighteen = (wp.constant(real(x)) for x in (2.0, 3.0, 18.0))

    @wp.func
    def elastic_energy(sigma: vec4, G: real, K: real) -> real:
        trace = sigma[0] + sigma[1] + sigma[3]
        return j2(sigma) / (two * G) + trace * trace / (eighteen * K)

    @wp.func
    def on_deviator(sigma: vec4, e: vec4) -> real:
        mean = (e[0] + e[1] + e[3]) / three
        along_axes = sigma[0] * (e[0] - mean) + sigma[1] * (e[1] - mean) + sigma[3] * (e[3] - mean)
        return along_axes + two * sigma[2] * e[2]

    @kernel
    def work_of_points(
        offset: int,
        particle_cell: wp.array[wp.vec2i],
        particle_mass: wp.array[real],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        cell_motion: wp.array[vec7],
        column_count: int,
        time_step: real,
        properties: law.properties_argument,
        balance_specific_volume: wp.array[real],
        balance_points: wp.array[vec2],
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        if cell[0] < 0:
            return
        c = cell[1] * column_count + cell[0]
        before = particle_stress[p]
        own, remembered = law.of_point(properties, particle_state, p)
        sigma, relaxed, moduli = plastic_step(before, cell_motion[c], time_step, own, remembered)
        G, K = moduli[0], moduli[1]
        V = particle_mass[p] * balance_specific_volume[c]
        balance_points[p] = balance_points[p] + V * vec2(
            on_deviator(sigma, relaxed) / (two * G),
            elastic_energy(sigma, G, K) - elastic_energy(before, G, K),
        )

    return work_of_points
