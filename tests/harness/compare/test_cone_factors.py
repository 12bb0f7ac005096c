"""Cone factors beside the literature and bands of experience; the table of a terminal."""

import csv
from collections.abc import Sequence

import numpy as np
import pytest
import xarray as xr

from harness.archive.conventions import Role, with_role
from harness.compare.compared import (
    NothingToCompareError,
    conditions_of,
    misses,
    stored_references,
    with_experience,
    with_references,
    with_tolerances,
)
from harness.compare.differences import differences
from harness.compare.result_table import cone_factor_table, which_strength
from harness.references.registry import band_of, reference_of
from tests.harness.compare.conftest import Two

THREE = tuple(map(reference_of, ("lu_2004", "teh_houlsby_1991", "yu_2000")))


def result(cone_factor: float = 11.0, **varied: Sequence[object]) -> xr.Dataset:
    """A study's result with the same cone factor in every case; `varied` are its dims."""
    fixed = {
        "rigidity_index": 100.0,
        "adhesion_factor": 0.5,
        "shaft_adhesion_factor": np.nan,
        "apex_angle": 60.0,
        "friction_coefficient": 0.0,
    }
    shape = tuple(len(values) for values in varied.values())
    dataset = xr.Dataset(
        {name: value for name, value in fixed.items() if name not in varied},
        coords={name: (name, values) for name, values in varied.items()},
    )
    dataset["cone_factor"] = tuple(varied), np.full(shape, cone_factor)
    shear = np.sqrt(3.0) * dataset["adhesion_factor"]  # statics of a cone of 60 degrees
    dataset["cone_factor_shear"] = shear.broadcast_like(dataset.cone_factor)
    dataset["cone_factor_normal"] = dataset.cone_factor - dataset.cone_factor_shear
    dataset["run_time"] = tuple(varied), np.full(shape, 12.34)
    dataset["status"] = tuple(varied), np.full(shape, "completed")
    return dataset


def rows(text: str) -> list[str]:
    """The table's rows below the heading, one blank between words."""
    lines = text.partition("\n\n")[0].splitlines()
    return [" ".join(line.split()) for line in lines[3:]]


def test_reference_and_deviation_stand_over_the_dims_of_the_cone_factor() -> None:
    dataset = with_references(
        result(material=["tresca", "von_mises"], rigidity_index=[50.0, 100.0]), THREE
    )
    reference = dataset["reference_teh_houlsby_1991"]
    deviation = dataset["deviation_teh_houlsby_1991"]
    assert reference.dims == deviation.dims == ("material", "rigidity_index")
    # By hand; in von Mises clay sqrt(3)/2 of the value at Ir 57.735, 115.4701 and adhesion 0.57735.
    by_hand = [[9.450439, 10.815628], [8.566040, 9.781250]]
    np.testing.assert_allclose(reference, by_hand, rtol=1e-6)
    np.testing.assert_array_equal(deviation, dataset.cone_factor / reference - 1)
    for variable in (reference, deviation):
        assert variable.attrs["units"] == "1"
        assert "Teh & Houlsby 1991" in variable.attrs["long_name"]
        assert "Geotechnique" in variable.attrs["source"]
        assert variable.attrs["criterion"] == "von_mises"
        assert "not read" in variable.attrs["how_known"]
        assert variable.attrs["su_mode"] == "triaxial_compression"
        assert "50 to 500" in variable.attrs["validity"]
    readings = {name for name in dataset if "yu_2000" in str(name)}
    kinds, tests = ("reference", "deviation"), ("pure_shear", "triaxial_compression")
    assert readings == {f"{kind}_yu_2000_{test}" for kind in kinds for test in tests}
    assert [it.id for it in stored_references(dataset.isel(material=[0]))][-1] in str(readings)


def test_attributes_of_a_parameter_do_not_leak_into_what_is_worked_out_from_it() -> None:
    dataset = result(rigidity_index=[50.0, 100.0])
    dataset["rigidity_index"].attrs = {"description": "rigidity index G/su", "role": "parameter"}
    dataset["adhesion_factor"].attrs = {"description": "adhesion factor", "role": "parameter"}
    dataset["cone_factor"].attrs = {"description": "steady", "role": "headline"}
    compared = with_references(dataset, THREE)
    for name in (it.id for it in THREE):
        assert compared[f"reference_{name}"].attrs["role"] == "reference"
        assert compared[f"deviation_{name}"].attrs["role"] == "deviation"
        for kind in ("reference", "deviation"):
            assert "description" not in compared[f"{kind}_{name}"].attrs


