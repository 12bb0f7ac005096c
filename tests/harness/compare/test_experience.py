"""Bands of experience beside a result: in its file and in one line below its table."""

from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr

from harness.archive.conventions import Role, with_role
from harness.archive.study_files import read_study, write_study
from harness.compare.compared import experience_notes, stored_experience, with_experience
from harness.compare.differences import differences
from harness.compare.result_table import cone_factor_table
from harness.references.registry import UnknownReferenceError, experience_entry

TWO = ("karlsrud_2005", "mayne_peuchen_2018")


def test_a_band_has_two_ends_and_says_what_it_is(two_soils: xr.Dataset) -> None:
    dataset = with_experience(two_soils, TWO)
    band = dataset["experience_karlsrud_2005"]
    entry = experience_entry("karlsrud_2005")
    assert band.dims == ("bound",)
    assert band.sel(bound="least") == entry.bounds[0]
    assert band.sel(bound="greatest") == entry.bounds[1]
    assert band.attrs["role"] == "experience"
    assert band.attrs["factor"] == "Nkt = (qt - sigma_v0) / su"
    assert "triaxial compression" in band.attrs["strength"]
    assert "second hand" in band.attrs["how_known"]
    assert "OCR 1.2 to 6.3" in band.attrs["validity"]


def test_a_band_is_no_reference_and_nothing_deviates_from_it(two_soils: xr.Dataset) -> None:
    added = with_experience(two_soils, TWO)
    assert with_role(added, Role.EXPERIENCE) == [f"experience_{name}" for name in TWO]
    assert not with_role(added, Role.REFERENCE, Role.DEVIATION)
    assert set(added.data_vars) - set(two_soils.data_vars) == set(with_role(added, "experience"))


def test_without_a_band_nothing_changes(two_soils: xr.Dataset) -> None:
    assert with_experience(two_soils, []).identical(two_soils)
    assert experience_notes(two_soils) == []


def test_bands_survive_a_file(tmp_path: Path, two_soils: xr.Dataset) -> None:
    write_study(tmp_path / "s.nc", with_experience(two_soils, TWO))
    read = read_study(tmp_path / "s.nc")
    assert tuple(entry.id for entry in stored_experience(read)) == TWO


def test_the_table_has_one_line_for_all_bands(two_soils: xr.Dataset) -> None:
    before = cone_factor_table(two_soils)
    after = cone_factor_table(with_experience(two_soils, TWO))
    assert after.startswith(before)
    (line,) = after.removeprefix(before).strip().splitlines()
    assert line == (
        "experience, bands and no references: karlsrud_2005 Nkt 6.2 to 18.1, mayne_peuchen_2018 "
        "Nkt 10.1 to 13.7; su: peak in triaxial compression, consolidated anisotropically"
    )


def test_bands_are_no_results_that_are_compared(two: Callable[..., list[xr.Dataset]]) -> None:
    first, second = two(10.0, 11.0, 12.0)
    found, lonely = differences(with_experience(first, TWO), second)
    assert not lonely
    assert all(it.size == 0.0 for it in found)
    assert not any("experience" in it.name for it in found)


def test_an_unknown_band_is_refused(two_soils: xr.Dataset) -> None:
    with pytest.raises(UnknownReferenceError, match="did you mean 'karlsrud_2005'"):
        with_experience(two_soils, ["karlsrud_2004"])
