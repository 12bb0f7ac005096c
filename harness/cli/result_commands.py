"""Commands on results: beside the literature and each other, as pictures, as a page.

What computes is imported by the command that needs it: help is at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.exit_codes import DONE, INCOMPLETE
from harness.errors import HarnessError, tell
from mpm_warp.scenes import scene_class

if TYPE_CHECKING:
    import xarray as xr


def compare(options: argparse.Namespace) -> int:
    """Print a result beside the literature, or beside another result."""
    from harness.archive.collection import read_study
    from harness.compare.cone_factor_table import cone_factor_table
    from harness.compare.cone_factors import NothingToCompareError
    from harness.compare.tolerances import ATTRIBUTE

    if options.tolerance is not None and options.other is None:
        raise HarnessError("--tolerance: is for two results; give OTHER, or put it into the study")
    dataset = read_study(options.file)
    if options.other is not None:
        return _compare_two(dataset, read_study(options.other), options.tolerance or 0.0)
    try:
        print(cone_factor_table(dataset))
    except NothingToCompareError as error:
        if ATTRIBUTE not in dataset.attrs:
            raise HarnessError(f"{options.file}: {error}") from None
    return list_misses(dataset)


def _compare_two(first: xr.Dataset, second: xr.Dataset, tolerance: float) -> int:
    from harness.compare.tolerances import difference_rows, differences, unshared

    found, lonely = differences(first, second)
    for line in unshared(first, second):
        tell(line)
    print(*difference_rows(found, tolerance), *lonely, sep="\n")
    return INCOMPLETE if lonely or any(it.size > tolerance for it in found) else DONE


def list_misses(dataset: xr.Dataset) -> int:
    """Tell which tolerances the results miss; the exit code."""
    from harness.compare.tolerances import ATTRIBUTE, misses

    lines = misses(dataset)
    for line in lines:
        tell(f"tolerance missed: {line}")
    if not lines and ATTRIBUTE in dataset.attrs:
        tell("all tolerances are kept")
    return INCOMPLETE if lines else DONE


def show(dataset: xr.Dataset, folder: Path) -> None:
    """Print the table and draw the pictures, as far as the scene has what they show."""
    from harness.compare.cone_factor_table import cone_factor_table
    from harness.compare.cone_factors import NothingToCompareError
    from harness.pictures.pictures import NothingToDrawError, draw

    try:
        print(cone_factor_table(dataset))
    except NothingToCompareError as error:
        tell(str(error))
    try:
        print(*draw(dataset, folder), sep="\n")
    except (NothingToCompareError, NothingToDrawError) as error:
        tell(str(error))


def plot(options: argparse.Namespace) -> int:
    """Draw the pictures of a result."""
    from harness.archive.atomic_files import prepare
    from harness.archive.collection import read_study
    from harness.pictures.pictures import NothingToDrawError, draw

    dataset = read_study(options.file)
    folder = options.out or options.file.parent
    prepare(folder)
    try:
        pictures = draw(dataset, folder)
    except NothingToDrawError as error:
        raise HarnessError(f"{options.file}: {error}") from None
    print(*pictures, sep="\n")
    return DONE


def report(options: argparse.Namespace) -> int:
    """Write a page on results."""
    from harness.archive.collection import read_study
    from harness.pictures.report import write_report

    write_report([read_study(file) for file in options.file], options.out)
    print(options.out)
    return DONE


def show_recommendation(options: argparse.Namespace) -> int:
    """Print the cheapest settings that keep an error."""
    from harness.compare.recommend import recommend, results_in

    scene_class(options.scene)
    found = recommend(options.scene, options.error, results_in(options.results))
    if found is None:
        print(f"{options.scene}: no settings in {options.results} reach {options.error:.2%}")
        return INCOMPLETE
    print(f"{options.scene}: {found}")
    return DONE
