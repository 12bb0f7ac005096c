"""The stress of single material points along given strain paths, without a grid.

The same stress step, rotation and return to the yield surface as in a simulation. Symbols:
sigma stress, D rate of strain, R rotation in a step.

    sigma <- yield(R sigma R' + dt (K tr D + 2 G dev D))
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.materials.elasticity import make_elastic_trial, make_stress_step
from mpm_warp.precision import Precision


@functools.cache
def make_strain_path(yielding: Any, precision: Precision) -> Any:
    """The kernel, launched over paths.

    `excess` is the greatest (sigma_1 - sigma_3) / 2 over the strength on the way, less 1.

    Args:
        yielding: returns a trial stress to the yield surface.
        precision: floating point types.
    """
    real, vec4, vec5 = precision.real, precision.vec4, precision.vec5
    half, one = wp.constant(real(0.5)), wp.constant(real(1.0))
    step_of, elastic_trial = make_stress_step(precision), make_elastic_trial(precision)

    @wp.func
    def principal_difference(stress: vec4) -> real:
        centre = half * (stress[0] + stress[1])
        deviation = half * (stress[0] - stress[1])
        radius = wp.sqrt(deviation * deviation + stress[2] * stress[2])
        return wp.max(centre + radius, stress[3]) - wp.min(centre - radius, stress[3])

    key = f"{yielding.key}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.strain_path.{key}", enable_backward=False)
    def strain_path(
        gradient: wp.array(dtype=vec5),
        step_count: int,
        shear_modulus: real,
        bulk_modulus: real,
        strength: real,
        stress: wp.array(dtype=vec4),
        excess: wp.array(dtype=real),
    ):
        path = wp.tid()
        step = step_of(gradient[path], one / real(step_count), shear_modulus, bulk_modulus)
        sigma = stress[path]
        greatest = real(0.0)
        for _ in range(step_count):
            sigma = yielding(elastic_trial(sigma, step), strength)
            greatest = wp.max(greatest, principal_difference(sigma))
        stress[path] = sigma
        excess[path] = half * greatest / strength - one

    return strain_path
