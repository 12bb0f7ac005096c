"""`harness list` and `describe`."""

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from harness.cli.main import main
from harness.study.files import study_names
from harness.study.study import Study, load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import catalogue, scene_names
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import study_in


def test_list_names_studies_and_scenes(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A package whose scene cannot be loaded takes nothing from the others."""
    lost = EntryPoint("lost", "nowhere:Scene", catalogue.GROUP)
    everything = {**catalogue._all_scenes(), "lost": lost}
    monkeypatch.setattr(catalogue, "_all_scenes", lambda: everything)
    assert main(["list"]) == 0
    listed = capsys.readouterr().out
    for name in study_names():
        assert f"  {name} " in listed
        assert f" {load_study(name).title}\n" in listed
    for name in scene_names():
        assert f"  {name} " in listed
    assert "scene 'lost': the entry point 'nowhere:Scene' of an unknown package cannot be" in listed


def test_describe_gives_unit_default_range_and_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    """And the range in which nearly all cases complete."""
    assert main(["describe", "cone_penetration"]) == 0
    described = capsys.readouterr().out
    allowed = parameters_of(ConePenetration)["cone_radius"].allowed
    assert ConePenetration.summary in described
    lines = {line.split()[0]: line for line in described.splitlines() if line}
    told = lines["cone_radius"].split(maxsplit=3)
    assert told == ["cone_radius", "0.01785", "m", f"radius of the cone's base; {allowed}"]
    assert lines["apex_angle"].endswith("<= 150; nearly all cases complete from 30 to 120")
    assert main(["describe", "sounding"]) == 0
    assert f"{'layer_top':26} none [m]" in capsys.readouterr().out


@pytest.mark.parametrize("excluded", [0, 100])
def test_a_study_of_very_many_cases_is_described_at_once(
    excluded: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    conditions = [f"rigidity_index > {1000 + it} and density > 1" for it in range(excluded)]
    study = study_in(
        tmp_path,
        'title = "t"\nscene = "cone_penetration"\n'
        f"exclude = {conditions}\n"
        "[vary]\nrigidity_index = { from = 50, to = 250, count = 99999 }\n",
    )
    monkeypatch.setattr(Study, "cases", property(lambda _: pytest.fail("each case was made")))
    assert main(["describe", str(study.source)]) == 0
    assert "cases        99999 at most, all combinations" in capsys.readouterr().out
