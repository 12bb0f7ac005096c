"""`status`, `collect` and `clean`: what they say, and that only what was listed is removed."""

import io
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from harness.archive.atomic_files import partial_ending, prepare
from harness.archive.case_files import case_file, write_case
from harness.archive.conventions import COMPLETED, CRASHED, HALF_WIDTH
from harness.archive.netcdf_files import write_netcdf
from harness.archive.provenance import SOURCES
from harness.archive.study_files import read_study
from harness.run.collect_and_clean import outcomes, remove_stray, stray_files
from harness.run.resources import RunOptions, case_time
from harness.run.worker import run_case
from harness.study.study import Study
from mpm_warp.provenance import sources_digest
from tests.harness.conftest import DONE, Command, Refusal, damage, keep, prepared

NOBODY = partial_ending(2**22 + 1)
"""Ending of what a process was writing that has ended."""


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


@pytest.fixture
def folder(out: Path, small: Study) -> Path:
    return prepared(small, out)


@pytest.fixture
def half_done(folder: Path, small: Study) -> Study:
    """A study of which one case is done, one has crashed and one has not run."""
    done = DONE.assign(case_time=case_time(12.25))
    write_case(folder, small.cases[0], done, COMPLETED)
    write_case(folder, small.cases[1], xr.Dataset(), CRASHED, "worker killed by SIGKILL")
    return small


@pytest.fixture
def of_small(command: Command, small: Study, out: Path) -> Command:
    """A command on that study."""
    return lambda name, *more, code=0: command(name, small.source, "--out", out, *more, code=code)


def test_status_lists_every_case_and_counts_them(half_done: Study, of_small: Command) -> None:
    _, done, crashed, missing, summary = of_small("status", code=1).out.splitlines()
    keys = [case.key for case in half_done.cases]
    assert done.split() == [keys[0], "completed", "12.2", "s", "adhesion_factor=0.0"]
    assert crashed.split(maxsplit=2)[:2] == [keys[1], "crashed"]
    assert crashed.endswith("adhesion_factor=0.5: worker killed by SIGKILL")
    assert missing.split() == [keys[2], "missing", "adhesion_factor=1.0"]
    assert summary == "3 cases: 1 completed, 1 crashed, 1 missing; 12.2 s in all"


def test_status_says_why_a_case_has_no_half_width_and_what_one_means(
    folder: Path, out: Path, small: Study, command: Command, of_small: Command
) -> None:
    told = ((), "Delta: it is beyond 0.95; speed: the speed is too high", {"role": "reason"})
    write_case(folder, small.cases[0], DONE.assign(why_no_uncertainty=told), COMPLETED)
    of_small("collect", code=1)
    for said in (of_small("status", code=1), command("status", out / "small.nc", code=1)):
        lines = said.out.splitlines()
        assert lines[1].endswith("adhesion_factor=0.0: no U: Delta, speed")
        assert lines[-1] == f"U: {HALF_WIDTH}"

    known = (), 0.1, {"role": "uncertainty"}
    partly = DONE.assign(why_no_uncertainty=told, last_cone_factor_uncertainty=known)
    write_case(folder, small.cases[0], partly, COMPLETED)
    assert "no U" not in of_small("status", code=1).out  # of some depths of a sounding alone


def test_collect_writes_what_there_is(out: Path, half_done: Study, of_small: Command) -> None:
    told = of_small("collect", code=1)
    assert told.out == f"{out / 'small.nc'}\n"
    assert "3 cases: 1 completed, 1 crashed, 1 missing" in told.err
    dataset = read_study(out / "small.nc")
    assert dataset.status.values.tolist() == [COMPLETED, CRASHED, "missing"]
    assert dataset.cone_factor.values[0] == 10
    keep(half_done, out)
    of_small("collect")
    of_small("status")


def test_a_study_of_the_same_name_is_not_replaced_silently(
    small: Study, out: Path, half_done: Study, of_small: Command
) -> None:
    of_small("collect", code=1)
    assert "another title" not in of_small("collect", code=1).err
    source = Path(small.source)
    title = f'title = "{small.title}"'
    assert title in source.read_text(encoding="utf-8")
    source.write_text(
        source.read_text(encoding="utf-8").replace(title, 'title = "Of another ground"'),
        encoding="utf-8",
    )
    told = of_small("collect", code=1).err
    named = f'{out / "small.nc"}: was of a study with another title, "{small.title}"; its cases'
    assert named in told


def test_results_of_other_settings_are_told(out: Path, half_done: Study, of_small: Command) -> None:
    of_small("collect", code=1)
    keep(half_done, out)
    assert "other result" not in of_small("collect").err
    told = of_small("collect", "--set", "adhesion_factor=[0, 0.5]").err
    assert f"{out / 'small.nc'}: had 1 other result, kept in the files of the cases; " in told
    assert "other result" not in of_small("collect").err


