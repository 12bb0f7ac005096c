"""The watch's check that no point has a stress outside its yield surface."""

import functools
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.kernel_types import kernel, maybe, one, real, vec4
from mpm_warp.materials.material import Law, Material
from mpm_warp.plan.plan import Plan

YIELD_ROUNDINGS = 64
"""Allowed distance outside the yield surface, over the rounding of the largest stress."""
BLOCK = 256
"""Number of particles in a block, which one thread checks."""


def add_yield_check(plan: Plan, material: Material) -> None:
    """Add the launch "yield_check" of the watch; none where the material never yields.

    For the worst particle of each block `yield.particle` has its number, and `yield.margin` its
    distance outside the yield surface, less the rounding allowed, over its strength.
    """
    law = material.law()
    if law.yield_function is None:
        return
    (count,) = plan.arrays["particle.mass"].shape
    blocks = -(-count // BLOCK)
    plan.add_zeros("yield.margin", "real", blocks)
    plan.add_zeros("yield.particle", "int", blocks)
    plan.between_steps["yield_check"] = plan.launch(_make_yield_check(law), blocks, count=count)


@functools.cache
def _make_yield_check(law: Law) -> Any:
    roundings = wp.constant(real(YIELD_ROUNDINGS * np.finfo(float).eps))

    @kernel
    def yield_check(
        count: int,
        particle_cell: wp.array[wp.vec2i],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        properties: law.properties_argument,
        yield_margin: wp.array[real],
        yield_particle: wp.array[int],
    ):
        block = wp.tid()
        first = block * wp.static(BLOCK)
        greatest_margin = real(-1e30)
        number = first
        for p in range(first, wp.min(first + wp.static(BLOCK), count)):
            if particle_cell[p][0] >= 0:
                s = particle_stress[p]
                own, remembered = law.of_point(properties, particle_state, p)
                measured = law.yield_function(s, own, remembered)
                f, k = measured[0], measured[1]
                greatest = wp.max(wp.abs(s))
                beyond = f / k - one - roundings * (one + greatest / k)
                # A comparison with NaN is false, so NaN stays the worst.
                if beyond > greatest_margin or wp.isnan(beyond):
                    greatest_margin = beyond
                    number = p
        yield_margin[block] = greatest_margin
        yield_particle[block] = number

    return yield_check
