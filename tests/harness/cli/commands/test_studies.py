"""`harness new`, and what is told of scenes and studies: `list`, `describe`, `plan`, `status`."""

import json
import re
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from harness.cli.main import main
from harness.run.verify import checks_of
from harness.study.files import read_toml, studies_folder, study_names
from harness.study.study import Study, load_study
from mpm_warp.fields.declaration import own_parameters_of
from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes import catalogue, scene_class, scene_names
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import HEAD, Command, study_in

pytestmark = pytest.mark.usefixtures("here")


@pytest.mark.slow
@pytest.mark.parametrize("scene", scene_names())
def test_a_new_study_is_sound_and_explains_every_parameter(scene: str) -> None:
    assert main(["new", "mine", "--scene", scene]) == 0
    study = load_study("mine.toml")
    assert len(study.cases) > 1
    text = Path("mine.toml").read_text(encoding="utf-8")
    assert max(map(len, text.splitlines())) <= 100
    for name in own_parameters_of(scene_class(scene)):
        assert f"{name} = " in text


@pytest.mark.parametrize("scene", ["cone_penetration", "sounding", "cone_bearing"])
def test_references_are_offered_to_a_scene_that_has_what_they_are_of(scene: str) -> None:
    main(["new", "mine", "--scene", scene])
    text = Path("mine.toml").read_text(encoding="utf-8")
    assert ("#[compare]" in text) == (scene == "cone_penetration")
    for line in ("[compare]", "references", "experience"):
        text = text.replace(f"#{line}", line)
    Path("edited.toml").write_text(text, encoding="utf-8")
    assert bool(load_study("edited.toml").compared.references) == (scene == "cone_penetration")


def test_defaults_that_are_uncommented_are_the_scenes_own() -> None:
    main(["new", "mine"])
    lines = (
        Path("mine.toml")
        .read_text(encoding="utf-8")
        .split("# A reference of your own")[0]
        .splitlines()
    )
    assert "#in_situ_stress = 400000.0" in lines
    given = [line[1:] if re.match(r"#\w+ = [^.\[]", line) else line for line in lines]
    Path("edited.toml").write_text("\n".join(given), encoding="utf-8")
    fixed = read_toml(Path("edited.toml"))["fixed"]
    known = parameters_of(scene_class("cone_penetration"))
    with_default = {name for name, it in known.items() if it.default is not None}
    assert fixed.keys() == with_default - {"rigidity_index"}  # which varies
    edited, mine = (load_study(f"{name}.toml") for name in ("edited", "mine"))
    assert [case.key for case in edited.cases] == [case.key for case in mine.cases]


def test_the_notebook_that_ships_is_written_once(command: Command) -> None:
    assert command("tour").out == "tour.ipynb\n"
    assert Path("tour.ipynb").read_bytes() == (studies_folder() / "tour.ipynb").read_bytes()
    assert "tour.ipynb: exists already" in command("tour", code=2).err


@pytest.mark.slow
def test_a_new_study_runs_as_it_stands(command: Command) -> None:
    command("new", "mine", "--scene", "material_point")
    assert main(["run", "mine.toml", "--set", "step_count=100"]) in (0, 1)
    assert "rigidity_index=100.0" in command("status", "results/mine.nc").out
    whole = "results/mine.nc  material_point: 2 cases: 2 completed"
    assert whole in command("status", "material_point").out


def test_a_study_is_described_and_planned(command: Command) -> None:
    described = command("describe", "stability_random").out
    assert "varied       undrained_shear_strength = 1 to 1e+07 Pa" in described
    assert "excluded     cells_per_radius**3 * penetration > 300" in described
    assert "a Latin hypercube" in described
    planned = command("plan", "stress_anisotropy", "--set", "stress_anisotropy=[0, 0.5]").out
    heading, *rows, total = planned.splitlines()
    assert heading.split() == ["points", "memory", "steps", "<", "time", "<", "case"]
    assert [row.split()[-1] for row in rows] == ["stress_anisotropy=0.0", "stress_anisotropy=0.5"]
    assert total.startswith("2 cases, ")


