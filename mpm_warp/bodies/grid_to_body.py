"""From the nodes to particles: velocity, position and stress from the field of their body.

Symbols: v_i velocity of node i, d_i its offset, N_i shape function, L velocity gradient
(xx, xy, yx, yy, zz), h cell size.

    v <- sum N_i v_i,    B <- 4 / h^2 sum N_i v_i d_i'      affine: linear fields arrive exactly
    L <- L + dt (L'L / 2 - D D)      the logarithmic strain of a finite step, to second order, D the
                                     symmetric part of L; without this term a body that turns grows
    x <- x + dt v,       V <- V exp(dt tr L)
    sigma <- R sigma R' + dt (K tr L + 2 G dev L)
    sigma_v = tau (K tr L + 2 G dev L)               viscous stress of a Kelvin-Voigt solid
    W <- W + dt V sigma_v : L                        what it has dissipated

The affine transfer: Jiang, Schroeder, Selle, Teran & Stomakhin (2015, ACM Trans. Graph. 34(4):51).
"""

import functools
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.bodies.grid import make_splines
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.materials.elasticity import make_elastic_trial, make_stress_increment
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


def add_grid_to_body(plan: Plan, scene: BodyScene) -> None:
    """Add the motion and the stress of particles, after the velocities of the nodes are final."""
    materials = [body.material for body in scene.bodies]
    moduli = np.array([(it.shear_modulus, it.bulk_modulus) for it in materials])
    plan.add_array("body.moduli", "vec2", moduli)
    retardation, viscous_stress, dissipated = None, None, None
    if scene.is_damped:
        times = np.array([body.retardation_time or 0.0 for body in scene.bodies])
        retardation = plan.add_array("body.retardation_time", "real", times)
        viscous_stress = "particle.viscous_stress"
        dissipated = plan.add_zeros("particle.dissipated", "real", plan.particle_count)
    plan.add_launch(
        make_grid_to_body(scene.grid.axisymmetric, scene.is_damped, plan.precision),
        plan.particle_count,
        body_retardation_time=retardation,
        **scene.grid.kernel_arguments(plan.precision),
        particle_viscous_stress=viscous_stress,
        particle_dissipated=dissipated,
    )


@functools.cache
def make_grid_to_body(axisymmetric: bool, damped: bool, precision: Precision) -> Any:
    """The kernel, launched over particles; `body_moduli` holds (G, K) of each body.

    Args:
        axisymmetric: whether there is a hoop direction.
        damped: whether there is a viscous stress.
        precision: floating point types.
    """
    real, vec2, vec4, vec5 = precision.real, precision.vec2, precision.vec4, precision.vec5
    mat22 = precision.mat22
    splines = make_splines(precision)
    first_node, local_coordinate = splines.first_node, splines.local_coordinate
    weights, slopes, offsets = splines.weights, splines.slopes, splines.offsets
    elastic_trial, stress_increment = (
        make_elastic_trial(precision),
        make_stress_increment(precision),
    )
    half, four = (wp.constant(real(x)) for x in (0.5, 4.0))

    shape = "axisymmetric" if axisymmetric else "plane"
    key = f"{shape}.{'damped.' if damped else ''}{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.grid_to_body.{key}", enable_backward=False)
    def grid_to_body(
        particle_body: wp.array(dtype=int),
        body_moduli: wp.array(dtype=vec2),
        body_retardation_time: wp.array(dtype=real),
        field_velocity: wp.array2d(dtype=vec2),
        lower: vec2,
        h: real,
        node_counts: wp.vec2i,
        time_step: real,
        particle_position: wp.array(dtype=vec2),
        particle_velocity: wp.array(dtype=vec2),
        particle_affine: wp.array(dtype=mat22),
        particle_stress: wp.array(dtype=vec4),
        particle_volume: wp.array(dtype=real),
        particle_viscous_stress: wp.array(dtype=vec4),
        particle_dissipated: wp.array(dtype=real),
    ):
        p = wp.tid()
        b = particle_body[p]
        x = particle_position[p]
        where = (x - lower) / h
        i = first_node(where[0], node_counts[0])
        j = first_node(where[1], node_counts[1])
        fx, fy = local_coordinate(where[0], i), local_coordinate(where[1], j)
        Nx, Ny = weights(fx), weights(fy)
        dNx, dNy = slopes(fx) / h, slopes(fy) / h
        dx, dy = offsets(fx), offsets(fy)

        v = vec2()
        B = mat22()
        gradient = mat22()
        for row in range(3):
            for column in range(3):
                node = (j + row) * node_counts[0] + i + column
                v_i = field_velocity[b, node]
                N = Nx[column] * Ny[row]
                d = h * vec2(dx[column], dy[row])
                v += N * v_i
                B += wp.outer(N * v_i, d)
                gradient += wp.outer(v_i, vec2(dNx[column] * Ny[row], Nx[column] * dNy[row]))
        stretching = half * (gradient + wp.transpose(gradient))
        gradient += time_step * (
            half * (wp.transpose(gradient) * gradient) - stretching * stretching
        )
        hoop = real(0.0)
        if wp.static(axisymmetric):
            hoop = v[0] / x[0]
        L = vec5(gradient[0, 0], gradient[0, 1], gradient[1, 0], gradient[1, 1], hoop)

        increment = stress_increment(L, time_step, body_moduli[b][0], body_moduli[b][1])
        particle_stress[p] = elastic_trial(particle_stress[p], increment)
        if wp.static(damped):
            viscous = (body_retardation_time[b] / time_step) * vec4(
                increment[0], increment[1], increment[2], increment[3]
            )
            particle_viscous_stress[p] = viscous
            power = viscous[0] * L[0] + viscous[1] * L[3] + viscous[3] * L[4]
            power += viscous[2] * (L[1] + L[2])
            particle_dissipated[p] = particle_dissipated[p] + time_step * particle_volume[p] * power
        particle_volume[p] = particle_volume[p] * wp.exp(time_step * (L[0] + L[3] + L[4]))
        particle_velocity[p] = v
        particle_affine[p] = (four / (h * h)) * B
        particle_position[p] = x + time_step * v

    return grid_to_body
