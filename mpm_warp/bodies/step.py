"""The step of bodies: from particles to the nodes of the field of their body, contact, and back.

Each body has a velocity field of its own. Symbols: m mass, V volume, v velocity, B affine velocity,
sigma stress (xx, yy, xy, zz), f_p load, d_i = x_i - x offset of node i, N_i its shape function, h
cell size. In axisymmetry x, y are r, z.

    m_i     = sum m N_i
    (m v)_i = sum m N_i (v + B d_i)
    f_i     = sum N_i f_p - V (sigma_xx dN/dx + sigma_xy dN/dy + sigma_zz N/r,
                               sigma_xy dN/dx + sigma_yy dN/dy)
    a_i     = sum V (dN/dx + N/r, dN/dy)      the integral of N n by the divergence theorem
    v_i     = ((m v)_i + dt f_i) / m_i

Then contact, and back, with L the velocity gradient (xx, xy, yx, yy, zz), D its symmetric part:

    v <- sum N_i v_i,    B <- 4 / h^2 sum N_i v_i d_i'      affine: exact for linear fields
    L <- L + dt (L'L / 2 - D D)      logarithmic strain of a finite step, to second order; without
                                     this term a body that turns grows
    x <- x + dt v,       V <- V exp(dt tr L)
    sigma <- R sigma R' + dt (K tr L + 2 G dev L)
    sigma_v = tau (K tr L + 2 G dev L)               viscous stress of a Kelvin-Voigt solid
    W <- W + dt V sigma_v : L                        energy that it has dissipated

The affine transfer: Jiang, Schroeder, Selle, Teran & Stomakhin (2015, ACM Trans. Graph. 34(4):51).

Arrays over "field" have a row for each body and a column for each node.
"""

import functools
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.bodies.body import Body, UniformGrid, add_loads, add_particles, clock, spline
from mpm_warp.bodies.contact import add_contact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.fields.checks import FROM_ONE, check_whole
from mpm_warp.grid.fitted import Integers
from mpm_warp.kernel_types import (
    half,
    kernel,
    mat22,
    maybe,
    one,
    real,
    vec2,
    vec3,
    vec4,
    vec5,
    zero,
)
from mpm_warp.materials.elasticity import elastic_increment, motion_of, rotated
from mpm_warp.plan.plan import Plan, TimeStepControl
from mpm_warp.planning import make_plan

four = wp.constant(real(4.0))


@make_plan.register
def make_body_plan(scene: BodyScene, share_count: int = 1, time_step: float | None = None) -> Plan:
    """The plan of a run of bodies, see `make_plan`; its launches have no shares."""
    check_whole("share_count", share_count, FROM_ONE)
    critical_time_step = scene.critical_time_step()
    if time_step is None:
        time_step = scene.time_step_fraction * critical_time_step
    plan = Plan(
        time_step=time_step,
        longest_time_step=max(1.0, scene.time_step_fraction) * critical_time_step,
        speed_limit=max(body.material.pressure_wave_speed for body in scene.bodies),
        particle_bounds=scene.grid.particle_bounds,
        given=scene.grid.kernel_arguments,
        control=TimeStepControl(
            first=scene.time_step_fraction * critical_time_step,
            fraction=scene.time_step_fraction,
            critical=lambda array: scene.critical_time_step(array("particle.volume")),
        ),
        remedy="try a smaller time_step_fraction, or a wider grid where a body has left it",
    )
    add_particles(plan, scene.bodies)
    if scene.loads:
        add_loads(plan, scene.loads)
    add_body_to_grid(plan, scene)
    if scene.contact is not None:
        add_contact(plan, scene.contact, scene.bodies, scene.grid)
    add_grid_to_body(plan, scene)
    if scene.loads:
        plan.add_launch(clock, 1)
    return plan


