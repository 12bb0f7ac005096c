"""The error of a result, measured by further runs of the case itself.

Each further run differs from the case in one choice of the method. A law says what the error of
this choice is in proportion to, its measure m. The case and as many further runs as there are
choices then determine the value v without these errors, and the slopes s:

    simulated value - what is known of its error = v + s_1 m_1 + s_2 m_2 + ...
"""

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import Field, dataclass, replace
from itertools import pairwise
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
import xarray as xr

from mpm_warp.errors import InaccurateRun, ParameterError, SimulationDiverged, UnfinishedRun
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled, variable

Progress = Callable[[float], None]
"""Is called now and then with the fraction done, 0 to 1."""
FAILURES = (SimulationDiverged, InaccurateRun, UnfinishedRun)
"""How a run may end without a result."""
ALONE: Floats = np.ones(1)
"""The weight of a run in its own value."""
REASON = "why_no_uncertainty"
"""Name of the text that says why a result has no uncertainty; "" where it has one."""


def reason(text: str) -> xr.Variable:
    """The variable `REASON`: "word: sentence", parted by semicolons; "" where there is none."""
    return variable(text, unit=None, meaning="why there is no uncertainty", role="reason")


def those_that_hold(conditions: Mapping[str, object]) -> list[str]:
    """The reasons that hold, of some with what says whether they do."""
    return [text for text, holds in conditions.items() if holds]


