"""The table that a study ends with: cone factors, or what else a scene is run for."""

import numpy as np
import pytest
import xarray as xr

from harness.archive.conventions import uncertainty_of, varied_names
from harness.compare.compared import NothingToCompareError
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
    meaning = "+-: half width of 95 %: numerical error only, of this clay, not of your soil"
    assert meaning in lines
    reasons = ["", "Delta: it is beyond 0.95; speed: it is too high"]
    told = stated.assign(why_no_uncertainty=("adhesion_factor", reasons, {"role": "reason"}))
    assert "6.10, no U: Delta, speed" in result_table(told).splitlines()[4]


def cone_and_bar() -> xr.Dataset:
    """A cone and two T-bars; only the cone has an apex angle, only a T-bar a half width."""
    nan, dims = np.nan, ("case",)
    headlines = labelled(
        dims=dims,
        role="headline",
        cone_factor=([11.36, nan, nan], "1", "cone factor"),
        resistance_factor=([nan, 10.81, 9.12], "1", "resistance factor"),
    )
    half_widths = labelled(
        dims=dims,
        role="uncertainty",
        cone_factor_uncertainty=([0.11, nan, nan], "1", "uncertainty"),
        resistance_factor_uncertainty=([nan, 0.07, nan], "1", "uncertainty"),
    )
    coordinates = {
        "scene": (dims, ["cone_penetration", "t_bar_penetration", "t_bar_penetration"]),
        "adhesion_factor": (dims, [0.5, 0.5, 0.0]),
        "rigidity_index": (dims, [100.0, 100.0, 100.0]),
        "apex_angle": (dims, [60.0, nan, nan]),
    }
    made = xr.Dataset(headlines | half_widths, coords=coordinates)
    return made.assign(status=(dims, ["completed"] * 3))


def test_cones_and_other_scenes_have_a_table_each() -> None:
    cones, others = (it.splitlines() for it in result_table(cone_and_bar()).split("\n\n")[::2])
    assert cones[3].split()[:4] == ["cone_penetration", "11.36", "+-", "0.11"]
    assert others[3].split() == ["t_bar_penetration", "0.5", "10.81", "+-", "0.07", "completed"]
    assert others[4].split() == ["t_bar_penetration", "0", "9.12", "completed"]


def test_of_several_scenes_a_parameter_is_varied_where_it_differs() -> None:
    assert set(varied_names(cone_and_bar())) == {"scene", "adhesion_factor"}


def test_each_scene_has_the_half_width_of_its_own_headline() -> None:
    np.testing.assert_array_equal(uncertainty_of(cone_and_bar()), [0.11, 0.07, np.nan])


def test_nothing_is_compared_where_nothing_completed() -> None:
    dataset = footings(["diverged", "failed"])[["status"]]
    with pytest.raises(NothingToCompareError, match="no case of 2 completed"):
        result_table(dataset)


def test_why_there_is_no_uncertainty_stands_below_the_table() -> None:
    """Once for all cases, or with the cases that it is of."""
    reason = "law: nobody has measured it"
    both = footings(["completed", "completed"])
    for reasons, line in (
        (["", reason], f"no uncertainty of adhesion_factor=1.0: {reason}"),
        ([reason, reason], f"no uncertainty: {reason}"),
    ):
        told = both.assign(why_no_uncertainty=("adhesion_factor", reasons, {"role": "reason"}))
        assert line in result_table(told).splitlines()
    assert "no uncertainty" not in result_table(both)
