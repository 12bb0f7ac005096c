"""Pictures of element tests and of cyclic tests."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.lines import Line2D

from harness.pictures.case_curves import cycles_figure, element_tests_figure
from tests.harness.pictures.conftest import IN_A_ROW, collected, figures

RATIOS = [1.0, 4.0]
STRAIN = np.linspace(0.01, 1.0, 100)


@pytest.fixture
def tested() -> xr.Dataset:
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
            "material.critical_state_ratio": ((), 1.2, {"role": "parameter"}),
            "status": (name, ["completed", "completed"]),
        },
        coords={
            name: (name, RATIOS, {"role": "parameter", "units": "1"}),
            "shear_strain": ("shear_strain", STRAIN, {"units": "1"}),
        },
    )
    return made.assign_attrs(study="demo", title="A demonstration", scene="element_test")


def test_curves_are_drawn_in_kilopascals_to_where_they_come_to_rest(tested: xr.Dataset) -> None:
    assert "element_tests" in figures(tested)
    shear, path, water = element_tests_figure(tested).axes
    np.testing.assert_allclose(shear.lines[1].get_ydata()[-1], 40.0)
    assert shear.get_xlim()[1] == pytest.approx(0.18)  # twice the last strain below 99 %
    np.testing.assert_allclose(path.lines[0].get_xdata()[-1], 40.0)
    np.testing.assert_allclose(path.lines[0].get_ydata()[-1], 20.0)
    x, y = path.lines[2].get_data()
    assert y[1] / x[1] == pytest.approx(1.2)  # the critical state
    np.testing.assert_allclose(water.lines[1].get_ydata()[-1], 40.0)


def test_without_effective_stress_there_is_one_panel(tested: xr.Dataset) -> None:
    total = tested.drop_vars(["effective_mean_stress", "excess_pore_pressure"])
    (shear,) = element_tests_figure(total).axes
    assert len(shear.lines) == 2
    assert "element_tests" not in figures(tested.drop_vars("shear_stress"))


STRENGTH = 20e3
CYCLE = np.array([0.25, 0.75, 1.25, 1.75])
DEPTH = np.array([1.0, 2.0, 3.0])
LEFT = {0.5: np.array([8.0, 6.0, 5.5, 5.2]), 0.2: np.array([6.0, 4.0, 3.0, 2.5])}


@pytest.fixture
def cyclic_tests() -> xr.Dataset:
    """Two clays: the first keeps more of its resistance and has a fit, the second has none."""
    factor = np.stack(list(LEFT.values()))
    loops = factor[:, :, None] * np.array([1.0, -1.0, 1.0, -1.0])[:, None] * STRENGTH
    loops = np.repeat(loops, DEPTH.size, axis=-1)
    of_cases = "remoulded_strength_ratio"
    nothing = np.nan
    made = xr.Dataset(
        {
            "cyclic_resistance": ((of_cases, "cycle", "penetration"), loops),
            "cyclic_resistance_factor": ((of_cases, "cycle"), factor),
            "resistance_ratio": (of_cases, factor[:, -1] / factor[:, 0], {"role": "headline"}),
            "fitted_resistance_factor": (of_cases, [10.0, nothing]),
            "fitted_remoulded_ratio": (of_cases, [0.5, nothing]),
            "fitted_cycles": (of_cases, [1.5, nothing]),
            "fit_misfit": (of_cases, [0.01, nothing]),
            "undrained_shear_strength": ((), STRENGTH, {"role": "parameter"}),
            "status": (of_cases, ["completed", "completed"]),
        },
        coords={
            of_cases: (of_cases, list(LEFT), {"role": "parameter", "units": "1"}),
            "cycle": ("cycle", CYCLE, {"units": "1"}),
            "penetration": ("penetration", DEPTH, {"units": "1"}),
        },
    )
    return made.assign_attrs(study="demo", title="A demonstration", scene="cyclic_t_bar")


def with_a_line(lines: list[Line2D]) -> list[Line2D]:
    return [it for it in lines if it.get_linestyle() == "-" and len(it.get_xdata()) > 10]


def test_it_is_drawn_of_loops_alone(cyclic_tests: xr.Dataset) -> None:
    assert "cycles" in figures(cyclic_tests)
    assert "cycles" not in figures(cyclic_tests.drop_vars("cyclic_resistance"))


@pytest.mark.parametrize("design", IN_A_ROW)
def test_it_is_drawn_of_cases_that_are_no_grid(
    design: str, cyclic_tests: xr.Dataset, tmp_path: Path
) -> None:
    of_cases = cyclic_tests.drop_vars(["status", "undrained_shear_strength"])
    each = [of_cases.isel(remoulded_strength_ratio=it, drop=True) for it in (0, 1)]
    dataset = collected(tmp_path, "cyclic_t_bar", design, *each)
    assert dataset["status"].dims == ("case",)
    loops, factors = figures(dataset)["cycles"].axes
    assert loops.lines[0].get_xdata()[0] == LEFT[0.2][0]
    assert len(factors.containers) == 2


def test_depth_goes_downward_and_the_loops_are_of_the_case_that_loses_most(
    cyclic_tests: xr.Dataset,
) -> None:
    loops, _ = cycles_figure(cyclic_tests).axes
    low, high = loops.get_ylim()
    assert low > high
    drawn = [it.get_xdata()[0] for it in loops.lines]
    np.testing.assert_allclose(drawn, LEFT[0.2] * [1.0, -1.0, 1.0, -1.0])
    np.testing.assert_array_equal(loops.lines[0].get_ydata(), DEPTH)


def test_each_case_is_a_series_over_cycles_with_its_fit_where_there_is_one(
    cyclic_tests: xr.Dataset,
) -> None:
    _, factors = cycles_figure(cyclic_tests).axes
    (fit,) = with_a_line(factors.lines)
    along = fit.get_xdata()
    expected = 10.0 * (0.5 + 0.5 * np.exp(-3.0 * along / 1.5))
    np.testing.assert_allclose(fit.get_ydata(), expected)
    assert len(factors.containers) == 2


def test_a_case_that_failed_has_no_series(cyclic_tests: xr.Dataset) -> None:
    cyclic_tests["status"].values[1] = "diverged"
    figure = figures(cyclic_tests)["cycles"]
    loops, factors = figure.axes
    assert len(factors.containers) == 1
    assert loops.lines[0].get_xdata()[0] == LEFT[0.5][0]


def test_resistance_that_stays_is_within_the_panel_and_no_fit_is_told(
    cyclic_tests: xr.Dataset,
) -> None:
    cyclic_tests["cyclic_resistance_factor"].values[:] = [10.0, 10.001, 10.0, 10.001]
    softening = cycles_figure(cyclic_tests)
    plastic = cycles_figure(cyclic_tests.assign(fitted_cycles=np.nan))
    assert plastic.axes[1].get_ylim()[1] > 10.2
    captions = [" ".join(it.get_text() for it in one.texts) for one in (softening, plastic)]
    assert ["fits" in it for it in captions] == [True, False]
