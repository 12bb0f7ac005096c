"""Two results side by side, case by case and bit by bit; tolerances that are kept and missed."""

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.conventions import COMPLETED
from harness.archive.provenance import SOURCES
from harness.archive.study_files import write_study
from harness.compare.compared import NothingToCompareError, misses, with_tolerances
from harness.compare.differences import Difference, differences, differing, unshared
from mpm_warp.fields.checked import complete
from mpm_warp.fields.declaration import parameter
from mpm_warp.provenance import sources_digest
from tests.harness.compare.conftest import FACTORS, Two, collected
from tests.harness.conftest import Command, Refusal, as_collected


def test_equal_results_do_not_differ(two: Two) -> None:
    one, other = two(*FACTORS)
    found, lonely = differences(one, other.assign(run_time=2 * other["run_time"]))
    assert [(it.name, it.size) for it in found] == [("cone_factor", 0), ("error", 0)]
    assert lonely == []


def test_the_largest_difference_is_named_with_its_case(two: Two) -> None:
    one, other = two(10.0, 11.11, 12.0)
    found, _ = differences(one, other.isel(adhesion_factor=slice(None, None, -1)))
    assert [it.name for it in found] == ["cone_factor", "error"]
    assert [it.size for it in found] == pytest.approx([0.01, 0.01])
    assert {it.label for it in found} == {"adhesion_factor=0.5"}


CURVE = np.array([[0.0, 64.0], [-1.0, 2.0], [3.0, np.nan]])


@pytest.mark.parametrize(
    ("change", "size", "label"),
    [
        ({}, 0.0, "0.0"),
        ({(0, 1): 64.0 * (1 + 2**-52)}, 2**-52, "0.0"),  # one bit
        ({(1, 0): -1.5}, 0.25, "0.5"),  # relative to the largest number of the curve
        ({(0, 0): np.nan}, np.inf, "0.0"),
        ({(2, 1): 0.0}, np.inf, "1.0"),
    ],
)
def test_given_two_curves_their_largest_difference_is_that_of_one_point(
    two: Two, change: dict[tuple[int, int], float], size: float, label: str
) -> None:
    one, other = two(*FACTORS)
    changed = CURVE.copy()
    for place, value in change.items():
        changed[place] = value
    dims, depth = ("adhesion_factor", "penetration"), {"penetration": [1.0, 2.0]}
    found, _ = differences(
        one.assign(curve=(dims, CURVE)).assign_coords(depth),
        other.assign(curve=(dims, changed)).assign_coords(depth),
    )
    assert found[1] == Difference("curve", size, f"adhesion_factor={label}")


def test_given_a_longer_curve_it_differs_without_bound(two: Two) -> None:
    one, other = two(*FACTORS)
    curve = xr.DataArray(CURVE.T, dims=("penetration", "adhesion_factor"))
    one = one.assign(curve=curve).assign_coords(penetration=[1.0, 2.0])
    other = other.assign(curve=curve[:1]).assign_coords(penetration=[1.0])
    found, _ = differences(one, other)
    assert found[1] == Difference("curve", np.inf, "adhesion_factor=0.0")


def test_a_case_that_failed_in_one_differs_without_bound(two: Two) -> None:
    """And counts by its status alone where there are no numbers."""
    one, other = two(10.0, np.nan, 12.0)
    lonely = ["completed in the first, diverged in the second: adhesion_factor=0.5"]
    found, told = differences(one, other)
    assert ({it.size for it in found}, told) == ({np.inf}, lonely)
    bare = ["status", "adhesion_factor"]
    assert differences(one[bare], other[bare]) == ([], lonely)


def test_what_was_not_compared_is_not_passed(tmp_path: Path, refusal: Refusal, two: Two) -> None:
    path = tmp_path / "s.nc"
    ours = {SOURCES: f"mpm_warp {sources_digest('mpm_warp')}"}
    write_study(path, collected(tmp_path).drop_vars(["cone_factor", "error"]).assign_attrs(ours))
    told = "harness: nothing to compare: no case has a result in either"
    assert refusal(["compare", str(path), str(path)]) == told
    one, other = two(*FACTORS)
    nothing = {"cone_factor": np.nan * one["cone_factor"], "error": np.nan * one["error"]}
    with pytest.raises(NothingToCompareError):
        differences(one.assign(nothing), other.assign(nothing))


