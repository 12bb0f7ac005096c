"""Results of three cases whose cone factors are given."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.case_files import write_case
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED
from harness.compare.compared import with_references
from harness.references.registry import reference_of
from tests.harness.conftest import HEAD, prepared, study_in

FACTORS = (10.0, 11.0, 12.0)


Two = Callable[..., list[xr.Dataset]]
"""Makes two results, the second with the cone factors and settings that it is given."""


def collected(
    folder: Path, factors: tuple[float, ...] = FACTORS, settings: tuple[str, ...] = ()
) -> xr.Dataset:
    """A study of three cases whose cone factors are given; one not a number has failed."""
    study = study_in(folder, f"{HEAD}[vary]\nadhesion_factor = [0, 0.5, 1]\n", *settings)
    out = prepared(study, folder)
    for case, factor in zip(study.cases, factors, strict=True):
        result = xr.Dataset(
            {
                "cone_factor": ((), factor, {"role": "headline"}),
                "error": ((), factor / 1000, {"role": "error"}),
                "run_time": ((), 1.0, {"role": "measured"}),
            }
        )
        if np.isnan(factor):
            write_case(out, case, xr.Dataset(), "diverged", "too fast")
        else:
            write_case(out, case, result, COMPLETED)
    return with_references(collect(study, out), [reference_of("lu_2004")])


@pytest.fixture
def two(tmp_path: Path) -> Two:
    """Makes two such studies in folders of their own."""

    def made(*changed: float, settings: tuple[str, ...] = ()) -> list[xr.Dataset]:
        folders = [tmp_path / "one", tmp_path / "other"]
        for folder in folders:
            folder.mkdir()
        return [collected(folders[0]), collected(folders[1], changed, settings)]

    return made
