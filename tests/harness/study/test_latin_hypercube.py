"""Latin hypercubes: each share is sampled once; the seed decides; a scene may refuse a sample."""

import math
from pathlib import Path

import pytest

from harness.study.tables import StudyError
from tests.harness.conftest import HEAD, study_in, values

HYPERCUBE = """design = "latin_hypercube"
samples = 20
seed = 3
[vary]
adhesion_factor = { from = 0, to = 1 }
rigidity_index = { from = 5, to = 500, spacing = "logarithmic" }
material = ["tresca", "von_mises"]
"""


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


POINT = 'title = "t"\nscene = "material_point"\n'


def test_integers_are_sampled_evenly(tmp_path: Path) -> None:
    text = 'design = "latin_hypercube"\nsamples = 30\nseed = 1\n[vary]\n'
    text += "step_count = { from = 11, to = 13 }\nrigidity_index = { from = 10, to = 100 }\n"
    steps = [step for (step,) in values(study_in(tmp_path, POINT + text), "step_count")]
    assert [steps.count(n) for n in (11, 12, 13)] == [10, 10, 10]
