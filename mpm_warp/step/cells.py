"""Stage 2: the mean stress of each cell.

Symbols: sigma stress (rr, zz, rz, tt), m mass, h length of a cell, rho density, c pressure wave
speed, b coefficient of the bulk viscosity, M mass of a full cell, K bulk modulus, e strain of the
last step.

    sigma_c = sum m sigma / sum m + b rho c h div v            mean stress and bulk viscosity
    sigma_c <- s sigma_c,  s = min(sum m / M, 1)               where a free surface may pass
    sigma_c <- (tr sigma_c / 3 + K tr e) 1                     an empty cell that soil encloses

Stage 5: the mean velocity gradient of each cell, and the strain and rotation of points in a step.

Symbols: v velocity of the nodes after the step, G_i the integrals over a cell of
(dN_i/dr r, dN_i/dz r, N_i), V volume of the cell, L velocity gradient (rr, rz, zr, zz, tt).

    L       = sum over nodes (v_r G_r, v_r G_z, v_z G_r, v_z G_z, v_r G_t) / V
    div v_c = L_rr + L_zz + L_tt
    motion  = (e, R)       strain and rotation by the spin in a step, see `motion_of`
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.kernel_types import (
    kernel,
    maybe,
    one,
    real,
    third,
    vec3,
    vec4,
    vec5,
    vec7,
    vec10,
    zero,
)
from mpm_warp.materials.elasticity import motion_of
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene
from mpm_warp.step.momentum import correction_of_cell


def add_cell_stress(plan: Plan, scene: Scene) -> None:
    """Add the stage.

    `FreeSurface` has added "cell.full_mass" to the plan, `EnclosedSoil` "cell.enclosed_modulus".
    """
    grid, viscosity = scene.grid, scene.bulk_viscosity
    plan.add_zeros("cell.stress", "vec4", grid.cell_count)
    if viscosity is not None:
        impedance = scene.material.density * scene.material.pressure_wave_speed
        plan.add_array("cell.viscosity", "real", viscosity * impedance * grid.cell_lengths)
        plan.add_zeros("cell.dilation_rate", "real", grid.cell_count)
    plan.add_zeros("cell.motion", "vec7", grid.cell_count)
    if "cell.full_mass" in plan.arrays:
        plan.add_zeros("cell.stress_share", "real", grid.cell_count)
    free_surface, enclosed = (
        f"cell.{name}" in plan.arrays for name in ("full_mass", "enclosed_modulus")
    )
    plan.add_launch(
        _make_cell_stress(plan.share_count, viscosity is not None, free_surface, enclosed),
        grid.cell_count,
    )


@functools.cache
def _make_cell_stress(share_count: int, viscous: bool, free_surface: bool, enclosed: bool) -> Any:
    """The kernel, launched over cells; it clears the sums over particles in all shares."""

    @kernel
    def cell_stress(
        offset: int,
        cell_stress_sum: wp.array2d[vec4],
        cell_mass: wp.array2d[real],
        cell_dilation_rate: maybe(real),
        cell_viscosity: maybe(real),
        cell_full_mass: maybe(real),
        cell_stress_share: maybe(real),
        cell_enclosed_modulus: maybe(real),
        cell_motion: wp.array[vec7],
        cell_stress: wp.array[vec4],
    ):
        c = offset + wp.tid()
        sums, m = vec4(), real(0.0)
        for share in range(wp.static(share_count)):
            part = cell_mass[share, c]
            if part != zero:
                sums += cell_stress_sum[share, c]
                m += part
                cell_stress_sum[share, c] = vec4()
                cell_mass[share, c] = zero
        if wp.static(free_surface):
            cell_stress_share[c] = wp.min(m / cell_full_mass[c], one)
        mean = (one / m) * sums
        total = mean[0] + mean[1] + mean[2] + mean[3]
        # A cell that is empty for a moment keeps its last stress, or its pressure follows its
        # volume. One that is not finite stays until the watch finds the particle.
        if total - total == zero:
            if wp.static(viscous):
                q = cell_viscosity[c] * cell_dilation_rate[c]
                mean += vec4(q, q, zero, q)
            if wp.static(free_surface):
                mean *= cell_stress_share[c]
            cell_stress[c] = mean
        elif wp.static(free_surface):
            cell_stress[c] = vec4()
        elif wp.static(enclosed):
            if m == zero:
                had, e = cell_stress[c], cell_motion[c]
                change = cell_enclosed_modulus[c] * (e[0] + e[1] + e[3])
                p = third * (had[0] + had[1] + had[3]) + change
                cell_stress[c] = vec4(p, p, zero, p)

    return cell_stress


def add_cell_rates(plan: Plan, scene: Scene, *, internal_flow: Any | None) -> None:
    """Add the stage.

    It also computes the rate of dilation and the mass-matrix correction, if earlier stages have
    added their arrays. `internal_flow` is a device function (velocities of the four nodes, weights
    of the cell) -> flow within the cell per time, a vector of 4; None: there is no such flow.
    """
    grid = scene.grid
    # k rho / 4, see `mpm_warp.step.momentum`.
    weight = scene.material.density * (1.0 - scene.particles_per_side**-2.0) / 24.0
    plan.add_array("cell.volume", "real", grid.cell_volumes)
    if internal_flow is not None:
        plan.add_zeros("cell.internal_flow", "vec4", grid.cell_count)
    viscous, corrected, blended = (
        f"cell.{name}" in plan.arrays for name in ("dilation_rate", "correction", "pic_fraction")
    )
    plan.add_launch(
        _make_cell_rates(viscous, corrected, blended, internal_flow),
        grid.cell_count,
        correction_weight=weight,
    )


@functools.cache
def _make_cell_rates(viscous: bool, corrected: bool, blended: bool, internal_flow: Any) -> Any:
    """The kernel, launched over cells; `blended`: cells with a PIC fraction are not corrected."""

    @wp.func
    def rates(v: vec4, G: vec3) -> vec5:
        return vec5(v[0] * G[0], v[0] * G[1], v[1] * G[0], v[1] * G[1], v[0] * G[2])

    @kernel
    def cell_rates(
        offset: int,
        node_velocities: wp.array[vec4],
        cell_integrals: wp.array2d[vec3],
        cell_volume: wp.array[real],
        column_count: int,
        time_step: real,
        cell_dilation_rate: maybe(real),
        correction_weight: real,
        cell_correction: maybe(vec4),
        cell_pic_fraction: maybe(real),
        cell_motion: wp.array[vec7],
        cell_interpolation_weights: maybe(vec10),
        cell_internal_flow: maybe(vec4),
    ):
        c = offset + wp.tid()
        node = c + c / column_count
        upper = node + column_count + 1
        v_00, v_10 = node_velocities[node], node_velocities[node + 1]
        v_01, v_11 = node_velocities[upper], node_velocities[upper + 1]
        L = (one / cell_volume[c]) * (
            rates(v_00, cell_integrals[c, 0])
            + rates(v_10, cell_integrals[c, 1])
            + rates(v_01, cell_integrals[c, 2])
            + rates(v_11, cell_integrals[c, 3])
        )
        if wp.static(viscous):
            cell_dilation_rate[c] = L[0] + L[3] + L[4]
        if wp.static(corrected):
            weight = correction_weight * cell_volume[c]
            if wp.static(blended):
                if cell_pic_fraction[c] > zero:
                    weight = zero
            cell_correction[c] = correction_of_cell(v_00, v_10, v_01, v_11, weight)
        cell_motion[c] = motion_of(L, time_step)
        if wp.static(internal_flow is not None):
            flow = internal_flow(v_00, v_10, v_01, v_11, cell_interpolation_weights[c])
            cell_internal_flow[c] = time_step * flow

    return cell_rates
