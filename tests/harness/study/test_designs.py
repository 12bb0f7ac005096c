"""Designs of studies: which cases there are."""

import math
from pathlib import Path

import pytest

from harness.study.cases import Case
from harness.study.study import Study, load_study
from harness.study.tables import StudyError

HEAD = 'title = "t"\nscene = "cone_penetration"\n'


def study(folder: Path, text: str, name: str = "s") -> Study:
    path = folder / f"{name}.toml"
    path.write_text(text)
    return load_study(str(path))


def values(cases: list[Case], *names: str) -> list[tuple[object, ...]]:
    return [tuple(case.parameters[name] for name in names) for case in cases]


def test_ranges(tmp_path: Path) -> None:
    text = """[vary]
    adhesion_factor = { from = 0, to = 1, count = 5 }
    rigidity_index = { from = 500, to = 5, count = 3, spacing = "logarithmic" }
    """
    varied = study(tmp_path, HEAD + text).parts[0].varied
    assert varied["adhesion_factor"] == (0, 0.25, 0.5, 0.75, 1)
    assert varied["rigidity_index"] == (500, 50, 5)


def test_one_at_a_time_begins_with_the_fixed_values(tmp_path: Path) -> None:
    text = 'design = "one_at_a_time"\n[fixed]\nrigidity_index = 50\n[vary]\n'
    text += "adhesion_factor = [0, 1]\nrigidity_index = [50, 200]\n"
    cases = study(tmp_path, HEAD + text).cases
    # 0 and 50 are the fixed values themselves: such a case is there once.
    expected = [(0, 50), (1, 50), (0, 200)]
    assert values(cases, "adhesion_factor", "rigidity_index") == expected
    others = study(tmp_path, HEAD + text.replace("[0, 1]", "[1]").replace("[50, ", "[")).cases
    assert values(others, "adhesion_factor", "rigidity_index") == expected


def test_a_list_of_cases(tmp_path: Path) -> None:
    text = 'design = "list"\n[fixed]\nadhesion_factor = 0.5\n[[case]]\nrigidity_index = 50\n'
    text += "[[case]]\nrigidity_index = 70\nadhesion_factor = 1\n"
    cases = study(tmp_path, HEAD + text).cases
    assert values(cases, "rigidity_index", "adhesion_factor") == [(50, 0.5), (70, 1)]


HYPERCUBE = """design = "latin_hypercube"
samples = 20
seed = 3
[vary]
adhesion_factor = { from = 0, to = 1 }
rigidity_index = { from = 5, to = 500, spacing = "logarithmic" }
material = ["tresca", "von_mises"]
"""


def test_a_latin_hypercube_samples_every_share_once(tmp_path: Path) -> None:
    cases = study(tmp_path, HEAD + HYPERCUBE).cases
    adhesion, rigidity, material = zip(
        *values(cases, "adhesion_factor", "rigidity_index", "material"), strict=True
    )
    assert sorted(int(20 * it) for it in adhesion) == list(range(20))
    assert sorted(int(20 * math.log10(it / 5) / 2) for it in rigidity) == list(range(20))
    assert material.count("tresca") == 10


