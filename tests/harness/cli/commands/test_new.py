"""`harness new`, and what is told of studies: `describe`, `plan`, `status`."""

import re
from pathlib import Path

import pytest

from harness.cli.main import main
from harness.study.files import read_toml
from harness.study.study import load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import scene_class, scene_names

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("scene", scene_names())
def test_a_new_study_is_sound_and_explains_every_parameter(scene: str) -> None:
    assert main(["new", "mine", "--scene", scene]) == 0
    study = load_study("mine.toml")
    assert len(study.cases) > 1
    text = Path("mine.toml").read_text()
    assert max(map(len, text.splitlines())) <= 100
    for name in parameters_of(scene_class(scene)):
        assert f"{name} = " in text


@pytest.mark.parametrize("scene", ["cone_penetration", "sounding", "cone_bearing"])
def test_references_are_offered_to_a_scene_that_has_what_they_are_of(scene: str) -> None:
    main(["new", "mine", "--scene", scene])
    text = Path("mine.toml").read_text()
    assert ("#[compare]" in text) == (scene == "cone_penetration")
    for line in ("[compare]", "references", "experience"):
        text = text.replace(f"#{line}", line)
    Path("edited.toml").write_text(text)
    assert bool(load_study("edited.toml").compared.references) == (scene == "cone_penetration")


def test_defaults_that_are_uncommented_are_the_scenes_own() -> None:
    main(["new", "mine"])
    lines = Path("mine.toml").read_text().split("# A reference of your own")[0].splitlines()
    assert "#in_situ_stress = 400000.0" in lines
    given = [line[1:] if re.match(r"#\w+ = [^.\[]", line) else line for line in lines]
    Path("edited.toml").write_text("\n".join(given))
    fixed = read_toml(Path("edited.toml"))["fixed"]
    known = parameters_of(scene_class("cone_penetration"))
    with_default = {name for name, it in known.items() if it.default is not None}
    assert fixed.keys() == with_default - {"rigidity_index"}  # which varies
    edited, mine = (load_study(f"{name}.toml") for name in ("edited", "mine"))
    assert [case.key for case in edited.cases] == [case.key for case in mine.cases]


def test_a_new_study_runs_as_it_stands(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", "mine", "--scene", "material_point"]) == 0
    assert main(["run", "mine.toml", "--set", "step_count=10"]) in (0, 1)
    assert main(["status", "results/mine.nc"]) in (0, 1)
    assert main(["status", "material_point"]) == 0
    out = capsys.readouterr().out
    assert "rigidity_index=100.0" in out
    assert "results/mine.nc  material_point: 2 cases: 2 completed" in out


def test_a_study_is_described_and_planned(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["describe", "stability_random"]) == 0
    described = capsys.readouterr().out
    assert "varied       undrained_shear_strength = 1 to 1e+07 Pa" in described
    assert "excluded     cells_per_radius**3 * penetration > 300" in described
    assert "a Latin hypercube" in described
    assert main(["plan", "adhesion_factor", "--set", "adhesion_factor=[0, 1]"]) == 0
    heading, *rows, total = capsys.readouterr().out.splitlines()
    assert heading.split() == ["points", "memory", "steps", "<", "time", "<", "case"]
    assert [row.split()[-1] for row in rows] == ["adhesion_factor=0.0", "adhesion_factor=1.0"]
    assert total.startswith("2 cases, ")


@pytest.mark.parametrize(
    ("setting", "warning"),
    [
        ("undrained_shear_strength=35", "= 35 is in Pa; if 35 kPa is meant, give 35000"),
        ("cone_radius=17.85", "= 17.85 is in m; if 17.85 mm is meant, give 0.01785"),
        ("density=17", "= 17 is in kg m-3; if 17 kN/m3 is meant, give 1732.93"),
        ("in_situ_stress=[200, 400]", "= 200 is in Pa; if 200 kPa is meant, give 200000"),
        ("undrained_shear_strength=[1, 1e3, 1e7]", ""),
        ("in_situ_stress=0", ""),
        ("cone_radius=0.0252", ""),
        ("cone_radius=1", ""),
    ],
)
def test_a_value_in_what_looks_like_another_unit_is_told(
    setting: str, warning: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["plan", "mesh_size", "--set", "cells_per_radius=1", "--set", setting]) == 0
    lines = [f"harness: {setting.partition('=')[0]} {warning}"] if warning else []
    assert capsys.readouterr().err.splitlines() == lines


@pytest.mark.parametrize(
    ("profile", "warning"),
    [
        ("strength [Pa]; 0, 25", "strength = 25 is in Pa; if 25 kPa is meant, its column is [kPa]"),
        (
            "strength [kPa], unit_weight [N/m3]; 0, 25, 17; 9, 25, 17",
            "unit_weight = 17 is in N/m3; if 17 kN/m3 is meant, its column is [kN/m3]",
        ),
        ("strength [kPa]; 0, 25", ""),
    ],
)
def test_a_column_of_a_profile_in_what_looks_like_another_unit_is_told(
    profile: str, warning: str, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["plan", "sounding", "--set", f'profile="depth [m], {profile}"'])
    told = [it for it in capsys.readouterr().err.splitlines() if " is meant" in it]
    assert told == ([f"harness: profile: {warning}"] if warning else [])


THROWN_OFF = "rho V^2 is 20 su, and above 10 su soil is thrown off; try speed_ratio = 0.1 or less"
SANE = "nearly all cases complete from 0.0001 to 0.1"


@pytest.mark.parametrize(
    ("settings", "lines"),
    [
        (["speed_ratio=0.1", "rigidity_index=900"], []),
        (["speed_ratio=[0.1, 0.2, 0.3]"], [f"speed_ratio = 0.3; {SANE}"]),
        (
            ["speed_ratio=[0.1, 0.2]", "rigidity_index=500"],
            [
                f"speed_ratio = 0.2; {SANE}",
                f"1 of 2 cases are likely to fail; speed_ratio=0.2: {THROWN_OFF}",
            ],
        ),
    ],
    ids=["sane", "beyond", "likely to fail"],
)
def test_a_value_that_fewer_cases_complete_with_is_told(
    settings: list[str], lines: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    given = [it for setting in settings for it in ("--set", setting)]
    assert main(["plan", "cone_penetration", *given]) == 0
    assert capsys.readouterr().err.splitlines() == [f"harness: {line}" for line in lines]


def test_a_cyclic_test_that_is_fast_for_remoulded_clay_is_told_of(
    capsys: pytest.CaptureFixture[str],
) -> None:
    settings = ("remoulded_strength_ratio=0.04", "ductility=10", "speed_ratio=[0.01, 0.1]")
    given = [it for setting in settings for it in ("--set", setting)]
    assert main(["plan", "cyclic_t_bar", *given]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert "speed_ratio=0.1: rho V^2 is 25 of the remoulded strength" in line
    assert line.endswith("try speed_ratio = 0.02 or less")
