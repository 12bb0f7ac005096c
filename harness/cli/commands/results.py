"""The commands on results: compare, plot, report, recommend and view."""

import argparse
import itertools
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import xarray as xr

from harness.archive.atomic_files import prepare
from harness.archive.case_files import ENDING, find_fields, read_fields
from harness.archive.conventions import TOLERANCES
from harness.archive.own_files import NotOwnFileError, check_replaceable
from harness.archive.provenance import tell_of_other_version
from harness.archive.study_files import read_study
from harness.archive.vtk_files import write_vtk
from harness.cli.process import DONE, INCOMPLETE
from harness.compare.compared import NothingToCompareError, misses
from harness.compare.costs import recommend, results_in
from harness.compare.differences import difference_rows, differences, unshared
from harness.compare.result_table import result_table
from harness.errors import HarnessError, defect, say, tell
from harness.pictures.drawing.plot_parts import write_figure
from harness.pictures.pictures import Failures, NothingToDrawError, draw
from harness.pictures.soil import sections_figure, traction_figure, write_animation
from harness.references.registry import UnknownReferenceError
from harness.report.report import write_report
from harness.run.collect_and_clean import outcomes_of, tell_of_other_sources
from harness.study.tables import StudyError


def compare(options: argparse.Namespace) -> int:
    """Print a result beside the literature, or beside another result."""
    if options.tolerance is not None and options.other is None:
        raise HarnessError(
            "--tolerance: needs a second result OTHER; tolerances of one result are in its study"
        )
    if options.format != "text" and options.other is not None:
        raise HarnessError("--format: is for the table of a single result; leave OTHER out")
    dataset = _read(options.file)
    if options.other is not None:
        return _compare_two(dataset, _read(options.other), options.tolerance or 0.0)
    with _result_of(options.file):
        try:
            say(result_table(dataset, options.format))
        except NothingToCompareError:
            if TOLERANCES not in dataset.attrs:
                raise
        return list_misses(dataset)


def _read(file: Path) -> xr.Dataset:
    """Read the result of a study; lines say what has another version of its scene, or sources."""
    dataset = read_study(file)
    tell_of_other_version(file, dataset)
    tell_of_other_sources(str(file), outcomes_of(dataset))
    return dataset


@contextmanager
def _result_of(*files: Path) -> Iterator[None]:
    """Name the file in errors that its content causes, such as an unknown reference."""
    try:
        yield
    except (NothingToCompareError, NothingToDrawError, StudyError, UnknownReferenceError) as error:
        raise HarnessError(f"{', '.join(map(str, files))}: {error}") from None


def _compare_two(first: xr.Dataset, second: xr.Dataset, tolerance: float) -> int:
    found, lonely = differences(first, second)
    for line in unshared(first, second):
        tell(line)
    say(*difference_rows(found, tolerance), *lonely)
    return (
        INCOMPLETE if lonely or any(difference.size > tolerance for difference in found) else DONE
    )


def list_misses(dataset: xr.Dataset) -> int:
    """Print which tolerances are missed; return the exit code."""
    missed = misses(dataset)
    for line in itertools.chain(*missed.values()):
        tell(f"tolerance missed: {line}")
    if not missed and TOLERANCES in dataset.attrs:
        tell("all tolerances are met")
    return INCOMPLETE if missed else DONE


def show(dataset: xr.Dataset, folder: Path, forms: Sequence[str], *, debug: bool) -> int:
    """Print the table and draw the pictures that fit the result; return the exit code."""
    try:
        say(result_table(dataset))
    except NothingToCompareError as error:
        tell(str(error))
    try:
        return _list_pictures(*draw(dataset, folder, forms), debug=debug)
    except (NotOwnFileError, NothingToDrawError) as error:
        tell(str(error))
    return DONE


def _list_pictures(paths: list[Path], failed: Failures, *, debug: bool) -> int:
    """Print which pictures were written and which failed; return the exit code."""
    for path in paths:
        say(path)
    for name, error in failed.items():
        if debug:
            traceback.print_exception(error)
        tell(f"the picture {name} could not be drawn: {defect(error)}")
    return INCOMPLETE if failed else DONE


def plot(options: argparse.Namespace) -> int:
    """Draw the pictures of a result."""
    dataset = _read(options.file)
    folder = options.out or options.file.parent
    prepare(folder)
    with _result_of(options.file):
        drawn = draw(dataset, folder, options.format)
    return _list_pictures(*drawn, debug=options.debug)


def report(options: argparse.Namespace) -> int:
    """Write a page on results."""
    check_replaceable(options.out)  # first, because drawing takes time
    datasets = [_read(file) for file in options.file]
    prepare(options.out.parent)
    with _result_of(*options.file):
        failed = write_report(datasets, options.out)
    return _list_pictures([options.out], failed, debug=options.debug)


def show_recommendation(options: argparse.Namespace) -> int:
    """Print the cheapest settings whose error is small enough."""
    found = recommend(options.scene, options.error, results_in(options.results))
    if found.error > options.error:
        reach = f"no settings in {options.results} reach {options.error:.2%}"
        say(f"{options.scene}: {reach}; the nearest: {found}")
        return INCOMPLETE
    say(f"{options.scene}: {found}")
    return DONE


def view(options: argparse.Namespace) -> int:
    """Draw the sections and the traction of the last snapshot, and a film of all of them."""
    path = find_fields(options.file, options.case)
    fields = read_fields(path)
    tell_of_other_version(path, fields)
    folder = options.out or options.file.parent
    prepare(folder)
    name = path.name.removesuffix(ENDING)
    # VTK first: if it cannot be written, nothing is drawn.
    series = write_vtk(fields, folder, name)[:1] if options.vtk else []
    written: list[Path] = []
    for kind, figure in (("sections", sections_figure), ("traction", traction_figure)):
        written += write_figure(figure(fields), folder / f"{name}_{kind}", options.format)
    written += write_animation(fields, folder / f"{name}_animation.gif")
    say(*written, *series)
    return DONE
