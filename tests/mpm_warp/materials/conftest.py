"""Laws of materials on strain paths."""

import numpy as np
from numpy.typing import ArrayLike

from mpm_warp import Material, Simulation
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.material.strain_paths import StrainPaths


def points_on(
    gradients: ArrayLike, material: Material, steps: int, start: ArrayLike = (0, 0, 0, 0)
) -> Simulation:
    """Points on strain paths of a second each, in so many steps, all from one stress; not begun."""
    gradient = np.array(gradients, dtype=float)
    stress = np.tile(np.array(start, dtype=float), (len(gradient), 1))
    paths = StrainPaths(material=material, gradient=gradient, stress=stress, step_count=steps)
    return Simulation(paths)


def returned(material: Material, trial: Floats) -> Floats:
    """Stresses of a material from trial stresses, both of shape [n, 4]: a step without strain."""
    simulation = points_on(np.zeros((len(trial), 5)), material, 1)
    simulation.assign("particle.stress", trial)
    simulation.advance(1)
    return simulation.array("particle.stress").copy()
