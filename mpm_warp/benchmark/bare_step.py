"""A bare step of the method, as in a textbook: the speed that a run is compared with.

It leaves out all that a scene adds. Each material point has an affine velocity and a stress of its
own, on a grid of square cells with four nodes each, in axisymmetry (affine transfers: Jiang et al.
2015, ACM Trans. Graph. 34(4):51). The soil yields by von Mises.

Symbols: xi, eta natural coordinates in the cell, N shape function of a node, dN its gradient, d
vector from the material point to the node; m mass, v velocity, C its gradient before the step and L
after it, s stress (rr, zz, rz, tt), q momentum, h cell size.
"""

import math
import time
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.materials.von_mises import VonMises
from mpm_warp.precision import FLOAT64

POINTS_PER_CELL = 4
RECORDED_STEPS = 16
MATERIAL = VonMises(shear_modulus=1.0, poissons_ratio=0.49, density=1.0, strength=0.01)
TIME_STEP = 1e-6
"""Time step over the time that a shear wave takes through a cell: so short that nothing moves."""

real, vec2, vec3, vec4 = FLOAT64.real, FLOAT64.vec2, FLOAT64.vec3, FLOAT64.vec4
mat22 = FLOAT64.mat22
ONE = wp.constant(real(1.0))
vec1 = FLOAT64.vector(1)
return_to_yield_surface = MATERIAL.law(FLOAT64).update


class BareStep:
    """Soil with random stresses in a square of cells, on one thread of the processor, in float64.

    The length of a cell, the density and the shear modulus are 1.

    Args:
        particle_count: number of material points, about.

    Attributes:
        particle_count: number of material points.
        arrays: the arrays on the device, by name.
    """

    def __init__(self, particle_count: int) -> None:
        self._cell_count = max(1, round(math.sqrt(particle_count / POINTS_PER_CELL)))
        middles = 0.5 * np.arange(2 * self._cell_count) + 0.25
        z, r = (g.ravel() for g in np.meshgrid(middles, middles, indexing="ij"))
        count, node_count = len(r), (self._cell_count + 1) ** 2
        self.particle_count = count
        greatest = 2.0 * MATERIAL.strength
        stress = np.random.default_rng(0).uniform(-greatest, greatest, (count, 4))
        self.arrays: dict[str, Any] = {
            "position": wp.array(np.stack([r, z], axis=-1), dtype=vec2, device="cpu"),
            "velocity": wp.zeros(count, dtype=vec2, device="cpu"),
            "affine": wp.zeros(count, dtype=mat22, device="cpu"),
            "stress": wp.array(stress, dtype=vec4, device="cpu"),
            "mass": wp.array(r / POINTS_PER_CELL, dtype=real, device="cpu"),
            "volume": wp.array(r / POINTS_PER_CELL, dtype=real, device="cpu"),
            "momentum": wp.zeros(node_count, dtype=vec4, device="cpu"),
            "node_velocity": wp.zeros(node_count, dtype=vec2, device="cpu"),
        }
        with wp.ScopedCapture(device="cpu") as capture:
            for _ in range(RECORDED_STEPS):
                self.take_step(TIME_STEP)
        self._graph = capture.graph

    def take_step(self, time_step: float) -> None:
        """Take a step; its length is over the time that a shear wave takes through a cell."""
        position, velocity, affine, stress, mass, volume, momentum, node_velocity = (
            self.arrays.values()
        )
        grid = (1.0, self._cell_count, time_step)
        points = (position, velocity, affine, stress)
        lame = MATERIAL.bulk_modulus - 2.0 / 3.0 * MATERIAL.shear_modulus
        moduli = (lame, MATERIAL.shear_modulus, MATERIAL.strength)
        scatter = [*points, mass, volume, *grid, momentum]
        gather = [node_velocity, *grid, *moduli, *points, volume]
        wp.launch(bare_scatter, self.particle_count, scatter, device="cpu")
        wp.launch(bare_nodes, len(momentum), [momentum, node_velocity], device="cpu")
        wp.launch(bare_gather, self.particle_count, gather, device="cpu")

    def rate(self, seconds: float) -> float:
        """Particle updates per second, measured over at least so long a time [s]."""
        start, steps = time.perf_counter(), 0
        while (taken := time.perf_counter() - start) < seconds:
            wp.capture_launch(self._graph)
            steps += RECORDED_STEPS
        return steps * self.particle_count / taken


