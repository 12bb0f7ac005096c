"""Settings that are recommended: out of which files and cases, and what is said where none are."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.conventions import COMPLETED, FORMAT_VERSION
from harness.archive.netcdf_files import write_netcdf
from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.cli.parser import share
from harness.compare.costs import DERIVED, recommend
from harness.errors import HarnessError
from tests.harness.conftest import Refusal

CELLS = [5.0, 10.0, np.nan, np.nan]


def two_scenes() -> xr.Dataset:
    """Two cases of each scene; the other scene's cells are not this one's."""
    return xr.Dataset(
        {
            "error": ("case", [0.05, 0.01, 0.5, 0.3]),
            "run_time": ("case", [1.0, 2.0, 0.1, 0.2]),
            "status": ("case", [COMPLETED] * 4),
            "message": ("case", [""] * 4),
            "case_key": ("case", list("abcd")),
        },
        coords={
            "case": range(4),
            "scene": ("case", ["thick_cylinder"] * 2 + ["sliding_block"] * 2),
            "cell_count": ("case", CELLS),
            "cells_per_length": ("case", CELLS[::-1]),
            "damping_ratio": ("case", [np.nan, np.nan, 0.05, 0.05]),
        },
        attrs={
            "scene": "thick_cylinder sliding_block",
            "scene_version": 1,
            "study": "made",
            "format_version": FORMAT_VERSION,
        },
    )


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
    assert other is not None
    assert other.settings == {"cells_per_length": 10}


def test_recommended_are_the_cheapest_settings_good_for_every_soil(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    file = written(tmp_path, two_soils)
    found = recommend("cone_penetration", 0.05, [file])
    assert found is not None
    assert found.settings == {"cells_per_radius": 2.0}
    assert (found.error, found.run_time) == (pytest.approx(0.02), 2.5)
    cheap = recommend("cone_penetration", 0.5, [file])
    assert cheap is not None
    assert cheap.settings == {"cells_per_radius": 1.5}


def test_settings_that_failed_once_are_not_recommended(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    dataset = two_soils
    dataset["status"].loc[{"rigidity_index": 100.0, "cells_per_radius": 2.0}] = "diverged"
    assert recommend("cone_penetration", 0.05, [written(tmp_path, dataset)]) is None


def test_nothing_is_recommended_from_nothing(tmp_path: Path, two_soils: xr.Dataset) -> None:
    file = written(tmp_path, two_soils.drop_vars("error_finest"))
    with pytest.raises(HarnessError, match="no result with errors"):
        recommend("cone_penetration", 0.05, [file])


@pytest.mark.parametrize(("error", "code"), [("5%", 0), ("0.0001", 1)])
def test_recommend_from_the_command_line(
    error: str, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str], two_soils: xr.Dataset
) -> None:
    written(tmp_path, two_soils)
    arguments = ["recommend", "cone_penetration", "--error", error, "--results", str(tmp_path)]
    assert main(arguments) == code
    assert ("cells_per_radius = 2.0" in capsys.readouterr().out) == (code == 0)


def test_files_that_are_no_studies_are_passed_over(tmp_path: Path) -> None:
    file = written(tmp_path, two_scenes())
    strange = xr.Dataset({"error": 0.1})
    case = strange.assign_attrs(format_version=FORMAT_VERSION, scene="thick_cylinder")
    for name, dataset in {"verify": strange, "case": case}.items():
        write_netcdf(dataset, tmp_path / f"{name}.nc")
    found = recommend("thick_cylinder", 0.02, sorted(tmp_path.glob("*.nc")))
    assert found is not None
    assert found.file == file


def test_a_damaged_file_is_told_of(tmp_path: Path) -> None:
    (tmp_path / "made.nc").write_bytes(b"noise")
    with pytest.raises(ArchiveError, match=r"made\.nc: cannot be read"):
        recommend("thick_cylinder", 0.02, [tmp_path / "made.nc"])


def test_values_that_the_scene_derives_are_alike(tmp_path: Path) -> None:
    dataset = two_scenes().drop_vars(["scene", "cell_count", "cells_per_length", "damping_ratio"])
    dataset = dataset.assign_coords(domain_radius=("case", [np.nan, np.nan, 20.0, 20.0]))
    file = written(tmp_path, dataset.assign_attrs(scene="cone_penetration"))
    found = recommend("cone_penetration", 0.1, [file])
    assert found is not None
    assert (found.settings, found.case_count) == ({"domain_radius": DERIVED}, 2)


def test_that_none_varies_the_method_is_told(tmp_path: Path) -> None:
    dataset = two_scenes().drop_vars(["error", "cell_count", "cells_per_length", "scene"])
    file = written(tmp_path, dataset.assign_attrs(scene="cone_penetration"))
    with pytest.raises(HarnessError, match="none varies the method: accuracy, cells_per_radius"):
        recommend("cone_penetration", 0.05, [file])


def test_that_a_scene_has_no_errors_is_told() -> None:
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
    assert found is not None
    assert found.error == pytest.approx(0.04)
    assert recommend("cone_penetration", 0.03, [written(tmp_path, dataset)]) is None


def test_fixed_settings_that_are_not_as_by_default_are_told(
    tmp_path: Path, two_soils: xr.Dataset
) -> None:
    dataset = two_soils.assign(cell_growth=((), 0.8, {"role": "parameter"}))
    found = recommend("cone_penetration", 0.05, [written(tmp_path, dataset)])
    assert found is not None
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
            "status": ("case", [COMPLETED] * 3),
            "message": ("case", [""] * 3),
            "case_key": ("case", list("abc")),
        },
        coords={"case": range(3), "cells_per_radius": (*cells, {"role": "parameter"})},
        attrs=two_scenes().attrs | {"scene": "cone_penetration"},
    )
    found = recommend("cone_penetration", 0.01, [written(tmp_path, dataset)])
    assert found is not None
    assert found.settings["cells_per_radius"] == 3.0
    assert found.error == pytest.approx(0.08 / 11.3), "no less than the half width it states"
    silent = dataset.drop_vars("cone_factor_uncertainty")
    found = recommend("cone_penetration", 0.01, [written(tmp_path, silent)])
    assert found is not None
    assert found.settings["cells_per_radius"] == 1.5


def test_an_error_of_the_whole_asks_whether_percent_are_meant(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        main(["recommend", "cone_penetration", "--error", "1"])
    assert "'1' is 100%: is 1% meant?" in capsys.readouterr().err
    assert share("150%") == 1.5
