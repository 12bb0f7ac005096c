"""The command that interprets a measured cone test."""

from __future__ import annotations

import argparse
import csv
import io
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import prepare, write_whole
from harness.archive.conventions import FORMAT_VERSION
from harness.archive.netcdf_files import write_netcdf
from harness.cli.process import DONE
from harness.errors import HarnessError, tell
from harness.interpret.measured import REASONS
from harness.interpret.site import load_site
from harness.interpret.strength import in_words, interpret
from harness.pictures.drawing.plot_parts import image, write_own
from harness.pictures.interpretation import interpretation_figure

COLUMNS = {
    "depth [m]": ("depth", 1.0),
    "qt [kPa]": ("total_resistance", 1e3),
    "sigma_v0 [kPa]": ("vertical_stress", 1e3),
    "u0 [kPa]": ("water_pressure", 1e3),
    "qnet [kPa]": ("net_resistance", 1e3),
    "Bq [1]": ("pore_pressure_ratio", 1.0),
    "Fr [1]": ("friction_ratio", 1.0),
    "Ic [1]": ("soil_index", 1.0),
}
"""Columns of the table that is written, beside those of percentiles."""


def interpret_site(options: argparse.Namespace) -> int:
    """Interpret the test of a site file; write dataset, table and picture; print what to quote."""
    site = load_site(options.site)
    points = read_points(options.laboratory) if options.laboratory else []
    found = interpret(site)
    prepare(options.out)
    base = options.out / f"{site.name}_interpretation"
    write_netcdf(found.assign_attrs(format_version=FORMAT_VERSION), base.with_suffix(".nc"))
    write_whole(_table(found).encode(), base.with_suffix(".csv"))
    for form in ("png", "svg"):
        write_own(image(interpretation_figure(found, points), form), base.with_suffix(f".{form}"))
    for sentence in in_words(site, found):
        print(sentence)
    left = [
        f"{count} {word}"
        for number, word in enumerate(REASONS)
        if number and (count := int((found.reason == number).sum()))
    ]
    if left:
        tell(f"depths without a strength, of {found.sizes['depth']}: {', '.join(left)}")
    tell(f"no design value, and no strength of drained soil; written: {base}.nc, .csv, .png, .svg")
    return DONE


def _table(found: xr.Dataset) -> str:
    """The result as CSV, a row a depth; "" where there is no number."""
    columns = {title: found[name].values / unit for title, (name, unit) in COLUMNS.items()}
    for name, title, unit in (
        ("resistance_factor", "Nkt {:g}% [1]", 1.0),
        ("strength", "su {:g}% [kPa]", 1e3),
    ):
        for percentile in found.percentile.values:
            values = found[name].sel(percentile=percentile).values / unit
            columns[title.format(percentile)] = values
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*columns, "reason"])
    numbers = np.stack(list(columns.values()), axis=-1)
    for row, reason in zip(numbers, found.reason.values, strict=True):
        writer.writerow([*("" if np.isnan(it) else f"{it:.6g}" for it in row), REASONS[reason]])
    return text.getvalue()


def read_points(path: Path) -> list[tuple[float, float]]:
    """Strengths of a laboratory: CSV with the columns depth [m] and strength [kPa].

    Raises:
        HarnessError: it cannot be read, or is no such table.
    """
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
        return [(float(it["depth [m]"]), 1e3 * float(it["strength [kPa]"])) for it in rows]
    except OSError as error:
        raise HarnessError(f"{path}: cannot be read: {error.strerror}") from None
    except (KeyError, TypeError, ValueError):
        raise HarnessError(
            f"{path}: must be CSV with the columns depth [m] and strength [kPa]"
        ) from None
