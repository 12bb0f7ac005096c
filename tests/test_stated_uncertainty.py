"""The tables under studies/ by which the uncertainty of the cone factor is set, and tested."""

import csv
import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from harness.references.cone_factors import Conditions
from harness.references.registry import cone_factor_reference
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.cone import NOISE
from mpm_warp.uncertainty.laws import (
    CURVATURE,
    CURVATURE_POWER,
    GROWTH_ERROR,
    LIMIT,
    MESH,
    MESH_ERRORS,
    RIGIDITY_INDICES,
    growth_measure,
    mesh_error,
)

STUDIES = Path(__file__).parent.parent / "studies"
GROWTH = 0.4
"""Growth of the cells of all cases."""
HELD_OUT, HELD_OUT_MESHES = 24, 12
"""Cases of the test of the interval, and of that of the law of the mesh."""
CONFIDENCE = 0.95
"""Share of the cases that the interval is to hold."""


def table(name: str) -> list[Mapping[str, float]]:
    with (STUDIES / f"{name}.csv").open() as file:
        return [{key: float(it) for key, it in row.items()} for row in csv.DictReader(file)]


def cell_size(cells_per_radius: float) -> float:
    """Width of square cells of a 60 degree cone over its radius."""
    slope = math.sqrt(3.0)
    return slope / round(cells_per_radius * slope)


def mesh_error_of(case: Mapping[str, float]) -> float:
    """By the law of the mesh."""
    return float(
        mesh_error(
            rigidity_index=case["rigidity_index"],
            adhesion_factor=case["adhesion_factor"],
            cell_size=cell_size(case["cells_per_radius"]),
            cell_growth=GROWTH,
        )
    )


def limits_by_meshes(power: float) -> tuple[Floats, Floats, float]:
    """Least squares over `mesh_error`, by N0 + B h + Q h^power + C g^1.5 h^1.3 with one Q.

    B is by rigidity index, and goes from smooth to rough with the square of the adhesion factor.

    Returns:
        the limit N0 of each case of the table; B of smooth and rough cones, shape [2, n]; Q.
    """
    cases = table("mesh_error")
    clays = sorted({(it["rigidity_index"], it["adhesion_factor"]) for it in cases})
    count = len(RIGIDITY_INDICES)
    system = np.zeros((len(cases), len(clays) + 2 * count + 1))
    factors = np.zeros(len(cases))
    limit_of = [clays.index((it["rigidity_index"], it["adhesion_factor"])) for it in cases]
    for row, (it, clay) in enumerate(zip(cases, limit_of, strict=True)):
        size, rough = cell_size(it["cells_per_radius"]), it["adhesion_factor"] ** 2
        rank = len(clays) + RIGIDITY_INDICES.index(it["rigidity_index"])
        system[row, clay] = 1.0
        system[row, [rank, rank + count]] = (1.0 - rough) * size, rough * size
        system[row, -1] = size**power
        factors[row] = it["cone_factor_simulated"] - GROWTH_ERROR * growth_measure(size, GROWTH)
    found = np.asarray(np.linalg.lstsq(system, factors, rcond=None)[0], dtype=np.float64)
    limits, slopes = found[limit_of], np.stack(np.split(found[len(clays) : -1], 2))
    return limits, slopes, float(found[-1])


def test_the_law_of_the_mesh_is_that_of_the_meshes_measured() -> None:
    """B and Q by least squares as they stand in the code, which has two decimals."""
    _, slopes, curvature = limits_by_meshes(CURVATURE_POWER)
    np.testing.assert_allclose(MESH_ERRORS, slopes, rtol=0, atol=0.0051)
    assert pytest.approx(curvature, abs=0.0051) == CURVATURE


def test_the_half_width_holds_where_finer_meshes_tend() -> None:
    """By other powers of h too, from every mesh of 3 to 20 rows beside the face."""
    cases = table("mesh_error")
    sizes = np.array([cell_size(it["cells_per_radius"]) for it in cases])
    corrected = [it["cone_factor_simulated"] - mesh_error_of(it) for it in cases]
    for power in (1.3, 1.5, 2.0):
        limits, *_ = limits_by_meshes(power)
        inside = np.abs(corrected - limits) <= np.hypot(LIMIT, MESH * sizes)
        assert inside.mean() >= CONFIDENCE


FINEST = {
    (50.0, 0.5): {28: 9.703},
    (100.0, 0.0): {28: 10.410, 40: 10.437},
    (100.0, 0.5): {28: 11.218, 40: 11.247},
    (300.0, 0.5): {28: 13.546},
}
"""Cone factors as simulated by rigidity index and adhesion factor, and rows of cells beside the
face: as `mesh_error`, on meshes that take up to a quarter of an hour each."""


