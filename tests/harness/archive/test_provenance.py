"""Provenance of a result: where, when and by which code its cases were computed."""

import dataclasses
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import xarray as xr

from harness.archive.case_files import case_file, case_folder, read_case, write_case
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED, CRASHED
from harness.archive.provenance import OF_CASE, SOURCES, other_version
from harness.archive.study_files import read_study, write_study
from harness.run.collect_and_clean import collect_and_write, outcomes
from harness.run.resources import RunOptions
from harness.run.worker import compute, run_case
from harness.study.cases import Case
from harness.study.study import Study
from mpm_warp import Gravity
from mpm_warp import provenance as origin
from mpm_warp.provenance import edited_packages, provenance, sources_digest, sources_of
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import DONE, Command, keep, prepared, study_in

EARLIER = {"commit": "earlier", "processor": "another", "device": "cuda:0", "time_written": "then"}


@pytest.fixture
def cases(small: Study, tmp_path: Path) -> list[Case]:
    """The cases of a study, which all completed at another time and place."""
    now = {SOURCES: f"mpm_warp {sources_digest('mpm_warp')}"}
    keep(small, tmp_path, *[DONE.assign_attrs(EARLIER | now)] * 3)
    return list(small.cases)


def test_a_scene_that_is_typed_in_has_no_sources(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where Python reads a script from its input, `__main__` has the file "<stdin>"."""
    typed = ModuleType("typed_in")
    typed.__file__ = "<stdin>"
    monkeypatch.setitem(sys.modules, "typed_in", typed)
    assert sources_digest("typed_in") == "none"


@pytest.mark.usefixtures("cases")
def test_a_result_says_where_its_cases_were_computed(small: Study, tmp_path: Path) -> None:
    collect_and_write(small, tmp_path)
    attributes = read_study(tmp_path / "small.nc").attrs
    assert {name: attributes[name] for name in EARLIER} == EARLIER
    here = provenance()
    assert attributes["history"].startswith("20")
    assert attributes["history"].endswith(f" (collected by {here['source']})")
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


def test_a_case_that_crashed_has_no_device(small: Study, cases: list[Case], folder: Path) -> None:
    write_case(folder, cases[0], xr.Dataset(), CRASHED, "worker killed")
    dataset = collect(small, folder)
    assert dataset.attrs["device"] == "cuda:0"
    assert dataset["commit"].values.tolist() == [provenance()["commit"], "earlier", "earlier"]


LAW = """
from mpm_warp import Tresca

class Soft(Tresca):
    pass
"""


@pytest.fixture
def own_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A package of two modules with a law; its folder."""
    package = tmp_path / "their_clay"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "soft.py").write_text(LAW)
    (package / "rates.py").write_text("rate = 1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield package
    for name in [name for name in sys.modules if name.startswith("their_clay")]:
        del sys.modules[name]
    sources_digest.cache_clear()


def test_the_sources_of_a_scene_are_those_of_its_law_and_its_parts_too(own_package: Path) -> None:
    from their_clay.soft import Soft  # type: ignore[import-not-found]

    scene = ConePenetration()
    built = scene.build()
    assert [it.split()[0] for it in sources_of(scene, built).split(", ")] == ["mpm_warp"]
    soft = Soft(shear_modulus=1e6, poissons_ratio=0.49, density=1700.0, strength=1e4)
    before = sources_of(scene, dataclasses.replace(built, material=soft))
    assert re.fullmatch(r"mpm_warp [0-9a-f]{16}, their_clay [0-9a-f]{16}", before)
    part = type("Part", (Gravity,), {"__module__": "their_clay.soft"})(9.81)
    assert sources_of(scene, built.with_parts(part)) == before
    (own_package / "notes.md").write_text("of no matter")
    sources_digest.cache_clear()
    assert edited_packages(before) == []
    (own_package / "rates.py").write_text("rate = 2\n")
    sources_digest.cache_clear()
    assert edited_packages(before) == ["their_clay"]
    assert edited_packages("") == ["mpm_warp"]


def test_a_case_whose_law_was_edited_is_run_again(
    own_package: Path, small: Study, tmp_path: Path, command: Command
) -> None:
    ours = sources_digest("mpm_warp")
    sources = f"mpm_warp {ours}, their_clay {sources_digest('their_clay')}"
    keep(small, tmp_path, *[DONE.assign_attrs(sources=sources)] * 3)
    of_study = (small.source, "--out", tmp_path)
    assert command("status", *of_study).err == ""
    (own_package / "soft.py").write_text(LAW.replace("pass", "rate = 2"))
    sources_digest.cache_clear()
    line = "small: 3 of 3 results computed by other sources of their_clay; `harness run` computes"
    for name in ("status", "collect"):
        told = command(name, *of_study, code=int(name == "status"))
        assert line in told.err
    assert [it.status for it in outcomes(small, tmp_path)] == ["outdated"] * 3
    case, folder = small.cases[0], case_folder(tmp_path, small)
    assert run_case(case, folder, options=RunOptions(memory_limit=1.0)).message != "by another run"
    assert [it.status for it in outcomes(small, tmp_path)] == ["refused", *["outdated"] * 2]


def test_a_result_from_python_has_the_provenance_of_a_case(stub: Study, tmp_path: Path) -> None:
    case, path, folder = stub.cases[0], tmp_path / "own.nc", prepared(stub, tmp_path)
    case.built().run().to_netcdf(path)
    with xr.open_dataset(path) as read:
        said = read.attrs
    run_case(case, folder)
    of_case = read_case(folder, case).attrs
    assert {*OF_CASE, "source", "history", "scene", "scene_version"} <= {*said}
    same = {*said} - {"time_written", "history"}
    assert {name: of_case[name] for name in same} == {name: said[name] for name in same}
    assert said["source"] == f"mpm_warp {said['mpm_warp_version']}, commit {said['commit']}"
    assert said["history"] == f"{said['time_written']} {said['command_line']}"


def test_attributes_are_in_the_order_of_a_reader(small: Study, folder: Path) -> None:
    write_case(folder, small.cases[0], DONE.assign_attrs(title="t"), COMPLETED)
    names = [*read_case(folder, small.cases[0]).attrs]
    first = ["title", "scene", "scene_version", "status", "message", "case_key", "source"]
    assert names[:8] == [*first, "history"]
    assert names[8:] == sorted(names[8:])


def test_a_case_names_the_code_that_computes_it_though_it_is_edited_meanwhile(
    small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(origin, "_commit", lambda: "loaded")
    origin._of_process.cache_clear()
    loaded = sources_digest("mpm_warp")

    def edited(*given: object) -> xr.Dataset:
        monkeypatch.setattr(origin, "_commit", lambda: "edited")
        monkeypatch.setattr(origin, "sources_digest", lambda _: "edited")
        return DONE

    monkeypatch.setattr(ConePenetration, "compute", edited)
    said = compute(small.cases[0]).dataset.attrs
    origin._of_process.cache_clear()
    assert (said[SOURCES], said["commit"]) == (f"mpm_warp {loaded}", "loaded")


@pytest.mark.usefixtures("cases")
@pytest.mark.parametrize(
    ("line", "code"),
    [
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
