"""The commands on the files of a study: status, collect and clean."""

import argparse
import sys
from pathlib import Path

from harness.archive.atomic_files import ArchiveError, check_folder, prepare
from harness.archive.conventions import (
    COMPLETED,
    DAMAGED,
    MISSING,
    UNREADABLE,
    labels_of,
    over_cases,
)
from harness.archive.netcdf_files import read_attributes
from harness.archive.provenance import tell_of_other_version
from harness.archive.study_files import check_place, read_study, study_file
from harness.cli.process import DONE, INCOMPLETE
from harness.errors import HarnessError, counted, say, tell
from harness.run import collect_and_clean as results
from harness.study.files import study_names
from harness.study.study import load_study
from mpm_warp.scenes import scene_names


def status(options: argparse.Namespace) -> int:
    """Print the status of the cases of a study, or a line for each stored result."""
    name = options.study
    is_of_many = name is None or (name in scene_names() and name not in study_names())
    if (is_of_many or name.endswith(".nc")) and (options.set or options.traceback):
        raise HarnessError("--set and --traceback need a study; name it, or leave them out")
    if is_of_many:
        _list_results(options.out, name)
        return DONE
    if name.endswith(".nc"):
        dataset = read_study(Path(name))
        tell_of_other_version(Path(name), dataset)
        keys, labels = over_cases(dataset, "case_key").tolist(), labels_of(dataset)
        stand = results.outcomes_of(dataset)
        results.tell_of_other_sources(name, stand)
        say(*results.status_rows(list(zip(keys, labels, strict=True)), stand))
        return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE
    study = load_study(name, options.set)
    stand = results.outcomes(study, options.out)
    say(*results.status_rows([(case.key, case.label) for case in study.cases], stand))
    if options.traceback:
        say(*results.tracebacks(study, options.out))
    results.tell_of_other_sources(study.name, stand)
    file = study_file(options.out, study)
    if all(outcome.status == MISSING for outcome in stand) and file.exists():
        tell(
            f"{file} has other cases; they were run with other settings (then repeat each --set) "
            f"or another version of the scene; `harness status {file}` lists them"
        )
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def _list_results(folder: Path, scene: str | None) -> None:
    """Print a line for each result in a folder, of all scenes or of one."""
    check_folder(folder)
    rows = []
    for path in sorted(folder.glob("*.nc")):
        try:
            if "study" not in read_attributes(path):
                continue  # such as the result of a measured test
            dataset = read_study(path)
        except ArchiveError as error:
            tell(str(error))
            continue
        scenes = str(dataset.attrs["scene"])
        if scene is None or scene in scenes.split():
            tell_of_other_version(path, dataset)
            stand = results.outcomes_of(dataset)
            rows.append(f"{path}  {scenes}: {results.summary(stand)}")
    if not rows:
        of_scene = "" if scene is None else f" of {scene}"
        raise HarnessError(f"{folder}: has no results{of_scene}; `harness run STUDY` writes some")
    say(*rows)


def collect(options: argparse.Namespace) -> int:
    """Write the dataset of a study from its case files."""
    study = load_study(options.study, options.set)
    results.check_begun(study, options.out)
    check_place(study_file(options.out, study))
    prepare(options.out)
    dataset = results.collect_and_write(study, options.out)
    stand = results.outcomes_of(dataset)
    for message, outcome in zip(over_cases(dataset, "message"), stand, strict=True):
        if outcome.status == DAMAGED:
            tell(f"{message}; `harness run` runs the case again")
        elif outcome.status == UNREADABLE:
            tell(f"{message}; kept")
    results.tell_of_other_sources(study.name, stand)
    tell(results.summary(stand))
    say(study_file(options.out, study))
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def clean(options: argparse.Namespace) -> int:
    """Remove files that do not belong to the study, if the user agrees."""
    study = load_study(options.study, options.set)
    found = results.stray_files(study, options.out)
    for file in found:
        say(f"{file.path}: {file.what}")
    if not found:
        tell("nothing to remove")
        return DONE
    if not options.yes and not _confirmed(f"remove {counted(len(found), 'file')}?"):
        tell("nothing removed")
        return INCOMPLETE
    count = results.remove_stray(found)
    tell(f"{counted(count, 'file')} removed")
    return DONE if count == len(found) else INCOMPLETE


def _confirmed(question: str) -> bool:
    tell(f"{question} [y/N]")
    answer = sys.stdin.readline()
    return answer.strip().lower() in ("y", "yes")
