"""Looking after the results of a study: how its cases stand, one dataset of them, what is left."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import netCDF4
import xarray as xr

from harness.archive.atomic_files import ArchiveError, abandoned
from harness.archive.case_files import case_file, case_folder, read_outcome
from harness.archive.collection import collect, write_study
from harness.compare.cone_factors import NothingToCompareError, with_references
from harness.compare.finest_error import with_errors
from harness.compare.tolerances import with_tolerances
from harness.errors import tell
from harness.study.cases import COMPLETED, DAMAGED, UNTIMED, Case, Outcome
from harness.study.study import Study
from mpm_warp.parameters import Value

Parameters = Mapping[str, Value | None]


def result_file(out: Path, study: Study) -> Path:
    """The collected dataset of a study."""
    return out / f"{study.name}.nc"


def check_begun(study: Study, cases: Sequence[Case], out: Path) -> None:
    """Refuse a study of which no case has a file: there is nothing to collect.

    Raises:
        ArchiveError: none has.
    """
    folder = case_folder(out, study)
    if not any(case_file(folder, case).exists() for case in cases):
        raise ArchiveError(
            f"{folder}: has no case of this study; "
            "run it first, or give each --set that it was run with"
        )


def collect_and_write(study: Study, cases: Sequence[Case], out: Path) -> xr.Dataset:
    """Collect a study, compare it with its references, and write its dataset.

    Raises:
        ArchiveError: the dataset cannot be written.
    """
    dataset = with_errors(collect(study, cases, case_folder(out, study)))
    dataset = with_tolerances(dataset, study.tolerances)
    try:
        dataset = with_references(dataset, study.references)
    except NothingToCompareError as error:
        tell(str(error))
    write_study(result_file(out, study), dataset)
    return dataset


def outcomes(study: Study, cases: Sequence[Case], out: Path) -> list[Outcome]:
    """How the cases of a study stand, in their order."""
    folder = case_folder(out, study)
    read = [read_outcome(folder, case) for case in cases]
    return [
        replace(outcome, status=UNTIMED)
        if outcome.status == COMPLETED and outcome.repeats < study.timing_repeats
        else outcome
        for outcome in read
    ]


def outcomes_of(dataset: xr.Dataset) -> list[Outcome]:
    """How the cases of a collected dataset stand; times are of completed ones."""
    statuses = dataset.status
    times = dataset["case_time"] if "case_time" in dataset else xr.zeros_like(statuses, float)
    pairs = zip(statuses.values.flat, times.fillna(0.0).values.flat, strict=True)
    return [Outcome(str(status), seconds=float(seconds)) for status, seconds in pairs]


def status_rows(cases: Sequence[Case], outcomes: Sequence[Outcome]) -> list[str]:
    """A line a case, and one of all."""
    rows = [f"{'case':16}  {'status':9}  {'time':>9}  parameters"]
    for case, outcome in zip(cases, outcomes, strict=True):
        time = f"{outcome.seconds:.1f} s" if outcome.seconds else ""
        why = f": {outcome.message}" if outcome.message else ""
        rows.append(f"{case.key}  {outcome.status:9}  {time:>9}  {case.label}{why}")
    return [*rows, summary(outcomes)]


def summary(outcomes: Sequence[Outcome]) -> str:
    """How many cases of each status there are, and how long they took."""
    counts = Counter(outcome.status for outcome in outcomes)
    told = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    seconds = sum(it.seconds for it in outcomes)
    return f"{counted(len(outcomes), 'case')}: {told}; {seconds:.1f} s in all"


def counted(count: int, noun: str) -> str:
    """A number of things in words: ``1 file``, ``2 files``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def leftovers(study: Study, cases: Sequence[Case], out: Path) -> dict[Path, str]:
    """Files that are no results of the study as it is now, and what they are.

    These are damaged files, results of cases that the study does not have (with other parameters,
    or of another version of the simulator), and what processes that were killed left half-written.
    """
    folder = case_folder(out, study)
    found = {path: "half-written" for place in (out, folder) for path in abandoned(place)}
    present = {case_file(folder, case): case for case in cases}
    keys, shared = {path.stem for path in present}, _shared_parameters(cases)
    for path in sorted(folder.glob("*.nc")):
        if path not in present:
            found[path] = _stranger(path, keys, shared)
        elif (outcome := read_outcome(folder, present[path])).status == DAMAGED:
            found[path] = outcome.message.removeprefix(f"{path}: ")
    return found


def _stranger(path: Path, keys: Container[str], shared: Mapping[str, Parameters]) -> str:
    """What a file in the folder of a study's cases is whose name is the key of none.

    Args:
        path: the file.
        keys: of the study's cases.
        shared: by scene, the parameters that are the same in all of these.
    """
    try:
        with netCDF4.Dataset(path) as file:
            parameters = dict(json.loads(file.parameters))
            key, scene = str(file.case_key), str(file.scene)
            told = f"{scene} version {file.scene_version}, {file.status}"
    except (OSError, RuntimeError, ValueError, TypeError, AttributeError):
        return "not a case file, or a damaged one"
    if key in keys:
        return f"a copy of case {key}"
    if scene not in shared:
        return f"no case of this study: {told}: another scene"
    others = ", ".join(
        f"{name}={value}"
        for name, value in parameters.items()
        if name not in shared[scene] or value != shared[scene][name]
    )
    return f"no case of this study: {told}: {others or 'the same parameters'}"


def _shared_parameters(cases: Sequence[Case]) -> dict[str, Parameters]:
    """By scene, the parameters that are the same in all of its cases."""
    shared: dict[str, Parameters] = {}
    for case in cases:
        before = shared.get(case.scene, case.parameters)
        same = {name: value for name, value in before.items() if value == case.parameters[name]}
        shared[case.scene] = same
    return shared
