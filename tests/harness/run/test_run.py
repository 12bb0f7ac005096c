"""`harness run`: what it refuses, what it leaves behind, and what it does when run again."""

import inspect
import os
from pathlib import Path

import pytest
import xarray as xr

from harness.archive import case_files, study_files
from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.run import run_study
from harness.run.pool import run_cases
from harness.study.study import load_study
from tests.harness.conftest import Refusal, written

pytestmark = pytest.mark.slow

TIMED = "[timing]\nrepeats = 3\n"


@pytest.mark.parametrize(
    ("more", "options", "expected"),
    [
        ("", "", {"worker_count": 8, "threads": None, "batch": 1, "repeats": 0}),
        ("", "--threads=2", {"worker_count": 4, "threads": 2}),
        ("", "--workers=3 --threads=2", {"worker_count": 3, "threads": 2}),
        ("", "--batch=5", {"worker_count": 8, "threads": None, "batch": 5}),
        ("", "--case-timeout=7 --device=cuda:1", {"time_limit": 7, "device": "cuda:1"}),
        (TIMED, "", {"worker_count": 1, "threads": 1, "batch": 1, "repeats": 3}),
        (TIMED, "--workers=1 --threads=2", {"worker_count": 1, "threads": 2}),
    ],
)
def test_cases_are_run_as_the_options_and_the_study_ask_for(
    more: str,
    options: str,
    expected: dict[str, object],
    small_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, object] = {}

    def note(*arguments: object, **named: object) -> None:
        bound = inspect.signature(run_cases).bind(*arguments, **named)
        bound.apply_defaults()
        asked.update(bound.arguments | vars(bound.arguments["options"]))

    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    monkeypatch.setattr(run_study, "check_device", lambda device: None)
    monkeypatch.setattr(run_study, "run_cases", note)
    small_file.write_text(small_file.read_text() + more)
    command = ["run", str(small_file), f"--out={tmp_path / 'out'}", *options.split()]
    assert main(command) == 1  # nothing was computed
    assert {name: asked[name] for name in expected} == expected


def test_a_case_that_timed_out_is_listed_and_tried_again(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    long = ["--set", "adhesion_factor=0", "--set", "penetration=200", "--set", "speed_ratio=0.0001"]
    run = ["run", str(small_file), "--out", str(tmp_path / "out"), *long, "--case-timeout=0.5"]
    for _ in range(2):
        assert main(run) == 1
        told = capsys.readouterr().err
        assert "1 case, 0 done already" in told
        assert "harness: cone_penetration: timed_out: ended after 0.5 s, at " in told


def test_a_folder_that_cannot_be_made_is_one_line(small_file: Path, refusal: Refusal) -> None:
    line = refusal(["run", str(small_file), "--out", str(small_file)])
    assert f"{small_file}/small/cases: cannot be made: Not a directory" in line


def test_run_gives_a_dataset_a_table_and_pictures(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    compared = '[compare]\nreferences = ["lu_2004"]\nexperience = ["karlsrud_2005"]\n'
    small_file.write_text(small_file.read_text() + compared)
    out = tmp_path / "out"
    assert main(["run", str(small_file), "--out", str(out)]) == 0
    captured = capsys.readouterr()
    assert captured.out.endswith(f"{out}/small.nc\n")
    assert "harness: small: 3 cases, 0 done already" in captured.err
    assert "24 hours" not in captured.err
    assert "[3/3] adhesion_factor=" in captured.err
    with xr.open_dataset(out / "small.nc") as dataset:
        assert dataset.cone_factor.dims == ("adhesion_factor",)
        assert "deviation_lu_2004" in dataset
        assert dataset.experience_karlsrud_2005.dims == ("bound",)
        assert dataset.attrs["command_line"]
    pictures = sorted(out.glob("*.png"))
    assert pictures

    assert main(["compare", str(out / "small.nc")]) == 0
    table = capsys.readouterr().out
    assert "lu_2004" in table
    assert "karlsrud_2005 Nkt" in table
    assert main(["plot", str(out / "small.nc"), "--out", str(out / "again")]) == 0
    again = capsys.readouterr().out.splitlines()
    assert [Path(line).name for line in again] == [path.name for path in pictures]


def test_running_again_goes_on_where_it_stopped(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    study = load_study(str(small_file))
    folder = case_files.case_folder(out, study)
    command = ["run", str(small_file), "--out", str(out)]

    assert main([*command, "--set", "adhesion_factor=[0.5]"]) == 0
    assert main(command) == 0
    assert "small: 3 cases, 1 done already" in capsys.readouterr().err
    first = written(study, out)
    assert len(first) == 3

    assert main(command) == 0
    assert written(study, out) == first

    damaged, failed, kept = study.cases
    case_files.case_file(folder, damaged).write_bytes(b"noise")
    case_files.write_case(folder, failed, xr.Dataset(), "failed", "for the test")
    assert written(study, out) == {kept.key: first[kept.key]}
    capsys.readouterr()
    assert main(command) == 0
    told = capsys.readouterr().err
    assert f"{damaged.key}.nc: cannot be read: " in told
    assert "1 done already" in told
    again = written(study, out)
    assert [again[case.key] == first[case.key] for case in study.cases] == [False, False, True]
    assert study_files.read_study(out / "small.nc").status.values.tolist() == [COMPLETED] * 3

    assert main([*command, "--fresh"]) == 0
    assert "0 done already" in capsys.readouterr().err
    assert case_files.read_case(folder, kept) is not None


def test_a_study_may_ask_for_timed_runs(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    untimed = small_file.read_text().replace("[0, 0.5, 1]", "[0, 1]")
    run = ["run", str(small_file), "--out", str(out)]
    status = ["status", *run[1:]]

    def told_after(definition: str) -> str:
        small_file.write_text(definition)
        capsys.readouterr()
        assert main(run) == 0
        return capsys.readouterr().err

    assert "0 done already" in told_after(untimed)
    keys = [case.key for case in load_study(str(small_file)).cases]
    small_file.write_text(untimed + TIMED)
    assert [case.key for case in load_study(str(small_file)).cases] == keys
    assert main(status) == 1
    assert "2 cases: 2 untimed" in capsys.readouterr().out

    told = told_after(untimed + TIMED)
    assert "0 done already" in told
    assert "timed alone, 3 warm runs a case; load now " in told
    assert main(status) == 0
    dataset = study_files.read_study(out / "small.nc")
    assert dataset.run_time_sample.dims == ("adhesion_factor", "repeat")
    assert dataset.run_time_sample.notnull().all()
    assert (dataset.run_time == dataset.run_time_sample.median("repeat")).all()
    assert (dataset.run_time_minimum == dataset.run_time_sample.min("repeat")).all()

    assert "2 done already" in told_after(untimed + "[timing]\nrepeats = 2\n")
    assert "2 done already" in told_after(untimed)
    assert "0 done already" in told_after(untimed + "[timing]\nrepeats = 4\n")
