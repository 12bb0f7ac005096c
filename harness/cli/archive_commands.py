"""Commands that look after the files of a study: how its cases stand, its dataset, what is left."""

from __future__ import annotations

import argparse
import sys

from harness.archive.atomic_files import prepare
from harness.archive.conventions import COMPLETED, DAMAGED, over_cases
from harness.archive.study_files import study_file
from harness.cli.exit_codes import DONE, INCOMPLETE
from harness.errors import tell
from harness.run import collect_and_clean as results
from harness.run.leftovers import leftovers, remove
from harness.study.study import load_study


def status(options: argparse.Namespace) -> int:
    """Print how the cases of a study stand."""
    study = load_study(options.study, options.set)
    stand = results.outcomes(study, options.out)
    print(*results.status_rows(study.cases, stand), sep="\n")
    results.tell_of_other_sources(study, stand)
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def collect(options: argparse.Namespace) -> int:
    """Write the dataset of a study out of the case files that there are."""
    study = load_study(options.study, options.set)
    results.check_begun(study, options.out)
    prepare(options.out)
    dataset = results.collect_and_write(study, options.out)
    stand = results.outcomes_of(dataset)
    for message, outcome in zip(over_cases(dataset, "message"), stand, strict=True):
        if outcome.status == DAMAGED:
            tell(f"{message}; `harness run` runs the case again")
    results.tell_of_other_sources(study, stand)
    tell(results.summary(stand))
    print(study_file(options.out, study))
    return DONE if all(outcome.status == COMPLETED for outcome in stand) else INCOMPLETE


def clean(options: argparse.Namespace) -> int:
    """Remove files that are no results of the study, where the user agrees."""
    study = load_study(options.study, options.set)
    found = leftovers(study, options.out)
    for leftover in found:
        print(f"{leftover.path}: {leftover.what}")
    if not found:
        tell("nothing to remove")
        return DONE
    if not options.yes and not _confirmed(f"remove {results.counted(len(found), 'file')}?"):
        tell("nothing removed")
        return INCOMPLETE
    count = remove(found)
    tell(f"{results.counted(count, 'file')} removed")
    return DONE if count == len(found) else INCOMPLETE


def _confirmed(question: str) -> bool:
    print(f"{question} [y/N] ", end="", file=sys.stderr, flush=True)
    answer = sys.stdin.readline()
    if not answer:  # closed: nobody can answer
        print(file=sys.stderr)
    return answer.strip().lower() in ("y", "yes")
