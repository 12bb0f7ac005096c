"""Figures on the pages are those of their commands: neither can change without the other."""

from typing import Any, NamedTuple

import pytest

from harness.study.study import load_study
from mpm_warp import scene_class
from tests.test_readme import ROOT

NC, HALF_WIDTH = "cone_factor", "cone_factor_uncertainty"
ADHESION_05 = "adhesion_factor=[0.5]"
OF_VON_MISES = ("material.strength_extension=[20e3]", "material.strength_simple_shear=[23094.0108]")
ENERGIES = [
    f"energy_{it}"
    for it in ("plastic", "sliding", "elastic", "ground", "transfer_loss", "residual")
]


class Figure(NamedTuple):
    """A phrase on a page, and where its numbers come from."""

    page: str
    phrase: str  # a format, for the values of all results of the first case, the second, ...
    study: str
    settings: tuple[str, ...]  # as after `--set`
    results: tuple[str, ...]
    factor: float = 1.0  # 100 for percent


FIGURES = [
    Figure(
        "README.md", "**{:.2f} ± {:.2f}**", "adhesion_factor", (ADHESION_05,), (NC, HALF_WIDTH)
    ),
    Figure(
        "mpm_warp/scenes/cone/README.md",
        "| 25 | {:.2f} ± {:.2f} | 0.8 s | {:.2f} ± {:.2f} | 4.1 s |",
        "adhesion_factor",
        (ADHESION_05, "rigidity_index=25", "accuracy=['quick', 'standard']"),
        (NC, HALF_WIDTH),
    ),
    Figure(
        "mpm_warp/scenes/cone/README.md",
        "| 500 | {:.2f} ± {:.2f} |",
        "adhesion_factor",
        (ADHESION_05, "rigidity_index=500", "accuracy=quick"),
        (NC, HALF_WIDTH),
    ),
]


def rendered(figure: Figure) -> str:
    """The phrase with what the command gives now."""
    values: list[float] = []
    for case in load_study(figure.study, list(figure.settings)).cases:
        result: Any = scene_class(case.scene)(**case.parameters).run()
        values += [figure.factor * float(result[name]) for name in figure.results]
    return figure.phrase.format(*values)


@pytest.mark.slow
@pytest.mark.parametrize("figure", FIGURES, ids=lambda it: f"{it.page}: {it.phrase}")
def test_a_page_has_what_its_command_gives(figure: Figure) -> None:
    assert rendered(figure) in " ".join((ROOT / figure.page).read_text().split())
