"""Case files and collected files: what was written comes back, in the layout of the study."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive import case_files, netcdf_files, study_files
from harness.archive.atomic_files import ArchiveError
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED, varied_names
from harness.study.cases import Case
from harness.study.study import Study, load_study


def result(depths: list[float], cone_factor: float) -> xr.Dataset:
    """What a scene returns, with exact and awkward numbers."""
    resistance = ("penetration", np.array(depths) / 3, {"units": "Pa", "long_name": "resistance"})
    labels = {"units": "1", "long_name": "cone factor", "role": "headline"}
    return xr.Dataset(
        {
            "cone_factor": ((), cone_factor, labels),
            "penetration_resistance": resistance,
            "particle_updates": ((), 2**40 + 1, {"units": "1", "long_name": "updates"}),
        },
        {"penetration": ("penetration", depths, {"units": "1", "long_name": "penetration"})},
    )


def complete(folder: Path, cases: Sequence[Case]) -> None:
    for k, case in enumerate(cases):
        case_files.write_case(folder, case, result([0.1, 0.2], 10 + k / 3), COMPLETED)


def test_a_case_comes_back_bit_for_bit(folder: Path, small: Study) -> None:
    case = small.cases[0]
    assert case_files.read_case(folder, case) is None
    written = result([0.1, 0.2, 0.3], 31 / 3)
    case_files.write_case(folder, case, written, "diverged", "why")
    read = case_files.read_case(folder, case)
    xr.testing.assert_equal(read, written)
    assert read.cone_factor.attrs == written.cone_factor.attrs
    assert (read.attrs["status"], read.attrs["message"]) == ("diverged", "why")
    assert read.attrs["Conventions"] == "CF-1.11"
    assert not list(folder.glob(".*"))


def test_a_file_is_read_as_xarray_reads_it(tmp_path: Path) -> None:
    kept = result([0.1, np.nan], np.nan).assign_coords(
        clay=("penetration", ["soft", ""]), is_rough=True, layer=3
    )
    kept["is_steady"] = "penetration", [True, False]
    kept["told"] = (), "a text"
    kept["over_nothing"] = "none", np.empty(0)
    kept = kept.assign_coords(none=("none", np.empty(0)), alone=("aside", [1.0, 2.0]))
    path = tmp_path / "kept.nc"
    netcdf_files.write_netcdf(kept.assign_attrs(whole=2.5), path)
    read = netcdf_files.read_netcdf(path)
    with xr.open_dataset(path) as known:
        xr.testing.assert_identical(read.assign_attrs(known.attrs), known.load())
        assert read.attrs == {"whole": 2.5}
        assert known.attrs == {"whole": 2.5, "format_version": 1}
        assert {name: it.dtype for name, it in read.variables.items()} == {
            name: it.dtype for name, it in known.variables.items()
        }
        assert list(read.variables) == list(known.variables)
        assert list(read.coords) == list(known.coords)


def test_a_case_file_is_of_no_other_case_and_of_no_study(folder: Path, small: Study) -> None:
    one, other, _ = small.cases
    complete(folder, [one])
    with pytest.raises(ArchiveError, match="not the result of a study, but of one case"):
        study_files.read_study(case_files.case_file(folder, one))
    case_files.case_file(folder, one).rename(case_files.case_file(folder, other))
    with pytest.raises(ArchiveError, match="is not the result of case"):
        case_files.read_case(folder, other)


def test_dims_are_the_varied_parameters_then_the_scenes_own(folder: Path, small_file: Path) -> None:
    study = load_study(str(small_file), ['material=["von_mises"]', "rigidity_index=[200, 100]"])
    complete(folder, study.cases)
    dataset = collect(study, folder)
    assert dataset.cone_factor.dims == ("adhesion_factor", "material", "rigidity_index")
    assert dataset.penetration_resistance.dims[-1] == "penetration"
    assert dataset.rigidity_index.values.tolist() == [200, 100]
    selected = dataset.cone_factor.sel(adhesion_factor=1, material="von_mises", rigidity_index=200)
    assert selected.item() == 10 + 4 / 3


def test_all_parameters_are_in_the_study(folder: Path, small: Study) -> None:
    complete(folder, small.cases)
    dataset = collect(small, folder)
    assert dataset.rigidity_index.item() == 100
    assert dataset.undrained_shear_strength.attrs["units"] == "Pa"
    assert dataset.material.item() == "tresca"
    # A default that is derived is stored as what was used: the adhesion factor of the face.
    shaft = dataset.shaft_adhesion_factor
    np.testing.assert_array_equal(shaft, dataset.adhesion_factor.broadcast_like(shaft))
    assert dataset.penetration_parameter.item() == 1  # `penetration` is a coordinate of the scene
    assert all("long_name" in variable.attrs for variable in dataset.variables.values())


def test_curves_of_different_length_are_padded(folder: Path, small: Study) -> None:
    cases = small.cases
    for case, depths in zip(cases, ([0.1, 0.2], [0.1, 0.2, 0.3], [0.3]), strict=True):
        case_files.write_case(folder, case, result(depths, 1.0), COMPLETED)
    resistance = collect(small, folder).penetration_resistance
    assert resistance.penetration.values.tolist() == [0.1, 0.2, 0.3]
    expected = [[0.1 / 3, 0.2 / 3, np.nan], [0.1 / 3, 0.2 / 3, 0.3 / 3], [np.nan, np.nan, 0.3 / 3]]
    np.testing.assert_array_equal(resistance.values, np.array(expected))


def test_a_missing_result_is_answered_with_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "mesh_size.nc").touch()
    with pytest.raises(ArchiveError, match=r"did you mean 'mesh_size\.nc'"):
        study_files.read_study(tmp_path / "meshsize.nc")


def test_parameters_that_a_scene_returns_are_those_of_the_case(folder: Path, small: Study) -> None:
    for case in small.cases:
        own = result([0.1, 0.2], 10.0)
        own["rigidity_index"] = (), 100.0, {"role": "parameter"}
        own["adhesion_factor"] = (), case.parameters["adhesion_factor"], {"role": "parameter"}
        case_files.write_case(folder, case, own, COMPLETED)
    dataset = collect(small, folder)
    assert dataset.rigidity_index.item() == 100
    assert dataset.adhesion_factor.values.tolist() == [0, 0.5, 1]
    assert dataset.adhesion_factor.attrs["role"] == "parameter"
    assert not {"rigidity_index_parameter", "adhesion_factor_parameter"} & set(dataset.variables)


def test_what_a_scene_derives_from_them_is_no_coordinate(folder: Path, small: Study) -> None:
    """Not where a law gives it in place of a default either, as Cam clay its strength."""
    derived = []
    for case in small.cases:
        own = {"shaft_adhesion_factor": case.parameters["adhesion_factor"]}
        own["undrained_shear_strength"] = 1e4 * (1.0 + own["shaft_adhesion_factor"])
        derived.append(dataclasses.replace(case, parameters={**case.parameters, **own}))
    vars(small)["cases"] = tuple(derived)
    complete(folder, derived)
    dataset = collect(small, folder)
    assert dataset.shaft_adhesion_factor.values.tolist() == [0, 0.5, 1]
    assert dataset.undrained_shear_strength.values.tolist() == [1e4, 1.5e4, 2e4]
    assert not {"shaft_adhesion_factor", "undrained_shear_strength"} & set(dataset.coords)
    assert varied_names(dataset) == ["adhesion_factor"]


def test_numbers_keep_their_type_where_all_cases_have_them(folder: Path, small: Study) -> None:
    complete(folder, small.cases)
    assert collect(small, folder).particle_updates.dtype == np.int64
    case_files.discard(folder, small.cases[:1])
    assert np.isnan(collect(small, folder).particle_updates.values[0])
