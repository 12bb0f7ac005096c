"""Energy: the loss in the transfers, and the balance of the work of a body on the soil.

Every 16th step records both. The audit of the transfers compares the kinetic energy of the
velocities v at the end of the previous step with that of the velocities u before the momentum
equation of this step. Only the transfer to particles and back is between. For a row of nodes

    E <- E + sum m u.u / 2        before the step
    E <- E - sum m v.v / 2        after the previous step

Symbols of the balance: m mass of a node, M the greater of m and its least mass, u velocity before
the step, w velocity after the stress of the soil has acted, g after the ground around has acted
too, v after the step, x = (u + v) / 2, B velocity of the body; V volume, b viscosity, d rate of
dilation of a cell; tau trial stress, sigma stress after the update, e elastic energy per volume,
dev the deviator, G and K moduli. For each node, cell and point the sums are

    by the body     m (v - g).B, of which m (v - g).x to the soil; the rest is sliding
    by the ground   m (g - w).x
    kinetic         m (v.v - u.u) / 2
    least mass      (m - M) (w - u).x: the part of the work of stress that it removes
    viscous         V b d^2 dt
    plastic         V sigma:dev(tau - sigma) / 2G
    elastic         V (e(sigma) - e(before)),   e = dev sigma:dev sigma / 4G + (tr sigma)^2 / 18K

With the velocity x the work on a node is exactly the change of its kinetic energy; the remainder is
the work of stress. The sums over cells and points give the same work in another way. The volumes of
points are those of the step: together they fill their cell.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.checks import check_kind
from mpm_warp.kernel_types import half, kernel, maybe, real, vec2, vec4, vec5, vec7, zero
from mpm_warp.materials.elasticity import Isotropic, make_plastic_step
from mpm_warp.materials.material import Law
from mpm_warp.materials.von_mises import j2
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Part, Scene

OF_NODES, OF_CELLS, OF_POINTS = "balance.nodes", "balance.cells", "balance.points"
"""Arrays of work per radian [J]: of nodes (by the body, by the body to the soil, by the ground,
kinetic, least mass), of cells (viscous), of slots (plastic, elastic)."""


class EnergyAudit(Part):
    """Records the energy that the transfers create or dissipate.

    Example:
        >>> ConePenetration().build().find(EnergyAudit) is not None
        True
    """

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add an audited step; the array "transfer.energy" is its E [J] of each row of nodes."""
        rows = scene.grid.row_count + 1
        plan.add_zeros("transfer.energy", "real", rows)
        of = functools.partial(plan.launch, kinetic_energy, rows)
        plan.audit(of(first=0, sign=-1.0), before=plan.step[0].name)
        plan.audit(of(first=2, sign=1.0), after="momentum")


class EnergyBalance(Part):
    """Records the balance of the work of the body; the scene has a bulk viscosity.

    Example:
        >>> ConePenetration(energy_audit="balance").build().find(EnergyBalance) is not None
        True
    """

    needs = (MovingGrid, SurfaceContact, EnergyAudit)
    cell_bytes, point_bytes = 88.0, 16.0

    def check(self, scene: Scene) -> None:
        """Check that there is a bulk viscosity, and that the moduli are constant."""
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
        # Here cells still have the mass of their points and the rates of the previous step.
        plan.audit(plan.launch(work_of_cells, grid.cell_count), before="cell_stress")
        plan.audit(keep(kept="balance.by_stress"), after="momentum")
        plan.audit(keep(kept="balance.by_ground"), before="surface_contact")
        plan.audit(plan.launch(work_of_nodes, grid.node_count), after="surface_contact")
        # Here the rates of cells are known, and points have the stress before the update.
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
    """Launched over rows of nodes; the velocity begins at component `first`: v at 0, u at 2."""
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
    """Viscous work, and volume over the mass of the points; launched over cells."""
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
