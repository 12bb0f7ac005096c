"""The commands that compute: run, bench, verify and benchmark."""

import argparse
import math
from collections.abc import Sequence

import xarray as xr
from tqdm import tqdm

from harness.archive.atomic_files import prepare, write_csv, write_whole
from harness.archive.conventions import COMPLETED, over_cases
from harness.archive.netcdf_files import write_netcdf
from harness.archive.own_files import MAKER, check_replaceable, write_own
from harness.archive.study_files import study_file
from harness.benchmark.cases import (
    benchmark_cases,
    benchmark_folder,
    read_submissions,
    run_benchmark,
)
from harness.benchmark.score import case_rows, formulas, scores, summary_rows
from harness.cli.commands.results import list_misses, show
from harness.cli.process import DONE, INCOMPLETE
from harness.compare.costs import bench_rows
from harness.errors import HarnessError, counted, say, tell
from harness.machine import usable_cores
from harness.pictures.drawing.plot_parts import write_figure
from harness.pictures.method.work_precision import checks_figure
from harness.report.plain_pages import benchmark_figure, benchmark_page
from harness.run.resources import RunOptions, spoken_time
from harness.run.run_study import on_cluster, on_this_machine, run_study
from harness.run.verify import HEADING, as_dataset, checks_of, quick, table_rows, verified_in_turn
from harness.study.description import warn_of_unusual_values
from harness.study.scene_part import loaded_scenes
from harness.study.study import Study, load_study, with_snapshots
from mpm_warp.fields.flat import parameters_of
from mpm_warp.provenance import provenance


def run(options: argparse.Namespace) -> int:
    """Run a study, show its result and list what is missing."""
    if options.dask is not None and options.case_timeout < math.inf:
        raise HarnessError("--case-timeout is not possible with --dask; leave one of them out")
    if options.dask is not None and (
        options.threads or options.device != "cpu" or options.memory_limit
    ):
        raise HarnessError(
            "--threads, --device and --memory-limit apply only to this machine; leave them out "
            "with --dask"
        )
    study = load_study(options.study, options.set)
    if options.uncertainty:
        _check_uncertainty(study)
        study = load_study(options.study, [*options.set, "uncertainty=measured"])
    if options.snapshots is not None:
        study = with_snapshots(study, options.snapshots)
    _ = study.cases  # made here so that mistakes are reported before anything starts
    warn_of_unusual_values(study)
    runner = (
        on_this_machine(
            study,
            options.workers,
            RunOptions(
                device=options.device,
                threads=options.threads,
                time_limit=options.case_timeout,
                memory_limit=options.memory_limit,
            ),
        )
        if options.dask is None
        else on_cluster(study, options.dask)
    )
    dataset = run_study(study, options.out, runner, fresh=options.fresh)
    undrawn = show(dataset, options.out, options.format, debug=options.debug)
    say(study_file(options.out, study))
    incomplete = _list_incomplete(study, dataset)
    return list_misses(dataset) or incomplete or undrawn


def _check_uncertainty(study: Study) -> None:
    """Refuse a study without a scene whose uncertainty further runs can measure."""
    names = [part.name for part in study.parts]
    if not any("uncertainty" in part.parameters for part in study.parts):
        measured = [
            name for name, it in loaded_scenes().items() if "uncertainty" in parameters_of(it)
        ]
        raise HarnessError(
            f"--uncertainty: cannot be measured for {', '.join(names)}, only for: "
            f"{', '.join(measured)}"
        )


def _list_incomplete(study: Study, dataset: xr.Dataset) -> int:
    status, message = over_cases(dataset, "status"), over_cases(dataset, "message")
    lost = [end for end in zip(study.cases, status, message, strict=True) if end[1] != COMPLETED]
    for case, how, why in lost:
        tell(f"{case.label}: {how}: {why}")
    return INCOMPLETE if lost else DONE