def test_the_seed_decides_the_samples(tmp_path: Path) -> None:
    one, again, other = (
        [case.key for case in study(tmp_path, HEAD + text).cases]
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
    cells = [it for (it,) in values(study(tmp_path, BLOCKS).cases, "cells_per_length")]
    assert len(cells) == 10
    assert min(cells) < 10
    excluding = 'exclude = ["cells_per_length < 10"]\n' + BLOCKS
    assert len(study(tmp_path, excluding).cases) == sum(it >= 10 for it in cells)


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
        _ = study(tmp_path, text).cases


def test_integers_are_sampled_evenly(tmp_path: Path) -> None:
    text = 'title = "t"\nscene = "material_point"\ndesign = "latin_hypercube"\nsamples = 30\n'
    text += "seed = 1\n[vary]\nstep_count = { from = 11, to = 13 }\n"
    text += "rigidity_index = { from = 10, to = 100 }\n"
    steps = [case.parameters["step_count"] for case in study(tmp_path, text).cases]
    assert [steps.count(n) for n in (11, 12, 13)] == [10, 10, 10]


def test_derived_parameters_in_their_order(tmp_path: Path) -> None:
    text = '[derived]\ndomain_radius = "6 * sqrt(rigidity_index)"\n'
    text += 'domain_above = "domain_radius / 3"\n[vary]\nrigidity_index = [25, 100]\n'
    cases = study(tmp_path, HEAD + text).cases
    assert values(cases, "domain_radius", "domain_above") == [(30, 10), (60, 20)]


def test_exclusions(tmp_path: Path) -> None:
    text = 'exclude = ["rigidity_index > 100 and adhesion_factor == 1"]\n[vary]\n'
    text += "adhesion_factor = [0, 1]\nrigidity_index = [50, 500]\n"
    cases = study(tmp_path, HEAD + text).cases
    assert values(cases, "adhesion_factor", "rigidity_index") == [(0, 50), (0, 500), (1, 50)]


def test_several_scenes(tmp_path: Path) -> None:
    text = 'title = "t"\nscene = ["strip_footing", "material_point"]\n[fixed]\n'
    text += "rigidity_index = 200\n[scenes.strip_footing.vary]\ncells_per_radius = [4, 8]\n"
    text += "[scenes.material_point.fixed]\nrigidity_index = 100\n"
    cases = study(tmp_path, text).cases
    assert [case.scene for case in cases] == ["strip_footing", "strip_footing", "material_point"]
    assert values(cases, "rigidity_index") == [(200,), (200,), (100,)]


def test_a_study_stands_on_another(tmp_path: Path) -> None:
    study(tmp_path, HEAD + "[fixed]\npenetration = 3\n[vary]\nrigidity_index = [50, 60]\n", "base")
    text = 'base = "base.toml"\n[vary]\nadhesion_factor = [0, 1]\n[fixed]\nrigidity_index = 70\n'
    (part,) = study(tmp_path, text).parts
    assert part.fixed == {"penetration": 3, "rigidity_index": 70}
    assert part.varied == {"adhesion_factor": (0, 1)}
    assert study(tmp_path, 'base = "adhesion_factor"\ntitle = "mine"').cases


MISTAKES = {
    "circle": ('base = "s.toml"\n' + HEAD, "in a circle"),
    "base out of nowhere": ('base = "adhesion_facto"\n', "did you mean 'adhesion_factor'"),
    "base of a wrong type": ("base = 3\n", "must be a text"),
    "design misspelt": (HEAD + 'design = "ful"\n', "did you mean 'full'"),
    "samples of a full design": (HEAD + "samples = 3\n", "latin_hypercube"),
    "no samples": (HEAD + 'design = "latin_hypercube"\nseed = 1\n', "samples: is missing"),
    "nothing to sample": (
        HEAD + 'design = "latin_hypercube"\nsamples = 2\nseed = 1\n',
        "nothing to sample",
    ),
    "cases of a full design": (HEAD + "[[case]]\ndensity = 1\n", 'design = "list" alone'),
    "no cases": (HEAD + 'design = "list"\n', "[[case]]"),
    "case misspelt": (HEAD + 'design = "list"\n[[case]]\ndensty = 1\n', "[[case]] 1: densty = 1"),
    "range of texts": (HEAD + "[vary]\nmaterial = { from = 1, to = 2 }\n", "has no ranges"),
    "range beyond": (
        HEAD + "[vary]\nadhesion_factor = { from = 0, to = 2, count = 3 }\n",
        "to = 2 is not allowed: must be a number >= 0 and <= 1",
    ),
    "range without end": (HEAD + "[vary]\ndensity = { from = 1, count = 2 }\n", "to: is missing"),
    "range without count": (HEAD + "[vary]\ndensity = { from = 1, to = 2 }\n", "count: is missing"),
    "range of very many": (
        HEAD + "[vary]\ndensity = { from = 1, to = 2, count = 10000000000 }\n",
        "2 to 100000",
    ),
    "logarithm of zero": (
        HEAD + '[vary]\nadhesion_factor = {from=0, to=1, count=3, spacing="logarithmic"}\n',
        "must be > 0",
    ),
    "unknown in an expression": (
        HEAD + '[derived]\ndensity = "2 * densit"\n',
        "did you mean 'density'",
    ),
    "derived of itself": (HEAD + '[derived]\ndensity = "2 * density"\n', "derived itself"),
    "derived out of range": (
        HEAD + '[derived]\nadhesion_factor = "rigidity_index"\n',
        "adhesion_factor = 100.0 is not allowed",
    ),
    "derived and fixed": (
        HEAD + '[fixed]\ndensity = 1\n[derived]\ndensity = "2"\n',
        "is under [fixed] as well",
    ),
    "condition that is none": (HEAD + 'exclude = ["density + 1"]\n', "neither true nor false"),
    "all excluded": (HEAD + 'exclude = ["density > 0"]\n', "leaves no case"),
    "executed": (HEAD + "exclude = [\"open('x')\"]\n", "unknown function 'open'"),
    "scene twice": ('title="t"\nscene = ["material_point", "material_point"]', "twice"),
    "scene not of the study": (HEAD + "[scenes.material_point]\n", "unknown key"),
    "key of the study under a scene": (
        HEAD + '[scenes.cone_penetration]\ntitle = "x"\n',
        "[scenes] [cone_penetration] title",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_with_its_place(tmp_path: Path, mistake: str) -> None:
    text, told = MISTAKES[mistake]
    with pytest.raises(StudyError) as caught:
        _ = study(tmp_path, text).cases
    assert told in str(caught.value)
    assert str(caught.value).startswith(f"{tmp_path / 's.toml'}:")
