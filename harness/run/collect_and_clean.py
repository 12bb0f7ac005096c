"""Looks after the results of a study: status of its cases, collected dataset."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import Outcome, case_file, case_folder, read_outcome
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED, NO_FIELDS, TRACEBACK, UNTIMED, over_cases
from harness.archive.fields_files import has_fields
from harness.archive.netcdf_files import read_attributes
from harness.archive.provenance import SOURCES, sources_digest
from harness.archive.study_files import read_study, study_file, write_study
from harness.compare.compared import (
    NothingToCompareError,
    with_experience,
    with_references,
    with_tolerances,
)
from harness.compare.finest_error import with_finest_error
from harness.errors import tell
from harness.study.study import Study
from harness.terminal import coloured


def check_begun(study: Study, out: Path) -> None:
    """Check that at least one case of a study has a file, so that there is something to collect.

    Raises:
        ArchiveError: no case has one.
    """
    folder = case_folder(out, study)
    if not any(case_file(folder, case).exists() for case in study.cases):
        raise ArchiveError(
            f"{folder}: has no case of this study; "
            "run it first, or give each --set that it was run with"
        )


def collect_and_write(study: Study, out: Path) -> xr.Dataset:
    """Collect a study, compare it with its references and experience, and write its dataset.

    Raises:
        ArchiveError: the dataset cannot be written.
    """
    dataset = collect(study, case_folder(out, study))
    if len(study.parts) == 1:
        dataset = _with_errors(dataset, study)
    dataset = with_tolerances(dataset, study.tolerances)
    try:
        dataset = with_references(dataset, study.references)
    except NothingToCompareError as error:
        tell(str(error))
    dataset = with_experience(dataset, study.experience)
    write_study(study_file(out, study), dataset)
    return dataset


def _with_errors(dataset: xr.Dataset, study: Study) -> xr.Dataset:
    """The dataset with the error of each case, where no exact solution gives it."""
    method, result = study.parts[0].scene.method, study.reference_result
    reference = None if result is None else read_study(result)
    try:
        return with_finest_error(dataset, method, reference)
    except NothingToCompareError as error:
        tell(f"{result}: {error}")
        return with_finest_error(dataset, method)


def outcomes(study: Study, out: Path) -> list[Outcome]:
    """How the cases of a study stand, in their order."""
    folder = case_folder(out, study)
    read = [read_outcome(folder, case) for case in study.cases]
    for place, (case, outcome) in enumerate(zip(study.cases, read, strict=True)):
        if outcome.status == COMPLETED and outcome.repeats < study.timing_repeats:
            read[place] = replace(outcome, status=UNTIMED)
        elif outcome.status == COMPLETED and not has_fields(folder, case):
            read[place] = replace(outcome, status=NO_FIELDS)
    return read


def outcomes_of(dataset: xr.Dataset) -> list[Outcome]:
    """How the cases of a collected dataset stand; times are of completed ones."""
    seconds = np.nan_to_num(over_cases(dataset, "case_time")).tolist()
    of_all = [dataset.attrs.get(SOURCES, "")] * len(seconds)
    sources = over_cases(dataset, SOURCES) if SOURCES in dataset else of_all
    return [
        Outcome(str(status), str(message), seconds=time, sources=str(digest))
        for status, message, time, digest in zip(
            over_cases(dataset, "status"),
            over_cases(dataset, "message"),
            seconds,
            sources,
            strict=True,
        )
    ]


def tell_of_other_sources(study: Study, outcomes: Sequence[Outcome]) -> None:
    """Say in one line how many results were computed by other sources of the simulator.

    A stored result belongs to a case with the same scene, scene version and parameters. Raising the
    version of a scene therefore computes all its cases anew. The sources may also change while the
    version stays the same, because a kernel was edited, or only a comment. The harness cannot know
    whether the numbers change. It keeps such results and prints this line with every `run`,
    `status` and `collect`, until ``run --fresh`` has computed them anew. A result whose file does
    not say by which sources it was computed counts as computed by other ones.
    """
    digests = {part.name: sources_digest(part.scene) for part in study.parts}
    completed = [
        (case, outcome)
        for case, outcome in zip(study.cases, outcomes, strict=True)
        if outcome.status == COMPLETED
    ]
    count = sum(outcome.sources != digests[case.scene] for case, outcome in completed)
    if count:
        tell(
            f"{study.name}: {count} of {counted(len(completed), 'result')} computed by other "
            "sources of the simulator, of the same version; kept: `harness run --fresh` computes "
            "them anew"
        )


def status_rows(cases: Sequence[tuple[str, str]], outcomes: Sequence[Outcome]) -> list[str]:
    """A line a case, of which key and label are given, and one of all."""
    rows = [f"{'case':16}  {'status':10}  {'time':>9}  parameters"]
    for (key, label), outcome in zip(cases, outcomes, strict=True):
        time = f"{outcome.seconds:.1f} s" if outcome.seconds else ""
        why = f": {outcome.message}" if outcome.message else ""
        status = coloured(f"{outcome.status:10}", is_good=outcome.status == COMPLETED)
        rows.append(f"{key}  {status}  {time:>9}  {label}{why}")
    return [*rows, summary(outcomes)]


def tracebacks(study: Study, out: Path) -> list[str]:
    """Where in the program the failed cases of a study failed, as far as their files say."""
    lines = []
    for case in study.cases:
        path = case_file(case_folder(out, study), case)
        if path.exists() and (text := read_attributes(path).get(TRACEBACK)):
            lines += ["", f"{case.key}  {case.label}", str(text).rstrip()]
    return lines or ["no case has failed by an error of the program"]


def summary(outcomes: Sequence[Outcome]) -> str:
    """How many cases of each status there are, and how long they took."""
    counts = Counter(outcome.status for outcome in outcomes)
    told = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    seconds = sum(it.seconds for it in outcomes)
    return f"{counted(len(outcomes), 'case')}: {told}; {seconds:.1f} s in all"


def counted(count: int, noun: str) -> str:
    """A number of things in words: ``1 file``, ``2 files``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"
