"""Files of a study: status of its cases, collected dataset, and files that do not belong to it."""

import json
from collections import Counter
from collections.abc import Container, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.atomic_files import (
    ArchiveError,
    DamagedError,
    abandoned,
    check_folder,
    remove_file,
)
from harness.archive.case_files import (
    Outcome,
    case_file,
    case_folder,
    check_no_link,
    fields_file,
    read_outcome,
)
from harness.archive.collection import collect
from harness.archive.conventions import (
    COMPLETED,
    HALF_WIDTH,
    OUTDATED,
    TRACEBACK,
    Role,
    over_cases,
    reasons_of,
    uncertainty_of,
    with_role,
    without_half_width,
)
from harness.archive.netcdf_files import read_attributes
from harness.archive.provenance import (
    SOURCES,
    tell_of_other_version,
)
from harness.archive.study_files import read_study, study_file, write_study
from harness.compare.compared import (
    NothingToCompareError,
    with_experience,
    with_references,
    with_tolerances,
)
from harness.compare.finest_error import with_finest_error
from harness.errors import counted, tell
from harness.run.replaced import tell_of_replaced
from harness.study.cases import Case
from harness.study.study import Study
from mpm_warp.fields.declaration import Value
from mpm_warp.provenance import SIMULATOR, edited_packages


def check_begun(study: Study, out: Path) -> None:
    """Refuse a study none of whose cases has a file, because there is nothing to collect."""
    folder = case_folder(out, study)
    check_folder(out, folder.parent, folder)
    if not any(case_file(folder, case).exists() for case in study.cases):
        raise ArchiveError(
            f"{folder}: has no case of this study; run it first, or give each --set that it was "
            "run with; cases of another version of its scene do not count"
        )


def collect_and_write(study: Study, out: Path) -> xr.Dataset:
    """Collect a study, compare it with its references and experience, and write its dataset."""
    dataset = collect(study, case_folder(out, study))
    if len(study.parts) == 1:
        dataset = _with_errors(dataset, study)
    dataset = with_tolerances(dataset, study.compared.tolerances)
    try:
        dataset = with_references(dataset, study.compared.references)
        _tell_of_no_value(dataset)
    except NothingToCompareError as error:
        tell(str(error))
    dataset = with_experience(dataset, study.compared.experience)
    tell_of_replaced(study_file(out, study), dataset, case_folder(out, study))
    write_study(study_file(out, study), dataset)
    return dataset


def _tell_of_no_value(dataset: xr.Dataset) -> None:
    """Print one line for each reference that has a value for none of the cases."""
    for name in with_role(dataset, Role.REFERENCE):
        if dataset[name].isnull().all():
            reference, validity = name.removeprefix(f"{Role.REFERENCE}_"), dataset[name].validity
            tell(f"reference {reference}: has a value for none of the cases ({validity})")


def _with_errors(dataset: xr.Dataset, study: Study) -> xr.Dataset:
    """The dataset with the error of each case, unless an exact solution gives it."""
    method, reference = study.parts[0].scene.method, read_reference(study)
    if study.compared.reference_result is not None and reference is not None:
        tell_of_other_version(study.compared.reference_result, reference)
    try:
        return with_finest_error(dataset, method, reference)
    except NothingToCompareError as error:
        tell(f"{study.compared.reference_result}: {error}")
        return with_finest_error(dataset, method)


def read_reference(study: Study) -> xr.Dataset | None:
    """The result of the reference study; None if the study names none."""
    result = study.compared.reference_result
    return None if result is None else read_study(result)


def outcomes(study: Study, out: Path) -> list[Outcome]:
    """The outcomes of the cases of a study, in their order."""
    folder = case_folder(out, study)
    check_folder(out, folder.parent, folder)
    return [read_outcome(folder, case, study.timing_repeats) for case in study.cases]


def outcomes_of(dataset: xr.Dataset) -> list[Outcome]:
    """The outcomes of the cases of a collected dataset; only completed cases have times."""
    seconds = np.nan_to_num(over_cases(dataset, "case_time")).tolist()
    same_sources = [dataset.attrs.get(SOURCES, "")] * len(seconds)
    sources = over_cases(dataset, SOURCES) if SOURCES in dataset else same_sources
    reasons = np.where(np.isfinite(uncertainty_of(dataset)), "", reasons_of(dataset)).tolist()
    texts = over_cases(dataset, "status"), over_cases(dataset, "message")
    rows = zip(*texts, seconds, sources, reasons, strict=True)
    return [
        Outcome(str(status), str(message), seconds=time, sources=str(digest), reason=reason)
        for status, message, time, digest, reason in rows
    ]


def tell_of_other_sources(name: str, outcomes: Sequence[Outcome]) -> None:
    """Print one line on how many results of a study were computed by other sources.

    The version of a scene stays the same when a kernel of the simulator, or only a comment, is
    edited. Whether the numbers change is unknown, so such results are kept. Laws and parts of other
    packages have no version, so results of their earlier sources are `outdated` and run again. A
    result whose file does not state its sources is counted too.
    """
    computed = [it for it in outcomes if it.status in (COMPLETED, OUTDATED)]
    edited = Counter(package for it in computed for package in edited_packages(it.sources))
    for package, count in edited.items():
        number = f"{name}: {count} of {counted(len(computed), 'result')} computed by other"
        if package == SIMULATOR:
            tell(
                f"{number} sources of the simulator, of the same version; kept: `harness run "
                "--fresh` computes them anew"
            )
        else:
            tell(f"{number} sources of {package}; `harness run` computes them anew")


