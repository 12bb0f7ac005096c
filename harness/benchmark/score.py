"""Scores of submissions: their differences from a yardstick, over the uncertainties.

    E = value - yardstick,   d = |E| / sqrt(U^2 + U_y^2)

The yardstick of a case is its exact value, with U_y = 0. If only two bounds of it are known, E is 0
between them and counts from the nearer one outside. If no exact value is known, the yardstick is
the value of one submission with its own U. If d <= 1, both agree within their uncertainties (ASME
V&V 20).
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.benchmark.cases import BenchmarkCase, Result, Submission
from harness.references.reference import USUAL
from harness.references.registry import REFERENCES
from harness.references.strength import Criterion, of_law
from harness.study.tables import StudyError
from mpm_warp.fields.names import nearest_name


@dataclass(frozen=True)
class Score:
    """One result of a submission beside its yardstick."""

    submission: str
    case: BenchmarkCase
    result: Result
    error: float  # E over the size of the yardstick; NaN if there is none or it is 0
    distance: float  # d; NaN if the result or its yardstick has no uncertainty


def scores(
    cases: Sequence[BenchmarkCase], submissions: Sequence[Submission], against: str
) -> list[Score]:
    """All results of all submissions beside the yardsticks of their cases, case by case.

    The submission called `against` is the yardstick of cases without an exact value.
    """
    names = Counter(submission.name for submission in submissions)
    if twice := [name for name, count in names.items() if count > 1]:
        raise StudyError(f"two submissions are called {twice[0]}; rename one of their folders")
    by_name = {submission.name: submission for submission in submissions}
    if against not in by_name:
        near = nearest_name(against, by_name)
        raise StudyError(f"--against {against}: is not a submission{near}")
    yardstick = by_name[against]
    return [
        _score(submission, case, yardstick)
        for case in cases
        for submission in submissions
        if case.name in submission.results
    ]


def _score(submission: Submission, case: BenchmarkCase, yardstick: Submission) -> Score:
    result, expected = submission.results[case.name], None
    if case.exact is not None:
        expected = Result(float(np.clip(result.value, *case.exact)), 0.0, math.nan)
    elif submission is not yardstick:
        expected = yardstick.results.get(case.name)
    error = distance = math.nan
    if expected is not None:
        difference = result.value - expected.value
        error = difference / abs(expected.value) if expected.value else math.nan
        distance = abs(difference) / math.hypot(result.uncertainty, expected.uncertainty)
    return Score(submission.name, case, result, error, distance)


def formulas(cases: Sequence[BenchmarkCase]) -> list[Submission]:
    """Cone factors of the literature as submissions without uncertainty, where they are valid."""
    computes = ("cone_penetration", "cone_factor")
    cones = [case for case in cases if (case.scene, case.result) == computes]
    found = []
    for reference in REFERENCES.values():
        results = {}
        for case in cones:
            adhesion = float(case.fixed.get("adhesion_factor", 0.0))
            changes = {"rate_factor", "remoulded_strength_ratio"} & case.fixed.keys()
            conditions = {
                **USUAL,
                "Ir": float(case.fixed.get("rigidity_index", 100.0)),
                "alpha_c": adhesion,
                "alpha_s": adhesion,
                "Delta": float(case.fixed.get("stress_anisotropy", 0.0)),
                "constant_su": 0.0 if changes else 1.0,
                **of_law(str(case.fixed.get("material", Criterion.TRESCA))),
            }
            if reference.applies(conditions) and reference.readings(conditions) == (reference,):
                value = float(reference.evaluate(conditions))
                results[case.name] = Result(value, math.nan, math.nan)
        if results:
            meta = {"code": reference.label, "method": reference.method}
            found.append(Submission(reference.id, meta, results))
    return found


def summary_rows(found: Sequence[Score]) -> list[list[str]]:
    """A heading, and a row for each submission: cases, share with d <= 1, errors, seconds."""
    rows = [["submission", "cases", "stated U", "inside", "median |E|", "largest |E|", "seconds"]]
    for name in dict.fromkeys(scored.submission for scored in found):
        own = [scored for scored in found if scored.submission == name]
        errors = np.abs([scored.error for scored in own if math.isfinite(scored.error)])
        stated = [scored.distance for scored in own if math.isfinite(scored.distance)]
        inside = sum(distance <= 1.0 for distance in stated)
        seconds = [scored.result.seconds for scored in own]
        rows.append(
            [
                name,
                str(len(own)),
                str(sum(math.isfinite(scored.result.uncertainty) for scored in own)),
                f"{inside} of {len(stated)}" if stated else "",
                f"{np.median(errors):.1%}" if len(errors) else "",
                f"{errors.max():.1%}" if len(errors) else "",
                f"{np.nansum(seconds):.0f}" if np.isfinite(seconds).any() else "",
            ]
        )
    return rows


def case_rows(found: Sequence[Score]) -> list[list[str]]:
    """A heading, and a row for each result."""
    forms = {"value": ".5g", "U": ".2g", "E": "+.1%", "d": ".2f", "seconds": ".3g"}
    rows = [["case", "submission", *forms]]
    for scored in found:
        own = scored.result
        numbers = own.value, own.uncertainty, scored.error, scored.distance, own.seconds
        pairs = zip(numbers, forms.values(), strict=True)
        texts = [format(number, form) if math.isfinite(number) else "" for number, form in pairs]
        rows.append([scored.case.name, scored.submission, *texts])
    return rows
