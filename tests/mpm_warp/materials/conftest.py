"""Laws of materials: on strain paths, and through kernels that do nothing but call them."""

import functools
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import ArrayLike

from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import kernel, zero
from mpm_warp.materials.material import Law, Material
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.simulation import Simulation


def points_on(
    gradients: ArrayLike, material: Material, steps: int, start: ArrayLike = (0, 0, 0, 0)
) -> Simulation:
    """Points on strain paths of a second each, in so many steps, all from one stress; not begun."""
    gradient = np.array(gradients, dtype=float)
    stress = np.tile(np.array(start, dtype=float), (len(gradient), 1))
    paths = StrainPaths(material=material, gradient=gradient, stress=stress, step_count=steps)
    return Simulation(paths)


@functools.cache
def make_apply_law(law: Law) -> Any:
    """The kernel that updates every trial stress, and measures what has come of it."""

    @kernel
    def apply_law(
        properties: law.properties_type,  # type: ignore[name-defined]
        stress: wp.array(dtype=wp.vec4d),
        measured: wp.array(dtype=wp.vec2d),
    ):
        k = wp.tid()
        if wp.static(law.yield_function is not None):
            measured[k] = law.yield_function(stress[k], properties, law.state_type())
        # Without strain the trial stress is the stress.
        updated, _ = law.update(stress[k], wp.vec4d(), zero, properties, law.state_type())
        stress[k] = updated

    return apply_law


def _apply(material: Material, stress: Floats) -> tuple[Floats, Floats]:
    law = material.law()
    on_device = wp.array(stress, dtype=wp.vec4d, device="cpu")
    measured = wp.zeros(len(stress), dtype=wp.vec2d, device="cpu")
    arguments = [law.properties_type(*material.properties), on_device, measured]
    wp.launch(make_apply_law(law), len(stress), arguments, device="cpu")
    return on_device.numpy(), measured.numpy()


def returned(material: Material, trial: Floats) -> Floats:
    """Stresses of a material without memory from trial stresses, both of shape [n, 4]."""
    return _apply(material, np.array(trial))[0]


def yield_measures(material: Material, stress: Floats) -> Floats:
    """Measure and strength (f, k) of a material [n, 2] at stresses [n, 4]."""
    return _apply(material, np.array(stress))[1]
