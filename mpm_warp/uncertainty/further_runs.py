"""The error of a result, measured by further runs of the case itself.

Each further run differs from the case in one choice of the method. A law says what the error of
this choice is in proportion to, its measure m. The case and as many further runs as there are
choices then determine the value v without these errors, and the slopes s:

    simulated value = v + s_1 m_1 + s_2 m_2 + ...
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import xarray as xr

from mpm_warp.errors import InaccurateRun, ParameterError, SimulationDiverged, UnfinishedRun
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled

Progress = Callable[[float], None]
"""Is called now and then with the fraction done, 0 to 1."""


class Size(Protocol):
    """How large a run is."""

    @property
    def particle_updates(self) -> float:
        """Material points times steps."""


class Sized(Protocol):
    """A test: a frozen dataclass of parameters whose run has a size."""

    def run_size(self) -> Size:
        """Of its run."""


Test = TypeVar("Test", bound=Sized)


@dataclass(frozen=True)
class Run(Generic[Test]):
    """A run of a test, and what came out."""

    test: Test
    results: xr.Dataset


@dataclass(frozen=True)
class WithoutErrors:
    """A value less the errors that follow from the laws.

    Attributes:
        value: v.
        left: size of the error that the best run still has, by choice.
        weights: what each simulated value counts for in v, shape [runs].
    """

    value: float
    left: dict[str, float]
    weights: Floats


def further_tests(
    test: Test, changes: Mapping[str, Mapping[str, Any]], differences: Mapping[str, str]
) -> dict[str, Test]:
    """The tests to be run beside that of the case.

    Args:
        test: the case, its uncertainty not to be measured.
        changes: the parameters that differ, by choice of the method.
        differences: what is said of them, as "smaller cells", by the same.

    Raises:
        ParameterError: one of them is outside the allowed range.
    """
    tests = {}
    for choice, changed in changes.items():
        try:
            tests[choice] = replace(test, **changed)  # type: ignore[type-var]
        except ParameterError as error:
            raise ParameterError(
                error.key,
                f"uncertainty = measured needs a run with {differences[choice]}, where {error}",
            ) from error
    return tests


def run_all(
    case: Test,
    further: Mapping[str, Test],
    run: Callable[[Test, Progress], xr.Dataset],
    progress: Progress,
) -> tuple[Run[Test], dict[str, Run[Test] | str]]:
    """Run a case and its further tests, one after the other.

    Args:
        case: the test whose error is measured.
        further: the further tests, by choice of the method.
        run: runs one test.
        progress: receives the fraction done of all.

    Returns:
        The run of the case, and those of the further tests; for one that failed, why.
    """
    updates = [it.run_size().particle_updates for it in (case, *further.values())]
    done = np.cumsum([0.0, *updates]) / sum(updates)

    def part(number: int) -> Progress:
        begin, end = done[number : number + 2]
        # Rounding must not take it beyond the begin of the next.
        return lambda fraction: progress(float(min(begin + fraction * (end - begin), end)))

    of_case = Run(case, run(case, part(0)))
    made: dict[str, Run[Test] | str] = {}
    for number, (choice, test) in enumerate(further.items(), start=1):
        try:
            made[choice] = Run(test, run(test, part(number)))
        except (SimulationDiverged, InaccurateRun, UnfinishedRun) as error:
            made[choice] = str(error)
    return of_case, made


def with_cost(case: xr.Dataset, further: Mapping[str, Run[Test] | str]) -> xr.Dataset:
    """The results of a case with the cost of its further runs in `run_time`, `particle_updates`."""
    made = [it.results for it in further.values() if isinstance(it, Run)]
    whole = {
        name: case[name].copy(data=sum((float(it[name]) for it in made), float(case[name])))
        for name in ("run_time", "particle_updates")
    }
    took = sum(float(it.run_time) for it in made)
    return case.assign(whole).assign(
        labelled(
            role="measured",
            uncertainty_run_time=(took, "s", "run time of the runs that measure the uncertainty"),
        )
    )


def without_errors(
    values: Sequence[float], measures: Sequence[Mapping[str, float]]
) -> WithoutErrors:
    """Solve for the value without errors.

    Args:
        values: as simulated by the case and by its further runs.
        measures: m of each run by choice of the method; one choice less than there are runs.
    """
    choices = list(measures[0])
    system = np.array([[1.0, *(of_run[it] for it in choices)] for of_run in measures])
    inverse = np.linalg.inv(system)
    value, *slopes = inverse @ np.array(values)
    left = np.abs(slopes) * system[:, 1:].min(axis=0)
    return WithoutErrors(
        value=float(value),
        left=dict(zip(choices, left.tolist(), strict=True)),
        weights=inverse[0],
    )
