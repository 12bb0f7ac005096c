"""A sounding of next to no cost."""

import dataclasses

import numpy as np

from mpm_warp import Scene, Simulation
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.sounding.sounding import Sounding
from tests.mpm_warp.conftest import SMALL_WINDOW

COARSE = Sounding(
    cone_radius=1.0,
    from_depth=12.0,
    to_depth=15.0,
    cells_per_radius=1.5,
    adhesion_factor=0.5,
    speed_ratio=0.2,
    **{**SMALL_WINDOW, "domain_below": 4},
)


def changed(**changes: object) -> Sounding:
    """A sounding in a small window, coarse and fast, with other parameters.

    What it gives is a curve, but no good cone factor.
    """
    return dataclasses.replace(COARSE, **changes)


def after_a_step(scene: Scene, stress: float) -> tuple[Simulation, Floats, float]:
    """A run of one step, and the speeds of its nodes, shape [rows + 1, columns + 1, 2].

    And the speed that a stress [Pa] would give to a node that nothing holds.
    """
    simulation = Simulation(scene)
    simulation.advance(1)
    shape = (scene.grid.row_count + 1, scene.grid.column_count + 1, 4)
    speeds = np.abs(simulation.array("node.velocities")).reshape(shape)[..., :2]
    density, height = scene.material.density, np.diff(scene.grid.rows).min()
    return simulation, speeds, float(simulation.plan.time_step * stress / (density * height))
