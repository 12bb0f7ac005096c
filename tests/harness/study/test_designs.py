"""Designs of studies: which cases there are, also of laws of other packages."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from harness.study import study as studies
from harness.study.description import unusual_values
from harness.study.tables import StudyError
from mpm_warp.parameters import parameter
from mpm_warp.scenes.material.material_point import MaterialPoint
from tests.harness.conftest import HEAD, HYPERCUBE, study_in, values


def test_ranges(tmp_path: Path) -> None:
    text = """[vary]
    adhesion_factor = { from = 0, to = 1, count = 5 }
    rigidity_index = { from = 500, to = 5, count = 3, spacing = "logarithmic" }
    """
    varied = study_in(tmp_path, HEAD + text).parts[0].varied
    assert varied["adhesion_factor"] == (0, 0.25, 0.5, 0.75, 1)
    assert varied["rigidity_index"] == (500, 50, 5)


def test_one_at_a_time_begins_with_the_fixed_values(tmp_path: Path) -> None:
    text = 'design = "one_at_a_time"\n[fixed]\nrigidity_index = 50\n[vary]\n'
    text += "adhesion_factor = [0, 1]\nrigidity_index = [50, 200]\n"
    study = study_in(tmp_path, HEAD + text)
    # 0 and 50 are the fixed values themselves: such a case is there once.
    expected = [(0, 50), (1, 50), (0, 200)]
    assert values(study, "adhesion_factor", "rigidity_index") == expected
    others = study_in(tmp_path, HEAD + text.replace("[0, 1]", "[1]").replace("[50, ", "["))
    assert values(others, "adhesion_factor", "rigidity_index") == expected


def test_a_list_of_cases(tmp_path: Path) -> None:
    text = 'design = "list"\n[fixed]\nadhesion_factor = 0.5\n[[case]]\nrigidity_index = 50\n'
    text += "[[case]]\nrigidity_index = 70\nadhesion_factor = 1\n"
    study = study_in(tmp_path, HEAD + text)
    assert values(study, "rigidity_index", "adhesion_factor") == [(50, 0.5), (70, 1)]


def test_a_latin_hypercube_samples_every_share_once(tmp_path: Path) -> None:
    study = study_in(tmp_path, HEAD + HYPERCUBE)
    adhesion, rigidity, material = zip(
        *values(study, "adhesion_factor", "rigidity_index", "material"), strict=True
    )
    assert sorted(int(20 * it) for it in adhesion) == list(range(20))
    assert sorted(int(20 * math.log10(it / 5) / 2) for it in rigidity) == list(range(20))
    assert material.count("tresca") == 10


def test_the_seed_decides_the_samples(tmp_path: Path) -> None:
    one, again, other = (
        [case.key for case in study_in(tmp_path, HEAD + text).cases]
        for text in (HYPERCUBE, HYPERCUBE, HYPERCUBE.replace("seed = 3", "seed = 4"))
    )
    assert one == again
    assert not set(one) & set(other)


BLOCKS = """title = "t"
scene = "sliding_block"
design = "latin_hypercube"
samples = 10
seed = 1
[fixed]
height_ratio = 0.3
[vary]
cells_per_length = { from = 4, to = 16 }
friction = { from = 0, to = 0.5 }
"""
"""Below 10 cells along the block it is less than 3 cells high, which its scene refuses."""


def test_what_chance_chose_and_the_scene_refuses_is_a_case_all_the_same(tmp_path: Path) -> None:
    cells = [it for (it,) in values(study_in(tmp_path, BLOCKS), "cells_per_length")]
    assert len(cells) == 10
    assert min(cells) < 10
    excluding = 'exclude = ["cells_per_length < 10"]\n' + BLOCKS
    assert len(study_in(tmp_path, excluding).cases) == sum(it >= 10 for it in cells)


@pytest.mark.parametrize(
    "text",
    [
        BLOCKS.replace("from = 4, to = 16", "from = 4, to = 5"),
        BLOCKS.replace("{ from = 4, to = 16 }", "[5, 10]")
        .replace("{ from = 0, to = 0.5 }", "[0.2]")
        .replace('design = "latin_hypercube"\nsamples = 10\nseed = 1\n', ""),
    ],
    ids=["all of chance", "one of choice"],
)
def test_what_the_scene_refuses_is_an_error_of_the_study(tmp_path: Path, text: str) -> None:
    with pytest.raises(StudyError, match=r"cells_per_length=.* the block must be 3 cells high"):
        _ = study_in(tmp_path, text).cases


def test_integers_are_sampled_evenly(tmp_path: Path) -> None:
    text = 'title = "t"\nscene = "material_point"\ndesign = "latin_hypercube"\nsamples = 30\n'
    text += "seed = 1\n[vary]\nstep_count = { from = 11, to = 13 }\n"
    text += "rigidity_index = { from = 10, to = 100 }\n"
    steps = [case.parameters["step_count"] for case in study_in(tmp_path, text).cases]
    assert [steps.count(n) for n in (11, 12, 13)] == [10, 10, 10]


def test_derived_parameters_in_their_order(tmp_path: Path) -> None:
    text = '[derived]\ndomain_radius = "6 * sqrt(rigidity_index)"\n'
    text += 'domain_above = "domain_radius / 3"\n[vary]\nrigidity_index = [25, 100]\n'
    study = study_in(tmp_path, HEAD + text)
    assert values(study, "domain_radius", "domain_above") == [(30, 10), (60, 20)]


def test_exclusions(tmp_path: Path) -> None:
    text = 'exclude = ["rigidity_index > 100 and adhesion_factor == 1"]\n[vary]\n'
    text += "adhesion_factor = [0, 1]\nrigidity_index = [50, 500]\n"
    study = study_in(tmp_path, HEAD + text)
    assert values(study, "adhesion_factor", "rigidity_index") == [(0, 50), (0, 500), (1, 50)]


def test_several_scenes(tmp_path: Path) -> None:
    text = 'title = "t"\nscene = ["strip_footing", "material_point"]\n[fixed]\n'
    text += "rigidity_index = 200\n[scenes.strip_footing.vary]\ncells_per_radius = [4, 8]\n"
    text += "[scenes.material_point.fixed]\nrigidity_index = 100\n"
    study = study_in(tmp_path, text)
    assert [case.scene for case in study.cases] == [
        "strip_footing",
        "strip_footing",
        "material_point",
    ]
    assert values(study, "rigidity_index") == [(200,), (200,), (100,)]


def test_a_study_stands_on_another(tmp_path: Path) -> None:
    study_in(
        tmp_path,
        HEAD + "[fixed]\npenetration = 3\n[vary]\nrigidity_index = [50, 60]\n",
        name="base",
    )
    text = 'base = "base.toml"\n[vary]\nadhesion_factor = [0, 1]\n[fixed]\nrigidity_index = 70\n'
    (part,) = study_in(tmp_path, text).parts
    assert part.fixed == {"penetration": 3, "rigidity_index": 70}
    assert part.varied == {"adhesion_factor": (0, 1)}
    assert study_in(tmp_path, 'base = "adhesion_factor"\ntitle = "mine"').cases


STUDY = 'title = "t"\nscene = "material_point"\n'


@dataclass(frozen=True, kw_only=True)
class WithLaw(MaterialPoint):
    """The scene where a package with a law is installed."""

    of_other_laws: ClassVar[tuple[str, ...]] = ("yield_stress",)

    yield_stress: float | None = parameter(None, "yield stress of my_law", unit="Pa", above=0.0)

    def _check_other_laws(self) -> None:
        """Here the law of the scene has it."""


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Installs the package."""
    monkeypatch.setattr(studies, "scene_class", lambda name: WithLaw)


def test_a_case_without_the_law_keeps_its_name(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    (before,) = study_in(tmp_path, STUDY).cases
    request.getfixturevalue("installed")
    (after,) = study_in(tmp_path, STUDY).cases
    assert after.key == before.key


@pytest.mark.usefixtures("installed")
def test_its_parameters_are_varied_and_name_the_case(tmp_path: Path) -> None:
    study = study_in(tmp_path, STUDY + "[vary]\nyield_stress = [2e4, 3e4]\n")
    assert [case.parameters["yield_stress"] for case in study.cases] == [2e4, 3e4]
    assert len({case.key for case in study.cases}) == 2


@pytest.mark.usefixtures("installed")
def test_a_stress_that_looks_like_kilopascals_is_told(tmp_path: Path) -> None:
    (line,) = unusual_values(study_in(tmp_path, STUDY + "[fixed]\nyield_stress = 20\n"))
    assert line == "yield_stress = 20 is in Pa; if 20 kPa is meant, give 20000"
