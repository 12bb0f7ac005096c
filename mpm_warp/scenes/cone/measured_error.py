"""The error of a cone factor, measured by further runs of the case itself.

The case and four runs, which differ from it in one choice of the method each, determine the
unknowns of

    Nc_simulated = Nc + B h + C g^1.5 h^1.3 + S i + W w

with h the width of the cells at the cone over its radius, g their growth, i = rho V^2 / su, and
w = (extent of the window of the case / extent)^2. These are the laws of `known_error.py`, where
other cases tell B, C and S. This is for cases that those say nothing of.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from mpm_warp.errors import InaccurateRun, ParameterError, SimulationDiverged, UnfinishedRun
from mpm_warp.results import labelled, variable
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.stated_error import (
    NOISE,
    growth_measure,
    inertia,
    parts_of_a_run,
    stated_error,
    why_no_law_holds,
)

FINER, GROWING, SLOWER, WIDER = 1.6, 2.0, 0.5, 1.4
"""Cells per radius, growth of the cells, speed and extents of the window in the further runs, over
those of the case."""
EFFECTS = {
    "face": "smaller cells",
    "growth": "more growth",
    "speed": "half the speed",
    "domain": "a wider window",
}
"""What B h and the other terms are of, in their order, and the further run that tells each."""
FORM = 0.5
"""Half width of an effect over what the best run still has of it: about what lies between a law and
one of the next order."""
APPROACH = 0.001
"""Half width of what the approach leaves, over Nc."""

Test = TypeVar("Test", bound=ConeTest)


@dataclass(frozen=True)
class Run:
    """A run by which the error of a case is measured.

    Attributes:
        test: what was run.
        cell_size: width of its cells at the cone over the radius, dimensionless.
        results: what came out.
    """

    test: ConeTest
    cell_size: float
    results: xr.Dataset

    @property
    def factor(self) -> float:
        """The cone factor as simulated."""
        return float(self.results.cone_factor_simulated)

    def measures(self, case: ConeTest) -> tuple[float, ...]:
        """h, g^1.5 h^1.3, i and w, which the `EFFECTS` are in proportion to."""
        assert self.test.domain_radius is not None
        assert case.domain_radius is not None
        return (
            self.cell_size,
            growth_measure(self.cell_size, self.test.cell_growth),
            inertia(self.test),
            (case.domain_radius / self.test.domain_radius) ** 2,
        )


def further_tests(test: Test) -> dict[str, Test]:
    """The tests to be run beside that of the case, by the effect that each tells.

    Raises:
        ParameterError: one of them is outside the allowed range.
    """
    assert test.cells_per_radius is not None
    assert test.speed_ratio is not None
    assert test.domain_above is not None
    assert test.approach is not None
    assert test.penetration is not None
    alone = replace(test, uncertainty="known")
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
    tests = {}
    for effect, changed in changes.items():
        try:
            tests[effect] = replace(alone, **changed)
        except ParameterError as error:
            raise ParameterError(
                error.key,
                f"uncertainty = measured needs a run with {EFFECTS[effect]}, where {error}",
            ) from error
    return tests


def with_measured_error(
    test: Test, run: Callable[[Test, Progress], Run], progress: Progress
) -> xr.Dataset:
    """Run a case and its further tests.

    Args:
        test: the case.
        run: runs one test.
        progress: is told the fraction done of all.

    Returns:
        The results of the case with its measured error, and what the further runs took, in
        `run_time` and `particle_updates` too.
    """
    further = further_tests(test)
    case_alone = replace(test, uncertainty="known")
    updates = [_updates(it) for it in (case_alone, *further.values())]
    done = np.cumsum([0.0, *updates]) / sum(updates)

    def part(number: int) -> Progress:
        begin, end = done[number : number + 2]
        return lambda fraction: progress(float(begin + fraction * (end - begin)))

    case = run(test, part(0))
    runs: dict[str, Run | str] = {}
    for number, (effect, it) in enumerate(further.items(), start=1):
        try:
            runs[effect] = run(it, part(number))
        except (SimulationDiverged, InaccurateRun, UnfinishedRun) as error:
            runs[effect] = str(error)
    made = [it.results for it in runs.values() if isinstance(it, Run)]
    took = sum(float(it.run_time) for it in made)
    results = case.results.drop_vars(
        [name for name in case.results if str(name).startswith("cone_factor_uncertainty")]
    )
    for name in ("run_time", "particle_updates"):
        whole = float(results[name]) + sum(float(it[name]) for it in made)
        results[name] = results[name].copy(data=whole)
    return results.assign(measured_error(case, runs)).assign(
        labelled(
            role="measured",
            uncertainty_run_time=(took, "s", "run time of the runs that tell the uncertainty"),
        )
    )


def measured_error(case: Run, further: Mapping[str, Run | str]) -> xr.Dataset:
    """The cone factor less its error, and its uncertainty, as five runs tell them.

    Args:
        case: the run whose error is measured; its results have the curve `penetration_resistance`,
            `cone_factor_simulated`, `cone_factor_shear` and `penetration_reached`.
        further: the runs of `further_tests`, or why there is none, by the effect that each tells.

    Returns:
        What `stated_error` gives, and what each further run gave. Nothing is known of the error
        where one of the runs failed, or where the laws do not hold.
    """
    runs = {"the case": case} | {f"the run with {EFFECTS[it]}": run for it, run in further.items()}
    not_known = "; ".join(
        f"{name}: {reason}" for name, run in runs.items() for reason in _faults(run)
    )
    parts = dict.fromkeys(EFFECTS, 0.0) | parts_of_a_run(case.test, case.results)
    correction = 0.0
    if not not_known:
        whole = [run for run in runs.values() if isinstance(run, Run)]
        measures = np.array([(1.0, *run.measures(case.test)) for run in whole])
        inverse = np.linalg.inv(measures)
        factor, *slopes = inverse @ [run.factor for run in whole]
        correction = float(factor) - case.factor
        least = measures[:, 1:].min(axis=0)
        parts |= dict(zip(EFFECTS, (FORM * np.abs(slopes) * least).tolist(), strict=True))
        parts["speed"] += APPROACH * case.factor
        # Each run has its noise; the first row tells what comes of it in Nc.
        parts["noise"] = NOISE * float(np.linalg.norm(inverse[0]))
    stated = stated_error(
        case.test, case.results, correction=correction, parts=parts, not_known=not_known
    )
    return stated.assign(
        {
            f"cone_factor_further_{effect}": variable(
                run.factor if isinstance(run, Run) else math.nan,
                unit="1",
                meaning=f"cone factor as simulated with {EFFECTS[effect]}",
            )
            for effect, run in further.items()
        }
    )


def _updates(test: ConeTest) -> float:
    size = test.run_size()
    assert size is not None
    return size.particle_updates


def _faults(run: Run | str) -> list[str]:
    """Why a run says nothing of an error."""
    if isinstance(run, str):
        return [run]
    phrases = why_no_law_holds(run.test, run.cell_size, run.results)
    return [phrase for phrase, holds in phrases.items() if holds]