def test_the_law_of_the_mesh_foretells_finer_meshes() -> None:
    """Fitted to 3 to 20 rows; the rounding of the readings and the noise of runs are left."""
    cases, (limits, *_) = table("mesh_error"), limits_by_meshes(CURVATURE_POWER)
    limit_of = {
        (it["rigidity_index"], it["adhesion_factor"]): limit
        for it, limit in zip(cases, limits, strict=True)
    }
    for (index, adhesion), readings in FINEST.items():
        for rows, factor in readings.items():
            size = math.sqrt(3.0) / rows
            error = mesh_error(
                rigidity_index=index, adhesion_factor=adhesion, cell_size=size, cell_growth=GROWTH
            )
            assert factor - error == pytest.approx(limit_of[index, adhesion], abs=NOISE)


def test_the_law_of_the_mesh_holds_for_cases_that_were_not_used_for_it() -> None:
    """Five rows beside the face and 14 have one limit, within the half width of B."""
    cases = table("held_out_mesh")
    by_rows = {
        rows: [it for it in cases if rows == round(it["cells_per_radius"] * math.sqrt(3.0))]
        for rows in (5, 14)
    }
    inside = []
    for coarse, fine in zip(*by_rows.values(), strict=True):
        limits = [it["cone_factor_simulated"] - mesh_error_of(it) for it in (coarse, fine)]
        half_widths = [MESH * cell_size(it["cells_per_radius"]) for it in (coarse, fine)]
        inside.append(abs(limits[0] - limits[1]) <= math.hypot(*half_widths))
    assert len(inside) == HELD_OUT_MESHES
    assert sum(inside) >= math.floor(CONFIDENCE * len(inside))


@pytest.mark.parametrize("name", ["held_out_default", "held_out_quick"])
def test_the_interval_holds_for_cases_that_were_not_used_for_it(name: str) -> None:
    """Nc +- U of a test against the same case on a fine mesh, in a large window."""
    held_out = {
        (it["rigidity_index"], it["adhesion_factor"], it["stress_anisotropy"]): it["cone_factor"]
        for it in table("held_out")
    }
    inside = [
        abs(it["cone_factor"] - held_out[key]) <= it["cone_factor_uncertainty"]
        for it in table(name)
        if (key := (it["rigidity_index"], it["adhesion_factor"], it["stress_anisotropy"]))
        in held_out
    ]
    assert len(inside) == len(held_out) == HELD_OUT
    assert sum(inside) >= math.floor(CONFIDENCE * len(inside))


@pytest.mark.parametrize("settings", ["default", "quick"])
def test_the_interval_holds_over_the_whole_range_of_the_laws(settings: str) -> None:
    """Nc +- U of a test, and of the same case on finer meshes: they agree within both."""
    cases = table("held_out_wide")
    inside = [
        abs(it[f"cone_factor_{settings}"] - it["cone_factor"])
        <= math.hypot(it[f"cone_factor_uncertainty_{settings}"], it["cone_factor_uncertainty"])
        for it in cases
    ]
    assert sum(inside) >= math.floor(CONFIDENCE * len(cases))


def test_further_runs_hold_for_other_cones_and_clays() -> None:
    """The same, where the error was measured; a finer run without a U is as simulated."""
    for it in table("held_out_others"):
        assert it["cone_factor_finer"] == pytest.approx(
            it["cone_factor"], abs=it["cone_factor_uncertainty"]
        )


def test_the_formula_of_the_cone_factor_is_that_of_its_table() -> None:
    """Coefficients by least squares as they stand in the code, and residuals as it says."""
    cases = table("cone_factor_table")

    def column(name: str) -> np.ndarray:
        return np.array([it[name] for it in cases])

    conditions = Conditions(
        rigidity_index=column("rigidity_index"),
        face_adhesion=column("adhesion_factor"),
        shaft_adhesion=column("shaft_adhesion_factor"),
        stress_anisotropy=column("stress_anisotropy"),
    )
    terms = [
        np.ones(len(cases)),
        np.log(conditions.rigidity_index),
        conditions.face_adhesion,
        conditions.shaft_adhesion,
        conditions.stress_anisotropy,
    ]
    found, *_ = np.linalg.lstsq(np.stack(terms, axis=1), column("cone_factor"), rcond=None)
    formula = cone_factor_reference("this_project")
    stated = [float(it) for it in re.findall(r"[0-9]+\.[0-9]+", formula.formula)]
    assert len(cases) == 200
    # The code has two decimals.
    np.testing.assert_allclose(np.abs(found), stated, rtol=0, atol=0.0051)
    residuals = np.abs(column("cone_factor") - formula.evaluate(conditions))
    assert np.quantile(residuals, CONFIDENCE) < 0.10
    assert residuals.max() < 0.16
