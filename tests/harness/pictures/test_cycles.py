"""The picture of cyclic tests: loops with depth downward, and resistance over cycles with fits."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.lines import Line2D

from harness.pictures.case_curves import cycles_figure
from tests.harness.pictures.conftest import figures

STRENGTH = 20e3
CYCLE = np.array([0.25, 0.75, 1.25, 1.75])
DEPTH = np.array([1.0, 2.0, 3.0])
LEFT = {0.5: np.array([8.0, 6.0, 5.5, 5.2]), 0.2: np.array([6.0, 4.0, 3.0, 2.5])}


@pytest.fixture
def result() -> xr.Dataset:
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


def test_it_is_drawn_of_loops_alone(result: xr.Dataset) -> None:
    assert "cycles" in figures(result)
    assert "cycles" not in figures(result.drop_vars("cyclic_resistance"))


def test_depth_goes_downward_and_the_loops_are_of_the_case_that_loses_most(
    result: xr.Dataset,
) -> None:
    loops, _ = cycles_figure(result).axes
    low, high = loops.get_ylim()
    assert low > high
    drawn = [it.get_xdata()[0] for it in loops.lines]
    np.testing.assert_allclose(drawn, LEFT[0.2] * [1.0, -1.0, 1.0, -1.0])
    np.testing.assert_array_equal(loops.lines[0].get_ydata(), DEPTH)


def test_each_case_is_a_series_over_cycles_with_its_fit_where_there_is_one(
    result: xr.Dataset,
) -> None:
    _, factors = cycles_figure(result).axes
    (fit,) = with_a_line(factors.lines)
    along = fit.get_xdata()
    expected = 10.0 * (0.5 + 0.5 * np.exp(-3.0 * along / 1.5))
    np.testing.assert_allclose(fit.get_ydata(), expected)
    assert len(factors.containers) == 2


def test_a_case_that_failed_has_no_series(result: xr.Dataset) -> None:
    result["status"].values[1] = "diverged"
    figure = figures(result)["cycles"]
    loops, factors = figure.axes
    assert len(factors.containers) == 1
    assert loops.lines[0].get_xdata()[0] == LEFT[0.5][0]
