"""How near to yield each material point is: what a picture of the yielding zone asks of soil."""

import functools
from typing import Any

import warp as wp

from mpm_warp.materials.material import (
    Law,
    Material,
    make_properties_of_point,
    make_state_of_point,
)
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


def add_yield_share(plan: Plan, material: Material) -> None:
    """Add the launch "yield_share", ordered between steps; none where the material never yields.

    It leaves in `yield.share` the shear stress of each slot over the shear strength, as the
    material's own criterion measures them: 1 where it yields.
    """
    law = material.law(plan.precision)
    if law.yield_function is None:
        return
    (count,) = plan.arrays["particle.mass"].shape
    plan.add_zeros("yield.share", "real", count)
    plan.between_steps["yield_share"] = plan.launch(
        _make_yield_share(law, plan.precision),
        count,
        particle_state=plan.find("particle.state"),
        properties=material.launch_properties(law),
    )


@functools.cache
def _make_yield_share(law: Law, precision: Precision) -> Any:
    """The kernel, launched over slots of particles; an empty slot gives what its stress gives."""
    real, vec4 = precision.real, precision.vec4
    properties_argument, state_type = law.properties_argument, law.state_type
    properties_of_point, state_of_point = make_properties_of_point(law), make_state_of_point(law)
    yield_function: Any = law.yield_function

    @wp.kernel(
        module=f"mpm_warp.yield_share.{law.key}.{precision.numpy_name}", enable_backward=False
    )
    def yield_share(
        particle_stress: wp.array(dtype=vec4),
        particle_state: wp.array(dtype=state_type),
        properties: properties_argument,
        yield_share: wp.array(dtype=real),
    ):
        p = wp.tid()
        remembered = state_of_point(particle_state, p)
        own = properties_of_point(properties, p)
        measured = yield_function(particle_stress[p], own, remembered)
        yield_share[p] = measured[0] / measured[1]

    return yield_share
