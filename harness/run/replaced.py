"""What the file of a study had before it is written anew: told, and kept where it would be lost."""

import itertools
from collections import Counter
from pathlib import Path

import xarray as xr

from harness.archive.atomic_files import DamagedError, NoFileError, write_whole
from harness.archive.conventions import COMPLETED, MISSING, over_cases
from harness.archive.netcdf_files import read_attributes
from harness.archive.provenance import other_version
from harness.archive.study_files import read_study
from harness.errors import counted, tell


def tell_of_replaced(path: Path, dataset: xr.Dataset, folder: Path) -> None:
    """Print one line if the file that is about to be replaced has another study or other cases.

    Two study files of the same name in different folders have the same file of results, and so do
    two runs of a study with different settings. A file with results that are in no file of a case
    any more, in `folder`, is kept under another name.
    """
    try:
        before = read_attributes(path).get("title", "no title")
        if before != dataset.attrs["title"]:
            tell(
                f'{path}: was of a study with another title, "{before}"; its cases are kept, and '
                "`harness collect` of it writes its file again; `--out FOLDER` keeps two of one "
                "name apart"
            )
            return
        earlier = read_study(path)
        statuses = dict(
            zip(*(over_cases(dataset, it) for it in ("case_key", "status")), strict=True)
        )
        missed = _completed_keys(earlier) - _completed_keys(dataset)
        others = {key for key in missed - statuses.keys() if (folder / f"{key}.nc").exists()}
        if others:
            remedy = (
                "`harness collect` with each --set of then gathers them again; `--out FOLDER` "
                "keeps two runs apart"
            )
            tell(
                f"{path}: had {counted(len(others), 'other result')}, kept in the files of the "
                f"cases; {other_version(earlier) or remedy}"
            )
        if lost := missed - others:
            now = Counter(str(statuses.get(key, MISSING)) for key in lost)
            kept = _free_name(path)
            write_whole(path.read_bytes(), kept)
            tell(
                f"{path}: had {counted(len(lost), 'result')} of cases that are "
                f"{' or '.join(now)} now; kept as it was in {kept.name}; "
                f"{other_version(earlier) or '`harness status` says why'}"
            )
    except (NoFileError, DamagedError):
        return


def _free_name(path: Path) -> Path:
    """NAME_before.nc for NAME.nc, or with a number if there is such a file."""
    endings = itertools.chain(["before"], (f"before_{number}" for number in itertools.count(2)))
    names = (path.with_stem(f"{path.stem}_{ending}") for ending in endings)
    return next(name for name in names if not name.exists())


def _completed_keys(dataset: xr.Dataset) -> set[str]:
    is_completed = over_cases(dataset, "status") == COMPLETED
    return {str(key) for key in over_cases(dataset, "case_key")[is_completed]}
