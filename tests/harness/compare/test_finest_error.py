"""The error of each case against the costliest one."""

from __future__ import annotations

import numpy as np
import xarray as xr

from harness.compare.finest_error import with_finest_error
from harness.study.study import ERROR_FINEST


def test_error_is_against_the_costliest_case_of_the_same_soil(two_soils: xr.Dataset) -> None:
    error = two_soils[ERROR_FINEST]
    np.testing.assert_allclose(error.sel(rigidity_index=50.0), [0.1, 0.02, np.nan], rtol=1e-12)
    # Where the finest case has failed, the next one is the reference.
    stiff = error.sel(rigidity_index=100.0)
    np.testing.assert_allclose(stiff, [11.0 / 10.1 - 1.0, np.nan, np.nan], rtol=1e-12)


def test_an_exact_error_is_left_alone(two_soils: xr.Dataset) -> None:
    dataset = two_soils.drop_vars(ERROR_FINEST).assign(error=0.5)
    assert ERROR_FINEST not in with_finest_error(dataset, ["cells_per_radius"])


def test_one_case_of_each_soil_has_no_error(two_soils: xr.Dataset) -> None:
    dataset = two_soils.drop_vars(ERROR_FINEST).isel(cells_per_radius=[1])
    assert ERROR_FINEST not in with_finest_error(dataset, ["cells_per_radius"])


def test_a_scene_without_parameters_of_the_method_has_no_error(two_soils: xr.Dataset) -> None:
    assert ERROR_FINEST not in with_finest_error(two_soils.drop_vars(ERROR_FINEST), [])
