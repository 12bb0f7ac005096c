"""The command that interprets measured cone tests."""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError, prepare, write_csv
from harness.archive.netcdf_files import read_attributes, write_netcdf
from harness.archive.own_files import check_replaceable, not_own, write_own
from harness.cli.process import DONE
from harness.errors import HarnessError, say, tell
from harness.interpret.check import checked, misfit_in_words, sounding_of
from harness.interpret.laboratory import refuse_shared
from harness.interpret.lines import TITLES, line_table, lines_in_words
from harness.interpret.measured import REASONS
from harness.interpret.result import (
    in_words,
    laboratory_in_words,
    laboratory_points,
    tests_in_words,
)
from harness.interpret.site import load_site
from harness.interpret.strength import interpret, laboratory_beside
from harness.pictures.drawing.plot_parts import write_figure
from harness.pictures.measured.interpreted import (
    check_figure,
    interpretation_figure,
    soundings_figure,
)
from harness.report.plain_pages import Interpreted, interpretation_page
from harness.run.resources import UPDATE_RATE
from mpm_warp.errors import InaccurateRun, ParameterError, SceneError, SimulationDiverged
from mpm_warp.provenance import provenance

COLUMNS = {
    "depth [m]": ("depth", 1.0),
    "qc [kPa]": ("cone_resistance", 1e3),
    "fs [kPa]": ("sleeve_friction", 1e3),
    "u2 [kPa]": ("pore_pressure", 1e3),
    "qt [kPa]": ("total_resistance", 1e3),
    "error of qt [kPa]": ("total_resistance_error", 1e3),
    "sigma_v0 [kPa]": ("vertical_stress", 1e3),
    "u0 [kPa]": ("water_pressure", 1e3),
    "qnet [kPa]": ("net_resistance", 1e3),
    "qnet without borders [kPa]": ("sharpened_resistance", 1e3),
    "Bq [1]": ("pore_pressure_ratio", 1.0),
    "Fr [1]": ("friction_ratio", 1.0),
    "Ic [1]": ("soil_index", 1.0),
    "feels another layer": ("near_border", 1.0),
}
"""Columns of the table, with their variables and units; those of percentiles and causes follow."""
TABLE = ",".join([*COLUMNS][:9])
"""Beginning of each table, by which the harness recognises its own."""
ENDING, CHECK_ENDING, LINES = "_interpretation", "_check", "_lines.csv"
TOGETHER = "soundings"
"""Name of the files on several tests together."""


def interpret_site(options: argparse.Namespace) -> int:
    """Interpret the tests of site files; print the results; write data, pictures and a page."""
    if options.laboratory and len(options.site) > 1:
        raise HarnessError(
            "--laboratory is of one sounding; of several, [[laboratory]] of each site file has the "
            "tests beside it"
        )
    sites = [load_site(path, options.laboratory) for path in options.site]
    names = [site.name for site in sites]
    if len(names) > 1 and (
        twice := [name for name in names if names.count(name) > 1 or name == TOGETHER]
    ):
        raise HarnessError(f"{twice[0]}.toml: another result has this name; rename the site file")
    refuse_shared({site.name: site.laboratory for site in sites})
    laboratory = [laboratory_beside(site, sharpen=options.sharpen) for site in sites]
    tests = []
    for place, (path, site) in enumerate(zip(options.site, sites, strict=True)):
        others = [*laboratory[:place], *laboratory[place + 1 :]]
        beside = [layer for sounding in others for layer in sounding]
        found = interpret(site, sharpen=options.sharpen, beside=beside)
        picture = interpretation_figure(found, laboratory_points(found))
        tests.append(Interpreted(path, site, found, picture))
    whole = f"{options.out}/{names[0] if len(names) == 1 else TOGETHER}{ENDING}"
    endings = (ENDING, CHECK_ENDING) if options.check else (ENDING,)
    titles = {f"{options.out}/{it.name}{end}": it.title for it in sites for end in endings}
    _check_targets(titles, whole, options.format)
    prepare(options.out)
    for test in tests:
        _write(test, f"{options.out}/{test.site.name}{ENDING}", options.format)
    together = None
    if len(names) > 1:
        found_of_all = [measured.found for measured in tests]
        together = soundings_figure(found_of_all, [laboratory_points(it) for it in found_of_all])
        write_figure(together, whole, options.format)
    write_own(interpretation_page(tests, together).encode(), Path(f"{whole}.html"))
    tell(f"no design value, and no strength of drained soil; a page of all: {whole}.html")
    for test in tests if options.check else ():
        base = f"{options.out}/{test.site.name}{CHECK_ENDING}"
        _check(test, options.check, base, options.format)
    return DONE


