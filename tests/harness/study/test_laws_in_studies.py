"""A law in a study: how it is given, what it has, and what remains of one given before."""

from pathlib import Path
from typing import Any

import pytest

from harness.study.description import unusual_values
from harness.study.study import load_study
from harness.study.tables import StudyError
from tests.harness.conftest import HEAD, study_in, values

POINT = 'title = "t"\nscene = "material_point"\n'


@pytest.mark.parametrize(
    "table",
    [
        'material = { law = "modified_cam_clay", swelling_slope = 0.03 }',
        'material.law = "modified_cam_clay"\nmaterial.swelling_slope = 0.03',
        'material = "modified_cam_clay"\n"material.swelling_slope" = 0.03',
    ],
)
def test_a_law_is_given_in_each_way_that_toml_has(tmp_path: Path, table: str) -> None:
    (case,) = study_in(tmp_path, f"{POINT}[fixed]\n{table}\n").cases
    assert case.parameters["material"] == "modified_cam_clay"
    assert case.parameters["material.swelling_slope"] == 0.03
    built: Any = case.built()
    assert built.material.own["swelling_slope"] == 0.03


def test_only_cases_of_a_law_have_its_parameters(
    tmp_path: Path,
) -> None:
    """And a stress that looks like kilopascals is told."""
    (plain,) = study_in(tmp_path, POINT).cases
    assert not [name for name in plain.parameters if "." in name]
    clay = f'{POINT}[fixed]\nmaterial = {{ law = "modified_cam_clay" }}\n'
    study = study_in(tmp_path, clay + "[vary]\nmaterial.mean_effective_stress = [2e4, 3e4]\n")
    assert values(study, "material.mean_effective_stress") == [(2e4,), (3e4,)]
    assert len({case.key for case in study.cases}) == 2
    fixed = clay + '"material.mean_effective_stress" = 20\n'
    (line,) = unusual_values(study_in(tmp_path, fixed))
    assert line == ("material.mean_effective_stress = 20 is in Pa; if 20 kPa is meant, give 20000")
    path = tmp_path / "again.toml"
    path.write_text(fixed)
    (again,) = load_study(str(path), ["material=tresca"]).cases
    assert again.key == plain.key


SLOPES = ("material.compression_slope", "material.swelling_slope")


@pytest.mark.parametrize(
    "settings",
    [
        ['material={law="modified_cam_clay", swelling_slope=0.04}'],
        ["material=modified_cam_clay", "material.swelling_slope=0.04"],
        ["material.swelling_slope=0.04", "material=modified_cam_clay"],
        ["material.law=modified_cam_clay", "material.swelling_slope=0.04"],
    ],
)
def test_a_law_that_is_given_anew_has_no_parameters_of_the_one_before(
    tmp_path: Path, settings: list[str]
) -> None:
    """In a setting, whatever the order, and in a case of a list."""
    (by_default,) = study_in(tmp_path, f'{POINT}[fixed]\nmaterial = "modified_cam_clay"\n').cases
    expected = by_default.parameters[SLOPES[0]], 0.04
    assert expected[0] not in (None, 0.3)
    table = 'material = {{ law = "modified_cam_clay", compression_slope = 0.3{} }}\n'
    base = f"{POINT}[fixed]\n{table.format('')}"
    assert values(study_in(tmp_path, base, *settings), *SLOPES) == [expected]
    listed = f'design = "list"\n[[case]]\n{table.format(", swelling_slope = 0.02")}'
    study = study_in(tmp_path, base.replace("[fixed]", f"{listed}[fixed]"), *settings)
    assert values(study, *SLOPES) == [expected]
    own = listed.replace("compression_slope = 0.3, ", "").replace("0.02", "0.04")
    study = study_in(tmp_path, base.replace("[fixed]", f"{own}[fixed]"))
    assert values(study, *SLOPES) == [expected]


STIFF = 'title = "t"\nscene = "cone_penetration"\n[{}]\nrigidity_index = {}\n'


def test_a_law_with_its_own_stiffness_replaces_a_rigidity_index_given_before(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """That of a base, or of a study that a setting changes; what varies is told."""
    clay = '[fixed]\nmaterial = "modified_cam_clay"\n'
    (own,) = study_in(tmp_path, HEAD + clay).cases
    assert own.parameters["rigidity_index"] != 150.0
    for table, value in (("fixed", "150"), ("vary", "[150, 200]")):
        study_in(tmp_path, STIFF.format(table, value), name="base")
        based = study_in(tmp_path, f'base = "base.toml"\n{clay}')
        capsys.readouterr()
        changed = load_study(str(tmp_path / "base.toml"), ["material=modified_cam_clay"])
        told = capsys.readouterr().err
        assert [case.key for study in (based, changed) for case in study.cases] == 2 * [own.key]
        assert ("rigidity_index: left out: --set material = 'modified_cam_clay' " in told) == (
            table == "vary"
        )
    for given in (f"{clay}rigidity_index = 150\n", f"{clay}[vary]\nrigidity_index = [150]\n"):
        with pytest.raises(StudyError, match=r"whose stiffness is its own: .* su; leave it out"):
            _ = study_in(tmp_path, HEAD + given).cases
    both = STIFF.format("fixed", "150") + '[vary]\nmaterial = ["tresca", "modified_cam_clay"]\n'
    with pytest.raises(StudyError, match="leave it out"):
        _ = study_in(tmp_path, both).cases
