"""Figures on the pages are those of their commands: neither can change without the other."""

from pathlib import Path
from typing import Any, NamedTuple

import pytest

from harness.study.study import load_study
from mpm_warp import ConePenetration, scene_class
from mpm_warp.fields.flat import parameters_of
from mpm_warp.fields.plain_numbers import numbers_by_column
from studies.laboratory.out_of_date import Origin, kept, line, origin_of
from tests.test_readme import ROOT

CONE = "mpm_warp/scenes/cone/README.md"
NC, HALF_WIDTH, SIMULATED = "cone_factor", "cone_factor_uncertainty", "cone_factor_simulated"
ADHESION_05 = "adhesion_factor=[0.5]"
SHARES = ("plastic", "sliding", "elastic", "ground", "transfers")


class Figure(NamedTuple):
    """A phrase on a page, and where its numbers come from."""

    page: str
    phrase: str  # format, for all results of the first case, of the second, and so on
    study: str
    settings: tuple[str, ...]  # as after `--set`
    results: tuple[str, ...]


FIGURES = [
    Figure(
        "README.md",
        "**{:.2f} ± {:.2f}** |",
        "adhesion_factor",
        (ADHESION_05, "rigidity_index=100"),
        (NC, HALF_WIDTH),
    ),
    Figure(
        CONE,
        "| 25 | {:.2f} ± {:.2f} | 0.8 s | {:.2f} ± {:.2f} | 4.1 s |",
        "adhesion_factor",
        (ADHESION_05, "rigidity_index=25", "accuracy=['quick', 'standard']"),
        (NC, HALF_WIDTH),
    ),
    Figure(
        CONE,
        "| 500 | {:.2f} ± {:.2f} | 0.9 s | {:.2f} ± {:.2f} | 3.8 s |",
        "adhesion_factor",
        (ADHESION_05, "rigidity_index=500", "accuracy=['quick', 'standard']"),
        (NC, HALF_WIDTH),
    ),
    Figure(
        CONE,
        "| 0.5 |" + " {:z.1%} |" * 5 + " {:.2%} |",
        "adhesion_factor",
        (ADHESION_05, "rigidity_index=100", "energy_audit=balance"),
        (*(f"work_share_{it}" for it in SHARES), "energy_residual"),
    ),
    Figure(
        "mpm_warp/materials/README.md",
        "Nc as simulated is {:.2f}.",
        "strength_anisotropy",
        ("material.strength_extension=[10e3]", "material.strength_simple_shear=[15e3]"),
        (SIMULATED,),
    ),
    Figure(
        "mpm_warp/materials/README.md",
        "as simulated, quick: {:.3f} and",
        "strength_anisotropy",
        ("material=von_mises",),
        (SIMULATED,),
    ),
    Figure(
        "studies/README.md",
        "| 0.4, 0.65 | {:.2f} |",
        "strength_anisotropy",
        ("material.strength_extension=[8e3]", "material.strength_simple_shear=[13e3]"),
        (SIMULATED,),
    ),
    Figure(
        "studies/README.md",
        "| 3 | 10.94, 0.451 | {:.2f}, {:.3f} |",
        "softening",
        ("ductility=[10]", "remoulded_strength_ratio=[0.2]"),
        (SIMULATED, "sleeve_friction_factor"),
    ),
    Figure(
        "studies/README.md",
        "At 20 mm/s Nc is {:.2f}, 15.62 and 19.53 for mu 0.05, 0.1 and 0.2, as simulated {:.2f},",
        "rate",
        ("rate_factor=[0.05]", "penetration_speed=[0.02]"),
        (NC, SIMULATED),
    ),
]


