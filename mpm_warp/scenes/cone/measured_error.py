"""The error of a cone factor, measured by further runs of the case itself.

The case and four runs, which differ from it in one choice of the method each, determine the
unknowns of

    Nc_simulated = Nc + B h + C g^1.5 h^1.3 + S i + W w

with h the width of the cells at the cone over its radius, g their growth, i = rho V^2 / su, and
w = (extent of the window of the case / extent)^2. These are the laws of `error_laws.py`, where
B, C and S are known from other cases. This is for cases whose error those do not give.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError
from mpm_warp.scenes import further_runs
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cone.error_laws import (
    LARGEST_CELL,
    LARGEST_INERTIA,
    growth_measure,
    why_not_linear,
)
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.stated_error import (
    APPROACH,
    NOISE,
    inertia,
    parts_of_a_run,
    stated_error,
    why_not_settled,
)
from mpm_warp.scenes.further_runs import Run
from mpm_warp.scenes.stated_value import further_values

FINER, GROWING, SLOWER, WIDER = 1.6, 2.0, 0.5, 1.4
"""Cells per radius, growth of the cells, speed and extents of the window in the further runs, over
those of the case."""
DIFFERENCES = {
    "face": "smaller cells",
    "growth": "more growth",
    "speed": "half the speed",
    "domain": "a wider window",
}
"""The effects of B h and of the other terms, and what the run that measures each has."""

FORM = 0.5
"""Half width of an error over what the best run still has of it: about what lies between a law and
one of the next order."""
LARGEST_CORRECTION = 0.12
"""Error that the laws, which are linear, may take off, over the cone factor. Friction of 0.2 needs
10 % and follows them to 12 cells per radius; a rough cone of 120 degrees would need 16 % and does
not."""

Test = TypeVar("Test", bound=ConeTest)


def further_tests(test: Test) -> dict[str, Test]:
    """The tests to be run beside that of the case, by the effect that each measures.

    Raises:
        ParameterError: one of them is outside the allowed range, or no law of the error holds.
    """
    for phrase, holds in why_not_linear(
        cell_size=test.relative_cell_size, inertia=inertia(test)
    ).items():
        if holds:
            raise ParameterError(
                "uncertainty",
                f"uncertainty = measured: {phrase}; cells at the cone must be <= "
                f"{LARGEST_CELL:g} of its radius, and rigidity_index speed_ratio^2 <= "
                f"{LARGEST_INERTIA:g}",
            )
    wider = {name: WIDER * getattr(test, name) for name in test.default_extents}
    # In a higher window the cone has more soil to pass.
    further = wider["domain_above"] - test.domain_above
    wider |= {"approach": test.approach + further, "penetration": test.penetration + further}
    changes: dict[str, dict[str, Any]] = {
        "face": {"cells_per_radius": FINER * test.cells_per_radius},
        "growth": {"cell_growth": GROWING * test.cell_growth},
        "speed": {"speed_ratio": SLOWER * test.speed_ratio},
        "domain": wider,
    }
    return further_runs.further_tests(replace(test, uncertainty="known"), changes, DIFFERENCES)


def with_measured_error(
    test: Test, run: Callable[[Test, Progress], xr.Dataset], progress: Progress
) -> xr.Dataset:
    """Run a case and its further tests.

    Args:
        test: the case.
        run: runs one test; its results have the curve `penetration_resistance`,
            `cone_factor_simulated`, `cone_factor_shear` and `penetration_reached`.
        progress: receives the fraction done of all.

    Returns:
        The results of the case with its measured error, and what the further runs took, in
        `run_time` and `particle_updates` too.
    """
    further = further_tests(test)
    alone = replace(test, uncertainty="known")
    case, made = further_runs.run_all(
        (test, *further.values()),
        updates=[_updates(it) for it in (alone, *further.values())],
        run=run,
        progress=progress,
    )
    runs = dict(zip(further, made, strict=True))
    results = case.results.drop_vars(
        [name for name in case.results if str(name).startswith("cone_factor_uncertainty")]
    )
    return further_runs.with_cost(results, made).assign(measured_error(case, runs))


def measured_error(case: Run[Test], further: Mapping[str, Run[Test] | str]) -> xr.Dataset:
    """The cone factor less its error, and its uncertainty, as measured by five runs.

    Args:
        case: the run whose error is measured.
        further: the runs of `further_tests`, or why there is none, by effect.

    Returns:
        What `stated_error` gives, and what each further run gave. Nothing is known of the error
        where one of the runs failed, or has not settled, or where the laws would have to take off
        more than `LARGEST_CORRECTION`.
    """
    runs = {"the case": case} | {
        f"the run with {DIFFERENCES[effect]}": run for effect, run in further.items()
    }
    not_known = "; ".join(
        f"{name}: {reason}" for name, run in runs.items() for reason in _faults(run)
    )
    parts = dict.fromkeys(DIFFERENCES, 0.0) | parts_of_a_run(case.test, case.results)
    correction = 0.0
    if not not_known:
        whole = [run for run in runs.values() if isinstance(run, Run)]
        found = further_runs.without_errors(
            [_factor(run) for run in whole], [_measures(run.test, case.test) for run in whole]
        )
        correction = found.value - _factor(case)
        if abs(correction) > LARGEST_CORRECTION * found.value:
            not_known = (
                f"its laws would take off {abs(correction) / found.value:.0%}, and hold up to "
                f"{LARGEST_CORRECTION:.0%}"
            )
        parts |= {choice: FORM * error for choice, error in found.left.items()}
        parts["speed"] += APPROACH * _factor(case)
        parts["noise"] = NOISE * float(np.linalg.norm(found.weights))
    stated = stated_error(
        case.test, case.results, correction=correction, parts=parts, not_known=not_known
    )
    factors = {
        effect: _factor(run) if isinstance(run, Run) else math.nan
        for effect, run in further.items()
    }
    return stated.assign(further_values("cone_factor", factors, DIFFERENCES))


def _factor(run: Run[Test]) -> float:
    return float(run.results.cone_factor_simulated)


def _measures(test: ConeTest, case: ConeTest) -> dict[str, float]:
    """h, g^1.5 h^1.3, i and w, which the errors are in proportion to."""
    size = test.relative_cell_size
    return {
        "face": size,
        "growth": growth_measure(size, test.cell_growth),
        "speed": inertia(test),
        "domain": (case.domain_radius / test.domain_radius) ** 2,
    }


def _updates(test: ConeTest) -> float:
    size = test.run_size()
    assert size is not None
    return size.particle_updates


def _faults(run: Run[Test] | str) -> list[str]:
    """Why a run cannot be used to measure an error."""
    if isinstance(run, str):
        return [run]
    phrases = why_not_settled(run.test, run.results)
    return [phrase for phrase, holds in phrases.items() if holds]
