"""A page on two studies that are made up."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.compare.compared import with_references
from harness.references.registry import cone_factor_reference
from harness.report.report import write_report
from tests.harness.conftest import as_collected

TITLE = "Nc < 12 & <script>document.title = 'changed'</script>"


def study(name: str, cells_per_radius: float, shift: float) -> xr.Dataset:
    """Cone factors over the rigidity index, of which the last failed."""
    index = [50.0, 100.0, 200.0, 1000.0]
    factor = np.array([9.0, 10.5, 12.0, np.nan]) + shift
    status = np.where(np.isfinite(factor), "completed", "diverged")
    dim = "rigidity_index"
    parameter = {"role": "parameter", "units": "1"}
    headline = {"role": "headline", "units": "1", "long_name": "cone factor"}
    measured = {"role": "measured", "units": "s", "long_name": "run time"}
    made = xr.Dataset(
        {
            "cone_factor": (dim, factor, headline),
            "run_time": (dim, [1.0, 10.0, 9.0, np.nan], measured),
            "peak_memory": (dim, [3e8] * 4, {"units": "byte", "long_name": "peak memory"}),
            "particle_updates": (dim, [1e6, 1e6, 1e6, np.nan]),
            "adhesion_factor": ((), 0.5, parameter),
            "cells_per_radius": ((), cells_per_radius, parameter),
        },
        coords={dim: (dim, index, parameter | {"long_name": "rigidity index"})},
    )
    said = {"study": name, "title": TITLE, "design": "full", "commit": "<b>unknown</b>"}
    collected = as_collected(made, dim, status, **said)
    return with_references(collected, [cone_factor_reference("lu_2004")])


@pytest.fixture(scope="session")
def results() -> list[xr.Dataset]:
    """Two studies of the same soils on two meshes."""
    return [study("coarse", 2.0, 0.0), study("fine", 4.0, 0.2)]


@pytest.fixture(scope="session")
def page_file(results: list[xr.Dataset], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page on both."""
    path = tmp_path_factory.mktemp("page") / "report.html"
    write_report(results, path)
    return path