STUDIES = "studies/README.md"
NC_ROW = " {:.2f} ± {:.2f} |"
SOFTENED = " {:.2f}, {:.3f} |"
SHOULDER, FACE = "pore_pressure_factor_shoulder", "pore_pressure_factor_face"
ROWS_BESIDE_FACE = f"cells_per_radius={[rows / 3**0.5 for rows in (3, 4, 5, 10)]}"
WHOLE_TABLES = [
    *(
        Figure(
            "README.md",
            f"| {index} | **cone factor Nc** |" + " **{:.2f} ± {:.2f}** |" * 5,
            "adhesion_factor",
            (f"rigidity_index={index}",),
            (NC, HALF_WIDTH),
        )
        for index in (50, 100, 300)
    ),
    Figure(STUDIES, "| Nc |" + NC_ROW * 6, "rigidity_index", (), (NC, HALF_WIDTH)),
    Figure(STUDIES, "| Nc |" + NC_ROW * 5, "stress_anisotropy", (), (NC, HALF_WIDTH)),
    *(
        Figure(
            STUDIES,
            f"| {ratio}, {ratio} | {{:.2f}} |",
            "strength_anisotropy",
            (
                f"material.strength_extension=[{strength}]",
                f"material.strength_simple_shear=[{strength}]",
            ),
            (SIMULATED,),
        )
        for ratio, strength in ((0.8, 16e3), (1, 20e3))
    ),
    *(
        Figure(
            STUDIES,
            f"| {cells} |" + SOFTENED * 4,
            "softening",
            (
                "ductility=[50, 10, 3, 1]",
                "remoulded_strength_ratio=[0.2]",
                f"cells_per_radius={cells}",
            ),
            (SIMULATED, "sleeve_friction_factor"),
        )
        for cells in (3, 4)
    ),
    Figure(
        STUDIES,
        "Nc is {0:.2f}, {2:.2f} and {4:.2f} for mu 0.05, 0.1 and 0.2, as simulated {1:.2f}, "
        "{3:.2f} and {5:.2f}.",
        "rate",
        ("penetration_speed=[0.02]",),
        (NC, SIMULATED),
    ),
    *(
        Figure(
            CONE,
            f"| {adhesion} |" + " {:z.1%} |" * 5 + " {:.2%} |",
            "adhesion_factor",
            (f"adhesion_factor=[{adhesion}]", "rigidity_index=100", "energy_audit=balance"),
            (*(f"work_share_{it}" for it in SHARES), "energy_residual"),
        )
        for adhesion in (0, 1)
    ),
    *(
        Figure(
            CONE,
            f"| {begin} | {{:.1f}} ± {{:.1f}} |" + NC_ROW * 3,
            "adhesion_factor",
            (f"adhesion_factor={adhesion}", "rigidity_index=100", ROWS_BESIDE_FACE),
            (SHOULDER, f"{SHOULDER}_uncertainty"),
        )
        for begin, adhesion in (("u2, adhesion factor 0", 0), ("1", 1))
    ),
    Figure(
        CONE,
        "| u1, adhesion factor 0 |" + NC_ROW * 4,
        "adhesion_factor",
        ("adhesion_factor=0", "rigidity_index=100", ROWS_BESIDE_FACE),
        (FACE, f"{FACE}_uncertainty"),
    ),
]
"""Figures of commands that take up to a minute each; compared with ``--deep``."""

RUN: dict[str, Any] = {}
"""Results of cases, by their keys: several figures may be of one case."""


def words_of(page: str) -> str:
    return " ".join((ROOT / page).read_text().split())


def rendered(figure: Figure) -> str:
    """The phrase with what the command gives now."""
    values: list[float] = []
    for case in load_study(figure.study, list(figure.settings)).cases:
        if case.key not in RUN:
            RUN[case.key] = case.built().run()
        values += [float(RUN[case.key][name]) for name in figure.results]
    return figure.phrase.format(*values).replace("%", "")  # tables of shares are in percent


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "figure" in metafunc.fixturenames:
        whole = WHOLE_TABLES if metafunc.config.getoption("deep") else []
        metafunc.parametrize(
            "figure", FIGURES + whole, ids=lambda it: f"{it.page}: {it.phrase} {it.settings}"
        )


@pytest.mark.slow
def test_a_page_has_what_its_command_gives(figure: Figure) -> None:
    assert rendered(figure) in words_of(figure.page)


def test_a_quick_test_has_a_larger_half_width_by_what_is_said() -> None:
    """By the 24 random cases that were run in both accuracies."""
    quick, standard = (
        numbers_by_column((ROOT / "studies" / f"held_out_{it}.csv").read_text())[HALF_WIDTH]
        for it in ("quick", "default")
    )
    larger = quick / standard - 1.0
    told = f"{100 * larger.min():.0f} to {100 * larger.max():.0f} %"
    assert f'with `"quick"` it is larger by {told}' in words_of("README.md")
    assert f"adds {told} to the uncertainty" in parameters_of(ConePenetration)["accuracy"].meaning


@pytest.mark.parametrize("path", kept(), ids=lambda path: path.name)
def test_kept_results_are_of_a_version_that_existed(path: Path) -> None:
    origin = origin_of(path)
    assert origin is None or 0 < origin.version <= scene_class(origin.scene).version


@pytest.mark.parametrize(("older", "told"), [(1, "x.csv"), (0, "")])
def test_results_of_another_version_are_out_of_date(older: int, told: str) -> None:
    now = scene_class("cone_penetration").version
    origin = Origin("cone_penetration", now - older, "harness run rate")
    assert line(ROOT / "x.csv", origin)[: len("x.csv")] == told