class Test(Protocol):
    """A frozen dataclass of parameters whose run has a size, and an error that can be measured."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def own_size(self) -> Any:
        """Of a run of it alone; `particle_updates` are material points times steps."""

    def further_tests(self) -> "Mapping[str, Self]":
        """Its further tests, by the effect that each measures."""

    def error_of(self, recorded: xr.Dataset) -> "TestRun":
        """A run of it, as far as its error goes."""


TestT = TypeVar("TestT", bound=Test)


@dataclass(frozen=True, kw_only=True, eq=False)
class TestRun:
    """A run of a test, as far as its error goes."""

    name: ClassVar[str]
    """Of the value whose error it is, "cone_factor"."""
    description: ClassVar[str]
    """How that value is defined."""
    differences: ClassVar[Mapping[str, str]]
    """What the further run has that measures an effect, as "smaller cells", by effect."""
    residual_shares: ClassVar[Mapping[str, float]]
    """Half width of an error over what the best run still has of it, by effect."""
    largest_correction: ClassVar[float] = math.inf
    """Error that the laws may take off, over the value."""
    approach: ClassVar[float] = 0.0
    """Half width of what a hurried approach leaves, over the value; it goes with that of speed."""

    recorded: xr.Dataset  # what came out

    @property
    @abstractmethod
    def factor(self) -> float:
        """The value as simulated."""

    def known_parts(self) -> dict[str, float]:
        """What is known of the errors of the value before anything is measured, by effect."""
        return {}

    def least_parts(self) -> dict[str, float]:
        """Half widths of what the laws leave open at least, by effect."""
        return {}

    @abstractmethod
    def measures(self, case: Self) -> dict[str, float]:
        """What the errors are in proportion to, m, by effect, where `case` is that to measure."""

    @abstractmethod
    def why_unsound(self, runs: Mapping[str, Self]) -> list[str]:
        """Why the error is not known by the sound ones of the runs; by what they are."""

    @abstractmethod
    def own_parts(self, weights: Floats, runs: Sequence[Self]) -> dict[str, float]:
        """Half widths that are of no effect, by runs that have these weights in the value."""

    def stated(
        self, correction: float, parts: Mapping[str, float], reasons: Sequence[str]
    ) -> dict[str, xr.Variable]:
        """What is said of the value: less its error, the correction, its uncertainty, the reason.

        Parts of the uncertainty are half widths of 95 %; their squares add up. Where there are
        reasons why nothing is known, each as "word: sentence", there is no correction, and the
        uncertainty is not a number.
        """
        if reasons:
            correction, parts = 0.0, dict.fromkeys(parts, math.nan)
        name, spoken = self.name, self.name.replace("_", " ")
        return {
            name: variable(
                self.factor + correction,
                meaning=spoken,
                description=self.description,
                role="headline",
            ),
            f"{name}_uncertainty": variable(
                math.nan if reasons else math.hypot(*parts.values()),
                meaning=f"uncertainty of the {spoken}",
                description="half width, 95 %",
                role="uncertainty",
            ),
            f"{name}_correction": variable(
                correction,
                meaning=f"correction of the {spoken}",
                description="what is known of the error of mesh, speed and window, taken off; "
                "0 where nothing is",
            ),
            REASON: reason("; ".join(reasons)),
        } | {
            f"{name}_uncertainty_{part}": variable(
                half_width, meaning=f"uncertainty of the {spoken}, {part}"
            )
            for part, half_width in parts.items()
        }


def further_tests(
    test: TestT, changes: Mapping[str, Mapping[str, Any]], differences: Mapping[str, str]
) -> dict[str, TestT]:
    """The tests that differ from a case, by choice of the method: parameters, and what is said."""
    tests = {}
    for choice, changed in changes.items():
        try:
            tests[choice] = replace(test, **changed)
        except ParameterError as error:
            raise ParameterError(
                error.key,
                f"uncertainty = measured needs a run with {differences[choice]}, where {error}",
            ) from error
    return tests


def with_measured_error(
    case: TestT, run: Callable[[TestT, Progress], xr.Dataset], progress: Progress
) -> xr.Dataset:
    """Run a test and its further tests, one after the other.

    Its results have the measured error, and what the further runs took, in `run_time` and
    `particle_updates` too.
    """
    further = case.further_tests()
    sizes = [single.own_size for single in (case, *further.values())]
    own, *parts = one_after_the_other(sizes, progress)
    results = run(case, own)
    made: dict[str, TestRun | str] = {}
    for part, (effect, test) in zip(parts, further.items(), strict=True):
        try:
            made[effect] = test.error_of(run(test, part))
        except FAILURES as error:
            made[effect] = str(error)
    measured = measured_error(case.error_of(results), made)
    known = [result for result in results if result in measured or "_uncertainty_" in str(result)]
    costs = [done.recorded for done in made.values() if isinstance(done, TestRun)]
    return with_cost(results.drop_vars(known), costs).assign(measured)


def one_after_the_other(sizes: Sequence[Any], progress: Progress) -> list[Progress]:
    """What receives the progress of each of some runs, by the share of all that each takes."""
    updates = [size.particle_updates for size in sizes]
    done = np.cumsum([0.0, *updates]) / sum(updates)

    def part(begin: float, end: float) -> Progress:
        # Rounding must not take it beyond the begin of the next.
        return lambda fraction: progress(float(min(begin + fraction * (end - begin), end)))

    return [part(*ends) for ends in pairwise(done)]


def measured_error(case: TestRun, further: Mapping[str, TestRun | str]) -> dict[str, xr.Variable]:
    """The value of a case less its error, and its uncertainty, as measured by its further runs.

    Beside what `TestRun.stated` gives is the value as simulated by each further run, by effect, not
    a number where it failed for the reason given. Nothing is known of the error where a run failed,
    or is not sound, or where the laws would have to take off too much.
    """
    with_effect = {effect: f"the run with {what}" for effect, what in case.differences.items()}
    failed = {with_effect[name]: why for name, why in further.items() if isinstance(why, str)}
    whole = {"the case": case} | {
        with_effect[name]: run for name, run in further.items() if isinstance(run, TestRun)
    }
    reasons = [f"further runs: {which}: {why}" for which, why in failed.items()]
    reasons += case.why_unsound(whole)
    runs, correction = list(whole.values()), 0.0
    parts = dict.fromkeys(case.differences, 0.0)
    if reasons:
        parts |= case.own_parts(ALONE, [case])
    else:
        measures = [run.measures(case) for run in runs]
        known = [run.known_parts() for run in runs]
        system = np.array([[1.0, *(of_run[part] for part in parts)] for of_run in measures])
        inverse = np.linalg.inv(system)
        factors = [run.factor - sum(of.values()) for run, of in zip(runs, known, strict=True)]
        value, *slopes = inverse @ np.array(factors)
        correction = float(value) - case.factor
        if abs(correction) > case.largest_correction * value:
            off = f"their laws would take off {abs(correction) / value:.0%}"
            reasons = [f"further runs: {off}, and hold up to {case.largest_correction:.0%}"]
        least = [min(of.get(effect, 0.0) for of in known) for effect in parts]
        of_best_run = np.abs(slopes * system[:, 1:].min(axis=0) + least)
        left = zip(parts, of_best_run.tolist(), strict=True)
        parts = {effect: case.residual_shares[effect] * error for effect, error in left}
        parts["speed"] += case.approach * case.factor
        parts |= {it: max(parts[it], least) for it, least in case.least_parts().items()}
        parts |= case.own_parts(inverse[0], runs)
    spoken = case.name.replace("_", " ")
    return case.stated(correction, parts, reasons) | {
        f"{case.name}_further_{effect}": variable(
            math.nan if isinstance(run, str) else run.factor,
            meaning=f"{spoken} as simulated with {case.differences[effect]}",
        )
        for effect, run in further.items()
    }


def with_cost(case: xr.Dataset, further: Sequence[xr.Dataset]) -> xr.Dataset:
    """The results of a case with the cost of its further runs in `run_time`, `particle_updates`."""
    whole = {
        name: case[name].copy(data=sum((float(run[name]) for run in further), float(case[name])))
        for name in ("run_time", "particle_updates")
    }
    took = sum(float(run.run_time) for run in further)
    return case.assign(whole).assign(
        labelled(
            role="measured",
            uncertainty_run_time=(took, "s", "run time of the runs that measure the uncertainty"),
        )
    )