def status_rows(cases: Sequence[tuple[str, str]], outcomes: Sequence[Outcome]) -> list[str]:
    """The table of `status`: a line for each case, given by key and label, and a summary."""
    rows = [f"{'case':16}  {'status':10}  {'time':>9}  parameters"]
    for (key, label), outcome in zip(cases, outcomes, strict=True):
        time = f"{outcome.seconds:.1f} s" if outcome.seconds else ""
        message = outcome.message or without_half_width(outcome.reason)
        why = f": {message}" if message else ""
        rows.append(f"{key}  {outcome.status:10}  {time:>9}  {label}{why}")
    note = [f"U: {HALF_WIDTH}"] if any(outcome.reason for outcome in outcomes) else []
    return [*rows, summary(outcomes), *note]


def tracebacks(study: Study, out: Path) -> list[str]:
    """The tracebacks of the failed cases of a study, from their files."""
    lines = []
    for case in study.cases:
        with suppress(ArchiveError):  # the table of `status` says why
            if text := read_attributes(case_file(case_folder(out, study), case)).get(TRACEBACK):
                lines += ["", f"{case.key}  {case.label}", str(text).rstrip()]
    return lines or ["no case has failed by an error of the program"]


def summary(outcomes: Sequence[Outcome]) -> str:
    """The number of cases of each status and their total time, in words."""
    counts = Counter(outcome.status for outcome in outcomes)
    statuses = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    seconds = sum(outcome.seconds for outcome in outcomes)
    return f"{counted(len(outcomes), 'case')}: {statuses}; {seconds:.1f} s in all"


Parameters = Mapping[str, Value | None]


@dataclass(frozen=True)
class StrayFile:
    """A file, or a link, that does not belong to a study."""

    path: Path
    what: str  # description
    identity: tuple[int, int, int]  # differs from that of a later file with the same name


def stray_files(study: Study, out: Path) -> list[StrayFile]:
    """Files that do not belong to the study as it is now.

    These are damaged files, results of cases that the study does not have (with other parameters,
    or of another version of the scene), and half-written files of killed processes. What the
    harness cannot read, or is no result of a case, is kept, and one line says so.
    """
    check_no_link(out, study)
    folder = case_folder(out, study)
    check_folder(out, folder.parent, folder)
    found = {path: "half-written" for place in (out, folder) for path in abandoned(place)}
    own = {file(folder, case) for case in study.cases for file in (case_file, fields_file)}
    keys, shared = {case.key for case in study.cases}, _shared_parameters(study.cases)
    for path in sorted(folder.glob("*.nc")):
        try:
            attributes = read_attributes(path)
        except DamagedError as error:
            found[path] = str(error).removeprefix(f"{path}: ")
        except ArchiveError as error:
            tell(f"{error}; kept")
        else:
            if "case_key" not in attributes:
                tell(f"{path}: is no result of a case; kept")
            elif path not in own or attributes["case_key"] != path.name.partition(".")[0]:
                found[path] = _described(attributes, keys, shared)
    return [StrayFile(path, what, _identity(path)) for path, what in found.items()]


def remove_stray(found: Iterable[StrayFile]) -> int:
    """Remove files; return how many were removed. For each of the others one line says why not.

    A file that was replaced since it was found is kept, because a run may have completed the case.
    """
    count = 0
    for file in found:
        try:
            if _identity(file.path) != file.identity:
                tell(f"{file.path}: was written anew meanwhile; kept")
                continue
            remove_file(file.path)
        except FileNotFoundError:
            continue
        except ArchiveError as error:
            tell(str(error))
        else:
            count += 1
    return count


def _identity(path: Path) -> tuple[int, int, int]:
    stat = path.lstat()
    return stat.st_ino, stat.st_mtime_ns, stat.st_size


def _described(
    attributes: Mapping[str, Any], keys: Container[str], shared: Mapping[str, Parameters]
) -> str:
    """Describe a file in the folder of a study's cases that belongs to none of these cases.

    `keys` are those of the cases; `shared` has, by scene, the parameters that are the same in all.
    """
    key, scene = attributes["case_key"], attributes["scene"]
    if key in keys:
        return f"a copy of case {key}"
    result = f"{scene} version {attributes['scene_version']}, {attributes['status']}"
    if scene not in shared:
        return f"no case of this study: {result}: another scene"
    parameters = json.loads(attributes["parameters"])
    others = [
        f"{name}={value}"
        for name, value in parameters.items()
        if (name, value) not in shared[scene].items()
    ]
    return f"no case of this study: {result}: {', '.join(others) or 'the same parameters'}"


def _shared_parameters(cases: Sequence[Case]) -> dict[str, Parameters]:
    """By scene, the parameters that are the same in all of its cases."""
    shared: dict[str, Parameters] = {}
    for case in cases:
        before = shared.get(case.scene, case.parameters)
        shared[case.scene] = dict(before.items() & case.parameters.items())
    return shared
