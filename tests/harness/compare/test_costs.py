"""The error against the case known best, settings recommended by errors, what a step costs."""

from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.conventions import COMPLETED
from harness.archive.netcdf_files import write_netcdf
from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.compare.compared import NothingToCompareError
from harness.compare.costs import DERIVED, bench_rows, recommend
from harness.compare.finest_error import FLOOR, with_finest_error
from harness.compare.result_table import result_table
from harness.errors import HarnessError
from harness.study.compared import ERROR_FINEST
from mpm_warp.fields.declaration import Value
from tests.harness.conftest import Command, as_collected


def test_error_is_against_the_costliest_case_of_the_same_soil(two_soils: xr.Dataset) -> None:
    error = two_soils[ERROR_FINEST]
    np.testing.assert_allclose(error.sel(rigidity_index=50.0), [0.1, 0.02, np.nan], rtol=1e-12)
    # Where the finest case has failed, the next one is the reference.
    stiff = error.sel(rigidity_index=100.0)
    np.testing.assert_allclose(stiff, [11.0 / 10.1 - 1.0, np.nan, np.nan], rtol=1e-12)


def test_where_nothing_is_to_be_compared_there_is_no_error(two_soils: xr.Dataset) -> None:
    """Beside an exact one, of one case of each soil, without parameters of the method."""
    bare, method = two_soils.drop_vars(ERROR_FINEST), ["cells_per_radius"]
    assert ERROR_FINEST not in with_finest_error(bare.assign(error=0.5), method)
    assert ERROR_FINEST not in with_finest_error(bare.isel(cells_per_radius=[1]), method)
    assert ERROR_FINEST not in with_finest_error(bare, [])


def stating(dataset: xr.Dataset, half_width: list[float], settled: list[float]) -> xr.Dataset:
    """The soil whose cases are all complete, with what they state of themselves."""
    soil = dataset.drop_vars(ERROR_FINEST).sel(rigidity_index=[50.0])
    return soil.assign(
        cone_factor_uncertainty=("cells_per_radius", half_width, {"role": "uncertainty"}),
        cone_factor_settled=("cells_per_radius", settled, {"role": "settled"}),
    )


def test_the_best_known_case_is_the_reference_and_its_u_the_floor(
    two_soils: xr.Dataset,
) -> None:
    dataset = stating(two_soils, [np.nan, 0.09, 0.3], [1.0, 1.0, 1.0])
    told = with_finest_error(dataset, ["cells_per_radius"])
    error, floor = told[ERROR_FINEST].values[0], told[FLOOR].values[0]
    np.testing.assert_allclose(error, [9.9 / 9.18 - 1.0, np.nan, 1.0 - 9.0 / 9.18], rtol=1e-12)
    np.testing.assert_allclose(floor, [0.09 / 9.18, np.nan, 0.09 / 9.18], rtol=1e-12)


