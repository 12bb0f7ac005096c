"""The error of the resistance of a ball or T-bar, measured by further runs of the case itself.

The case and four runs, which differ from it in one or two choices of the method, determine the
unknowns of

    N_simulated = N + M h^2 + S V^1.4 + C h^2 V^1.4 + W / E

with h the width of the cells at the body over its radius, V the speed over sqrt(su / rho), and E
the extent of the window over that of the case. The powers are between those observed (README.md
of this folder). The error of the speed is larger with wider cells: hence C. At a pole the first
chord is the longest, which adds an error in proportion to h. It is a part of the uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError
from mpm_warp.scenes import further_runs
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.full_flow.penetrometer import FullFlowPenetrometer
from mpm_warp.scenes.further_runs import Run
from mpm_warp.scenes.stated_value import further_values, stated_value

FINER, SLOWER, WIDER = 1.5, 0.5, 1.5
"""Cells per radius, speed and extent of the window in further runs, over those of the case."""
DIFFERENCES = {
    "mesh": "smaller cells",
    "speed": "half the speed",
    "mesh_and_speed": "smaller cells and half the speed",
    "domain": "a wider window",
}
"""The effects of M h^2 and of the other terms, and what the run that measures each has."""
FORM = dict.fromkeys(DIFFERENCES, 0.5) | {"mesh": 1.0}
"""Half widths of the errors over what the best run still has of them. From 3 to 6 cells per radius
some bodies follow h^2, some come to rest at once."""
POWER_OF_SPEED = 1.4
POLES = 0.03
"""Half width of what the poles add, over N h: at a smooth bar, where they add most, it made N some
0.05 N h too high where the rows at the poles were as high as all others, twice as high as now."""
FEWEST_CELLS = 3
"""Cells per radius from which on the laws hold."""
FEWEST_POINTS = 4
"""Material points per cell, the fewest that are allowed."""
STILL_TO_GO = 1.5
"""Half width of what is to come, over the last change of the mean."""
POINTS, FEW_POINTS = 0.002, 0.012
"""Half widths of what more points change, over N: in general; of a bar with 4 of them in a cell."""

Test = TypeVar("Test", bound=FullFlowPenetrometer)


def further_tests(test: Test) -> dict[str, Test]:
    """The tests to be run beside that of the case, by the choice whose error each measures.

    Args:
        test: the case, its uncertainty not to be measured.

    Raises:
        ParameterError: one of them is outside the allowed range, or the cells are too wide.
    """
    if test.cells_per_radius < FEWEST_CELLS:
        raise ParameterError(
            "cells_per_radius",
            f"cells_per_radius = {test.cells_per_radius} must be >= {FEWEST_CELLS} where "
            "uncertainty = measured",
        )
    finer = {"cells_per_radius": math.ceil(FINER * test.cells_per_radius)}
    slower = {"speed_ratio": SLOWER * test.speed_ratio}
    changes: dict[str, dict[str, Any]] = {
        "mesh": finer,
        "speed": slower,
        "mesh_and_speed": finer | slower,
        "domain": {"domain_extent": math.ceil(WIDER * test.domain_extent)},
    }
    return further_runs.further_tests(test, changes, DIFFERENCES)


def with_measured_error(
    test: Test, run: Callable[[Test, Progress], xr.Dataset], progress: Progress
) -> xr.Dataset:
    """Run a case and its further tests.

    Args:
        test: the case, its uncertainty not to be measured.
        run: runs one test; its results have `resistance_factor`, `resistance_factor_change` and
            `empty_cells`.
        progress: receives the fraction done of all.

    Returns:
        The results of the case with `resistance_factor` less its error, its correction, its
        uncertainty and the parts of it; what each further run gave, and what all of them took, in
        `run_time` and `particle_updates` too. Where a further run failed nothing is known of the
        error, nor where one leaves a hole behind the body.
    """
    further = further_tests(test)
    tests = (test, *further.values())
    case, made = further_runs.run_all(
        tests, updates=[it.run_size().particle_updates for it in tests], run=run, progress=progress
    )
    simulated = _factor(case)
    reasons = [
        f"the run with {DIFFERENCES[choice]}: {it}"
        for choice, it in zip(further, made, strict=True)
        if isinstance(it, str)
    ]
    runs = [case, *(it for it in made if isinstance(it, Run))]
    if any(float(it.results.empty_cells) > 0.0 for it in runs):
        reasons.append("soil leaves a hole behind the body")
    correction = 0.0
    few = test.body.planar and test.particles_per_cell == FEWEST_POINTS
    parts = dict.fromkeys(DIFFERENCES, 0.0) | {
        "steadiness": 0.0,
        "points": (FEW_POINTS if few else POINTS) * simulated,
        "poles": POLES / max(it.cells_per_radius for it in tests) * simulated,
    }
    if not reasons:
        found = further_runs.without_errors(
            [_factor(it) for it in runs], [_measures(it.test, test) for it in runs]
        )
        correction = found.value - simulated
        parts |= {choice: FORM[choice] * error for choice, error in found.left.items()}
        to_come = STILL_TO_GO * np.array([_change(it) for it in runs])
        parts["steadiness"] = float(np.linalg.norm(found.weights * to_come))
    values = {
        choice: _factor(it) if isinstance(it, Run) else math.nan
        for choice, it in zip(further, made, strict=True)
    }
    return further_runs.with_cost(case.results, made).assign(
        stated_value(
            "resistance_factor",
            simulated,
            correction=correction,
            parts=parts,
            not_known="; ".join(reasons),
            description="resistance over projected area and su, corrected for mesh, speed and "
            "window",
        )
        | further_values("resistance_factor", values, DIFFERENCES)
    )


def _factor(run: Run[Test]) -> float:
    return float(run.results.resistance_factor)


def _change(run: Run[Test]) -> float:
    """Of the resistance factor over its last two radii."""
    return float(run.results.resistance_factor_change) * _factor(run)


def _measures(test: FullFlowPenetrometer, case: FullFlowPenetrometer) -> dict[str, float]:
    """h^2, V^1.4, their product, and 1 / E, which the errors are in proportion to."""
    mesh = 1.0 / test.cells_per_radius**2
    speed = math.pow(test.speed_ratio * math.sqrt(test.rigidity_index), POWER_OF_SPEED)
    return {
        "mesh": mesh,
        "speed": speed,
        "mesh_and_speed": mesh * speed,
        "domain": case.domain_extent / test.domain_extent,
    }
