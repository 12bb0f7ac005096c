"""The tables under studies/ by which the uncertainty of the cone factor is set, and tested."""

import itertools
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from harness.references.reference import USUAL
from harness.references.registry import reference_of
from mpm_warp.fields.plain_numbers import numbers_by_column
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty import laws
from studies.laboratory.limit_of_mesh import limits

STUDIES = Path(__file__).parent.parent / "studies"
HELD_OUT, HELD_OUT_MESHES = 24, 12
"""Cases of the test of the interval, and of that of the law of the mesh."""
CONFIDENCE = 0.95
OF_MESH = laws.EFFECTS["mesh"].half_width
"""Share of the cases that the interval is to hold."""


def table(name: str) -> list[Mapping[str, float]]:
    columns = numbers_by_column((STUDIES / f"{name}.csv").read_text())
    rows = zip(*columns.values(), strict=True)
    return [dict(zip(columns, map(float, row), strict=True)) for row in rows]


def cell_size(cells_per_radius: float) -> float:
    """Width of square cells of a 60 degree cone over its radius."""
    slope = math.sqrt(3.0)
    return slope / round(cells_per_radius * slope)


def mesh_error_of(case: Mapping[str, float]) -> float:
    """By the law of the mesh."""
    return float(
        laws.mesh_error(
            rigidity_index=case["rigidity_index"],
            adhesion_factor=case["adhesion_factor"],
            cell_size=cell_size(case["cells_per_radius"]),
            cell_growth=laws.GROWTH_OF_MESHES,
        )
    )


def limits_by_meshes(
    power: float, cases: Sequence[Mapping[str, float]]
) -> tuple[Floats, Floats, Floats]:
    """Least squares over some cases, by N0 + B h + Q h^power + C g^1.5 h^1.3.

    B is by rigidity index, Q of rough cones too, that of smooth ones is one but in the softest
    clay; both go from smooth to rough with the square of the adhesion factor.

    Returns:
        the limit N0 of each case; B and Q of smooth and rough cones, shape [2, n].
    """
    clays = sorted({(it["rigidity_index"], it["adhesion_factor"]) for it in cases})
    count = len(laws.TABLE.rigidity_index)
    unknowns = np.arange(len(clays) + 3 * count + 2)
    limit, slope, curvature = np.split(unknowns, [-3 * count - 2, -count - 2])
    system = np.zeros((len(cases), len(unknowns)))
    factors = np.zeros(len(cases))
    limit_of = [clays.index((it["rigidity_index"], it["adhesion_factor"])) for it in cases]
    for row, (it, clay) in enumerate(zip(cases, limit_of, strict=True)):
        size, rough = cell_size(it["cells_per_radius"]), it["adhesion_factor"] ** 2
        index = laws.TABLE.rigidity_index.tolist().index(it["rigidity_index"])
        share = np.array([1.0 - rough, rough])
        system[row, limit[clay]] = 1.0
        system[row, slope[[index, index + count]]] = share * size
        system[row, curvature[[min(index, 1), index + 2]]] = share * size**power
        of_growth = laws.EFFECTS["growth"].size * laws.growth_measure(size, laws.GROWTH_OF_MESHES)
        factors[row] = it["cone_factor_simulated"] - of_growth
    found = np.asarray(np.linalg.lstsq(system, factors, rcond=None)[0], dtype=np.float64)
    softest, smooth, *rough_ones = found[curvature]
    smooth_ones = [softest, *[smooth] * (count - 1)]
    return found[limit_of], found[slope].reshape(2, count), np.stack([smooth_ones, rough_ones])


def test_the_law_of_the_mesh_is_that_of_the_meshes_measured() -> None:
    """B and Q by least squares as they stand in the table, which has two decimals."""
    _, *found = limits_by_meshes(laws.CURVATURE_POWER, table("mesh_error"))
    stated = [laws.TABLE.columns[it].T for it in ("slope", "curvature")]
    np.testing.assert_allclose(stated, found, rtol=0, atol=0.0051)


