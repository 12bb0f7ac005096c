"""The error against the case known best, and settings that are recommended by errors."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.conventions import COMPLETED, FORMAT_VERSION
from harness.archive.netcdf_files import write_netcdf
from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.cli.options import share
from harness.compare.compared import NothingToCompareError
from harness.compare.costs import DERIVED, recommend
from harness.compare.finest_error import FLOOR, with_finest_error
from harness.errors import HarnessError
from harness.study.compared import ERROR_FINEST
from tests.harness.conftest import Command, Refusal, as_collected


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


CELLS = [5.0, 10.0, np.nan, np.nan]


def two_scenes() -> xr.Dataset:
    """Two cases of each scene; the other scene's cells are not this one's."""
    made = xr.Dataset(
        {
            "error": ("case", [0.05, 0.01, 0.5, 0.3]),
            "run_time": ("case", [1.0, 2.0, 0.1, 0.2]),
        },
        coords={
            "case": range(4),
            "scene": ("case", ["thick_cylinder"] * 2 + ["sliding_block"] * 2),
            "cell_count": ("case", CELLS),
            "cells_per_length": ("case", CELLS[::-1]),
            "damping_ratio": ("case", [np.nan, np.nan, 0.05, 0.05]),
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
    assert found is not None
    assert str(found).startswith("cell_count = 10: error 1.00% and 2 s at most, over 1 case of")
    assert recommend("sliding_block", 0.02, [file]) is None
    other = recommend("sliding_block", 0.5, [file])
    assert other.settings == {"cells_per_length": 10}


def test_recommended_are_the_cheapest_settings_good_for_every_soil(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    """None that failed once."""
    file = written(tmp_path, two_soils)
    found = recommend("cone_penetration", 0.05, [file])
    assert found.settings == {"cells_per_radius": 2.0}
    assert (found.error, found.run_time) == (pytest.approx(0.02), 2.5)
    cheap = recommend("cone_penetration", 0.5, [file])
    assert cheap.settings == {"cells_per_radius": 1.5}
    two_soils["status"].loc[{"rigidity_index": 100.0, "cells_per_radius": 2.0}] = "diverged"
    assert recommend("cone_penetration", 0.05, [written(tmp_path, two_soils)]) is None


@pytest.mark.parametrize(("error", "code"), [("5%", 0), ("0.0001", 1)])
def test_recommend_from_the_command_line(
    error: str, code: int, tmp_path: Path, command: Command, two_soils: xr.Dataset
) -> None:
    written(tmp_path, two_soils)
    arguments = ["recommend", "cone_penetration", "--error", error, "--results", tmp_path]
    told = command(*arguments, code=code).out
    assert ("cells_per_radius = 2.0" in told) == (code == 0)


def test_files_that_are_no_studies_are_passed_over(tmp_path: Path) -> None:
    file = written(tmp_path, two_scenes())
    strange = xr.Dataset({"error": 0.1})
    case = strange.assign_attrs(format_version=FORMAT_VERSION, scene="thick_cylinder")
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
    with pytest.raises(HarnessError, match="no result with errors"):
        recommend("cone_penetration", 0.05, [file])
    dataset = two_scenes().drop_vars(["error", "cell_count", "cells_per_length", "scene"])
    file = written(tmp_path, dataset.assign_attrs(scene="cone_penetration"))
    with pytest.raises(HarnessError, match="none varies the method: accuracy, cells_per_radius"):
        recommend("cone_penetration", 0.05, [file])
    with pytest.raises(HarnessError, match="step_cost: has no errors"):
        recommend("step_cost", 0.05, [])


def test_a_folder_that_is_not_there_is_told(tmp_path: Path, refusal: Refusal) -> None:
    nowhere = str(tmp_path / "nowhere")
    line = refusal(["recommend", "thick_cylinder", "--error", "1%", "--results", nowhere])
    assert line == f"harness: --results {nowhere}: no such folder"


def test_no_error_is_promised_below_the_uncertainty_of_the_reference(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    dataset = two_soils.assign(error_floor=0.04 + 0.0 * two_soils.error_finest)
    found = recommend("cone_penetration", 0.05, [written(tmp_path, dataset)])
    assert found.error == pytest.approx(0.04)
    assert recommend("cone_penetration", 0.03, [written(tmp_path, dataset)]) is None


def test_fixed_settings_that_are_not_as_by_default_are_told(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    dataset = two_soils.assign(cell_growth=((), 0.8, {"role": "parameter"}))
    found = recommend("cone_penetration", 0.05, [written(tmp_path, dataset)])
    assert found.settings == {"cell_growth": 0.8, "cells_per_radius": 2.0}


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


def test_an_error_of_the_whole_asks_whether_percent_are_meant(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        main(["recommend", "cone_penetration", "--error", "1"])
    assert "'1' is 100%: is 1% meant?" in capsys.readouterr().err
    assert share("150%") == 1.5
