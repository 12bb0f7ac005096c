"""Laws of materials on strain paths."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mpm_warp import Material, ModifiedCamClay, Simulation
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.material.strain_paths import StrainPaths

STRESS, LAMBDA, KAPPA, V = 50e3, 0.2, 0.04, 2.0
"""The defaults of p0', lambda, kappa and v of modified Cam clay."""
SHARE = 1.0 - KAPPA / LAMBDA


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


def cam_clay(ratio: float = 1.0, **changed: Any) -> ModifiedCamClay:
    given = {"density": 1700.0, "poissons_ratio": 0.49} | changed
    return ModifiedCamClay(isotropic_overconsolidation_ratio=ratio, **given)