def bench(options: argparse.Namespace) -> int:
    """Measure what a step costs."""
    study = load_study("bench", options.set)
    runner = on_this_machine(study, None, RunOptions(device=options.device))
    dataset = run_study(study, options.out, runner, fresh=True)
    say(*bench_rows(dataset))
    say(study_file(options.out, study))
    return _list_incomplete(study, dataset)


SETTING_UP = 10.0
"""Time to start and compile many small checks, about [s]."""
VERIFIED_FILES = {"verify.nc": "observed order", "verify.txt": HEADING}
"""Files that `verify --out` writes, and a text in each by which an older one is recognised.

Only a recognised file is overwritten.
"""
VERIFIED_BAR = "{percentage:3.0f} % of the work |{bar}| {elapsed} < {remaining}"


def verify_scenes(options: argparse.Namespace) -> int:
    """Compare scenes with their exact solutions."""
    checks = checks_of(options.scene, extreme=options.extreme)
    if options.quick:
        asked, checks = checks, quick(checks)
        left = {it.scene for it in asked} - {it.scene for it in checks}
        if options.scene and left:
            tell(f"--quick: these scenes have no quick check: {', '.join(sorted(left))}")
    if options.out is not None:
        prepare(options.out)
        pictures = {f"verify.{form}": MAKER for form in options.format}
        for name, mark in (VERIFIED_FILES | pictures).items():
            check_replaceable(options.out / name, mark)
    seconds = [check.predicted_time for check in checks]
    tell(
        f"{counted(len(checks), 'check')} of "
        f"{counted(len({check.scene for check in checks}), 'scene')}, about "
        f"{spoken_time(sum(seconds) / usable_cores() + SETTING_UP)} on a quiet machine"
    )
    lines, results = [HEADING], []
    say(lines[0])
    bar = tqdm(total=sum(seconds), disable=None, bar_format=VERIFIED_BAR, leave=False)
    for verified, its_own in zip(verified_in_turn(checks), seconds, strict=True):
        results.append(verified)
        lines.append(table_rows(verified))
        bar.clear()
        say(lines[-1])
        bar.update(its_own)
        if options.out is not None:
            dataset = as_dataset(results).assign_attrs(provenance())
            write_netcdf(dataset, options.out / "verify.nc")
            write_whole("\n".join([*lines, ""]).encode(), options.out / "verify.txt")
    bar.close()
    if options.out is not None:
        write_figure(checks_figure(as_dataset(results)), options.out / "verify", options.format)
    return INCOMPLETE if any(result.shortfalls for result in results) else DONE


def benchmark(options: argparse.Namespace) -> int:
    """Run the cases as a submission, or score submissions."""
    if options.action == "run":
        if options.folder is None:
            raise HarnessError("benchmark run: name the folder of the submission")
        if options.against is not None:
            raise HarnessError("benchmark run: --against is only for score; leave it out")
        return INCOMPLETE if run_benchmark(options.folder, options.accuracy or "standard") else DONE
    if options.accuracy is not None:
        raise HarnessError("benchmark score: --accuracy is only for run; leave it out")
    against = options.against or "mpm_warp_standard"
    cases = benchmark_cases()
    shipped = read_submissions(benchmark_folder() / "submissions")
    own = [] if options.folder is None else read_submissions(options.folder)
    given = {submission.name: submission for submission in [*shipped, *own]}
    submissions = [*given.values(), *formulas(cases)]
    found = scores(cases, submissions, against)
    prepare(options.out)
    base = options.out / "benchmark"
    figure = benchmark_figure(found, against)
    write_csv(case_rows(found), base.with_suffix(".csv"))
    write_figure(figure, base, options.format)
    page = benchmark_page(submissions, found, figure, against)
    write_own(page.encode(), base.with_suffix(".html"))
    _print_table(case_rows(found))
    say()
    _print_table(summary_rows(found))
    tell(
        "scores are against the exact value where there is one, otherwise against "
        f"{against} with its uncertainty; written: {base}.csv, .{', .'.join(options.format)}, .html"
    )
    return DONE


def _print_table(rows: Sequence[Sequence[str]]) -> None:
    """Print a table with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        say("  ".join(cells).rstrip())
