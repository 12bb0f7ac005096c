"""Stage 2: the mean stress of each cell.

Symbols: sigma stress (rr, zz, rz, tt), m mass, h length of a cell, rho density, c pressure wave
speed, b coefficient of the bulk viscosity, M mass of a cell that is full.

    sigma_c = sum m sigma / sum m + b rho c h div v            mean stress and bulk viscosity
    sigma_c <- min(sum m / M, 1) sigma_c                       where a free surface may pass
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.kernel_types import kernel, one, real, vec4, zero
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene


def add_cell_stress(plan: Plan, scene: Scene) -> None:
    """Add the stage; the plan has "cell.full_mass" where soil may fill cells in part alone."""
    grid, viscosity = scene.grid, scene.bulk_viscosity
    plan.add_zeros("cell.stress", "vec4", grid.cell_count)
    if viscosity is not None:
        impedance = scene.material.density * scene.material.pressure_wave_speed
        plan.add_array("cell.viscosity", "real", viscosity * impedance * grid.cell_lengths)
        plan.add_zeros("cell.dilation_rate", "real", grid.cell_count)
    free_surface = plan.find("cell.full_mass") is not None
    plan.add_launch(
        _make_cell_stress(plan.share_count, viscosity is not None, free_surface),
        grid.cell_count,
        cell_dilation_rate=plan.find("cell.dilation_rate"),
        cell_viscosity=plan.find("cell.viscosity"),
        cell_full_mass=plan.find("cell.full_mass"),
    )


@functools.cache
def _make_cell_stress(share_count: int, viscous: bool, free_surface: bool) -> Any:
    """The kernel, launched over cells; it clears the particles' sums of all shares."""

    @kernel
    def cell_stress(
        offset: int,
        cell_stress_sum: wp.array2d(dtype=vec4),
        cell_mass: wp.array2d(dtype=real),
        cell_dilation_rate: wp.array(dtype=real),
        cell_viscosity: wp.array(dtype=real),
        cell_full_mass: wp.array(dtype=real),
        cell_stress: wp.array(dtype=vec4),
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
        mean = (one / m) * sums
        total = mean[0] + mean[1] + mean[2] + mean[3]
        # A cell that is empty for a moment keeps the stress it had: soil is all around it. So does
        # one whose soil is not finite, until the watch finds the particle.
        if total - total == zero:
            if wp.static(viscous):
                q = cell_viscosity[c] * cell_dilation_rate[c]
                mean += vec4(q, q, zero, q)
            if wp.static(free_surface):
                mean *= wp.min(m / cell_full_mass[c], one)
            cell_stress[c] = mean
        elif wp.static(free_surface):
            cell_stress[c] = vec4()

    return cell_stress