def test_a_failed_case_has_a_reference_and_no_deviation() -> None:
    dataset = result(adhesion_factor=[0.0, 1.0])
    dataset["cone_factor"][1] = np.nan
    compared = with_references(dataset, [reference_of("yu_2000")])
    assert np.isfinite(compared["reference_yu_2000"]).all()
    assert compared["deviation_yu_2000"].isnull().values.tolist() == [False, True]


def test_shaft_adhesion_is_the_faces_where_it_is_not_given() -> None:
    dataset = result(shaft_adhesion_factor=[0.0, np.nan])
    assert conditions_of(dataset)["alpha_s"].values.tolist() == [0.0, 0.5]
    assert conditions_of(result().drop_vars("shaft_adhesion_factor"))["alpha_s"] == 0.5


def test_a_cone_that_friction_makes_rough_is_compared_as_a_rough_one() -> None:
    """One case has what was built beside its parameters, the other failed."""
    built = {"adhesion_factor_built": 1.0, "friction_coefficient_built": 0.0}
    rows = {name: ("friction_coefficient", [value, np.nan]) for name, value in built.items()}
    dataset = result(friction_coefficient=[0.2, 0.3]).assign(rows)
    conditions = conditions_of(dataset)
    assert conditions["friction"].values.tolist() == [0.0, 0.3]
    assert conditions["alpha_c"].values.tolist() == [1.0, 0.5]
    laws = result(material=["tresca", "von_mises", "anisotropic", "a_law_of_their_own"])
    assert conditions_of(laws)["constant_su"].values.tolist() == [1.0, 1.0, 0.0, 0.0]


@pytest.mark.parametrize("missing", ["cone_factor", "rigidity_index", "adhesion_factor"])
def test_what_cannot_be_compared_is_refused_in_one_line(missing: str) -> None:
    dataset = result().drop_vars(missing)
    for compare in (lambda: with_references(dataset, THREE), lambda: cone_factor_table(dataset)):
        with pytest.raises(NothingToCompareError, match=missing) as caught:
            compare()
        assert "\n" not in str(caught.value)


def test_table_has_one_row_a_case_with_all_of_it() -> None:
    dataset = with_references(result(adhesion_factor=[0.0, 0.5, 1.0]), [reference_of("lu_2004")])
    dataset["cone_factor_shear"][1] = 0.875
    text = cone_factor_table(dataset)
    # 11 / 11.418 - 1 = -3.7 %
    assert rows(text) == [
        "0 11.0 11.0 0.000 10.77 +2.2% 12.3 completed",
        "0.5 11.0 10.1 0.875 11.42 -3.7% 12.3 completed",
        "1 11.0 9.27 1.732 12.07 -8.9% 12.3 completed",
    ]
    widths = {len(line) for line in text.partition("\n\n")[0].splitlines()[2:]}
    assert len(widths) == 1
    assert "as commonly quoted; the original was not read" in text


def test_another_criterion_is_named_in_brackets_and_another_su_is_told() -> None:
    """The envelope in von Mises clay, by any reading of its two references, is 9.70 to 10.73."""
    dataset = with_references(result(10.0, material=["tresca", "von_mises"]), THREE)
    text = cone_factor_table(dataset)
    tresca, mises = rows(text)
    assert "11.42 -12.4% [10.82 -7.5% von Mises]" in tresca
    assert "[11.42 -12.4% Tresca]" in mises
    assert " 9.78 +2.2% 10.73 -6.8% 9.70 +3.1% yes " in mises
    assert tresca.endswith(" [-] 12.3 completed")
    assert "von Mises, su in triaxial compression, which is 0.866 or 1 times su here" in text
    assert "no confidence interval" in text


def test_a_column_is_explained_without_references_too() -> None:
    """The place in the envelope, what was simulated, and the two parts of the factor."""
    dataset = result(10.0, material=["von_mises"])
    text = cone_factor_table(dataset.assign(cone_factor_simulated=dataset.cone_factor))
    assert "envelope" in text.splitlines()[1]
    notes = "envelope: least to", "as simulated: before the correction", "normal part, shear part: "
    assert all(f"\n{note}" in text for note in notes)
    assert "as simulated" not in cone_factor_table(dataset)


