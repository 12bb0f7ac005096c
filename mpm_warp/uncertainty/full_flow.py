"""The error of the resistance of a ball or T-bar, measured by further runs of the case itself.

The case and four runs, which differ from it in one or two choices of the method, determine the
unknowns of

    N_simulated = N + M h^2 + S V^1.4 + C h^2 V^1.4 + W / E

with h the width of the cells at the body over its radius, V the speed over sqrt(su / rho), and E
the extent of the window over that of the case. The powers are between those observed
(`scenes/full_flow/README.md`). The error of the speed is larger with wider cells: hence C. At a
pole the first chord is the longest, which adds an error in proportion to h. It is a part of the
uncertainty.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.further_runs import TestRun
from mpm_warp.uncertainty.steadiness import STILL_TO_COME

FINER, SLOWER, WIDER = 1.5, 0.5, 1.5
"""Cells per radius, speed and extent of the window in further runs, over those of the case."""
DIFFERENCES = {
    "mesh": "smaller cells",
    "speed": "half the speed",
    "mesh_and_speed": "smaller cells and half the speed",
    "domain": "a wider window",
}
"""The effects of M h^2 and of the other terms, and what the run that measures each has."""
LEFT_OPEN = dict.fromkeys(DIFFERENCES, 0.5) | {"mesh": 1.0}
"""Half widths of the errors over what the best run still has of them. From 3 to 6 cells per radius
some bodies follow h^2, some come to rest at once."""
POWER_OF_SPEED = 1.4
POLES = 0.03
"""Half width of what the poles add, over N h: at a smooth bar, where they add most, it made N some
0.05 N h too high where the rows at the poles were as high as all others, twice as high as now."""
FEWEST_CELLS = 3
"""Cells per radius from which on the laws hold."""
LARGEST_GROWTH = 1.0
"""Growth of the cells up to which they hold: no further run has another. With 0.8 to 1.5 four bars
are within 0.8 of their half width of the limit load, with 2 of four bars three are 1.2 to 2.5 off:
the effects of growth and of the cells at the bar cancel as the cells get smaller."""
FEWEST_POINTS = 4
"""Material points per cell, the fewest that are allowed."""
POINTS, FEW_POINTS = 0.002, 0.012
"""Half widths of what more points change, over N: in general; of a bar with 4 of them in a cell."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FullFlowRun(TestRun):
    """A run of a ball or T-bar, as far as its error goes.

    It has recorded `resistance_factor`, `resistance_factor_change` and `empty_cells`.
    """

    name = "resistance_factor"
    description = "resistance over projected area and su, corrected for mesh, speed and window"
    differences = DIFFERENCES
    left_open = LEFT_OPEN

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
        """What is still to come in all runs, what more points change, and what the poles add."""
        changes = [float(run.recorded.resistance_factor_change) * run.factor for run in runs]
        to_come = STILL_TO_COME * np.array(changes)
        finest = math.ceil(FINER * self.cells_per_radius)
        return {
            "steadiness": float(np.linalg.norm(weights * to_come)),
            "points": (FEW_POINTS if self.has_few_points else POINTS) * self.factor,
            "poles": POLES / finest * self.factor,
        }

    def why_unsound(self, runs: Mapping[str, Self]) -> list[str]:
        """Where one leaves a hole behind the body."""
        leaves_hole = any(float(run.recorded.empty_cells) > 0.0 for run in runs.values())
        return ["hole: soil leaves one behind the body"] if leaves_hole else []


def check_measurable(cells_per_radius: int, cell_growth: float) -> None:
    """Raise `ParameterError` where cells are too wide for further runs to measure the error.

    Those at the body may be, or those away from it.
    """
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
