"""`status`, `collect` and `clean`, as the command line has them."""

import io
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from harness.archive import case_files, study_files
from harness.archive.atomic_files import partial_ending
from harness.archive.conventions import COMPLETED, CRASHED, HALF_WIDTH
from harness.cli.main import main
from harness.run.resources import case_time
from harness.study.cases import Case
from harness.study.study import Study
from tests.harness.conftest import DONE, prepared

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path: Path, small: Study) -> Path:
    return prepared(small, tmp_path / "out")


@pytest.fixture
def half_done(folder: Path, small: Study) -> list[Case]:
    """A study of which one case is done, one has crashed and one has not run."""
    cases = list(small.cases)
    done = DONE.assign(case_time=case_time(12.25))
    case_files.write_case(folder, cases[0], done, COMPLETED)
    case_files.write_case(folder, cases[1], xr.Dataset(), CRASHED, "worker killed by SIGKILL")
    return cases


def command(name: str, small_file: Path, *more: str) -> list[str]:
    return [name, str(small_file), "--out", str(small_file.parent / "out"), *more]


def test_status_lists_every_case_and_counts_them(
    half_done: list[Case], small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command("status", small_file)) == 1
    _, done, crashed, missing, summary = capsys.readouterr().out.splitlines()
    keys = [case.key for case in half_done]
    assert done.split() == [keys[0], "completed", "12.2", "s", "adhesion_factor=0.0"]
    assert crashed.split(maxsplit=2)[:2] == [keys[1], "crashed"]
    assert crashed.endswith("adhesion_factor=0.5: worker killed by SIGKILL")
    assert missing.split() == [keys[2], "missing", "adhesion_factor=1.0"]
    assert summary == "3 cases: 1 completed, 1 crashed, 1 missing; 12.2 s in all"


def test_status_says_why_a_case_has_no_half_width_and_what_one_means(
    folder: Path, small: Study, small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = ((), "Delta: it is beyond 0.95; speed: it is too high", {"role": "reason"})
    case_files.write_case(folder, small.cases[0], DONE.assign(why_no_uncertainty=told), COMPLETED)
    main(command("collect", small_file))
    capsys.readouterr()
    collected = ["status", str(small_file.parent / "out" / f"{small.name}.nc")]
    for which in (command("status", small_file), collected):
        main(which)
        lines = capsys.readouterr().out.splitlines()
        assert lines[1].endswith("adhesion_factor=0.0: no U: Delta, speed")
        assert lines[-1] == f"U: {HALF_WIDTH}"

    known = (), 0.1, {"role": "uncertainty"}
    partly = DONE.assign(why_no_uncertainty=told, last_cone_factor_uncertainty=known)
    case_files.write_case(folder, small.cases[0], partly, COMPLETED)
    main(command("status", small_file))
    assert "no U" not in capsys.readouterr().out  # of some depths of a sounding alone


def test_collect_writes_what_there_is(
    folder: Path, half_done: list[Case], small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command("collect", small_file)) == 1
    captured = capsys.readouterr()
    path = small_file.parent / "out" / "small.nc"
    assert captured.out == f"{path}\n"
    assert "3 cases: 1 completed, 1 crashed, 1 missing" in captured.err
    dataset = study_files.read_study(path)
    assert dataset.status.values.tolist() == [COMPLETED, CRASHED, "missing"]
    assert dataset.cone_factor.values[0] == 10
    for case in half_done:
        case_files.write_case(folder, case, DONE, COMPLETED)
    assert main(command("collect", small_file)) == 0
    assert main(command("status", small_file)) == 0


@pytest.fixture
def leftovers(folder: Path, half_done: list[Case]) -> set[Path]:
    """One of each kind of file that belongs to no case."""
    case = half_done[0]
    stranger = replace(case, parameters={**case.parameters, "rigidity_index": 50.0})
    case_files.write_case(folder, stranger, DONE, COMPLETED)
    damaged = case_files.case_file(folder, half_done[2])
    damaged.write_bytes(b"noise")
    noise = folder / "noise.nc"
    noise.write_bytes(b"noise")
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    half = case_files.case_file(folder, case)
    partial = half.with_name(f".{half.name}{partial_ending(ended.pid)}")
    partial.touch()
    return {case_files.case_file(folder, stranger), damaged, noise, partial}


def removed(folder: Path, leftovers: set[Path]) -> set[Path]:
    return {path for path in leftovers if path not in set(folder.iterdir())}


@pytest.mark.parametrize("answer", [None, "", "n\n", "yes please\n"])
def test_clean_removes_nothing_without_a_yes(
    answer: str | None,
    folder: Path,
    leftovers: set[Path],
    small_file: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Nobody can answer where standard input is closed.
    monkeypatch.setattr(sys, "stdin", None if answer is None else io.StringIO(answer))
    assert main(command("clean", small_file)) == 1
    captured = capsys.readouterr()
    assert {Path(line.partition(": ")[0]) for line in captured.out.splitlines()} == leftovers
    assert "rigidity_index=50.0" in captured.out
    assert "remove 4 files? [y/N]" in captured.err
    assert captured.err.endswith("nothing removed\n")
    assert removed(folder, leftovers) == set()


def test_clean_leaves_the_results_of_the_study_and_what_is_being_written(
    folder: Path, half_done: list[Case], leftovers: set[Path], small_file: Path
) -> None:
    being_written = folder / f".x.nc{partial_ending(os.getpid())}"
    elsewhere = folder / ".x.nc.another_machine-1.part"
    for path in (being_written, elsewhere):
        path.touch()
    assert main(command("clean", small_file, "--yes")) == 0
    assert removed(folder, leftovers) == leftovers
    kept = {case_files.case_file(folder, case) for case in half_done[:2]}
    assert set(folder.iterdir()) == {*kept, being_written, elsewhere}
    assert main(command("clean", small_file)) == 0  # nothing to ask about


def test_clean_says_what_each_file_is(
    folder: Path, half_done: list[Case], small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    second = half_done[1]
    copy, older, stiff = (folder / name for name in ("copy.nc", "older.nc", "stiff.nc"))
    copy.write_bytes(case_files.case_file(folder, second).read_bytes())
    for path, changed in (
        (older, replace(second, scene_version=0)),
        (stiff, replace(second, parameters={**second.parameters, "rigidity_index": 50.0})),
    ):
        case_files.write_case(folder, changed, DONE, COMPLETED)
        case_files.case_file(folder, changed).rename(path)
    damaged = case_files.case_file(folder, second)
    damaged.write_bytes(b"noise")
    assert main(command("clean", small_file, "--yes")) == 0
    told = dict(line.split(": ", 1) for line in capsys.readouterr().out.splitlines())
    assert told.pop(str(damaged)).startswith("cannot be read: ")
    stranger = "no case of this study: cone_penetration version"
    version = second.scene_version
    of_second = "adhesion_factor=0.5, shaft_adhesion_factor=0.5"
    assert told == {
        str(copy): f"a copy of case {second.key}",
        str(older): f"{stranger} 0, completed: {of_second}",
        str(stiff): f"{stranger} {version}, completed: rigidity_index=50.0, {of_second}",
    }
