"""Cases of the benchmark, and submissions: the results of a code with their uncertainty and time.

A submission is a folder of two files. `meta.toml` says who computed and by what means.
`results.csv` has a row for each case: ``case,value,uncertainty,seconds``. An unknown number stays
empty. This program writes its own submission case by case.
"""

import csv
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from harness.archive.atomic_files import prepare, write_csv, write_whole
from harness.archive.conventions import Role, with_role
from harness.errors import in_one_line, say, tell
from harness.study.files import read_text, read_toml, studies_folder
from harness.study.tables import StudyError, Table, parse_setting, text_key
from mpm_warp.errors import InaccurateRun, SimulationDiverged, UnfinishedRun
from mpm_warp.fields.names import nearest_name
from mpm_warp.fields.plain_numbers import number_of, plain_number
from mpm_warp.provenance import provenance
from mpm_warp.scenes import scene_class

META_KEYS: Mapping[str, str] = {
    "author": "who computed the results, for questions",
    "code": "name of the code, or of the formula",
    "version": "of the code",
    "method": "material points, finite elements, ...; element or shape functions, contact",
    "mesh": "cells at the penetrometer, and how they grow",
    "domain": "extent of the soil",
    "speed": "of the penetrometer, and what it was compared with",
    "machine": "processor, cores, memory used",
    "uncertainty": "how the uncertainty was found, or 'not stated'",
}
"""Keys of `meta.toml`, all required texts, with their meaning."""
COLUMNS = ("case", "value", "uncertainty", "seconds")
"""Columns of `results.csv`: the uncertainty is the half width of 95 % in the unit of the value;
seconds are wall-clock time."""


@dataclass(frozen=True, kw_only=True)
class BenchmarkCase:
    """One case of the benchmark, and the scene of this program that computes it."""

    name: str
    phase: int  # 1 exact anchors, 2 cone factors, 3 layers and gradients
    title: str
    unit: str
    exact: tuple[float, float] | None  # bounds of the exact value; None if it is unknown
    scene: str
    result: str  # the variable of the scene's dataset, "NAME" or "NAME @ COORDINATE=NUMBER"
    fixed: Mapping[str, float | str]  # parameters of the scene
    accuracy: Mapping[str, Mapping[str, float | str]]  # further parameters by `ACCURACIES`


@dataclass(frozen=True)
class Result:
    """The result of a case: value, uncertainty and time [s]; the last two are NaN if not given."""

    value: float
    uncertainty: float
    seconds: float


@dataclass(frozen=True)
class Submission:
    """The results of one code."""

    name: str  # name of its folder
    meta: Mapping[str, str]  # values of `META_KEYS`
    results: Mapping[str, Result]  # by case


ACCURACIES = ("quick", "standard", "fine")


def benchmark_folder() -> Path:
    """Folder of the benchmark's cases, and of the submissions that come with this program."""
    return studies_folder() / "benchmark"


def benchmark_cases() -> tuple[BenchmarkCase, ...]:
    """All cases of the benchmark, in their order."""
    path = benchmark_folder() / "cases.csv"
    return tuple(
        BenchmarkCase(
            name=row["case"],
            phase=int(number_of(row["phase"])),
            title=row["title"],
            unit=row["unit"],
            exact=(number_of(row["exact_low"]), number_of(row["exact_high"]))
            if row["exact_low"]
            else None,
            scene=row["scene"],
            result=row["result"],
            fixed=dict(map(parse_setting, row["parameters"].split())),
            accuracy={name: dict(map(parse_setting, row[name].split())) for name in ACCURACIES},
        )
        for row in csv.DictReader(read_text(path, "a table of cases").splitlines())
    )


def read_submissions(folder: Path) -> list[Submission]:
    """The submissions in a folder, sorted by name, or the one that the folder itself is.

    Hidden folders are ignored.
    """
    if (folder / "meta.toml").exists() or (folder / "results.csv").exists():
        return [read_submission(folder)]
    found = [path for path in sorted(folder.glob("[!.]*")) if path.is_dir()]
    if not found:
        raise StudyError(f"{folder}: has no submission, a folder with meta.toml and results.csv")
    return [read_submission(path) for path in found]


def read_submission(folder: Path) -> Submission:
    """Read a submission."""
    table = Table(f"{folder / 'meta.toml'}:", read_toml(folder / "meta.toml"))
    table.allow(*META_KEYS)
    meta = {key: table.read(text_key(key, meaning)) for key, meaning in META_KEYS.items()}
    return Submission(folder.name, meta, read_results(folder / "results.csv"))


