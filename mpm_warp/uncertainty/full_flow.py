"""The error of the resistance of a ball or T-bar, measured by further runs of the case itself.

The case and four further runs, each with one or two choices of the method changed, determine the
unknowns of

    N_simulated = N + M h^2 + S V^1.4 + C h^2 V^1.4 + W / E

with h the width of the cells at the body over its radius, V the speed over sqrt(su / rho), and E
the extent of the window over that of the case. The powers are between those observed
(`measured/full_flow_effects.csv`). The term with C is there because the error of the speed is
larger with wider cells. At a pole of the body the first chord is the longest. This adds an error in
proportion to h, which is a part of the uncertainty.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.further_runs import TestRun
from mpm_warp.uncertainty.steadiness import REMAINING_CHANGE
from mpm_warp.uncertainty.tables import effects

FINER, SLOWER, WIDER = 1.5, 0.5, 1.5
"""Cells per radius, speed and extent of the window in further runs, over those of the case."""
DIFFERENCES = {
    "mesh": "smaller cells",
    "speed": "half the speed",
    "mesh_and_speed": "smaller cells and half the speed",
    "domain": "a wider window",
}
"""The effects, M h^2 and the other terms, and what is different in the run that measures each."""
REMEDIES = {
    "mesh": "more cells_per_radius",
    "speed": "a lower speed_ratio",
    "mesh_and_speed": "more cells_per_radius, or a lower speed_ratio",
    "domain": "a larger domain_extent",
    "steadiness": "more penetration",
    "points": "more particles_per_cell",
    "poles": "more cells_per_radius",
}
"""What makes each part of U smaller."""
RESIDUAL_SHARES = dict.fromkeys(DIFFERENCES, 0.5) | {"mesh": 1.0}
"""Half width of each error, over the error that is left in the best run. From 3 to 6 cells per
radius some bodies follow h^2, others reach their limit at once."""
POWER_OF_SPEED = 1.4
EFFECTS = effects("full_flow_effects")
FEWEST_CELLS = 3
"""Fewest cells per radius for which the laws hold."""
LARGEST_GROWTH = 1.0
"""Largest growth of the cells for which the laws hold; no further run changes it. At 0.8 to 1.5
four bars are within 0.8 half widths of the limit load. At 2 three of four bars are 1.2 to 2.5 half
widths off: the effects of growth and of the cells at the bar cancel as the cells get smaller."""
FEWEST_POINTS = 4
"""Fewest material points per cell that are allowed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FullFlowRun(TestRun):
    """What the error of a run of a ball or T-bar depends on.

    `recorded` holds `resistance_factor`, `resistance_factor_change` and `empty_cells`.
    """

    name = "resistance_factor"
    description = "resistance over projected area and su, corrected for mesh, speed and window"
    differences = DIFFERENCES
    residual_shares = RESIDUAL_SHARES
    remedies = REMEDIES

    cells_per_radius: int  # of the body
    relative_speed: float  # over sqrt(su / rho)
    extent: float  # of the window, over the radius
    has_few_points: bool  # whether it is a bar with the fewest points that are allowed

    @property
    def factor(self) -> float:
        """The resistance factor as simulated."""
        return float(self.recorded.resistance_factor)

    def measures(self, case: Self) -> dict[str, float]:
        """h^2, V^1.4, their product, and 1 / E."""
        mesh = 1.0 / self.cells_per_radius**2
        speed = math.pow(self.relative_speed, POWER_OF_SPEED)
        return {
            "mesh": mesh,
            "speed": speed,
            "mesh_and_speed": mesh * speed,
            "domain": case.extent / self.extent,
        }

    def own_parts(self, weights: Floats, runs: Sequence[Self]) -> dict[str, float]:
        """Steadiness of all runs, number of points, and error at the poles."""
        changes = [float(run.recorded.resistance_factor_change) * run.factor for run in runs]
        remaining = REMAINING_CHANGE * np.array(changes)
        finest = math.ceil(FINER * self.cells_per_radius)
        points = "few_points" if self.has_few_points else "points"
        return {
            "steadiness": float(np.linalg.norm(weights * remaining)),
            "points": EFFECTS[points].half_width * self.factor,
            "poles": EFFECTS["poles"].half_width / finest * self.factor,
        }

    def why_unsound(self, runs: Mapping[str, Self]) -> list[str]:
        """Whether a run leaves a hole behind the body."""
        leaves_hole = any(float(run.recorded.empty_cells) > 0.0 for run in runs.values())
        return ["hole: soil leaves one behind the body"] if leaves_hole else []


def check_measurable(cells_per_radius: int, cell_growth: float) -> None:
    """Raise `ParameterError` where cells, at the body or away, are too wide for further runs."""
    if cell_growth > LARGEST_GROWTH:
        raise ParameterError(
            "cell_growth",
            f"cell_growth = {cell_growth:g} must be <= {LARGEST_GROWTH:g} where "
            "uncertainty = measured",
        )
    if cells_per_radius < FEWEST_CELLS:
        raise ParameterError(
            "cells_per_radius",
            f"cells_per_radius = {cells_per_radius} must be >= {FEWEST_CELLS} where "
            "uncertainty = measured",
        )
