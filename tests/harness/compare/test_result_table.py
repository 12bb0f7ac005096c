"""The table that a study ends with; ratios, differences and the spread below it."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.stats.qmc import LatinHypercube

from harness.archive.conventions import (
    COMPLETED,
    DISTRIBUTION,
    headline_values,
    stated,
    uncertainty_of,
)
from harness.compare.compared import NothingToCompareError
from harness.compare.differences import difference, ratio, slope
from harness.compare.result_table import MOST_CASES, reason_notes, result_table
from harness.compare.spread import NUMERICAL, TOGETHER, first_order, spread_rows, spreads_of
from harness.study.files import studies_folder
from mpm_warp.fields.plain_numbers import numbers_by_column
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


FORMS = {
    "markdown": ["| bearing capacity |", "| 5.75 +- 0.02 |", "- +-: half width of 95 %"],
    "latex": [
        "bearing capacity &",
        r"5.75 $\pm$ 0.02 &",
        r"1.00\% &",
        r"completed \\",
        "% +-: half",
    ],
    "csv": [
        "adhesion factor,bearing capacity,bearing capacity +-,bearing capacity no U,",
        "0,5.75,0.02,,5.69,1.00%,1.0,completed",
        "1,6.10,,,6.05,1.00%,2.0,completed",
    ],
}


@pytest.mark.parametrize("form", FORMS)
def test_a_table_for_a_paper_has_the_cells_of_the_text(form: str) -> None:
    text = result_table(with_half_widths(0.02, np.nan), form)
    assert all(part in text for part in FORMS[form])


def with_half_widths(*half_widths: float) -> xr.Dataset:
    """Both footings, with what is stated of their loads."""
    known = {"bearing_capacity_uncertainty": (half_widths, "1", "uncertainty of the limit load")}
    made = footings(["completed", "completed"])
    return made.assign(labelled(dims=("adhesion_factor",), role="uncertainty", **known))


def test_a_headline_has_the_half_width_that_is_stated_of_it() -> None:
    stated = with_half_widths(0.02, np.nan)
    lines = result_table(stated).splitlines()
    assert lines[3].split()[1:4] == ["5.75", "+-", "0.02"]
    assert lines[4].split()[1] == "6.10"
    meaning = "+-: half width of 95 %: numerical error only, of this clay, not of your soil"
    assert meaning in lines
    reasons = ["", "Delta: it is beyond 0.95; speed: the speed is too high"]
    told = stated.assign(why_no_uncertainty=("adhesion_factor", reasons, {"role": "reason"}))
    assert "6.10, no U: Delta, speed" in result_table(told).splitlines()[4]


@pytest.mark.parametrize(
    ("value", "half_width", "text"),
    [
        (123456.0, 2000.0, "123000 +- 2000"),
        (123456.0, 1500.0, "123500 +- 1500"),
        (-123456.0, 9990.0, "-123000 +- 10000"),
        (12345.0, 15.0, "12345 +- 15"),
        (10.494, 0.08, "10.49 +- 0.08"),
        (-0.001, 0.1, "0.00 +- 0.10"),
        (123456.0, np.nan, "1.23e+05"),
    ],
)
def test_a_value_has_digits_by_its_half_width(value: float, half_width: float, text: str) -> None:
    assert stated(value, half_width) == text


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
    """Of all parameters those are varied that differ between cases of one scene."""
    cones, others = (it.splitlines() for it in result_table(cone_and_bar()).split("\n\n")[::2])
    assert cones[3].split()[:4] == ["cone_penetration", "11.36", "+-", "0.11"]
    assert others[3].split() == ["t_bar_penetration", "0.5", "10.81", "+-", "0.07", "completed"]
    assert others[4].split() == ["t_bar_penetration", "0", "9.12", "completed"]
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
    many = xr.concat([told] * MOST_CASES, "cell_count").stack(case=[...], create_index=False)
    few = many.why_no_uncertainty.where(np.arange(many.sizes["case"]) > 0, "")
    line = f"no uncertainty of {2 * MOST_CASES - 1} of {2 * MOST_CASES} cases: {reason}"
    assert line in reason_notes(many.assign(why_no_uncertainty=few))
    two = many.assign(why_no_uncertainty=few.where(np.arange(many.sizes["case"]) < 3, ""))
    assert "; adhesion_factor=" in reason_notes(two)[0], "cases are told apart"
    of_u2 = ("adhesion_factor", [reason, reason])
    told = told.assign(pore_pressure_factor_shoulder_why_no_uncertainty=of_u2)
    assert "of u2" not in result_table(told)  # for the reason of all
    told = told.assign(why_no_uncertainty=("adhesion_factor", ["", ""], {"role": "reason"}))
    assert f"no uncertainty of u2: {reason}" in result_table(told).splitlines()


def test_half_widths_are_those_of_samples() -> None:
    """Normal numbers of these means; a half width of 95 % is twice the standard deviation."""
    places = np.array([0.0, 1.0, 3.0])
    values = np.array([[11.4, 0.11], [10.8, 0.08], [9.9, 0.10]])
    drawn = np.random.default_rng(1).normal(values[:, 0], values[:, 1] / 2.0, (40_000, 3))
    for found, samples in (
        (difference((11.4, 0.11), (10.8, 0.08)), drawn[:, 0] - drawn[:, 1]),
        (ratio((11.4, 0.11), (10.8, 0.08)), drawn[:, 0] / drawn[:, 1]),
        (ratio((0.0, 0.11), (10.8, 0.08)), (drawn[:, 0] - 11.4) / drawn[:, 1]),
        (slope(places, values), np.polyfit(places, drawn.T, 1)[0]),
    ):
        # Samples tell a standard deviation to 0.35 %, a mean to half a percent of it.
        assert found[0] == pytest.approx(samples.mean(), abs=0.02 * found[1])
        assert found[1] == pytest.approx(2.0 * samples.std(), rel=0.02)


def test_differences_and_ratios_of_random_cases_are_inside() -> None:
    default, held_out = (
        numbers_by_column((studies_folder() / f"{name}.csv").read_text())
        for name in ("held_out_default", "held_out")
    )
    known, fine = (
        list(zip(them["cone_factor"], them["cone_factor_uncertainty"], strict=True))
        for them in (default, held_out)
    )
    pairs = [(i, j) for i in range(len(known)) for j in range(i)]
    found = []
    for i, j in pairs:
        for compared in (difference, ratio):
            of_tests, of_fine = compared(known[i], known[j]), compared(fine[i], fine[j])
            found.append(abs(of_tests[0] - of_fine[0]) / math.hypot(of_tests[1], of_fine[1]))
    assert len(pairs) == 276
    assert max(found) <= 1.0  # as the module says
    errors = held_out["cone_factor"] - default["cone_factor"]
    # Of two cases: their mean square in common over the whole mean square.
    assert 1.0 - errors.var(ddof=1) / np.mean(errors**2) == pytest.approx(0.22, abs=0.0051)


def test_the_ratio_of_two_scenes_in_one_soil_stands_below_the_tables() -> None:
    lines = result_table(cone_and_bar()).splitlines()
    said = "cone penetration over t bar penetration, adhesion_factor=0.5: 1.051 +- 0.012"
    assert said in lines
    assert not any("adhesion_factor=0.0:" in it for it in lines)  # no cone there
    mesh = {"cone_penetration": 1.75, "t_bar_penetration": 3.0}
    cells = [mesh[scene] for scene in cone_and_bar()["scene"].values.tolist()]
    own_meshes = cone_and_bar().assign_coords(
        cells_per_radius=("case", cells, {"role": "parameter", "units": "1"})
    )
    assert said in result_table(own_meshes).splitlines()
    assert not any(" over t bar" in it for it in result_table(footings(["completed"] * 2)))


def test_errors_and_results_of_other_kinds_have_no_ratio() -> None:
    """A scene may be run for its error, which others have beside their headline."""
    errors = xr.Dataset({"error": ("case", [0.01, 0.02, 0.03], {"role": "headline"})})
    by_error = errors.merge(cone_and_bar())
    assert headline_values(by_error).tolist() == headline_values(cone_and_bar()).tolist()
    assert " over t bar" in result_table(by_error)
    assert " over t bar" not in result_table(by_error.drop_vars(["cone_factor"]))
    in_pascal = cone_and_bar()
    in_pascal["resistance_factor"].attrs["units"] = "Pa"
    assert " over t bar" not in result_table(in_pascal)
    share = cone_and_bar().rename(resistance_factor="resistance_ratio")
    assert " over t bar" not in result_table(share)


def test_of_one_varied_number_difference_ratio_and_slope_stand_below() -> None:
    known = with_half_widths(0.02, 0.03)
    said = (
        "adhesion_factor from 0 to 1: difference 0.35 +- 0.04, ratio 1.061 +- 0.006, "
        "slope of the straight line 0.35 +- 0.04"
    )
    assert said in result_table(known).splitlines()
    in_pascal = known.copy(deep=True)
    for name, unit in (("bearing_capacity", "Pa"), ("adhesion_factor", "m")):
        in_pascal[name].attrs["units"] = unit
    said = (
        "adhesion_factor from 0 to 1 m: difference 0.35 +- 0.04 Pa, ratio 1.061 +- 0.006, "
        "slope of the straight line 0.35 +- 0.04 Pa per m"
    )
    assert said in result_table(in_pascal).splitlines()
    assert "difference" not in result_table(footings(["completed", "completed"]))
    for name in ("cells_per_radius", "penetration_parameter"):
        method = known.rename(adhesion_factor=name).assign_attrs(scene="cone_penetration")
        assert "difference" not in result_table(method)


COUNT = 1024
DRAWN = dict(zip("abc", LatinHypercube(3, rng=1).random(COUNT).T, strict=True))
"""Numbers from 0 to 1, whose variance is 1/12."""


def study(values: np.ndarray, half_width: float, **inputs: np.ndarray) -> xr.Dataset:
    """A study whose parameters are distributions, with its headline."""
    case = ("case",)
    dataset = xr.Dataset(
        {
            "factor": (case, values, {"role": "headline"}),
            "factor_uncertainty": (case, np.full(len(values), half_width), {"role": "uncertainty"}),
            "status": (case, np.full(len(values), COMPLETED)),
        },
        {name: (case, it, {DISTRIBUTION: "low 0, high 1"}) for name, it in inputs.items()},
    )
    return dataset.assign_coords(case=np.arange(len(values)))


def test_first_order_shares_are_those_of_a_polynomial() -> None:
    """Of a + b^2 + (c - 1/2)(a - 1/2): 1/12, 4/45 and 1/144 by both together."""
    a, b, c = DRAWN.values()
    shares = first_order(DRAWN, a + b**2 + (c - 0.5) * (a - 0.5))
    total = 1 / 12 + 4 / 45 + 1 / 144
    # Chance correlates two inputs by 1 over the root of the count, 0.03.
    assert shares["a"] == pytest.approx(1 / 12 / total, abs=0.02)
    assert shares["b"] == pytest.approx(4 / 45 / total, abs=0.02)
    assert shares["c"] == pytest.approx(0.0, abs=0.01)


def test_what_the_polynomial_does_not_tell_is_left() -> None:
    noise = np.random.default_rng(1).normal(size=COUNT)
    (found,) = spreads_of(study(DRAWN["a"] + noise / math.sqrt(12.0), math.nan, **DRAWN))
    assert found.shares["a"] == pytest.approx(0.5, abs=0.08)
    assert found.shares[TOGETHER] == pytest.approx(0.5, abs=0.08)
    assert NUMERICAL not in found.shares


def test_the_numerical_error_is_added_as_squares() -> None:
    values = np.exp(DRAWN["a"])
    (found,) = spreads_of(study(values, 1.96 * 3.0 * values.std(ddof=1), **DRAWN))
    assert found.mean == pytest.approx(math.e - 1.0, abs=1e-3)
    assert found.combined == pytest.approx(1.96 * math.sqrt(10.0) * values.std(ddof=1))
    assert found.shares[NUMERICAL] == pytest.approx(0.9)
    assert sum(found.shares.values()) == pytest.approx(1.0)
    assert found.percentiles == pytest.approx(np.exp([0.05, 0.5, 0.95]), abs=0.01)


def test_where_one_case_has_no_uncertainty_the_spread_is_that_of_the_inputs() -> None:
    dataset = study(DRAWN["a"], 0.1, **DRAWN)
    (known,) = spreads_of(dataset)
    dataset.factor_uncertainty[7] = math.nan
    (found,) = spreads_of(dataset)
    assert (found.numerical, found.combined) == (0.0, pytest.approx(1.96 * found.deviation))
    labels = [spread_rows(it)[0][0] for it in (known, found)]
    assert labels == ["mean with the combined U", "mean with the U of the inputs"]
    assert spread_rows(found)[0][1] == stated(found.mean, found.combined)


def test_of_few_cases_no_shares_are_told() -> None:
    few = {name: it[:19] for name, it in DRAWN.items()}
    (found,) = spreads_of(study(few["a"], 0.1, **few))
    assert dict(spread_rows(found))["share of the variance"] == "unknown: 20 samples are needed"


def test_a_study_without_distributions_has_no_spread() -> None:
    dataset = study(DRAWN["a"], 0.1, **DRAWN)
    for name in DRAWN:
        dataset[name].attrs.clear()
    assert spreads_of(dataset) == []
