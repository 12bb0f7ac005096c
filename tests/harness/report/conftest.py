"""A page on two studies that are made up."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.report.report import write_report
from tests.harness.pictures.conftest import result

TITLE = "Nc < 12 & <script>document.title = 'changed'</script>"
FACTORS = np.array([9.0, 10.5, 12.0])


def study(name: str, cells_per_radius: float, shift: float) -> xr.Dataset:
    """Cone factors over the rigidity index, of which the last failed."""
    made = result({"rigidity_index": [50.0, 100.0, 200.0, 1000.0]}, [*(FACTORS + shift), np.nan])
    dim, seconds = "rigidity_index", {"role": "measured", "units": "s", "long_name": "run time"}
    return (
        made.drop_vars("penetration_resistance")
        .assign(
            run_time=(dim, [1.0, 10.0, 9.0, np.nan], seconds),
            peak_memory=(dim, [3e8] * 4, {"units": "byte", "long_name": "peak memory"}),
            particle_updates=(dim, [1e6, 1e6, 1e6, np.nan]),
            cells_per_radius=((), cells_per_radius, {"role": "parameter", "units": "1"}),
        )
        .assign_attrs(study=name, title=TITLE, commit="<b>unknown</b>")
    )


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
