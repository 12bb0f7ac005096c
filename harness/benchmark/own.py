"""This program's own submission: each case is run by its scene, and kept as soon as it is done."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import xarray as xr

from harness.archive.atomic_files import prepare, write_csv, write_whole
from harness.archive.conventions import Role, with_role
from harness.archive.provenance import provenance
from harness.benchmark.cases import COLUMNS, BenchmarkCase, Result, benchmark_cases, read_results
from harness.errors import in_one_line, tell
from harness.study.tables import StudyError
from mpm_warp.errors import InaccurateRun, SimulationDiverged, UnfinishedRun
from mpm_warp.scenes import scene_class


def run_benchmark(folder: Path, accuracy: str) -> int:
    """Write a submission of all cases; those that the folder has already are not run again.

    Returns:
        How many cases did not complete; a line says why.

    Raises:
        StudyError: results are there that cannot be read, or are another submission's.
    """
    prepare(folder)
    path, meta, failed = folder / "results.csv", folder / "meta.toml", 0
    if meta.exists() and meta.read_text() != _meta(accuracy):
        raise StudyError(f"{meta}: is of another program, accuracy or machine; name a new folder")
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
        print(f"{case.name}: {results[case.name].value:.5g} {case.unit}", flush=True)
    return failed


def computed(case: BenchmarkCase, accuracy: str) -> Result:
    """Value, uncertainty and seconds of a case, kernels compiled before or not."""
    values = {**case.fixed, **case.accuracy[accuracy]}
    scene = scene_class(case.scene)(**values)
    start = time.perf_counter()
    found = scene.run()
    seconds = time.perf_counter() - start
    name, _, place = (it.strip() for it in case.result.partition("@"))
    stated = [it for it in with_role(found, Role.UNCERTAINTY) if it == f"{name}_uncertainty"]
    value, uncertainty = (
        _at(found[it], place) if it else math.nan for it in (name, next(iter(stated), ""))
    )
    return Result(value, uncertainty, seconds)


def _at(values: xr.DataArray, place: str) -> float:
    """A number of a result: itself, or where its coordinate has the value that `place` says."""
    if values.ndim:
        coordinate, _, number = place.partition("=")
        values = values.interp({coordinate: float(number)})
    return float(values)


def _rows(results: Mapping[str, Result]) -> Iterator[Sequence[str]]:
    yield COLUMNS
    for name, it in results.items():
        cells = (f"{it.value:.7g}", f"{it.uncertainty:.2g}", f"{it.seconds:.3g}")
        yield [name, *("" if cell == "nan" else cell for cell in cells)]


def _meta(accuracy: str) -> str:
    came = provenance()
    meta = {
        "author": "the mpm_warp developers",
        "code": "mpm_warp",
        "version": came["mpm_warp_version"],
        "method": "material points with B-bar cells of linear functions, adhesive contact",
        "mesh": f"accuracy {accuracy}; see the column of that name in cases.csv",
        "domain": "by the scenes, corrected to an infinite one where an uncertainty is stated",
        "speed": "by the scenes; the effect of inertia is part of the uncertainty",
        "machine": f"{came['processor']}, {came['cores']} cores",
        "uncertainty": "by laws of the error that were measured over meshes, windows and speeds",
    }
    return "".join(f'{key} = "{value}"\n' for key, value in meta.items())
