"""The error of a mesh by least squares: exact for a power of the width, large where none fits."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.conventions import FORMAT_VERSION
from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.compare.compared import NothingToCompareError
from harness.compare.least_squares import fit, least_squares_table
from mpm_warp.uncertainty.laws import mesh_error

SIZES = [0.8, 0.4, 0.2, 0.1]
MESH_ERROR = Path(__file__).parents[3] / "studies" / "mesh_error.csv"


@pytest.mark.parametrize("order", [0.5, 1.0, 1.5, 2.0])
def test_a_power_of_the_width_is_found_and_its_half_width_is_a_quarter_more(order: float) -> None:
    found = fit(SIZES, [10.0 + 0.3 * size**order for size in SIZES])
    assert found.is_taken
    assert found.order == pytest.approx(order, abs=1e-9)
    assert found.limit == pytest.approx(10.0, abs=1e-9)
    expected = [1.25 * 0.3 * size**order for size in SIZES]
    np.testing.assert_allclose(found.half_widths, expected, atol=1e-9)


def test_of_another_order_the_first_or_second_is_taken_and_doubted() -> None:
    found = fit(SIZES, [10.0 + size**4 for size in SIZES])
    assert not found.is_taken
    assert found.order == pytest.approx(4.0)
    assert (found.half_widths > 1.25 * np.array(SIZES) ** 4).all()


def test_values_that_scatter_have_a_larger_half_width() -> None:
    values = np.array([10.0 + 0.3 * size for size in SIZES])
    scatter = np.array([0.0, 0.1, -0.1, 0.1])
    assert (fit(SIZES, values + scatter).half_widths > fit(SIZES, values).half_widths).all()


def cases() -> xr.Dataset:
    """The cases of `mesh_error`, their cone factors corrected for the mesh."""
    table = np.genfromtxt(MESH_ERROR, delimiter=",", names=True)
    names = ("rigidity_index", "adhesion_factor", "cells_per_radius")
    rows = np.round(table["cells_per_radius"] * math.sqrt(3.0))
    errors = [
        mesh_error(
            rigidity_index=case["rigidity_index"],
            adhesion_factor=case["adhesion_factor"],
            cell_size=math.sqrt(3.0) / row,
            cell_growth=0.4,
        )
        for case, row in zip(table, rows, strict=True)
    ]
    simulated = table["cone_factor_simulated"]
    return xr.Dataset(
        {
            "cone_factor_simulated": ("case", simulated),
            "cone_factor": ("case", simulated - errors),
            "status": ("case", ["completed"] * len(table)),
            "message": ("case", [""] * len(table)),
            "case_key": ("case", [str(it) for it in range(len(table))]),
        },
        coords={"case": np.arange(len(table))} | {name: ("case", table[name]) for name in names},
    )


def test_on_the_meshes_of_the_project_it_has_the_same_limits_and_takes_no_order() -> None:
    """What a reviewer would find: the limits agree, but no power of the width fits."""
    lines = least_squares_table(cases()).splitlines()[3:47]
    words = [line.split() for line in lines]
    limits = np.array([float(it[6]) for it in words])
    corrected = np.array([float(it[-1]) for it in words])
    is_default = np.array([float(it[2]) for it in words]) == 2.89
    assert np.abs(limits - corrected)[is_default].max() < 0.075
    assert all("not taken" in line for line in lines)


def test_three_meshes_are_too_few() -> None:
    few = cases().isel(case=slice(3))
    with pytest.raises(NothingToCompareError, match="no cone factor on 4 values of cells_per_rad"):
        least_squares_table(few)


def test_the_table_from_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    attributes = {"study": "s", "scene": "cone_penetration", "scene_version": 1}
    write_study(tmp_path / "s.nc", cases().assign_attrs(attributes, format_version=FORMAT_VERSION))
    assert main(["compare", str(tmp_path / "s.nc"), "--standards"]) == 0
    assert "least squares: Eca & Hoekstra" in capsys.readouterr().out
