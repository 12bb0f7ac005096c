"""The file of a study's result, ``OUT/<study>.nc``: write and read it."""

from pathlib import Path

import xarray as xr

from harness.archive.atomic_files import ArchiveError, DamagedError, NoFileError
from harness.archive.case_files import ENDING as FIELDS_ENDING
from harness.archive.conventions import ORDER
from harness.archive.netcdf_files import read_attributes, read_netcdf, write_netcdf
from harness.archive.provenance import provenance_of_collector
from harness.study.study import Study
from mpm_warp.fields.names import did_you_mean, known_names

MOST_NAMED = 10
"""Number of files that an error lists if none has a name similar to the requested one."""


def study_file(out: Path, study: Study) -> Path:
    """The file of a study's result."""
    return out / f"{study.name}.nc"


def check_place(path: Path) -> None:
    """Refuse to overwrite a file that is not a result of a study, or a damaged one of ours."""
    try:
        if "study" in read_attributes(path):
            return
        problem = f"{path}: is not the result of a study"
    except (NoFileError, DamagedError):
        return
    except ArchiveError as error:
        problem = str(error)
    raise ArchiveError(f"{problem}; not overwritten: move it away, or give another --out")


def write_study(path: Path, dataset: xr.Dataset) -> None:
    """Write the result of a study."""
    write_netcdf(dataset.assign_attrs(provenance_of_collector()), path)


def read_study(path: Path) -> xr.Dataset:
    """Read the result of a study."""
    dataset = read_result(path)
    if "study" not in dataset.attrs:
        raise ArchiveError(f"{path}: is not the result of a study{_content(path, dataset)}")
    order = str(dataset.attrs.get(ORDER, "")).split()
    in_order = sorted(dataset.coords, key=lambda name: (*order, name).index(name))
    return dataset[[*dataset.data_vars, *in_order]]


def _content(path: Path, dataset: xr.Dataset) -> str:
    """What a file has instead of a study's result, and how to use it."""
    if "site" in dataset.attrs:
        again = f"`harness interpret {dataset.attrs['site']}.toml` writes it again, with a page"
        return f", but of a measured test; {again}; in Python `xarray.open_dataset` reads it"
    if path.name.endswith(FIELDS_ENDING):
        return f", but has snapshots of a case; `harness view {path}` draws them"
    if "case_key" in dataset.attrs:
        return ", but of one case; `xarray.open_dataset` reads it"
    return "; `xarray.open_dataset` reads it"


def read_result(path: Path) -> xr.Dataset:
    """Read the result of a case or of a study."""
    try:
        return read_netcdf(path)
    except NoFileError as error:
        beside = [file.name for file in path.parent.glob("*.nc") if file != path]
        # A list of very many case files would not help.
        listed = known_names(beside) if len(beside) <= MOST_NAMED else ""
        raise NoFileError(f"{error}{did_you_mean(path.name, beside) or listed}") from None