def test_the_plan_of_one_case_says_what_each_group_of_arrays_takes(command: Command) -> None:
    lines = command("plan", "cone_penetration").out.splitlines()
    assert len(lines) < 30
    assert lines[0] == "kernels of a step: 10"
    assert re.fullmatch(
        r"  particles_to_grid \d+, cell_stress \d+, momentum \d+ x \d+, .*", lines[1]
    )
    assert any("(5 times)" in line for line in lines)
    (total,) = (
        re.fullmatch(r"arrays: \d+, ([\d,]+) bytes", line) for line in lines if "arrays" in line
    )
    groups = [re.fullmatch(r"  (\w+) +([\d,]+) bytes  \w+.*", line) for line in lines]
    sizes = {found[1]: int(found[2].replace(",", "")) for found in groups if found}
    assert sizes["particle"] > sizes["node"] > sizes["window"] > 0
    assert sum(sizes.values()) == int(total[1].replace(",", ""))


PROFILE = 'profile="depth [m], {}"'
OTHER_UNITS = {
    "undrained_shear_strength=35": "undrained_shear_strength = 35 is in Pa; if 35 kPa is meant, "
    "give 35000",
    "cone_radius=17.85": "cone_radius = 17.85 is in m; if 17.85 mm is meant, give 0.01785",
    "density=17": "density = 17 is in kg m-3; if 17 kN/m3 is meant, give 1732.93",
    "in_situ_stress=[200, 400]": "in_situ_stress = 200 is in Pa; if 200 kPa is meant, give 200000",
    PROFILE.format("strength [Pa]; 0, 25; 9, 25"): "profile: strength = 25 is in Pa; if 25 kPa is "
    "meant, its column is [kPa]",
    PROFILE.format("strength [kPa], unit_weight [N/m3]; 0, 25, 17; 9, 25, 17"): "profile: "
    "unit_weight = 17 is in N/m3; if 17 kN/m3 is meant, its column is [kN/m3]",
    "undrained_shear_strength=[1, 1e3, 1e7]": None,
    "in_situ_stress=0": None,
    "cone_radius=0.0252": None,
    "cone_radius=1": None,
    PROFILE.format("strength [kPa]; 0, 25; 9, 25"): None,
}


@pytest.mark.parametrize("setting", OTHER_UNITS)
def test_a_value_in_what_looks_like_another_unit_is_told(setting: str, command: Command) -> None:
    subject, told = "sounding" if "profile" in setting else "cone_penetration", OTHER_UNITS[setting]
    lines = command("plan", subject, "--set", setting).err.splitlines()
    assert [it for it in lines if " is meant" in it] == ([f"harness: {told}"] if told else [])


SANE = "nearly all cases complete from 0.0001 to 0.1"
ANGLE = "nearly all cases complete from 30 to 120"
LIKELY = "1 of 2 cases is likely to fail; speed_ratio="
OF_SU = "rho V^2 is 20 su, and above 10 su soil is thrown off; try speed_ratio = 0.1 or less, or "
CELLS = "cells_per_radius or more"
OF_STRONGEST = (
    "of the strongest soil rho V^2 is 18.2 su, and above 5 su soil is thrown off; try speed_ratio "
    "= 0.24 or less"
)
BRITTLE = (
    "the clay is brittle, and shears in layers thinner than the cells; no choice of the method is "
    "known to help below a ductility of 5 with a remoulded_strength_ratio below 0.15"
)
LEFT = "rho V^2 is 6.25 of the strength that is left in the end, and above 5 soil is "


