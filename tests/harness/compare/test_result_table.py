"""The table that a study ends with: cone factors, or what else a scene is run for."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from harness.compare.cone_factors import NothingToCompareError
from harness.compare.result_table import result_table
from mpm_warp.results import labelled


def footings(status: list[str]) -> xr.Dataset:
    """Limit loads of two footings, of which the exact ones are known, with an error."""
    done = np.array(status) == "completed"
    dims = ("adhesion_factor",)
    load = (np.where(done, [5.75, 6.1], np.nan), "1", "limit load over area and su")
    made = xr.Dataset(
        labelled(dims=dims, role="headline", bearing_capacity=load)
        | labelled(
            dims=dims, bearing_capacity_exact=([5.69, 6.05], "1", "exact limit load", "Shield")
        )
        | labelled(dims=dims, role="error", error=(np.where(done, 0.01, np.nan), "1", "error")),
        coords={"adhesion_factor": [0.0, 1.0]},
    )
    return made.assign(run_time=("adhesion_factor", [1.0, 2.0]), status=(dims, status))


def test_a_result_without_cone_factor_stands_beside_its_exact_values() -> None:
    lines = result_table(footings(["completed", "diverged"])).splitlines()
    assert lines[3].split() == ["0", "5.75", "5.69", "1.00%", "1.0", "completed"]
    assert lines[4].split() == ["1", "-", "6.05", "-", "2.0", "diverged"]
    assert "bearing_capacity_exact: exact limit load; Shield" in lines


def test_a_headline_has_the_half_width_that_is_stated_of_it() -> None:
    half_width = ([0.02, np.nan], "1", "uncertainty of the limit load")
    stated = footings(["completed", "completed"]).assign(
        labelled(
            dims=("adhesion_factor",), role="uncertainty", bearing_capacity_uncertainty=half_width
        )
    )
    lines = result_table(stated).splitlines()
    assert lines[3].split()[1:4] == ["5.75", "+-", "0.02"]
    assert lines[4].split()[1] == "6.10"


def test_nothing_is_compared_where_nothing_completed() -> None:
    dataset = footings(["diverged", "failed"])[["status"]]
    with pytest.raises(NothingToCompareError, match="no case of 2 completed"):
        result_table(dataset)
