"""The command of the open benchmark."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Sequence

from harness.archive.atomic_files import prepare, write_whole
from harness.benchmark.cases import benchmark_cases, benchmark_folder, read_submissions
from harness.benchmark.own import run_benchmark
from harness.benchmark.score import case_rows, formulas, scores, summary_rows
from harness.cli.process import DONE, INCOMPLETE
from harness.errors import HarnessError, tell
from harness.pictures.benchmark import benchmark_figure
from harness.pictures.drawing.plot_parts import image, write_own
from harness.report.benchmark import benchmark_page


def benchmark(options: argparse.Namespace) -> int:
    """Run the cases as a submission, or score submissions."""
    if options.action == "run":
        if options.folder is None:
            raise HarnessError("benchmark run: name the folder of the submission")
        return INCOMPLETE if run_benchmark(options.folder, options.accuracy) else DONE
    cases = benchmark_cases()
    shipped = read_submissions(benchmark_folder() / "submissions")
    own = [] if options.folder is None else read_submissions(options.folder)
    given = {it.name: it for it in [*shipped, *own]}
    submissions = [*given.values(), *formulas(cases)]
    found = scores(cases, submissions, options.against)
    prepare(options.out)
    base = options.out / "benchmark"
    picture = image(benchmark_figure(found))
    write_whole(_csv(case_rows(found)).encode(), base.with_suffix(".csv"))
    write_own(picture, base.with_suffix(".png"))
    page = benchmark_page(submissions, found, picture, options.against)
    write_own(page.encode(), base.with_suffix(".html"))
    _print(case_rows(found))
    print()
    _print(summary_rows(found))
    tell(
        "exact cases: against the exact value; others: against "
        f"{options.against}, with its uncertainty; written: {base}.csv, .png, .html"
    )
    return DONE


def _csv(rows: Sequence[Sequence[str]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _print(rows: Sequence[Sequence[str]]) -> None:
    """A table, its columns as wide as what stands in them."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        print("  ".join(cells).rstrip())