def test_a_tolerance_holds_for_cases_of_the_criterion_by_every_reading() -> None:
    limits = {"lu_2004": 0.2, "yu_2000": 0.05}
    computed = result(10.0, material=["tresca", "von_mises"])
    dataset = with_references(computed.assign_attrs(scene="cone_penetration"), THREE)
    beyond = misses(with_tolerances(dataset, limits))
    assert beyond == {
        "yu_2000": ["yu_2000_pure_shear: material=von_mises: 0.0676 is beyond the tolerance 0.05"],
    }


def test_table_of_two_varied_parameters_names_every_combination() -> None:
    text = cone_factor_table(result(material=["tresca", "von_mises"], rigidity_index=[50.0, 100.0]))
    assert [row.split()[:2] for row in rows(text)] == [
        ["tresca", "50"],
        ["tresca", "100"],
        ["von_mises", "50"],
        ["von_mises", "100"],
    ]


def test_table_shows_a_failed_case_as_failed() -> None:
    dataset = result(adhesion_factor=[0.0, 1.0])
    for name in ("cone_factor", "cone_factor_normal", "cone_factor_shear", "run_time"):
        dataset[name][1] = np.nan
    dataset["status"] = "adhesion_factor", ["completed", "diverged"]
    failed = rows(cone_factor_table(dataset))[1]
    assert failed == "1 - - - - diverged"


def test_a_csv_has_one_number_a_cell() -> None:
    dataset = with_references(result(rigidity_index=[50.0, 25.0]), [reference_of("lu_2004")])
    dataset["Bq"] = "rigidity_index", [0.5, 0.4]
    names, first, second = csv.reader(cone_factor_table(dataset, "csv").splitlines())
    inside, outside = (dict(zip(names, row, strict=True)) for row in (first, second))
    assert len(names) == len(inside)
    assert [it for it in names if it != it.strip()] == []
    found = [inside[f"lu 2004{it}"] for it in ("", " deviation", " applies")]
    assert found == ["10.31", "+6.7%", "yes"]
    assert outside["lu 2004 applies"] == "no"
    assert (inside["cone factor"], inside["cone factor +-"], inside["Bq"]) == ("11.0", "", "0.50")


OUTSIDE = {"rigidity_index": 25.0, "remoulded_strength_ratio": 0.2, "rate_factor": 0.1}
INSIDE = {"rigidity_index": 50.0, "remoulded_strength_ratio": 1.0, "rate_factor": 0.0}


@pytest.mark.parametrize("name", OUTSIDE)
def test_table_brackets_formulas_outside_their_validity(name: str) -> None:
    """They are all of clay that keeps its strength."""
    varied = {name: [OUTSIDE[name], INSIDE[name]]}
    dataset = with_references(result(**varied).assign(material="von_mises"), THREE[1:])
    outside, inside = rows(cone_factor_table(dataset))
    assert outside.count("[") == 4  # one reference by one su, another by two, and the envelope
    assert "[" not in inside


def test_formulas_do_not_apply_where_su_depends_on_the_test() -> None:
    dataset = result(material=["anisotropic", "tresca"])
    dataset["cone_factor"].attrs["long_name"] = "cone factor, compression"
    by_mode = dataset.assign(
        undrained_shear_strength=("material", [20e3, 20e3]),
        strength_by_compression=("material", [20e3, np.nan]),
        cone_factor_by_compression=("material", [9.0, np.nan]),
        cone_factor_by_average=("material", [12.0, np.nan]),
    )
    text = cone_factor_table(with_references(by_mode, THREE[:1]))
    directed, same_in_all = rows(text)
    assert directed.count("[") == 2  # its su in pure shear is not known
    assert "[" not in same_in_all
    assert " 12.0 " in directed
    assert "for a law with several strengths it is that of the law's main test" in text


@pytest.mark.parametrize("order", [slice(None), slice(None, None, -1)])
def test_table_tells_the_difference_of_the_finest_two(order: slice) -> None:
    dataset = result(cells_per_radius=[2.0, 4.0, 8.0], adhesion_factor=[0.0, 1.0])
    dataset["cone_factor"][:] = [[12.0, 12.0], [10.0, 12.0], [10.2, np.nan]]
    text = cone_factor_table(dataset.isel(cells_per_radius=order))
    assert "finest two (cells_per_radius 4 to 8): cone factor +2.00%, failed" in text
    assert "finest two" not in cone_factor_table(dataset.isel(cells_per_radius=[0]))