def _check_targets(titles: Mapping[str, str], whole: str, forms: Sequence[str]) -> None:
    """Refuse to replace files that are not of the harness; name those of another site.

    Args:
        titles: title of the site, by the path of its results without ending.
        whole: path of the page and of the picture of several tests, without ending.
        forms: formats of the pictures.
    """
    for base in dict.fromkeys([*titles, whole]):
        for form in forms:
            check_replaceable(Path(f"{base}.{form}"))
    check_replaceable(Path(f"{whole}.html"))
    others = {}
    for base, title in titles.items():
        if base.endswith(ENDING):
            check_replaceable(Path(f"{base}.csv"), TABLE)
            check_replaceable(Path(f"{base}{LINES}"), ",".join(TITLES))
        path = Path(f"{base}.nc")
        if path.exists() and (before := _title_of(path)) != title:
            others[path] = before
    for path, before in others.items():
        tell(
            f'{path}: was of a site with another title, "{before}", and is replaced; '
            "`--out FOLDER` keeps two of one name apart"
        )


def _title_of(path: Path) -> str:
    """Title of the site of a dataset; damaged files and files of other programs are refused."""
    try:
        said = read_attributes(path)
    except ArchiveError as error:
        raise ArchiveError(f"{error}; remove it, or give another --out") from None
    if "site" not in said:
        raise not_own(path)
    return str(said["title"])


def _write(test: Interpreted, base: str, forms: Sequence[str]) -> None:
    """Write the results of a test; print the sentences to quote and the depths left out."""
    found = test.found
    _write_data(found, base)
    write_csv(_table(found), Path(f"{base}.csv"))
    write_csv(line_table(test.site, found), Path(f"{base}{LINES}"))
    write_figure(test.figure, base, forms)
    words = [*in_words(test.site, found), *laboratory_in_words(test.site, found)]
    say(*words, *tests_in_words(found), *lines_in_words(found))
    left = [
        f"{count} {word}"
        for number, word in enumerate(REASONS)
        if number and (count := int((found.reason == number).sum()))
    ]
    if left:
        tell(f"depths without a strength, of {found.sizes['depth']}: {', '.join(left)}")
    if found.attrs["notes"]:
        tell(f"{test.site.test.file}: {found.attrs['notes']}")
    tell(f"written: {base}.nc, .csv, .{', .'.join(forms)}, {LINES}")


def _write_data(dataset: xr.Dataset, base: str) -> None:
    write_netcdf(dataset.assign_attrs(provenance()), Path(f"{base}.nc"))


def _check(test: Interpreted, accuracy: str, base: str, forms: Sequence[str]) -> None:
    """Simulate the sounding through the interpreted ground; print and write the misfit."""
    site = test.site
    try:
        sounding = sounding_of(site, test.found, accuracy)
        seconds = sounding.run_size().particle_updates / UPDATE_RATE
        tell(f"simulating the sounding, {accuracy}: about {seconds:,.0f} s on one idle core")
        simulated = sounding.run()
    except (InaccurateRun, ParameterError, SceneError, SimulationDiverged) as error:
        raise HarnessError(f"{site.name}: the simulated sounding {error.status}: {error}") from None
    both = checked(test.found, simulated)
    _write_data(both, base)
    write_figure(check_figure(both), base, forms)
    say(*misfit_in_words(site, both))
    tell(f"written: {base}.nc, .{', .'.join(forms)}")


def _table(found: xr.Dataset) -> Iterator[list[str]]:
    """The titles of the columns, then a row for each depth; cells without a value are empty."""
    columns = {
        title: found[name].values / unit for title, (name, unit) in COLUMNS.items() if name in found
    }
    for name, title, unit in (
        ("resistance_factor", "Nkt {:g}% [1]", 1.0),
        ("strength", "su {:g}% [kPa]", 1e3),
    ):
        for percentile in found.percentile.values:
            values = found[name].sel(percentile=percentile).values / unit
            columns[title.format(percentile)] = values
    for cause in found.cause.values:
        columns[f"share of {cause} [1]"] = found.error_share.sel(cause=cause).values
    yield [*columns, "reason"]
    numbers = np.stack(list(columns.values()), axis=-1)
    for row, reason in zip(numbers, found.reason.values, strict=True):
        yield [*("" if np.isnan(number) else f"{number:.6g}" for number in row), REASONS[reason]]