def test_a_result_from_before_a_parameter_is_compared_at_its_default(two: Two) -> None:
    one, other = two(*FACTORS)
    older = one.drop_vars("friction_coefficient")
    assert differences(older, other) == differences(one, other)
    assert differences(other, older) == differences(other, one)
    assert unshared(one, other) == []
    told = "has friction_coefficient; for the other the default is assumed"
    assert unshared(older, other) == [f"only the second {told}"]
    assert unshared(other, older) == [f"only the first {told}"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Derives:
    """A scene that fills in what it derives."""

    adhesion_factor: float = parameter(0.0, unit="1", meaning="of the face", minimum=0)
    shaft_adhesion_factor: float | None = parameter(None, unit="1", meaning="of the shaft")

    def __post_init__(self) -> None:
        if self.shaft_adhesion_factor is None:
            complete(self, shaft_adhesion_factor=self.adhesion_factor)

    @classmethod
    def of(cls, values: dict[str, float]) -> "Derives":
        return cls(**values)


@pytest.mark.parametrize("derived", [np.nan, None])
def test_what_an_older_result_does_not_say_is_what_the_scene_derives(
    derived: float | None, two: Two, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("harness.compare.differences.scene_class", lambda name: Derives)
    one, other = two(*FACTORS)
    name, role = "shaft_adhesion_factor", {"role": "parameter"}
    older = one.drop_vars(name) if derived is None else one
    newer = other.assign({name: ("adhesion_factor", [0.0, 0.5, 1.0], role)})
    found, lonely = differences(older, newer)
    assert ([it.size for it in found], lonely) == ([0.0, 0.0], [])
    another = other.assign({name: ("adhesion_factor", [0.0, 0.5, 0.0], role)})
    _, lonely = differences(older, another)
    assert lonely == [
        "only in the first: adhesion_factor=1.0",
        "only in the second: adhesion_factor=1.0",
    ]


def test_a_result_of_other_parameters_or_from_before_one_is_not_compared(two: Two) -> None:
    one, other = two(*FACTORS, settings=("friction_coefficient=0.1",))
    with pytest.raises(NothingToCompareError):
        differences(one, other)
    with pytest.raises(NothingToCompareError):
        differences(one.drop_vars("friction_coefficient"), other)


def test_a_parameter_that_only_one_varies_leaves_its_default_to_compare(two: Two) -> None:
    varied = ("adhesion_factor=0.5", "friction_coefficient=[0.2, 0.1, 0]")
    one, other = two(10.0, 11.0, 11.11, settings=varied)
    found, lonely = differences(one.drop_vars("friction_coefficient"), other)
    assert [it.size for it in found] == pytest.approx([0.01, 0.01])
    assert sum(line.startswith("only in the second: ") for line in lonely) == 2


def test_a_parameter_that_is_no_more_is_named(two: Two) -> None:
    one, other = two(*FACTORS)
    older = one.assign(viscosity=((), 1.0, {"role": "parameter"}))
    assert differences(older, other) == differences(one, other)
    assert unshared(older, other) == [
        "only the first has viscosity; for the other the default is assumed"
    ]
    with pytest.raises(NothingToCompareError):
        differences(older, other.assign(viscosity=older["viscosity"] + 1.0))


@pytest.mark.parametrize(("tolerance", "code"), [("0", 1), ("0.005", 1), ("0.02", 0)])
def test_two_files_compared(
    tmp_path: Path, command: Command, tolerance: str, code: int, two: Two
) -> None:
    paths = tmp_path / "one.nc", tmp_path / "other.nc"
    for path, dataset in zip(paths, two(10.0, 11.11, 12.0), strict=True):
        write_study(path, dataset)
    first, *_ = command("compare", *paths, "--tolerance", tolerance, code=code).out.splitlines()
    assert first.split()[:3] == ["cone_factor", "0.01", "MISSED" if code else "ok"]


def test_a_single_bit_a_type_and_a_sign_of_zero_differ() -> None:
    one = xr.Dataset(
        {"a": ("x", [0.0, 1.0]), "run_time": ((), 1.0, {"role": "measured"})}, {"x": ["b", "c"]}
    )
    assert differing(one, one.assign(run_time=2 * one["run_time"])) == []
    for other in (
        one.assign(a=("x", [-0.0, 1.0])),
        one.assign(a=("x", [0.0, 1.0 + 2**-52])),
        one.assign(a=one.a.astype(np.float32)),
        one.drop_vars("a"),
    ):
        assert differing(one, other) == differing(other, one) == ["a"]
    assert differing(one, one.assign_coords(x=["b", "d"])) == ["x"]
    nan = one.assign(a=("x", [np.nan, 1.0]))
    assert differing(nan, nan.copy(deep=True)) == []


def test_a_headline_is_a_measurement_where_the_scene_measures_the_machine() -> None:
    one = xr.Dataset({"update_rate": ((), 1.0, {"role": "headline"})})
    assert differing(one, one + 1.0) == ["update_rate"]
    assert differing(one, one + 1.0, measures_machine=True) == []


def missed(dataset: xr.Dataset, **tolerances: float) -> list[str]:
    return list(itertools.chain(*misses(with_tolerances(dataset, tolerances)).values()))


@pytest.mark.parametrize(
    ("name", "limit", "told"),
    [
        ("error", 0.012, ""),
        ("error", 0.0115, "adhesion_factor=1.0: 0.012 is beyond the tolerance 0.0115"),
        # 10 / 10.77 - 1, 11 / 11.42 - 1, 12 / 12.07 - 1
        ("lu_2004", 0.08, ""),
        ("lu_2004", 0.05, "adhesion_factor=0.0: 0.0713 is beyond the tolerance 0.05"),
        ("eror", 1.0, "is neither a reference nor a result here; did you mean 'error'?"),
    ],
)
def test_beyond_a_tolerance_is_missed(tmp_path: Path, name: str, limit: float, told: str) -> None:
    assert missed(collected(tmp_path), **{name: limit}) == ([f"{name}: {told}"] if told else [])


def test_a_reference_is_not_asked_outside_its_validity(tmp_path: Path) -> None:
    dataset = collected(tmp_path, settings=("rigidity_index=5",))
    assert missed(dataset, lu_2004=0.001) == ["lu_2004: applies to no case"]
    dataset = collected(tmp_path, settings=("adhesion_factor=0", "rigidity_index=[5, 100, 200]"))
    cases = [line.split(":")[1] for line in missed(dataset, lu_2004=0.001)]
    assert cases == [" rigidity_index=100.0", " rigidity_index=200.0"]


def test_what_failed_is_missed(tmp_path: Path) -> None:
    (line,) = missed(collected(tmp_path, (10.0, np.nan, 12.0)), error=1.0)
    assert line.startswith("error: adhesion_factor=0.5: nan")


def test_a_scene_that_does_not_have_a_result_does_not_miss_its_tolerance() -> None:
    """One of which no case completed may have it; one that has it may have no number of it."""
    scenes = ["cone_penetration", "cone_penetration", "cavity_expansion", "cavity_expansion"]
    errors = {"error": ("case", [0.01, np.nan, np.nan, np.nan], {"scenes": scenes[0]})}
    made = xr.Dataset(errors, {"case": range(4), "scene": ("case", scenes)})
    both = as_collected(made, "case", [COMPLETED, "failed", COMPLETED, "failed"], scene="two")
    (line,) = missed(both, error=0.02)
    assert line == "error: scene=cone_penetration: nan is beyond the tolerance 0.02"
    none = as_collected(made, "case", [COMPLETED, COMPLETED, "failed", "failed"], scene="two")
    assert len(missed(none, error=0.02)) == 3
    of_both = both.error.assign_attrs(scenes=" ".join(scenes[1:3]))
    assert len(missed(both.assign(error=of_both), error=0.02)) == 3


@pytest.mark.parametrize(("limit", "code"), [(0.02, 0), (0.011, 1)])
def test_missed_tolerances_end_with_1(
    tmp_path: Path, command: Command, limit: float, code: int
) -> None:
    dataset = collected(tmp_path).assign_attrs(design="full")
    write_study(tmp_path / "s.nc", with_tolerances(dataset, {"error": limit}))
    told = command("compare", tmp_path / "s.nc", code=code).err
    assert ("error: adhesion_factor=1.0" in told) == bool(code)


def test_collecting_keeps_the_tolerances_of_the_study(tmp_path: Path, command: Command) -> None:
    collected(tmp_path)
    study = tmp_path / "s.toml"
    study.write_text(f"{study.read_text()}[compare]\ntolerance = {{ error = 0.011 }}\n")
    command("collect", study, "--out", tmp_path)
    command("compare", tmp_path / "s.nc", code=1)
    # Nothing is to be run again: run checks what is there.
    assert "tolerance missed: error" in command("run", study, "--out", tmp_path, code=1).err
