"""One page of HTML on results, with all that they hold and nothing to be fetched."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.atomic_files import write_whole
from harness.archive.conventions import COMPLETED, Role, limits_of, over_cases, spoken, with_role
from harness.archive.provenance import OF_CASE
from harness.compare.cone_factor_table import cone_factor_table
from harness.compare.cone_factors import NothingToCompareError
from harness.compare.finest_error import error_name
from harness.compare.tolerances import misses
from harness.pictures.pictures import figures
from harness.pictures.plot_parts import FAILED, png
from harness.pictures.stability import shows_stability
from harness.pictures.stability_map import stability_rows

STYLE = """
body { font: 15px/1.5 sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222 }
h1, h2, h3 { font-weight: 600 } h2 { border-top: 1px solid #ccc; padding-top: 1em }
table { border-collapse: collapse; font-size: 13px; display: block; overflow-x: auto }
td, th { padding: .2em .7em; text-align: left; border-bottom: 1px solid #ddd; white-space: nowrap }
pre { font-size: 12px; overflow-x: auto; background: #f6f6f6; padding: 1em }
img { max-width: 48em; width: 100% }
"""
STYLE += f".bad {{ color: {FAILED} }}\n"


def write_report(datasets: Sequence[xr.Dataset], path: Path) -> None:
    """Write the page, whole or not at all.

    Args:
        datasets: results of studies.
        path: the HTML file; an earlier one is replaced.

    Raises:
        ArchiveError: it cannot be written.
    """
    write_whole(page(datasets).encode(), path)


def page(datasets: Sequence[xr.Dataset]) -> str:
    """The page as text: title, parameters, provenance, table, pictures and cases of each result."""
    titles = [str(dataset.attrs.get("title", "")) for dataset in datasets]
    body = "\n".join(_section(dataset) for dataset in datasets)
    return (
        "<!DOCTYPE html>\n"
        f'<html lang="en"><head><meta charset="utf-8"><title>{_text("; ".join(titles))}</title>'
        f"<style>{STYLE}</style></head><body>\n<h1>Report</h1>\n{body}\n</body></html>\n"
    )


def _section(dataset: xr.Dataset) -> str:
    parts = [f"<h2>{_text(dataset.attrs.get('title', dataset.attrs['study']))}</h2>"]
    missed = misses(dataset)
    parts += [f'<p class="bad">{_text(line)}</p>' for line in missed]
    try:
        parts.append(f"<pre>{_text(cone_factor_table(dataset))}</pre>")
    except NothingToCompareError as error:
        parts.append(f"<p>{_text(error)}</p>")
    parts += [_picture(name, figure) for name, figure in figures(dataset).items()]
    if shows_stability(dataset):
        heading, *rows = stability_rows(dataset)
        parts += ["<h3>Stability</h3>", _table(heading, rows)]
    parts += ["<h3>Cases</h3>", _cases(dataset)]
    parts += ["<h3>Fixed parameters</h3>", _table(("parameter", "value", "unit"), _fixed(dataset))]
    parts += ["<h3>Provenance</h3>", _table(("attribute", "value"), _provenance(dataset))]
    return "\n".join(parts)


def _cases(dataset: xr.Dataset) -> str:
    dims = dataset["status"].dims
    varied = [name for name, it in dataset.coords.items() if it.dims and set(it.dims) <= set(dims)]
    wanted = (
        *with_role(dataset, Role.HEADLINE),
        error_name(dataset),
        *limits_of(dataset),
        *("run_time", "peak_memory", "message"),
    )
    shown = [name for name in wanted if name in dataset and dataset[name].dims == dims]
    names = list(dict.fromkeys(map(str, (*varied, "status", *shown))))
    columns = [over_cases(dataset, name) for name in names]
    good = over_cases(dataset, "status") == COMPLETED
    heading = "".join(f"<th>{_text(spoken(name))}</th>" for name in names)
    rows = []
    for case, values in enumerate(zip(*columns, strict=True)):
        cells = "".join(f"<td>{_text(_shown(value))}</td>" for value in values)
        rows.append(f"<tr>{cells}</tr>" if good[case] else f'<tr class="bad">{cells}</tr>')
    return f"<table><tr>{heading}</tr>{''.join(rows)}</table>"


def _fixed(dataset: xr.Dataset) -> Iterable[tuple[str, str, str]]:
    for name in with_role(dataset, Role.PARAMETER):
        if dataset[name].ndim == 0:
            unit = str(dataset[name].attrs.get("units", ""))
            yield name, _shown(dataset[name].item()), unit


def _provenance(dataset: xr.Dataset) -> Iterable[tuple[str, str]]:
    yield from ((str(name), str(value)) for name, value in dataset.attrs.items())
    for name in OF_CASE:
        if name in dataset:  # not the same for all cases
            yield name, "; ".join(sorted({*map(str, dataset[name].values.flat)} - {""}))


def _table(heading: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    first = "".join(f"<th>{_text(name)}</th>" for name in heading)
    rest = "".join(f"<tr>{''.join(f'<td>{_text(it)}</td>' for it in row)}</tr>" for row in rows)
    return f"<table><tr>{first}</tr>{rest}</table>"


def _picture(name: str, figure: Figure) -> str:
    data = base64.b64encode(png(figure)).decode("ascii")
    return f'<p><img alt="{_text(name)}" src="data:image/png;base64,{data}"></p>'


def _shown(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float | np.floating) else str(value)


def _text(value: object) -> str:
    return html.escape(str(value))