def test_the_reference_is_that_of_the_least_error_but_for_what_a_longer_run_takes_away(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    """The finest mesh, whose U is no smaller because the test was too short."""
    dataset = stating(two_soils, [0.3, 0.2, 0.25], [1.0] * 3)
    steadiness = ("cells_per_radius", [0.0, 0.0, 0.22])
    parts = [*["mesh, 90 % of U^2: more cells"] * 2, "steadiness, 77 % of U^2: more penetration"]
    dataset = dataset.assign(
        cone_factor_uncertainty_steadiness=steadiness,
        largest_part_of_uncertainty=("cells_per_radius", parts),
    )
    judged = with_finest_error(dataset, ["cells_per_radius"])
    assert np.isfinite(judged[ERROR_FINEST].values[0]).tolist() == [True, True, False]
    table = result_table(judged)
    assert "cells_per_radius=2.0: mesh: more cells\n" in table
    assert "U of rigidity_index=50.0, cells_per_radius=4.0: steadiness: more penetration" in table
    wide = judged.assign(cone_factor_uncertainty=judged["cone_factor_uncertainty"] * [1, 2, 1])
    found = recommend("cone_penetration", 0.05, [written(tmp_path, wide)])
    assert "largest part of its U: mesh, 90 % of U^2: more cells" in str(found)


def test_a_case_not_settled_has_no_error_and_is_no_reference(
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
    with pytest.raises(NothingToCompareError, match="the soil and cone of a case here"):
        with_finest_error(two_soils.drop_vars(ERROR_FINEST), ["cells_per_radius"], other)


CELLS = [5.0, 10.0, np.nan, np.nan]


def two_scenes() -> xr.Dataset:
    """Two cases of each scene; the other scene's cells are not this one's."""
    made = xr.Dataset(
        {"error": ("case", [0.05, 0.01, 0.5, 0.3]), "run_time": ("case", [1.0, 2.0, 0.1, 0.2])},
        coords={
            "case": range(4),
            "scene": ("case", ["thick_cylinder"] * 2 + ["sliding_block"] * 2),
            "cell_count": ("case", CELLS),
            "cells_per_length": ("case", CELLS[::-1]),
            "damping_ratio": ("case", [np.nan, np.nan, 0.2, 0.2], {"role": "parameter"}),
        },
    )
    return as_collected(made, "case", [COMPLETED] * 4, scene="thick_cylinder sliding_block")


def written(folder: Path, dataset: xr.Dataset) -> Path:
    file = folder / "made.nc"
    write_study(file, dataset)
    return file


def test_cases_of_one_scene_of_several(tmp_path: Path) -> None:
    file = written(tmp_path, two_scenes())
    found = recommend("thick_cylinder", 0.02, [file])
    assert str(found).startswith("cell_count = 10: error 1.00% and 2 s at most, over 1 case of")
    assert recommend("sliding_block", 0.02, [file]).error == 0.3  # none reach it: the nearest
    other = recommend("sliding_block", 0.5, [file])
    assert other.settings == {"damping_ratio": 0.2, "cells_per_length": 10}


def test_the_cheapest_settings_good_for_every_soil(tmp_path: Path, two_soils: xr.Dataset) -> None:
    """None that failed once."""
    file = written(tmp_path, two_soils)
    found = recommend("cone_penetration", 0.05, [file])
    assert found.settings == {"cells_per_radius": 2.0}
    assert (found.error, found.run_time) == (pytest.approx(0.02), 2.5)
    assert found.case_count == 1  # in the other soil it is the reference
    cheap = recommend("cone_penetration", 0.5, [file])
    assert cheap.settings == {"cells_per_radius": 1.5}
    two_soils["status"].loc[{"rigidity_index": 100.0, "cells_per_radius": 2.0}] = "diverged"
    assert recommend("cone_penetration", 0.05, [written(tmp_path, two_soils)]).error > 0.05


@pytest.mark.parametrize(("error", "code"), [("5%", 0), ("0.0001", 1)])
def test_recommend_from_the_command_line(
    error: str, code: int, tmp_path: Path, command: Command, two_soils: xr.Dataset
) -> None:
    written(tmp_path, two_soils)
    arguments = ["recommend", "cone_penetration", "--error", error, "--results", tmp_path]
    told = command(*arguments, code=code).out
    assert ("no settings in" in told) == (code == 1)
    assert "cells_per_radius = 2.0: error 2.00% and 2.5 s" in told


def test_a_setting_named_as_a_result_is_told(tmp_path: Path, two_soils: xr.Dataset) -> None:
    far = two_soils.rename(cells_per_radius="penetration_parameter")
    found = recommend("cone_penetration", 0.05, [written(tmp_path, far)])
    assert (found.settings, found.case_count) == ({"penetration": 2.0}, 1)


def test_files_that_are_no_studies_are_passed_over(tmp_path: Path) -> None:
    file = written(tmp_path, two_scenes())
    strange = xr.Dataset({"error": 0.1})
    case = strange.assign_attrs(scene="thick_cylinder")
    for name, dataset in {"verify": strange, "case": case}.items():
        write_netcdf(dataset, tmp_path / f"{name}.nc")
    found = recommend("thick_cylinder", 0.02, sorted(tmp_path.glob("*.nc")))
    assert found.file == file


def test_values_that_the_scene_derives_are_alike(tmp_path: Path) -> None:
    dataset = two_scenes().drop_vars(["scene", "cell_count", "cells_per_length", "damping_ratio"])
    dataset = dataset.assign_coords(domain_radius=("case", [np.nan, np.nan, 20.0, 20.0]))
    file = written(tmp_path, dataset.assign_attrs(scene="cone_penetration"))
    found = recommend("cone_penetration", 0.1, [file])
    assert (found.settings, found.case_count) == ({"domain_radius": DERIVED}, 2)


def test_why_nothing_is_recommended_is_told(tmp_path: Path, two_soils: xr.Dataset) -> None:
    file = written(tmp_path, two_soils.drop_vars("error_finest"))
    with pytest.raises(HarnessError, match="no stored result has errors"):
        recommend("cone_penetration", 0.05, [file])
    dataset = two_scenes().drop_vars(["error", "cell_count", "cells_per_length", "scene"])
    file = written(tmp_path, dataset.assign_attrs(scene="cone_penetration"))
    with pytest.raises(HarnessError, match="none varies the method: accuracy, cells_per_radius"):
        recommend("cone_penetration", 0.05, [file])
    with pytest.raises(HarnessError, match="step_cost: its error is unknown"):
        recommend("step_cost", 0.05, [])


def test_no_error_is_promised_below_the_floor(tmp_path: Path, two_soils: xr.Dataset) -> None:
    dataset = two_soils.assign(error_floor=0.04 + 0.0 * two_soils.error_finest)
    found = recommend("cone_penetration", 0.05, [written(tmp_path, dataset)])
    assert found.error == pytest.approx(0.04)
    assert recommend("cone_penetration", 0.03, [written(tmp_path, dataset)]).error > 0.03


@pytest.mark.parametrize(
    ("name", "value", "by_default"),
    [
        ("time_step_fraction", 0.5, 0.85),
        ("poissons_ratio_bound", 0.45, 0.475),
        ("accuracy", "fine", "standard"),
    ],
)
def test_fixed_settings_that_are_not_as_by_default_are_told(
    name: str, value: Value, by_default: Value, tmp_path: Path, two_soils: xr.Dataset
) -> None:
    """A default may follow from the soil: Ir 50 has another bound of Poisson's ratio."""
    for given, told in ((value, {name: value}), (by_default, {})):
        dataset = two_soils.assign({name: ((), given, {"role": "parameter"})})
        found = recommend("cone_penetration", 0.05, [written(tmp_path, dataset)])
        assert found.settings == told | {"cells_per_radius": 2.0}


def test_a_case_that_tells_nothing_of_its_error_is_not_recommended(tmp_path: Path) -> None:
    """Among others that do: it may be near the reference by luck."""
    cells = ("case", [1.5, 3.0, 6.0])
    dataset = xr.Dataset(
        {
            "error_finest": ("case", [0.001, 0.006, 0.004], {"role": "error"}),
            "cone_factor": ("case", [11.4, 11.3, 11.35], {"role": "headline"}),
            "cone_factor_uncertainty": ("case", [np.nan, 0.08, 0.06], {"role": "uncertainty"}),
            "run_time": ("case", [0.5, 5.0, 40.0]),
        },
        coords={"case": range(3), "cells_per_radius": (*cells, {"role": "parameter"})},
    )
    dataset = as_collected(dataset, "case", [COMPLETED] * 3)
    found = recommend("cone_penetration", 0.01, [written(tmp_path, dataset)])
    assert found.settings["cells_per_radius"] == 3.0
    assert found.error == pytest.approx(0.08 / 11.3), "no less than the half width it states"
    silent = dataset.drop_vars("cone_factor_uncertainty")
    found = recommend("cone_penetration", 0.01, [written(tmp_path, silent)])
    assert found.settings["cells_per_radius"] == 1.5


SPEED = "million updates/s, median (least to most)"
GAIN = "times as fast as one thread"
MEMORY = "arrays, bytes a point"
QUICK = ["--set", "samples=2", "--set", "sample_time=0.01", "--set", "size=600"]


def table(rows: Sequence[str], title: str) -> dict[str, str]:
    """What stands in the table of that title, by whatever varies besides the size."""
    first = rows.index(f"| {title} | 600 points |") + 2
    cells = [row.strip("| ").split(" | ") for row in takewhile(bool, rows[first:])]
    return dict(cells)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("one")
    assert main(["bench", *QUICK, "--out", str(folder)]) == 0
    return folder / "bench.nc"


@pytest.mark.slow
def test_bench_measures_every_case_and_shows_the_stages_of_the_fullest_and_can_be_compared(
    result: Path, command: Command
) -> None:
    assert "update_rate " in command("compare", result, result, "--tolerance", "1e6").out
    dataset = xr.open_dataset(result)
    assert dict(dataset.update_rate.sizes) == {"physics": 3, "threads": 2}
    assert (dataset.update_rate_lowest <= dataset.update_rate).all()
    assert (dataset.update_rate <= dataset.update_rate_highest).all()
    rows = bench_rows(dataset)
    assert len(table(rows, SPEED)) == 6
    case = dataset.sel(physics="cone", threads=1)
    assert {"particles_to_grid", "grid_to_particles", "cell_rates"} <= set(case.stage.values)
    stages = {row.split("`")[1]: row.split("|")[2:-1] for row in rows if row.startswith("| `")}
    assert stages
    times = case.stage_time.dropna("stage")
    rates = 1e9 * case.stage_bytes / times
    for name, (time, share, size, bandwidth) in stages.items():
        assert time.strip() == f"{times.sel(stage=name):.2f}"
        assert share.strip() == f"{times.sel(stage=name) / times.sum():.1%}"
        assert size.strip() == f"{case.stage_bytes.sel(stage=name):.0f}"
        assert bandwidth.strip() == f"{(rates.sel(stage=name) / case.copy_rate).item():.0%}"
    reached = (1e9 * case.stage_bytes.sum() / times.sum() / case.copy_rate).item()
    assert f" {reached:.0%} of what a copy moves here " in rows[-1]
    assert rows[-1].endswith("not memory.") == (reached <= 0.8)
    assert list(table(rows, MEMORY).values()) == [
        f"{case:.0f}" for case in dataset.array_bytes.values.flat
    ]
    assert (dataset.thread_gain.sel(threads=2) > 0).all()
    assert dataset.thread_gain.sel(threads=1).isnull().all()
    assert list(table(rows, GAIN).values()) == [
        f"{gain:.2f}" for gain in dataset.thread_gain.sel(threads=2).values
    ]