def add_body_to_grid(plan: Plan, scene: BodyScene) -> None:
    """Add the velocities of the nodes after the step, of each body as if it were alone."""
    grid, damped, loaded = scene.grid, scene.is_damped, bool(scene.loads)
    plan.add_zeros("field.momentum", "vec3", scene.field_shape)
    if damped:
        plan.add_zeros("particle.viscous_stress", "vec4", plan.particle_count)
    if scene.contact is not None:
        plan.add_zeros("field.surface", "vec2", scene.field_shape)
    plan.add_launch(
        make_body_to_grid(grid.axisymmetric, damped, loaded, scene.contact is not None),
        plan.particle_count,
    )
    held = np.stack([_held_nodes(body, grid) for body in scene.bodies])
    plan.add_array("field.held", "int", held)
    plan.add_zeros("field.inverse_mass", "real", scene.field_shape)
    plan.add_zeros("field.velocity", "vec2", scene.field_shape)
    plan.add_launch(body_prediction, scene.field_shape)


def _held_nodes(body: Body, grid: UniformGrid) -> Integers:
    """1 at the nodes that a held particle reaches, else 0; shape [node_count]."""
    held = np.zeros(grid.node_counts[::-1], dtype=np.int32)
    if body.held is not None:
        cells = (body.position[body.held] - np.asarray(grid.lower)) / grid.cell_size
        for column, row in np.floor(cells - 0.5).astype(int):
            held[row : row + 3, column : column + 3] = 1
    return held.ravel()


@functools.cache
def make_body_to_grid(axisymmetric: bool, damped: bool, loaded: bool, contact: bool) -> Any:
    """The kernel, launched over particles; `contact`: it also sums up the surfaces of bodies."""

    @kernel
    def body_to_grid(
        particle_body: wp.array[int],
        particle_position: wp.array[vec2],
        particle_velocity: wp.array[vec2],
        particle_affine: wp.array[mat22],
        particle_stress: wp.array[vec4],
        particle_mass: wp.array[real],
        particle_volume: wp.array[real],
        particle_viscous_stress: maybe(vec4),
        particle_load: maybe(vec2),
        lower: vec2,
        h: real,
        node_counts: wp.vec2i,
        time_step: real,
        field_momentum: wp.array2d[vec3],
        field_surface: maybe(vec2, 2),
    ):
        p = wp.tid()
        b = particle_body[p]
        x = particle_position[p]
        where = (x - lower) / h
        i, Nx, dNx, dx = spline(where[0], h, node_counts[0])
        j, Ny, dNy, dy = spline(where[1], h, node_counts[1])
        m, V, v, B, sigma = (
            particle_mass[p],
            particle_volume[p],
            particle_velocity[p],
            particle_affine[p],
            vec4(particle_stress[p]),
        )
        if wp.static(damped):
            sigma += particle_viscous_stress[p]

        for row in range(3):
            for column in range(3):
                node = (j + row) * node_counts[0] + i + column
                N = Nx[column] * Ny[row]
                G = vec2(dNx[column] * Ny[row], Nx[column] * dNy[row])
                force = -V * vec2(
                    sigma[0] * G[0] + sigma[2] * G[1], sigma[2] * G[0] + sigma[1] * G[1]
                )
                if wp.static(axisymmetric):
                    force -= V * vec2(sigma[3] * N / x[0], real(0.0))
                    G += vec2(N / x[0], real(0.0))
                if wp.static(loaded):
                    force += N * particle_load[p]
                d = vec2(dx[column], dy[row])
                share = N * m * (v + B * d) + time_step * force
                wp.atomic_add(field_momentum, b, node, vec3(N * m, share[0], share[1]))
                if wp.static(contact):
                    wp.atomic_add(field_surface, b, node, V * G)

    return body_to_grid