@wp.func
def cell_at(position: vec2, cell_count: int) -> wp.vec2i:
    """Column and row of the cell at a position in cell sizes; outside, of the nearest cell."""
    last = cell_count - 1
    return wp.vec2i(wp.clamp(int(position[0]), 0, last), wp.clamp(int(position[1]), 0, last))


@wp.func
def shape(a: int, b: int, xi: real, eta: real) -> vec3:
    """N and h dN of the node in column a and row b of a cell's four nodes, each 0 or 1."""
    along_r, along_z = wp.where(a == 0, ONE - xi, xi), wp.where(b == 0, ONE - eta, eta)
    return vec3(along_r * along_z, real(2 * a - 1) * along_z, real(2 * b - 1) * along_r)


@wp.kernel(module="mpm_warp.bare_scatter", enable_backward=False)
def bare_scatter(
    position: wp.array[vec2],
    velocity: wp.array[vec2],
    affine: wp.array[mat22],
    stress: wp.array[vec4],
    mass: wp.array[real],
    volume: wp.array[real],
    h: real,
    cell_count: int,
    time_step: real,
    momentum: wp.array[vec4],
):
    """Add up mass and momentum at the end of the step at the nodes; over material points."""
    p = wp.tid()
    x = position[p]
    in_cells = x / h
    cell = cell_at(in_cells, cell_count)
    xi, eta = in_cells[0] - real(cell[0]), in_cells[1] - real(cell[1])
    first = cell[1] * (cell_count + 1) + cell[0]
    m, v, C, s = mass[p], velocity[p], affine[p], stress[p]
    pull = time_step * volume[p]
    hoop = s[3] / x[0]
    for b in range(2):
        for a in range(2):
            shapes = shape(a, b, xi, eta)
            N, dN = shapes[0], vec2(shapes[1], shapes[2]) / h
            d = h * vec2(wp.where(a == 0, -xi, ONE - xi), wp.where(b == 0, -eta, ONE - eta))
            force = vec2(s[0] * dN[0] + s[2] * dN[1] + hoop * N, s[2] * dN[0] + s[1] * dN[1])
            q = (m * N) * (v + C * d) - pull * force
            momentum[first + b * (cell_count + 1) + a] += vec4(m * N, q[0], q[1], real(0.0))


@wp.kernel(module="mpm_warp.bare_nodes", enable_backward=False)
def bare_nodes(momentum: wp.array[vec4], node_velocity: wp.array[vec2]):
    """Work out the velocity of the nodes and clear their sums; over nodes."""
    k = wp.tid()
    sums = momentum[k]
    if sums[0] > real(0.0):
        node_velocity[k] = vec2(sums[1], sums[2]) / sums[0]
    momentum[k] = vec4()


@wp.kernel(module="mpm_warp.bare_gather", enable_backward=False)
def bare_gather(
    node_velocity: wp.array[vec2],
    h: real,
    cell_count: int,
    time_step: real,
    lame: real,
    shear: real,
    strength: real,
    position: wp.array[vec2],
    velocity: wp.array[vec2],
    affine: wp.array[mat22],
    stress: wp.array[vec4],
    volume: wp.array[real],
):
    """Velocity, its gradient, stress, volume and position after the step; over material points."""
    p = wp.tid()
    x = position[p]
    in_cells = x / h
    cell = cell_at(in_cells, cell_count)
    xi, eta = in_cells[0] - real(cell[0]), in_cells[1] - real(cell[1])
    first = cell[1] * (cell_count + 1) + cell[0]
    v, L = vec2(), mat22()
    for b in range(2):
        for a in range(2):
            shapes = shape(a, b, xi, eta)
            u = node_velocity[first + b * (cell_count + 1) + a]
            v += shapes[0] * u
            L += wp.outer(u, vec2(shapes[1], shapes[2]) / h)
    rr, zz, tt = time_step * L[0, 0], time_step * L[1, 1], time_step * v[0] / x[0]
    rz = time_step * real(0.5) * (L[0, 1] + L[1, 0])
    strain = vec4(rr, zz, rz, tt)
    volumetric = rr + zz + tt
    isotropic = lame * volumetric * vec4(ONE, ONE, real(0.0), ONE)
    trial = stress[p] + isotropic + real(2.0) * shear * strain
    returned, _ = return_to_yield_surface(trial, strain, time_step, vec1(strength), vec1())
    stress[p] = returned
    volume[p] *= ONE + volumetric
    velocity[p] = v
    affine[p] = L
    position[p] = x + time_step * v
