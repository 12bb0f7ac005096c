"""What a study is to be compared with is checked before it runs, as far as that can be known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.study.study import load_study

CONE = 'title = "t"\nscene = "cone_penetration"\n[compare]\n'
POINT = CONE.replace("cone_penetration", "material_point")
BOTH = CONE.replace('"cone_penetration"', '["material_point", "cone_penetration"]')

REFUSED = {
    "result misspelt": (
        CONE + "tolerance = { cone_facto = 0.1 }",
        "cone_facto = 0.1: is neither a reference nor a result; did you mean 'cone_factor'?",
    ),
    "error misspelt": (CONE + "tolerance = { eror = 0.1 }", "did you mean 'error'?"),
    "reference misspelt": (
        CONE + 'references = ["lu_2004"]\ntolerance = { lu_2005 = 0.1 }',
        "did you mean 'lu_2004'?",
    ),
    "result of a check misspelt": (
        POINT.replace("material_point", "flying_block") + "tolerance = { momentum_eror = 0.1 }",
        "did you mean 'momentum_error'?",
    ),
    "experience misspelt": (
        CONE + 'experience = ["karlsrud_2006"]',
        "unknown band of experience 'karlsrud_2006'; did you mean 'karlsrud_2005'?",
    ),
    "experience twice": (
        CONE + 'experience = ["karlsrud_2005", "karlsrud_2005"]',
        "names a band of experience twice",
    ),
    "experience of no cone": (
        POINT + 'experience = ["karlsrud_2005"]',
        "no scene here gives a cone_factor, which they are of",
    ),
    "tolerance of a band": (
        CONE + 'experience = ["karlsrud_2005"]\ntolerance = { karlsrud_2005 = 0.1 }',
        "is a band of experience, from which no result deviates",
    ),
    "references of a footing": (
        POINT.replace("material_point", "strip_footing") + 'references = ["lu_2004"]',
        "no scene here gives a cone_factor, which they are of",
    ),
    "reference study misspelt": (
        CONE + 'reference_study = "work_precision_referense"',
        "no such study; did you mean 'work_precision_reference'?",
    ),
    "reference study without a result": (
        CONE + 'reference_study = "mesh_size"',
        "mesh_size.nc is missing: run that study, and put it there",
    ),
    "reference study of no cone": (
        POINT + 'reference_study = "work_precision_reference"',
        "needs one scene, which gives a cone_factor",
    ),
    "reference study of two scenes": (
        BOTH + 'reference_study = "work_precision_reference"',
        "needs one scene, which gives a cone_factor",
    ),
    "references of no cone": (
        POINT + 'references = ["lu_2004"]',
        "no scene here gives a cone_factor, which they are of",
    ),
}


@pytest.mark.parametrize("mistake", REFUSED)
def test_what_cannot_be_compared_is_refused_before_the_run(
    mistake: str, tmp_path: Path, refusal: Callable[[list[str]], str]
) -> None:
    text, told = REFUSED[mistake]
    path = tmp_path / "s.toml"
    path.write_text(text)
    assert refusal(["run", str(path), "--out", str(tmp_path / "out")]).endswith(told)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "text",
    [
        BOTH + 'references = ["lu_2004"]\ntolerance = { lu_2004 = 0.1 }',
        CONE + "tolerance = { cone_factor_variation = 0.01, cone_factor_shear = 1 }",
        CONE + "tolerance = { error = 0.1, error_finest = 0.1, run_time = 1 }",
        POINT + "tolerance = { error = 0.1, stress_exact = 1 }",
        POINT + "references = []",
        CONE + 'experience = ["karlsrud_2005", "mayne_peuchen_2018"]',
    ],
)
def test_results_that_only_a_run_can_tell_of_are_accepted(tmp_path: Path, text: str) -> None:
    path = tmp_path / "s.toml"
    path.write_text(text)
    assert load_study(str(path))