@pytest.mark.parametrize("status", ["missing", "damaged", "unreadable"])
def test_a_file_with_results_that_would_be_lost_is_kept(
    status: str, small: Study, out: Path, folder: Path, of_small: Command
) -> None:
    keep(small, out)
    of_small("collect")
    path = out / "small.nc"
    before = path.read_bytes()
    lost = case_file(folder, small.cases[0])
    match status:
        case "missing":
            lost.unlink()
        case "damaged":
            damage(lost)
        case "unreadable":
            lost.write_bytes(b"of another program")
    for name in ("small_before.nc", "small_before_2.nc"):
        path.write_bytes(before)
        told = of_small("collect", code=1).err
        assert (
            f"{path}: had 1 result of cases that are {status} now; kept as it was in {name}; "
            in told
        )
        assert (out / name).read_bytes() == before
    assert "kept as it was" not in of_small("collect", code=1).err


def test_results_of_other_settings_whose_files_are_gone_are_kept(
    small: Study, out: Path, folder: Path, of_small: Command
) -> None:
    keep(small, out)
    of_small("collect")
    case_file(folder, small.cases[2]).unlink()
    told = of_small("collect", "--set", "adhesion_factor=[0, 0.5]").err
    assert "had 1 result of cases that are missing now; kept as it was in small_before.nc" in told
    assert read_study(out / "small_before.nc").cone_factor.size == 3


@pytest.mark.parametrize("command", ["collect", "run"])
def test_the_result_of_a_site_is_not_overwritten_by_that_of_a_study(
    command: str, small: Study, out: Path, half_done: Study, refusal: Refusal
) -> None:
    path = out / "small.nc"
    write_netcdf(DONE.assign_attrs(site="small"), path)
    before = path.read_bytes()
    assert refusal([command, str(small.source), "--out", str(out)]) == (
        f"harness: {path}: is not the result of a study; not overwritten: move it away, or give "
        "another --out"
    )
    assert path.read_bytes() == before


def test_a_failure_does_not_replace_what_another_run_has_completed(
    small: Study, folder: Path, half_done: Study, out: Path
) -> None:
    too_little = RunOptions(memory_limit=1.0)
    for case in small.cases:
        run_case(case, folder, options=too_little)
    assert [it.status for it in outcomes(small, out)] == [COMPLETED, "refused", "refused"]


OTHERS = (
    "harness: small: 2 of 3 results computed by other sources of the simulator, of the same "
    "version; kept: `harness run --fresh` computes them anew"
)


def keep_made(study: Study, out: Path, *sources: str | None) -> None:
    """Write results of all cases, which say by which sources they were computed."""
    said = [{} if digest is None else {SOURCES: digest} for digest in sources]
    keep(study, out, *(DONE.assign(made=1.0).assign_attrs(it) for it in said))


@pytest.mark.parametrize("name", ["run", "status", "collect"])
def test_results_of_other_sources_are_told(
    name: str, small: Study, out: Path, command: Command, of_small: Command
) -> None:
    ours = f"mpm_warp {sources_digest('mpm_warp')}"
    keep_made(small, out, ours, ours, ours)
    assert "sources" not in of_small(name).err
    keep_made(small, out, ours, "earlier", None)
    assert OTHERS in of_small(name).err.splitlines()
    if name != "status":
        dataset = read_study(out / "small.nc")
        assert dataset["made"].values.tolist() == [1.0, 1.0, 1.0]
        assert dataset[SOURCES].values.tolist() == [ours, "earlier", ""]
        path = out / "small.nc"
        told = command("compare", path).err.splitlines()
        assert OTHERS.replace("small", str(path), 1) in told


@pytest.fixture
def leftovers(folder: Path, half_done: Study) -> set[Path]:
    """One of each kind of file that belongs to no case."""
    case = half_done.cases[0]
    stranger = replace(case, parameters={**case.parameters, "rigidity_index": 50.0})
    write_case(folder, stranger, DONE, COMPLETED)
    damaged, noise = case_file(folder, half_done.cases[2]), folder / "noise.nc"
    for path in (damaged, noise):
        damage(path)
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    partial = folder / f".{case.key}.nc{partial_ending(ended.pid)}"
    partial.touch()
    return {case_file(folder, stranger), damaged, noise, partial}


