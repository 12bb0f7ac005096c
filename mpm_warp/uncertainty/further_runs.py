"""The error of a result, measured by further runs of the case itself.

Each further run differs from the case in one choice of the method, such as the width of the cells.
The error of this choice, its effect, is in proportion to a measure m. The case and one further run
for each effect determine the slopes s and the value v without these errors:

    simulated value - known part of its error = v + s_1 m_1 + s_2 m_2 + ...
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
"""Called from time to time with the fraction done, 0 to 1."""
FAILURES = (SimulationDiverged, InaccurateRun, UnfinishedRun)
"""Errors that end a run without a result."""
ALONE: Floats = np.ones(1)
"""Weights of the runs where the value is from a single run."""
REASON = "why_no_uncertainty"
"""Name of the variable that says why a result has no uncertainty; "" where it has one."""
LARGEST_PART = "largest_part_of_uncertainty"
"""Name of the variable that says which part of U is the largest, and what makes it smaller."""

NOT_CORRECTED = "nothing is corrected"
CARRIED_ON = "corrected by the laws of Tresca clay, for mesh, speed, window and Poisson's ratio"
"""What a reason says of the correction, where there is no uncertainty."""


def reason(text: str) -> xr.Variable:
    """The variable `REASON`; the text is "word: sentence", several separated by semicolons."""
    return variable(text, unit=None, meaning="why there is no uncertainty", role="reason")


def largest_part(parts: Mapping[str, float], remedies: Mapping[str, str]) -> xr.Variable:
    """The variable `LARGEST_PART`, as "mesh, 38 % of U^2: more cells_per_radius"; "" without U.

    Args:
        parts: half widths by cause, NaN where there is no U; U^2 is the sum of their squares.
        remedies: what makes each smaller.
    """
    text, whole = "", sum(part**2 for part in parts.values())
    if whole > 0.0:
        name = max(parts, key=lambda part: parts[part])
        text = f"{name}, {parts[name] ** 2 / whole:.0%} of U^2: {remedies[name]}"
    return variable(text, unit=None, meaning="largest part of U, and what makes it smaller")


def those_that_hold(conditions: Mapping[str, object]) -> list[str]:
    """The texts whose condition is true."""
    return [text for text, holds in conditions.items() if holds]


class Test(Protocol):
    """A frozen dataclass of parameters, with further tests that measure its error."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def own_size(self) -> Any:
        """Size of the run without further ones; `particle_updates` is points times steps."""

    def further_tests(self) -> "Mapping[str, Self]":
        """The further tests, by the effect that each measures."""

    def error_of(self, recorded: xr.Dataset) -> "TestRun":
        """What the error of its run depends on."""


TestT = TypeVar("TestT", bound=Test)


@dataclass(frozen=True, kw_only=True, eq=False)
class TestRun:
    """What the error of a run depends on; a subclass knows the laws of one kind of test."""

    name: ClassVar[str]
    """Name of the value whose error is measured, as "cone_factor"."""
    description: ClassVar[str]
    """Definition of that value."""
    differences: ClassVar[Mapping[str, str]]
    """Difference of the run that measures an effect, as "smaller cells", by effect."""
    residual_shares: ClassVar[Mapping[str, float]]
    """Half width of an effect over its size in the run where it is smallest, by effect."""
    largest_correction: ClassVar[float] = math.inf
    """Largest correction over the value for which the laws are trusted."""
    remedies: ClassVar[Mapping[str, str]]
    """What makes each part of the half width smaller."""
    approach: ClassVar[float] = 0.0
    """Half width of the effect of a fast approach over the value; added to the effect "speed"."""

    recorded: xr.Dataset  # results of the run

    @property
    @abstractmethod
    def factor(self) -> float:
        """The value as simulated."""

    @property
    def usual_correction(self) -> float:
        """The best that is known of the correction where further runs cannot measure it."""
        return 0.0

    @property
    def usual_correction_is(self) -> str:
        """What that correction is."""
        return NOT_CORRECTED

    def known_parts(self) -> dict[str, float]:
        """Parts of the error that are known without further runs, by effect."""
        return {}

    def least_parts(self) -> dict[str, float]:
        """Lower bounds of the half widths, by effect."""
        return {}

    @abstractmethod
    def measures(self, case: Self) -> dict[str, float]:
        """The measures m, by effect; `case` is the run whose error is measured."""

    @abstractmethod
    def why_unsound(self, runs: Mapping[str, Self]) -> list[str]:
        """Why the runs cannot measure the error; keys are their names in a reason, "the case"."""

    @abstractmethod
    def own_parts(self, weights: Floats, runs: Sequence[Self]) -> dict[str, float]:
        """Half widths that belong to no effect; the value is the sum of weight times run."""

    def stated(
        self, correction: float, parts: Mapping[str, float], reasons: Sequence[str]
    ) -> dict[str, xr.Variable]:
        """The corrected value, its correction, its uncertainty with parts, and the reasons.

        The parts of the uncertainty are half widths of 95 %, added as squares. With reasons why the
        error is not known, each as "word: sentence", the uncertainty is NaN, the correction is the
        usual one, and the last reason says which that is.
        """
        if reasons:
            correction, parts = self.usual_correction, dict.fromkeys(parts, math.nan)
            reasons = [*reasons[:-1], f"{reasons[-1]}: {self.usual_correction_is}"]
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
            LARGEST_PART: largest_part(parts, self.remedies),
        } | {
            f"{name}_uncertainty_{part}": variable(
                half_width, meaning=f"uncertainty of the {spoken}, {part}"
            )
            for part, half_width in parts.items()
        }


def further_tests(
    test: TestT, changes: Mapping[str, Mapping[str, Any]], differences: Mapping[str, str]
) -> dict[str, TestT]:
    """The further tests of a case, by effect.

    Args:
        test: the case.
        changes: changed parameters, by effect.
        differences: the difference in words, as "smaller cells", by effect; for messages.
    """
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

    Returns:
        Results of the case, with the measured error. `run_time` and `particle_updates` include the
        further runs.
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
    """A progress function for each of several runs, whose shares are in proportion to size."""
    updates = [size.particle_updates for size in sizes]
    done = np.cumsum([0.0, *updates]) / sum(updates)

    def part(begin: float, end: float) -> Progress:
        # Rounding must not pass the start of the next run.
        return lambda fraction: progress(float(min(begin + fraction * (end - begin), end)))

    return [part(*ends) for ends in pairwise(done)]


def measured_error(case: TestRun, further: Mapping[str, TestRun | str]) -> dict[str, xr.Variable]:
    """The corrected value of a case and its uncertainty, as measured by its further runs.

    The result holds what `TestRun.stated` gives, and the value as simulated by each further run,
    NaN where it failed. The error is not known where a run failed or is not sound, or where the
    correction would be too large.

    Args:
        case: the run of the case.
        further: each further run, or the message with which it failed, by effect.
    """
    label = {effect: f"the run with {what}" for effect, what in case.differences.items()}
    failed = {label[name]: why for name, why in further.items() if isinstance(why, str)}
    completed = {"the case": case} | {
        label[name]: run for name, run in further.items() if isinstance(run, TestRun)
    }
    reasons = [f"further runs: {which}: {why}" for which, why in failed.items()]
    reasons += case.why_unsound(completed)
    runs, correction = list(completed.values()), 0.0
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
        known_left = [min(of.get(effect, 0.0) for of in known) for effect in parts]
        of_best_run = np.abs(slopes * system[:, 1:].min(axis=0) + known_left)
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
    """The results of a case; `run_time` and `particle_updates` include those of further runs."""
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