@kernel
def body_prediction(
    field_held: wp.array2d[int],
    field_momentum: wp.array2d[vec3],
    field_inverse_mass: wp.array2d[real],
    field_velocity: wp.array2d[vec2],
):
    """Velocity and inverse mass of each node; clears its sums. Launched over (bodies, nodes).

    The inverse mass is -1 at a node without mass and 0 at a held node, which no impulse moves.
    """
    b, node = wp.tid()
    sums = field_momentum[b, node]
    field_momentum[b, node] = vec3()
    field_velocity[b, node] = vec2()
    if sums[0] <= zero:
        field_inverse_mass[b, node] = -one
    elif field_held[b, node] != 0:
        field_inverse_mass[b, node] = zero
    else:
        field_inverse_mass[b, node] = one / sums[0]
        field_velocity[b, node] = vec2(sums[1], sums[2]) / sums[0]


def add_grid_to_body(plan: Plan, scene: BodyScene) -> None:
    """Add the motion and stress update of particles, after contact."""
    materials = [body.material for body in scene.bodies]
    moduli = np.array([(elastic.shear_modulus, elastic.bulk_modulus) for elastic in materials])
    plan.add_array("body.moduli", "vec2", moduli)
    if scene.is_damped:
        times = np.array([body.retardation_time or 0.0 for body in scene.bodies])
        plan.add_array("body.retardation_time", "real", times)
        plan.add_zeros("particle.dissipated", "real", plan.particle_count)
    plan.add_launch(
        make_grid_to_body(scene.grid.axisymmetric, scene.is_damped), plan.particle_count
    )


@functools.cache
def make_grid_to_body(axisymmetric: bool, damped: bool) -> Any:
    """The kernel, launched over particles; `body_moduli` holds (G, K) of each body."""

    @kernel
    def grid_to_body(
        particle_body: wp.array[int],
        body_moduli: wp.array[vec2],
        body_retardation_time: maybe(real),
        field_velocity: wp.array2d[vec2],
        lower: vec2,
        h: real,
        node_counts: wp.vec2i,
        time_step: real,
        particle_position: wp.array[vec2],
        particle_velocity: wp.array[vec2],
        particle_affine: wp.array[mat22],
        particle_stress: wp.array[vec4],
        particle_volume: wp.array[real],
        particle_viscous_stress: maybe(vec4),
        particle_dissipated: maybe(real),
    ):
        p = wp.tid()
        b = particle_body[p]
        x = particle_position[p]
        where = (x - lower) / h
        i, Nx, dNx, dx = spline(where[0], h, node_counts[0])
        j, Ny, dNy, dy = spline(where[1], h, node_counts[1])

        v = vec2()
        B = mat22()
        gradient = mat22()
        for row in range(3):
            for column in range(3):
                node = (j + row) * node_counts[0] + i + column
                v_i = field_velocity[b, node]
                N = Nx[column] * Ny[row]
                d = vec2(dx[column], dy[row])
                v += N * v_i
                B += wp.outer(N * v_i, d)
                gradient += wp.outer(v_i, vec2(dNx[column] * Ny[row], Nx[column] * dNy[row]))
        stretching = half * (gradient + wp.transpose(gradient))
        gradient += time_step * (
            half * (wp.transpose(gradient) * gradient) - stretching * stretching
        )
        hoop = v[0] / x[0] if wp.static(axisymmetric) else zero
        L = vec5(gradient[0, 0], gradient[0, 1], gradient[1, 0], gradient[1, 1], hoop)

        motion = motion_of(L, time_step)
        strain = vec4(motion[0], motion[1], motion[2], motion[3])
        increment = elastic_increment(strain, body_moduli[b][0], body_moduli[b][1])
        particle_stress[p] = rotated(particle_stress[p], motion) + increment
        if wp.static(damped):
            viscous = (body_retardation_time[b] / time_step) * increment
            particle_viscous_stress[p] = viscous
            power = viscous[0] * L[0] + viscous[1] * L[3] + viscous[3] * L[4]
            power += viscous[2] * (L[1] + L[2])
            particle_dissipated[p] = particle_dissipated[p] + time_step * particle_volume[p] * power
        particle_volume[p] = particle_volume[p] * wp.exp(time_step * (L[0] + L[3] + L[4]))
        particle_velocity[p] = v
        particle_affine[p] = (four / (h * h)) * B
        particle_position[p] = x + time_step * v

    return grid_to_body