@pytest.mark.parametrize("answer", [None, "", "n\n", "yes please\n"])
def test_clean_removes_nothing_without_a_yes(
    answer: str | None, leftovers: set[Path], of_small: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Nobody can answer where standard input is closed.
    monkeypatch.setattr(sys, "stdin", None if answer is None else io.StringIO(answer))
    told = of_small("clean", code=1)
    assert {Path(line.partition(": ")[0]) for line in told.out.splitlines()} == leftovers
    assert "rigidity_index=50.0" in told.out
    assert "remove 4 files? [y/N]" in told.err
    assert told.err.endswith("nothing removed\n")
    assert all(path.exists() for path in leftovers)


def test_clean_leaves_the_results_of_the_study_and_what_is_being_written(
    folder: Path, half_done: Study, leftovers: set[Path], of_small: Command
) -> None:
    being_written = folder / f".x.nc{partial_ending(os.getpid())}"
    elsewhere = folder / ".x.nc.another_machine-1.part"
    for path in (being_written, elsewhere):
        path.touch()
    of_small("clean", "--yes")
    kept = {case_file(folder, case) for case in half_done.cases[:2]}
    assert set(folder.iterdir()) == {*kept, being_written, elsewhere}
    of_small("clean")  # nothing to ask about


def test_clean_keeps_what_is_no_result_of_a_case_and_removes_what_no_process_can_be_writing(
    folder: Path, half_done: Study, of_small: Command
) -> None:
    """Results that another study wrote into this folder; a number that no process has."""
    of_small("collect", code=1)
    inner = folder / "small.nc"
    inner.write_bytes((folder.parents[1] / "small.nc").read_bytes())
    partial = folder / f".abc{partial_ending('9' * 20)}"
    partial.touch()
    told = of_small("clean", "--yes")
    assert told.out == f"{partial}: half-written\n"
    assert f"{inner}: is no result of a case; kept" in told.err
    assert inner.exists()
    assert not partial.exists()


def test_clean_says_what_each_file_is(folder: Path, half_done: Study, of_small: Command) -> None:
    second = half_done.cases[1]
    copy, older, stiff = (folder / name for name in ("copy.nc", "older.nc", "stiff.nc"))
    copy.write_bytes(case_file(folder, second).read_bytes())
    for path, changed in (
        (older, replace(second, scene_version=0)),
        (stiff, replace(second, parameters={**second.parameters, "rigidity_index": 50.0})),
    ):
        write_case(folder, changed, DONE, COMPLETED)
        case_file(folder, changed).rename(path)
    damaged = case_file(folder, second)
    damage(damaged)
    told = dict(line.split(": ", 1) for line in of_small("clean", "--yes").out.splitlines())
    assert told.pop(str(damaged)).startswith("cannot be read: ")
    stranger = "no case of this study: cone_penetration version"
    of_second = "adhesion_factor=0.5, shaft_adhesion_factor=0.5"
    assert told == {
        str(copy): f"a copy of case {second.key}",
        str(older): f"{stranger} 0, completed: {of_second}",
        str(stiff): f"{stranger} {second.scene_version}, completed: rigidity_index=50.0, "
        f"{of_second}",
    }


@pytest.fixture
def outside(tmp_path: Path, small: Study) -> Path:
    """A folder beside the results, with files that `clean` would remove among its own."""
    outside = tmp_path / "outside"
    (outside / "cases").mkdir(parents=True)
    for place in (outside, outside / "cases"):
        damage(place / "precious.nc")
        damage(case_file(place, small.cases[0]))
        (place / f".x.nc{NOBODY}").touch()
    return outside


@pytest.mark.parametrize("name", ["clean --yes", "run", "run --fresh"])
@pytest.mark.parametrize("link", ["small", "small/cases"])
def test_a_linked_folder_is_refused_and_left_as_it_is(
    link: str, name: str, outside: Path, out: Path, of_small: Command
) -> None:
    place = out / link
    prepare(place.parent)
    place.symlink_to(outside)
    before = set(outside.rglob("*"))
    (line,) = of_small(*name.split(), code=2).err.splitlines()
    assert line.startswith(
        f"harness: {place}: is a link, and files outside the results are never removed"
    )
    assert set(outside.rglob("*")) == before


def test_the_results_may_be_a_link(
    small: Study, out: Path, tmp_path: Path, of_small: Command
) -> None:
    folder = prepared(small, tmp_path / "real")
    damage(folder / "noise.nc")
    out.symlink_to(tmp_path / "real")
    assert of_small("clean", "--yes").err == "harness: 1 file removed\n"
    assert not list(folder.iterdir())


def test_links_go_and_what_they_lead_to_stays_and_a_folder_stops_nothing(
    outside: Path, small: Study, folder: Path, of_small: Command
) -> None:
    links = {
        folder / "file.nc": outside / "precious.nc",
        case_file(folder, small.cases[1]): outside / "precious.nc",
    }
    kept_links = {folder / "folder.nc": outside / "cases", folder / "nowhere.nc": outside / "none"}
    for link, end in (links | kept_links).items():
        link.symlink_to(end)
    folders = {case_file(folder, small.cases[0]), folder / "a.nc", folder / f".half.nc{NOBODY}"}
    for kept in folders:
        kept.mkdir()
        (kept / "inside.nc").touch()
    before = set(outside.rglob("*"))
    told = of_small("clean", "--yes")
    assert {Path(line.partition(": ")[0]) for line in told.out.splitlines()} == links.keys()
    assert told.err.count("it is no file but a folder or a device; kept") == 3
    assert told.err.endswith("harness: 2 files removed\n")
    assert set(outside.rglob("*")) == before
    assert set(folder.iterdir()) == {*folders, *kept_links}


def test_what_was_written_anew_since_it_was_listed_is_kept(
    small: Study, out: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = case_file(folder, small.cases[0])
    for noise in (path, folder / "noise.nc"):
        damage(noise)
    found = stray_files(small, out)
    assert len(found) == 2
    path.write_bytes(b"a result that another run has written")
    assert remove_stray(found) == 1
    assert capsys.readouterr().err == f"harness: {path}: was written anew meanwhile; kept\n"
    assert list(folder.iterdir()) == [path]