def read_results(path: Path) -> dict[str, Result]:
    """The rows of `results.csv` by case."""
    lines = read_text(path, "a table of results").splitlines()
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines)]
    if not rows or tuple(rows[0]) != COLUMNS:
        raise StudyError(f"{path}: its first row must be {','.join(COLUMNS)}")
    known, results = [case.name for case in benchmark_cases()], {}
    for number, row in enumerate(rows[1:], start=2):
        where = f"{path}: row {number}"
        if len(row) != len(COLUMNS):
            raise StudyError(f"{where}: has {len(row)} cells, must have {len(COLUMNS)}")
        name = row[0]
        if name not in known:
            raise StudyError(f"{where}: case {name!r} is unknown{nearest_name(name, known)}")
        if name in results:
            raise StudyError(f"{where}: case {name} is listed twice")
        results[name] = Result(*_numbers(where, row[1:]))
    if not results:
        raise StudyError(f"{path}: has no results")
    return results


def _numbers(where: str, cells: Sequence[str]) -> list[float]:
    """Value, uncertainty and seconds; the last two may be empty."""
    numbers = []
    for name, cell in zip(COLUMNS[1:], cells, strict=True):
        number = plain_number(cell) if cell or name == "value" else math.nan
        if number is None:
            raise StudyError(f"{where}: {name} = {cell[:40]!r} must be a finite number")
        if name != "value" and number <= 0.0:
            raise StudyError(f"{where}: {name} = {cell} must be > 0, or empty if unknown")
        numbers.append(number)
    return numbers


def run_benchmark(folder: Path, accuracy: str) -> int:
    """Write a submission of all cases; return how many did not complete, each told in a line.

    Cases with a result in the folder are not run again. A folder of another submission is refused.
    """
    prepare(folder)
    path, meta, failed = folder / "results.csv", folder / "meta.toml", 0
    if meta.exists() and read_text(meta, "a submission") != _meta(accuracy):
        raise StudyError(f"{meta}: is from another program, accuracy or machine; name a new folder")
    results = read_results(path) if path.exists() else {}
    for case in benchmark_cases():
        if case.name in results:
            continue
        try:
            results[case.name] = computed(case, accuracy)
        except (InaccurateRun, SimulationDiverged, UnfinishedRun) as error:
            failed += 1
            tell(f"{case.name}: {in_one_line(error)}")
            continue
        write_whole(_meta(accuracy).encode(), meta)
        write_csv(_rows(results), path)
        say(f"{case.name}: {results[case.name].value:.5g} {case.unit}")
    return failed


def computed(case: BenchmarkCase, accuracy: str) -> Result:
    """Compute value, uncertainty and seconds of a case."""
    values = {**case.fixed, **case.accuracy[accuracy]}
    scene = scene_class(case.scene)(**values)
    start = time.perf_counter()
    found = scene.run()
    seconds = time.perf_counter() - start
    name, _, place = (word.strip() for word in case.result.partition("@"))
    half_width = f"{name}_uncertainty"
    is_stated = half_width in with_role(found, Role.UNCERTAINTY)
    uncertainty = _at(found[half_width], place) if is_stated else math.nan
    return Result(_at(found[name], place), uncertainty, seconds)


def _at(values: xr.DataArray, place: str) -> float:
    """The number of a scalar, or of a curve at `place`, such as "depth=10"."""
    if values.ndim:
        coordinate, _, number = place.partition("=")
        values = values.interp({coordinate: number_of(number)})
    return float(values)


def _rows(results: Mapping[str, Result]) -> Iterator[Sequence[str]]:
    yield COLUMNS
    for name, result in results.items():
        cells = (f"{result.value:.7g}", f"{result.uncertainty:.2g}", f"{result.seconds:.3g}")
        yield [name, *("" if cell == "nan" else cell for cell in cells)]


def _meta(accuracy: str) -> str:
    origin = provenance()
    meta = {
        "author": "the mpm_warp developers",
        "code": "mpm_warp",
        "version": origin["mpm_warp_version"],
        "method": "material points with B-bar cells of linear functions, adhesive contact",
        "mesh": f"accuracy {accuracy}; see the column of that name in cases.csv",
        "domain": "by the scenes, corrected to an infinite one where an uncertainty is stated",
        "speed": "by the scenes; the effect of inertia is part of the uncertainty",
        "machine": f"{origin['processor']}, {origin['cores']} cores",
        "uncertainty": "by laws of the error that were measured over meshes, windows and speeds",
    }
    return "".join(f'{key} = "{value}"\n' for key, value in meta.items())