@pytest.mark.parametrize(
    ("indices", "adhesions"),
    [
        ((20, 30, 50, 100), (0, 0.5)),
        ((20, 30, 50, 100), (1,)),
        ((300,), (0, 0.5, 1)),
        ((1000,), (0, 0.5, 1)),
    ],
    ids=["smooth and half rough", "rough", "stiff", "very stiff"],
)
def test_the_half_width_of_the_limit_is_what_other_forms_of_the_law_give(
    indices: tuple[float, ...], adhesions: tuple[float, ...]
) -> None:
    """Root mean square over the clays of a group; the table has steps of 0.005."""
    found = limits()
    of_group = [found[clay].half_width for clay in itertools.product(indices, adhesions)]
    stated = laws.TABLE.at("limit_half_width", indices[0], min(adhesions))
    assert stated == pytest.approx(math.hypot(*of_group) / math.sqrt(len(of_group)), abs=0.0026)


@pytest.mark.parametrize("power", [1.5, laws.CURVATURE_POWER, 2.0])
def test_the_half_width_holds_where_finer_meshes_tend(power: float) -> None:
    """By other powers of h too, fitted to all meshes of five rows beside the face and more."""
    cases = [
        it for it in table("mesh_error") if cell_size(it["cells_per_radius"]) < math.sqrt(3.0) / 4.5
    ]
    sizes = np.array([cell_size(it["cells_per_radius"]) for it in cases])
    corrected = [it["cone_factor_simulated"] - mesh_error_of(it) for it in cases]
    indices, adhesions = (
        np.array([it[name] for it in cases]) for name in ("rigidity_index", "adhesion_factor")
    )
    of_limit = laws.TABLE.at("limit_half_width", indices, adhesions**2)
    limits, *_ = limits_by_meshes(power, cases)
    inside = np.abs(corrected - limits) <= np.hypot(of_limit, OF_MESH * sizes)
    assert inside.mean() >= CONFIDENCE


def test_the_law_of_the_mesh_holds_between_the_clays_that_it_was_fitted_to() -> None:
    """All meshes have one limit, within the half widths of B, of the limit and of the noise."""
    cases = table("mesh_error_between")
    for index, adhesion in sorted({(it["rigidity_index"], it["adhesion_factor"]) for it in cases}):
        clay = {"rigidity_index": index, "adhesion_factor": adhesion}
        own = [it for it in cases if clay.items() <= it.items()]
        sizes = np.array([math.sqrt(3.0) / it["rows_on_face"] for it in own])
        errors = [mesh_error_of(clay | {"cells_per_radius": 1.0 / size}) for size in sizes]
        limits = np.array([it["cone_factor_simulated"] for it in own]) - errors
        of_limit = float(laws.TABLE.at("limit_half_width", index, adhesion**2))
        noise = laws.EFFECTS["noise"].half_width * np.hypot(sizes, sizes[-1])
        left = np.hypot(np.hypot(OF_MESH * (sizes - sizes[-1]), noise), of_limit)
        assert np.all(np.abs(limits - limits[-1]) <= left)


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
        half_widths = [OF_MESH * cell_size(it["cells_per_radius"]) for it in (coarse, fine)]
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

    conditions = {
        **USUAL,
        "Ir": column("rigidity_index"),
        "alpha_c": column("adhesion_factor"),
        "alpha_s": column("shaft_adhesion_factor"),
        "Delta": column("stress_anisotropy"),
    }
    linear = (conditions[name] for name in ("alpha_c", "alpha_s", "Delta"))
    terms = [np.ones(len(cases)), np.log(conditions["Ir"]), *linear]
    found, *_ = np.linalg.lstsq(np.stack(terms, axis=1), column("cone_factor"), rcond=None)
    formula = reference_of("this_project")
    stated = [float(it) for it in re.findall(r"[0-9]+\.[0-9]+", formula.text)]
    assert len(cases) == 200
    # The code has two decimals.
    np.testing.assert_allclose(np.abs(found), stated, rtol=0, atol=0.0051)
    residuals = np.abs(column("cone_factor") - formula.evaluate(conditions).values)
    assert np.quantile(residuals, CONFIDENCE) < 0.11
    assert residuals.max() < 0.16