UNUSUAL = {
    "sane": ("cone_penetration", "speed_ratio=0.1 rigidity_index=900", []),
    "beyond": (
        "cone_penetration",
        "speed_ratio=[0.1,0.2,0.3]",
        [f"speed_ratio = 0.2, 0.3; {SANE}"],
    ),
    "far beyond": (
        "cone_penetration",
        "apex_angle=[150,149,148,147,146,145,144,143,142,120,60]",
        [f"apex_angle = {', '.join(str(142 + it) for it in range(8))} and 1 more; {ANGLE}"],
    ),
    "likely to fail": (
        "cone_penetration",
        "speed_ratio=[0.1,0.2] rigidity_index=500 cells_per_radius=1.5",
        [f"speed_ratio = 0.2; {SANE}", f"{LIKELY}0.2: {OF_SU}1.8 cells_per_radius or more"],
    ),
    "of remoulded clay": (
        "cyclic_t_bar",
        "remoulded_strength_ratio=0.04 ductility=10 speed_ratio=[0.01,0.05]",
        [f"{LIKELY}0.05: {LEFT}thrown off; try speed_ratio = 0.02 or less"],
    ),
    "sounding": (
        "sounding",
        "speed_ratio=[0.1,0.45] rigidity_index=90 cells_per_radius=1.5",
        [f"{LIKELY}0.45: {OF_STRONGEST}"],
    ),
    "ball": (
        "ball_penetration",
        "cells_per_radius=3 rigidity_index=625 speed_ratio=[0.01,0.1]",
        [f"{LIKELY}0.1: {LEFT}thrown off; try speed_ratio = 0.04 or less, and 4 {CELLS}"],
    ),
    "brittle": (
        "t_bar_penetration",
        "remoulded_strength_ratio=0.1 ductility=[4,6]",
        [f"{LIKELY.replace('speed_ratio', 'ductility')}4.0: {BRITTLE}"],
    ),
}


@pytest.mark.parametrize(("scene", "settings", "lines"), UNUSUAL.values(), ids=UNUSUAL)
def test_a_value_that_fewer_cases_complete_with_is_told(
    scene: str, settings: str, lines: list[str], command: Command
) -> None:
    told = command("plan", scene, *(f"--set={setting}" for setting in settings.split())).err
    assert told.splitlines() == [f"harness: {line}" for line in lines]


LOST = "scene 'lost': the entry point 'nowhere:Scene' of an unknown package cannot be loaded: "


@pytest.fixture
def lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """A package whose scene cannot be loaded; it is to take nothing from the others."""
    lost = EntryPoint("lost", "nowhere:Scene", catalogue.GROUP)
    everything = {**catalogue._all_scenes(), "lost": lost}
    monkeypatch.setattr(catalogue, "_all_scenes", lambda: everything)


@pytest.mark.usefixtures("lost")
def test_list_names_studies_and_scenes(command: Command) -> None:
    listed = command("list").out
    for name in study_names():
        assert f"  {name} " in listed
        assert f" {load_study(name).title}\n" in listed
    for name in scene_names():
        assert f"  {name} " in listed
    assert LOST in listed


@pytest.mark.usefixtures("lost")
def test_a_scene_that_cannot_be_loaded_is_left_out_and_told(command: Command) -> None:
    told = command("schema")
    (line,) = told.err.splitlines()
    assert line.startswith(f"harness: left out: {LOST}")
    scenes = json.loads(told.out)["properties"]["scenes"]["properties"]
    assert scenes.keys() == set(scene_names()) - {"lost"}
    assert "lost" not in {check.scene for check in checks_of()}
    without = command("run", "sliding_block", "--uncertainty", code=2).err
    assert "only for: " in without


def test_describe_gives_unit_default_range_and_meaning(command: Command) -> None:
    """And the range in which nearly all cases complete."""
    described = command("describe", "cone_penetration").out
    allowed = parameters_of(ConePenetration)["cone_radius"].allowed
    assert ConePenetration.summary in described
    lines = {line.split()[0]: line for line in described.splitlines() if line}
    told = lines["cone_radius"].split(maxsplit=3)
    assert told == ["cone_radius", "0.01785", "m", f"radius of the cone's base; {allowed}"]
    assert lines["apex_angle"].endswith("<= 150; nearly all cases complete from 30 to 120")
    assert f"{'layer_top':26} none [m]" in command("describe", "sounding").out


@pytest.mark.parametrize("excluded", [0, 100])
def test_a_study_of_very_many_cases_is_described_at_once(
    excluded: int, tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    conditions = [f"rigidity_index > {1000 + it} and density > 1" for it in range(excluded)]
    varied = "[vary]\nrigidity_index = { from = 50, to = 250, count = 99999 }\n"
    study = study_in(tmp_path, f"{HEAD}exclude = {conditions}\n{varied}")
    monkeypatch.setattr(Study, "cases", property(lambda _: pytest.fail("each case was made")))
    told = command("describe", study.source).out
    assert "cases        99999 at most, all combinations" in told
