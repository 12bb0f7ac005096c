"""A collected result: what it says of where its cases were computed, and whether it is whole."""

import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import xarray as xr

import mpm_warp
from harness.archive.case_files import case_file, case_folder, write_case
from harness.archive.conventions import COMPLETED, CRASHED
from harness.archive.netcdf_files import write_netcdf
from harness.archive.provenance import SOURCES, provenance, sources_digest
from harness.archive.study_files import collect, read_study, write_study
from harness.cli.main import main
from harness.run.collect_and_clean import collect_and_write
from harness.study.cases import Case
from harness.study.study import Study
from tests.harness.conftest import DONE, Refusal, keep

EARLIER = {"commit": "earlier", "processor": "another", "device": "cuda:0", "time_written": "then"}


@pytest.fixture
def cases(small: Study, tmp_path: Path) -> list[Case]:
    """The cases of a study, which all completed at another time and place."""
    now = {SOURCES: sources_digest(small.parts[0].scene)}
    keep(small, tmp_path, *[DONE.assign_attrs(EARLIER | now)] * 3)
    return list(small.cases)


@pytest.fixture
def result(small: Study, cases: list[Case], tmp_path: Path) -> Path:
    """The file of the collected study."""
    collect_and_write(small, tmp_path)
    return tmp_path / "small.nc"


def test_a_result_says_where_its_cases_were_computed(result: Path) -> None:
    attributes = read_study(result).attrs
    assert {name: attributes[name] for name in EARLIER} == EARLIER
    here = provenance()
    assert attributes["collected_commit"] == here["commit"]
    assert attributes["collected_time_written"].startswith("20")
    assert attributes["Conventions"] == here["Conventions"]


def test_what_differs_between_the_cases_is_told_of_each(
    small: Study, cases: list[Case], tmp_path: Path
) -> None:
    folder = case_folder(tmp_path, small)
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
    small: Study, cases: list[Case], tmp_path: Path
) -> None:
    folder = case_folder(tmp_path, small)
    write_case(folder, cases[0], xr.Dataset(), CRASHED, "worker killed")
    dataset = collect(small, folder)
    assert dataset.attrs["device"] == "cuda:0"
    assert dataset["commit"].values.tolist() == [provenance()["commit"], "earlier", "earlier"]


def test_a_damaged_case_does_not_keep_the_others_from_being_collected(
    small: Study, cases: list[Case], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = case_file(case_folder(tmp_path, small), cases[1])
    path.write_bytes(path.read_bytes()[:-3000])
    assert main(["collect", str(small.source), "--out", str(tmp_path)]) == 1
    told = capsys.readouterr().err.splitlines()
    assert told[-2].startswith(f"harness: {path}: cannot be read: ")
    assert told[-2].endswith("; `harness run` runs the case again")
    assert told[-1].startswith("harness: 3 cases: 2 completed, 1 damaged; ")
    dataset = read_study(tmp_path / "small.nc")
    assert dataset.status.values.tolist() == [COMPLETED, "damaged", COMPLETED]
    assert str(dataset.message.values[1]).startswith(f"{path}: cannot be read: ")
    assert np.isnan(dataset.cone_factor.values).tolist() == [False, True, False]


def test_a_result_is_not_replaced_by_one_of_nothing(
    small: Study, result: Path, refusal: Refusal
) -> None:
    before = result.read_bytes()
    out = ["--out", str(result.parent)]
    line = refusal(["collect", str(small.source), "--set", "rigidity_index=50", *out])
    assert line == (
        f"harness: {case_folder(result.parent, small)}: has no case of this study; "
        "run it first, or give each --set that it was run with"
    )
    assert result.read_bytes() == before


def test_a_folder_without_results_is_not_made(
    small: Study, tmp_path: Path, refusal: Refusal
) -> None:
    refusal(["collect", str(small.source), "--out", str(tmp_path / "none")])
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(
    ("damage", "name"),
    [
        (lambda it: it.drop_vars("status"), "status"),
        (lambda it: it.drop_vars("message"), "message"),
        (lambda it: it.drop_vars("case_key"), "case_key"),
        (lambda it: it.assign(status=it["cone_factor"]), "status"),
        (lambda it: it.assign(case_key="one for all"), "case_key"),
        (lambda it: it.attrs.pop("scene"), "scene"),
        (lambda it: it.attrs.pop("scene_version"), "scene_version"),
        (lambda it: it.assign_attrs(scene_version="new"), "scene_version"),
        (lambda it: it.assign_attrs(study="../../evil"), "study"),
        (lambda it: it.assign_attrs(study=3), "study"),
        (lambda it: it.assign_attrs(tolerances="{"), "tolerances"),
        (lambda it: it.assign_attrs(tolerances="[1]"), "tolerances"),
        (lambda it: it.assign_attrs(tolerances='{"error": "1"}'), "tolerances"),
    ],
)
@pytest.mark.parametrize("command", ["report", "rerun"])
def test_a_result_that_is_not_whole_is_refused_in_one_line(
    command: str, damage: Callable[[xr.Dataset], object], name: str, result: Path, refusal: Refusal
) -> None:
    whole = read_study(result)
    damaged = damage(whole)  # or whole itself is damaged
    write_netcdf(damaged if isinstance(damaged, xr.Dataset) else whole, result)
    line = refusal([command, str(result)])
    told = f"harness: {result}: is no whole result"
    of_study = f"{told}: {name} is missing or malformed; collect it again"
    # Without a status that is one, what a study's variables have to be is not known.
    assert line == of_study or (name == "status" and line.startswith(f"{told}: "))


@pytest.mark.parametrize("command", ["compare", "plot", "report", "rerun"])
def test_a_missing_file_is_one_line_without_an_empty_list(
    command: str, tmp_path: Path, refusal: Refusal
) -> None:
    path = tmp_path / "none.nc"
    assert refusal([command, str(path)]) == f"harness: {path}: no such file"
    for number in range(20):
        (tmp_path / f"{number:016x}.nc").touch()
    assert refusal([command, str(path)]) == f"harness: {path}: no such file"


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
