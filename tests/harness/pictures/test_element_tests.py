"""The picture of element tests: of laws with effective stress, and of those without."""

import numpy as np
import pytest
import xarray as xr

from harness.pictures.case_curves import element_tests_figure
from tests.harness.pictures.conftest import figures

RATIOS = [1.0, 4.0]
STRAIN = np.linspace(0.01, 1.0, 100)


@pytest.fixture
def result() -> xr.Dataset:
    """Two tests that come to their strengths, 10 and 40 kPa, at strains of a tenth."""
    share = np.minimum(10.0 * STRAIN, 1.0)
    shear = np.array([[10e3], [40e3]]) * share
    name = "isotropic_overconsolidation_ratio"
    made = xr.Dataset(
        {
            "shear_stress": ((name, "shear_strain"), shear),
            "deviator_stress": ((name, "shear_strain"), 2.0 * shear),
            "effective_mean_stress": ((name, "shear_strain"), 50e3 - shear),
            "excess_pore_pressure": ((name, "shear_strain"), shear),
            "strength": (name, [10e3, 40e3], {"role": "headline", "units": "Pa"}),
            "critical_state_ratio": ((), 1.2, {"role": "parameter"}),
            "status": (name, ["completed", "completed"]),
        },
        coords={
            name: (name, RATIOS, {"role": "parameter", "units": "1"}),
            "shear_strain": ("shear_strain", STRAIN, {"units": "1"}),
        },
    )
    return made.assign_attrs(study="demo", title="A demonstration", scene="element_test")


def test_curves_are_drawn_in_kilopascals_to_where_they_come_to_rest(result: xr.Dataset) -> None:
    assert "element_tests" in figures(result)
    shear, path, water = element_tests_figure(result).axes
    np.testing.assert_allclose(shear.lines[1].get_ydata()[-1], 40.0)
    assert shear.get_xlim()[1] == pytest.approx(0.18)  # twice the last strain below 99 %
    np.testing.assert_allclose(path.lines[0].get_xdata()[-1], 40.0)
    np.testing.assert_allclose(path.lines[0].get_ydata()[-1], 20.0)
    x, y = path.lines[2].get_data()
    assert y[1] / x[1] == pytest.approx(1.2)  # the critical state
    np.testing.assert_allclose(water.lines[1].get_ydata()[-1], 40.0)


def test_without_effective_stress_there_is_one_panel(result: xr.Dataset) -> None:
    total = result.drop_vars(["effective_mean_stress", "excess_pore_pressure"])
    (shear,) = element_tests_figure(total).axes
    assert len(shear.lines) == 2
    assert "element_tests" not in figures(result.drop_vars("shear_stress"))
