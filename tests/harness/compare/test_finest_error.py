"""The error of each case against the one that is known best."""

import numpy as np
import pytest
import xarray as xr

from harness.compare.compared import NothingToCompareError
from harness.compare.finest_error import FLOOR, with_finest_error
from harness.study.compared import ERROR_FINEST


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


def stating(dataset: xr.Dataset, half_width: list[float], settled: list[float]) -> xr.Dataset:
    """The soil whose cases are all complete, with what they state of themselves."""
    soil = dataset.drop_vars(ERROR_FINEST).sel(rigidity_index=[50.0])
    return soil.assign(
        cone_factor_uncertainty=("cells_per_radius", half_width, {"role": "uncertainty"}),
        cone_factor_settled=("cells_per_radius", settled, {"role": "settled"}),
    )


def test_the_case_that_is_known_best_is_the_reference_and_its_uncertainty_the_floor(
    two_soils: xr.Dataset,
) -> None:
    dataset = stating(two_soils, [np.nan, 0.09, 0.3], [1.0, 1.0, 1.0])
    told = with_finest_error(dataset, ["cells_per_radius"])
    error, floor = told[ERROR_FINEST].values[0], told[FLOOR].values[0]
    np.testing.assert_allclose(error, [9.9 / 9.18 - 1.0, np.nan, 1.0 - 9.0 / 9.18], rtol=1e-12)
    np.testing.assert_allclose(floor, [0.09 / 9.18, np.nan, 0.09 / 9.18], rtol=1e-12)


def test_a_case_that_has_not_settled_has_no_error_and_is_no_reference(
    two_soils: xr.Dataset,
) -> None:
    dataset = stating(two_soils, [np.nan] * 3, [1.0, 1.0, 0.0])
    error = with_finest_error(dataset, ["cells_per_radius"])[ERROR_FINEST].values[0]
    np.testing.assert_allclose(error, [9.9 / 9.18 - 1.0, np.nan, np.nan], rtol=1e-12)


def kept(dataset: xr.Dataset, cells: float, factor: float, half_width: float) -> xr.Dataset:
    """The result of a study of one case of the first soil, on another mesh."""
    one = dataset.drop_vars(ERROR_FINEST).isel(rigidity_index=[0], cells_per_radius=[0])
    one = one.assign_coords(cells_per_radius=("cells_per_radius", [cells], {"role": "parameter"}))
    one["cone_factor"][:] = factor
    width = ("cells_per_radius", [half_width], {"role": "uncertainty"})
    return one.assign(cone_factor_uncertainty=width).assign_attrs(study="kept")


def test_a_kept_reference_stands_for_the_true_value_of_its_soil(two_soils: xr.Dataset) -> None:
    """The soil that it is not of keeps the best known case of its own."""
    bare = two_soils.drop_vars(ERROR_FINEST)
    told = with_finest_error(bare, ["cells_per_radius"], kept(two_soils, 8.0, 9.2, 0.05))
    error, floor = told[ERROR_FINEST], told[FLOOR]
    own = bare.cone_factor.sel(rigidity_index=50.0).values
    np.testing.assert_allclose(error.sel(rigidity_index=50.0), abs(own / 9.2 - 1.0), rtol=1e-12)
    np.testing.assert_allclose(floor.sel(rigidity_index=50.0), 0.05 / 9.2, rtol=1e-12)
    np.testing.assert_array_equal(
        error.sel(rigidity_index=100.0), two_soils[ERROR_FINEST].sel(rigidity_index=100.0)
    )
    assert "study kept" in error.attrs["description"]


def test_a_kept_reference_of_another_soil_is_none(two_soils: xr.Dataset) -> None:
    other = kept(two_soils, 8.0, 9.2, 0.05).assign(adhesion_factor=0.7)
    other["adhesion_factor"].attrs["role"] = "parameter"
    with pytest.raises(NothingToCompareError, match="in the method alone"):
        with_finest_error(two_soils.drop_vars(ERROR_FINEST), ["cells_per_radius"], other)
