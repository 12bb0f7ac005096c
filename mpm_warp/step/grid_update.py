"""Stage 2: the momentum equation on cells and nodes.

Symbols: sigma stress (rr, zz, rz, tt), V volume of a cell, m mass, M half a quarter of the mass of
the cells around a node when they are full, u and v velocity before and after the step, h length of
a cell, c pressure wave speed, b coefficient of the bulk viscosity, G_i the integrals over a cell of
(dN_i/dr r, dN_i/dz r, N_i), S the sharpening of `mpm_warp.step.mass_matrix_correction` where there is one.

    sigma_c = sum m sigma / sum m + b rho c h div v          mean stress and bulk viscosity
    f_i     = - sum over cells (sigma_rr G_r + sigma_rz G_z + sigma_tt G_t,
                                sigma_rz G_r + sigma_zz G_z)
    u_i     = (m v)_i / m_i + (S v)_i / max(m_i, 2 M_i)
    v_i     = u_i + dt f_i / max(m_i, M_i)
    div v_c = sum over nodes (v_r (G_r + G_t) + v_z G_z) / V
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.materials.elasticity import make_stress_step
from mpm_warp.parts.even_flow_kernel import make_even_flow
from mpm_warp.precision import Precision
from mpm_warp.step.mass_matrix_correction import make_sharpening


@functools.cache
def make_cell_stress(
    share_count: int, viscous: bool, partly_filled: bool, precision: Precision
) -> Any:
    """Mean stress of each cell from the particles' sums, which it clears; launched over cells.

    Args:
        share_count: how many sums there are of each.
        viscous: whether there is a bulk viscosity.
        partly_filled: whether cells may hold less soil than fills them, by which stress is scaled.
        precision: floating point types.
    """
    real, vec4 = precision.real, precision.vec4
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    key = f"{'viscous' if viscous else 'inviscid'}.{'partly' if partly_filled else 'full'}"
    key = f"{share_count}.{key}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.cell_stress.{key}", enable_backward=False)
    def cell_stress(
        first: int,
        stress_sum: wp.array2d(dtype=vec4),
        mass: wp.array2d(dtype=real),
        dilation_rate: wp.array(dtype=real),
        viscosity: wp.array(dtype=real),
        full_mass: wp.array(dtype=real),
        stress: wp.array(dtype=vec4),
    ):
        c = first + wp.tid()
        sums, m = vec4(), real(0.0)
        for share in range(wp.static(share_count)):
            part = mass[share, c]
            if part != zero:
                sums += stress_sum[share, c]
                m += part
                stress_sum[share, c] = vec4()
                mass[share, c] = zero
        mean = (one / m) * sums
        total = mean[0] + mean[1] + mean[2] + mean[3]
        # A cell that is empty for a moment keeps the stress it had: soil is all around it. So does
        # one whose soil is not finite, until the watch finds the particle.
        if total - total == zero:
            if wp.static(viscous):
                q = viscosity[c] * dilation_rate[c]
                mean += vec4(q, q, zero, q)
            if wp.static(partly_filled):
                mean *= wp.min(m / full_mass[c], one)
            stress[c] = mean
        elif wp.static(partly_filled):
            stress[c] = vec4()

    return cell_stress


@functools.cache
def make_node_update(share_count: int, sharpened: bool, precision: Precision) -> Any:
    """Velocity of each node before and after the step; launched over (rows, columns) of nodes.

    The sums of mass and momentum are cleared; `motion` is (v_r, v_z, u_r, u_z), velocity after the
    step and before it. The force is that of full cells, whatever particles are near the node at the
    moment; so `least_mass` bounds what it can do to a node that has few.

    Args:
        share_count: how many sums there are of each.
        sharpened: whether velocity is sharpened, see `mpm_warp.step.mass_matrix_correction`.
        precision: floating point types.
    """
    real, vec2, vec3, vec4 = precision.real, precision.vec2, precision.vec3, precision.vec4
    zero, half, one = (wp.constant(real(x)) for x in (0.0, 0.5, 1.0))
    sharpening_at_node = make_sharpening(precision).at_node

    @wp.func
    def pull(stress: vec4, G: vec3) -> vec2:
        return vec2(
            stress[0] * G[0] + stress[2] * G[1] + stress[3] * G[2],
            stress[2] * G[0] + stress[1] * G[1],
        )

    key = f"{share_count}.{'sharp' if sharpened else 'plain'}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.node_update.{key}", enable_backward=False)
    def node_update(
        first: int,
        momentum: wp.array2d(dtype=vec4),
        stress: wp.array(dtype=vec4),
        integrals: wp.array2d(dtype=vec3),
        column_count: int,
        row_count: int,
        time_step: real,
        least_mass: wp.array(dtype=real),
        absurd_speed: real,
        sharpening: wp.array(dtype=vec4),
        mass: wp.array(dtype=real),
        motion: wp.array(dtype=vec4),
    ):
        row, i = wp.tid()
        j = first + row
        node = j * (column_count + 1) + i
        sums = vec4()
        for share in range(wp.static(share_count)):
            part = momentum[share, node]
            if part[0] != zero:
                sums += part
                momentum[share, node] = vec4()
        m = sums[0]
        mass[node] = m
        if m <= zero:
            motion[node] = vec4()
            return
        force = vec2()
        cell = j * column_count + i
        if j < row_count:
            if i < column_count:
                force -= pull(stress[cell], integrals[cell, 0])
            if i > 0:
                force -= pull(stress[cell - 1], integrals[cell - 1, 1])
        if j > 0:
            cell -= column_count
            if i < column_count:
                force -= pull(stress[cell], integrals[cell, 2])
            if i > 0:
                force -= pull(stress[cell - 1], integrals[cell - 1, 3])
        before = (one / m) * vec2(sums[1], sums[2])
        if wp.static(sharpened):
            sharper = sharpening_at_node(sharpening, i, j, column_count, row_count)
            before += (half / wp.max(half * m, least_mass[node])) * sharper
        if not wp.dot(before, before) < absurd_speed * absurd_speed:
            # The particle that gave it such a velocity is left alone until the watch finds it.
            motion[node] = vec4()
            return
        after = before + (time_step / wp.max(m, least_mass[node])) * force
        motion[node] = vec4(after[0], after[1], before[0], before[1])

    return node_update


def cell_step_type(even: bool, precision: Precision) -> Any:
    """Type of what a step does to the soil of a cell: that to its stress, and its even flow."""
    return precision.vec11 if even else precision.vec7


@functools.cache
def make_cell_rates(viscous: bool, sharpened: bool, even: bool, precision: Precision) -> Any:
    """What a step at the velocity gradient of a cell does to its stress; launched over cells.

    Args:
        viscous: whether there is a bulk viscosity, which needs the rate of dilation.
        sharpened: whether velocity is sharpened, see `mpm_warp.step.mass_matrix_correction`.
        even: whether flow is made even within cells, see `mpm_warp.parts.even_flow_kernel`.
        precision: floating point types.
    """
    real, vec3, vec4 = precision.real, precision.vec3, precision.vec4
    vec5 = precision.vec5
    vec10, vec11 = precision.vec10, precision.vec11
    one = wp.constant(real(1.0))
    step_of = make_stress_step(precision)
    even_flow = make_even_flow(precision)
    sharpening_of_cell = make_sharpening(precision).of_cell

    @wp.func
    def rates(v: vec4, G: vec3) -> vec5:
        return vec5(v[0] * G[0], v[0] * G[1], v[1] * G[0], v[1] * G[1], v[0] * G[2])

    parts = ("viscous" if viscous else "inviscid", "sharp" if sharpened else "plain")
    key = f"{'.'.join(parts)}.{'even' if even else 'bilinear'}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.cell_rates.{key}", enable_backward=False)
    def cell_rates(
        first: int,
        motion: wp.array(dtype=vec4),
        integrals: wp.array2d(dtype=vec3),
        volume: wp.array(dtype=real),
        column_count: int,
        time_step: real,
        shear_modulus: real,
        bulk_modulus: real,
        dilation_rate: wp.array(dtype=real),
        sharpness: real,
        sharpening: wp.array(dtype=vec4),
        cell_step: wp.array(dtype=cell_step_type(even, precision)),
        evening: wp.array(dtype=vec10),
    ):
        c = first + wp.tid()
        node = c + c / column_count
        upper = node + column_count + 1
        v_00, v_10, v_01, v_11 = motion[node], motion[node + 1], motion[upper], motion[upper + 1]
        L = (one / volume[c]) * (
            rates(v_00, integrals[c, 0])
            + rates(v_10, integrals[c, 1])
            + rates(v_01, integrals[c, 2])
            + rates(v_11, integrals[c, 3])
        )
        if wp.static(viscous):
            dilation_rate[c] = L[0] + L[3] + L[4]
        if wp.static(sharpened):
            sharpening[c] = sharpening_of_cell(v_00, v_10, v_01, v_11, sharpness * volume[c])
        step = step_of(L, time_step, shear_modulus, bulk_modulus)
        if wp.static(even):
            E = time_step * even_flow(v_00, v_10, v_01, v_11, evening[c])
            cell_step[c] = vec11(
                step[0],
                step[1],
                step[2],
                step[3],
                step[4],
                step[5],
                step[6],
                E[0],
                E[1],
                E[2],
                E[3],
            )
        else:
            cell_step[c] = step

    return cell_rates
