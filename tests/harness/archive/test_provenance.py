"""Provenance of a result: where, when and by which code its cases were computed."""

import sys
from pathlib import Path
from types import ModuleType

import pytest
import xarray as xr

import mpm_warp
from harness.archive import provenance as origin
from harness.archive.case_files import case_file, write_case
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED, CRASHED
from harness.archive.provenance import SOURCES, other_version, provenance, sources_digest
from harness.archive.study_files import read_study, write_study
from harness.run.collect_and_clean import collect_and_write
from harness.run.worker import compute
from harness.study.cases import Case
from harness.study.study import Study
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import DONE, Command, keep, study_in

EARLIER = {"commit": "earlier", "processor": "another", "device": "cuda:0", "time_written": "then"}


@pytest.fixture
def cases(small: Study, tmp_path: Path) -> list[Case]:
    """The cases of a study, which all completed at another time and place."""
    now = {SOURCES: sources_digest(small.parts[0].scene)}
    keep(small, tmp_path, *[DONE.assign_attrs(EARLIER | now)] * 3)
    return list(small.cases)


@pytest.mark.usefixtures("cases")
def test_a_result_says_where_its_cases_were_computed(small: Study, tmp_path: Path) -> None:
    collect_and_write(small, tmp_path)
    attributes = read_study(tmp_path / "small.nc").attrs
    assert {name: attributes[name] for name in EARLIER} == EARLIER
    here = provenance()
    assert attributes["collected_commit"] == here["commit"]
    assert attributes["collected_time_written"].startswith("20")
    assert attributes["Conventions"] == here["Conventions"]


def test_what_differs_between_the_cases_is_told_of_each(
    small: Study, cases: list[Case], folder: Path, tmp_path: Path
) -> None:
    later = DONE.assign_attrs(EARLIER | {"commit": "later"})
    write_case(folder, cases[1], later, COMPLETED)
    case_file(folder, cases[2]).unlink()
    dataset = collect(small, folder)
    assert dataset["commit"].dims == ("adhesion_factor",)
    assert dataset["commit"].values.tolist() == ["earlier", "later", ""]
    assert "commit" not in dataset.attrs
    assert dataset.attrs["device"] == "cuda:0"  # of all that were computed
    write_study(tmp_path / "small.nc", dataset)
    assert read_study(tmp_path / "small.nc")["commit"].values.tolist() == ["earlier", "later", ""]


def test_a_case_that_never_reached_a_device_has_none(
    small: Study, cases: list[Case], folder: Path
) -> None:
    write_case(folder, cases[0], xr.Dataset(), CRASHED, "worker killed")
    dataset = collect(small, folder)
    assert dataset.attrs["device"] == "cuda:0"
    assert dataset["commit"].values.tolist() == [provenance()["commit"], "earlier", "earlier"]


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A simulator of two files."""
    package = tmp_path / "mpm_warp"
    (package / "step").mkdir(parents=True)
    (package / "scene.py").write_text("a = 1\n")
    (package / "step" / "momentum.py").write_text("b = 1\n")
    monkeypatch.setattr(mpm_warp, "__path__", [str(package)])
    return package


def digest(scene: type = object) -> str:
    """What a fresh process finds."""
    sources_digest.cache_clear()
    try:
        return sources_digest(scene)
    finally:
        sources_digest.cache_clear()


def test_every_source_of_the_simulator_counts_and_nothing_else(sources: Path) -> None:
    before = digest()
    assert len(before) == 16
    (sources / "notes.md").write_text("of no matter")
    assert digest() == before
    (sources / "step" / "momentum.py").write_text("b = 2\n")
    changed = digest()
    (sources / "step" / "momentum.py").rename(sources / "momentum.py")
    moved = digest()
    (sources / "added.py").touch()
    assert len({before, changed, moved, digest()}) == 4


def test_the_module_of_a_scene_of_another_package_counts(
    sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "dam.py"
    file.write_text("height = 1\n")
    module = ModuleType("dam")
    module.__file__ = str(file)
    monkeypatch.setitem(sys.modules, "dam", module)
    scene = type("Dam", (), {"__module__": "dam"})
    before = digest(scene)
    assert before != digest()
    file.write_text("height = 2\n")
    assert digest(scene) not in (before, digest())


def test_a_case_names_the_code_that_computes_it_though_it_is_edited_meanwhile(
    small: Study, sources: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = digest(ConePenetration)
    for function in (origin.sources_digest, origin._of_process):
        function.cache_clear()
    monkeypatch.setattr(origin, "_commit", lambda: "loaded")

    def edited(*_: object) -> xr.Dataset:
        (sources / "scene.py").write_text("a = 2\n")
        monkeypatch.setattr(origin, "_commit", lambda: "edited")
        return DONE

    monkeypatch.setattr(ConePenetration, "run", edited)
    said = compute(small.cases[0]).dataset.attrs
    for function in (origin.sources_digest, origin._of_process):
        function.cache_clear()
    assert (said[SOURCES], said["commit"]) == (loaded, "loaded")


@pytest.mark.usefixtures("cases")
@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("compare small.nc", 0),
        ("compare same.nc small.nc", 0),
        ("plot small.nc", 0),
        ("status small.nc", 0),
        ("status --out .", 0),
        ("report small.nc", 0),
        ("collect small.toml --out .", 0),
        ("collect referring.toml --out .", 0),
        ("recommend cone_penetration --error 1% --results .", 2),
    ],
)
def test_a_result_of_another_version_of_its_scene_is_told(
    line: str, code: int, small: Study, here: Path, command: Command
) -> None:
    collect_and_write(small, here)
    same = read_study(here / "small.nc")
    write_study(here / "same.nc", same)
    text = f'{small.source.read_text()}[compare]\nreference_study = "small.toml"\n'
    keep(study_in(here, text, name="referring"), here)
    assert "another version" not in command(*line.split(), code=code).err
    installed = ConePenetration.version
    older = same.assign_attrs(scene_version=installed - 1)
    write_study(here / "small.nc", older.assign(case_key="0" + older["case_key"]))
    told = (
        "3 of 3 cases computed by another version of the scene "
        f"(cone_penetration {installed - 1}, installed is {installed})"
    )
    said = command(*line.split(), code=code).err
    assert said.count(told) == 1
    assert "small.nc" in said
    if line.startswith("report"):
        assert f'<p class="bad">{told}.</p>' in (here / "report.html").read_text()


def test_versions_are_told_scene_by_scene_and_of_snapshots(
    small: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = study_in(tmp_path, 'title = "t"\nscene = ["cone_penetration", "t_bar_penetration"]\n')
    result = collect(both, keep(both, tmp_path))
    installed = ConePenetration.version
    fields = xr.Dataset(attrs={"scene": "cone_penetration", "scene_version": installed})
    assert other_version(result) == other_version(fields) == ""
    monkeypatch.setattr(ConePenetration, "version", installed + 1)
    scene = f"another version of the scene (cone_penetration {installed}, installed is"
    assert other_version(result).startswith(f"1 of 2 cases computed by {scene}")
    assert other_version(fields).startswith(f"1 of 1 case computed by {scene}")
