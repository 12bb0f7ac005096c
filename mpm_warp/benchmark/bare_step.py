"""A run of bare steps: how fast a textbook's step of the method is on this machine."""

from __future__ import annotations

import math
import time

import numpy as np
import warp as wp

from mpm_warp.benchmark.bare_step_kernels import make_gather, make_nodes, make_scatter
from mpm_warp.precision import FLOAT64
from mpm_warp.materials.materials import VonMises

POINTS_PER_CELL = 4
RECORDED_STEPS = 16
MATERIAL = VonMises(shear_modulus=1.0, poissons_ratio=0.49, density=1.0, strength=0.01)
TIME_STEP = 1e-6
"""In times that a shear wave takes through a cell: so short that nothing moves."""


class BareStep:
    """Soil of random stresses in a square of cells, one thread of the processor, float64.

    Args:
        particle_count: material points, about.

    Attributes:
        particle_count: material points.
        arrays: by name; length of a cell, density and shear modulus are 1.
    """

    def __init__(self, particle_count: int) -> None:
        self._cell_count = max(1, round(math.sqrt(particle_count / POINTS_PER_CELL)))
        middles = 0.5 * np.arange(2 * self._cell_count) + 0.25
        z, r = (g.ravel() for g in np.meshgrid(middles, middles, indexing="ij"))
        count, node_count = len(r), (self._cell_count + 1) ** 2
        self.particle_count = count
        greatest = 2.0 * MATERIAL.strength
        stress = np.random.default_rng(0).uniform(-greatest, greatest, (count, 4))
        self.arrays = {
            "position": wp.array(np.stack([r, z], axis=-1), dtype=FLOAT64.vec2, device="cpu"),
            "velocity": wp.zeros(count, dtype=FLOAT64.vec2, device="cpu"),
            "affine": wp.zeros(count, dtype=FLOAT64.mat22, device="cpu"),
            "stress": wp.array(stress, dtype=FLOAT64.vec4, device="cpu"),
            "mass": wp.array(r / POINTS_PER_CELL, dtype=FLOAT64.real, device="cpu"),
            "volume": wp.array(r / POINTS_PER_CELL, dtype=FLOAT64.real, device="cpu"),
            "momentum": wp.zeros(node_count, dtype=FLOAT64.vec4, device="cpu"),
            "node_velocity": wp.zeros(node_count, dtype=FLOAT64.vec2, device="cpu"),
        }
        with wp.ScopedCapture(device="cpu") as capture:
            for _ in range(RECORDED_STEPS):
                self.take_step(TIME_STEP)
        self._graph = capture.graph

    def take_step(self, time_step: float) -> None:
        """Take a step of this length, in times that a shear wave takes through a cell."""
        position, velocity, affine, stress, mass, volume, momentum, node_velocity = (
            self.arrays.values()
        )
        grid = (1.0, self._cell_count, time_step)
        points = (position, velocity, affine, stress)
        lame = MATERIAL.bulk_modulus - 2.0 / 3.0 * MATERIAL.shear_modulus
        moduli = (lame, MATERIAL.shear_modulus, MATERIAL.strength)
        scatter = [*points, mass, volume, *grid, momentum]
        gather = [node_velocity, *grid, *moduli, *points, volume]
        wp.launch(make_scatter(), self.particle_count, scatter, device="cpu")
        wp.launch(make_nodes(), len(momentum), [momentum, node_velocity], device="cpu")
        wp.launch(make_gather(MATERIAL), self.particle_count, gather, device="cpu")

    def rate(self, seconds: float) -> float:
        """Updates of material points per second, over so long a time [s] at least."""
        start, steps = time.perf_counter(), 0
        while (taken := time.perf_counter() - start) < seconds:
            wp.capture_launch(self._graph)
            steps += RECORDED_STEPS
        return steps * self.particle_count / taken