def test_table_shows_what_is_known_of_the_error_beside_the_cone_factor() -> None:
    dataset = result(adhesion_factor=[0.0, 1.0]).assign(
        cone_factor_uncertainty=("adhesion_factor", [0.083, np.nan], {"role": "uncertainty"})
    )
    known, unknown = rows(cone_factor_table(dataset))
    assert known.startswith("0 11.00 +- 0.08 ")
    assert unknown.startswith("1 11.0 ")


TWO = ("karlsrud_2005", "mayne_peuchen_2018")


def test_beside_a_band_the_factor_is_given_by_its_su_too() -> None:
    """In von Mises clay su in triaxial compression is sqrt(3)/2 of that in pure shear."""
    dataset = with_experience(result(9.0, material=["tresca", "von_mises"]), TWO)
    by_compression = dataset["cone_factor_by_compression"]
    np.testing.assert_allclose(by_compression, (9.0, 9.0 / np.sqrt(0.75)), rtol=1e-12)
    assert "cone_factor_by_compression" not in with_experience(result(material=["tresca"]), TWO)


def test_a_band_has_two_ends_says_what_it_is_and_is_no_reference(two_soils: xr.Dataset) -> None:
    dataset = with_experience(two_soils, TWO)
    band = dataset["experience_karlsrud_2005"]
    entry = band_of("karlsrud_2005")
    assert band.dims == ("bound",)
    assert band.sel(bound="least") == entry.bounds[0]
    assert band.sel(bound="greatest") == entry.bounds[1]
    assert band.attrs["role"] == "experience"
    assert band.attrs["factor"] == "Nkt = (qt - sigma_v0) / su"
    assert "triaxial compression" in band.attrs["strength"]
    assert "second hand" in band.attrs["how_known"]
    assert "OCR 1.2 to 6.3" in band.attrs["validity"]
    assert with_role(dataset, Role.EXPERIENCE) == [f"experience_{name}" for name in TWO]
    assert not with_role(dataset, Role.REFERENCE, Role.DEVIATION)
    assert set(dataset.data_vars) - set(two_soils.data_vars) == set(
        with_role(dataset, "experience")
    )


def test_the_table_has_one_line_for_all_bands(two_soils: xr.Dataset) -> None:
    before = cone_factor_table(two_soils)
    after = cone_factor_table(with_experience(two_soils, TWO))
    assert after.startswith(before)
    (line,) = after.removeprefix(before).strip().splitlines()
    assert line == (
        "experience (bands measured in the field): karlsrud_2005 Nkt 6.2 to 18.1, "
        "mayne_peuchen_2018 Nkt 10.1 to 13.7; su: peak in triaxial compression, consolidated "
        "anisotropically"
    )


def test_bands_are_no_results_that_are_compared(two: Two) -> None:
    first, second = two(10.0, 11.0, 12.0)
    found, lonely = differences(with_experience(first, TWO), second)
    assert not lonely
    assert all(it.size == 0.0 for it in found)
    assert not any("experience" in it.name for it in found)


@pytest.mark.parametrize(
    ("long_name", "by_compression", "said"),
    [
        ("cone factor", [np.nan, np.nan], "su is the strength in pure shear"),
        ("cone factor, simple shear", [9.0, 10.0], "cone factor, simple shear: by su in that test"),
        (
            "cone factor, by the su given",
            [9.0, 10.0],
            "cone factor, by the su given, N_ke too; other columns: by other su",
        ),
        (
            "cone factor",
            [9.0, 10.0],
            "cone factor: by su in the main test of each law, unless su is given, N_ke too",
        ),
        (
            "cone factor",
            [np.nan, 10.0],
            "for a law with several strengths it is that of the law's main test",
        ),
    ],
)
def test_each_law_tells_its_strength(
    long_name: str, by_compression: list[float], said: str
) -> None:
    """A case that did not complete tells nothing."""
    dims = ("case",)
    made = xr.Dataset(
        {
            "cone_factor": (dims, [10.0, 11.0, np.nan], {"long_name": long_name}),
            "strength_by_compression": (dims, [*by_compression, np.nan]),
            "status": (dims, ["completed", "completed", "failed"]),
        }
    )
    assert said in which_strength(made)
