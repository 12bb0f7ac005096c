"""`harness run`: what it refuses, shows and leaves behind, and what it does when run again."""

import inspect
import io
import re
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from harness.archive import case_files, study_files
from harness.archive.case_files import Outcome
from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.run import run_study
from harness.run.pool import run_cases
from harness.run.run_study import Display
from harness.study.study import Study, load_study
from tests.harness.conftest import HEAD, Command, Refusal, written

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("in_this_process")]

TIMED = "[timing]\nrepeats = 3\n"


@pytest.mark.parametrize(
    ("more", "options", "expected"),
    [
        ("", "", {"worker_count": 8, "threads": None, "repeats": 0}),
        ("", "--threads=2", {"worker_count": 4, "threads": 2}),
        ("", "--workers=3 --threads=2", {"worker_count": 3, "threads": 2}),
        ("", "--case-timeout=7 --device=cuda:1", {"time_limit": 7, "device": "cuda:1"}),
        ("", "--uncertainty --set=cells_per_radius=2.31", {"uncertainty": "measured"}),
        (TIMED, "", {"worker_count": 1, "threads": 1, "repeats": 3}),
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
        asked.update(bound.arguments["cases"][0].parameters)

    monkeypatch.setattr("harness.run.pool.usable_cores", lambda: 8)
    monkeypatch.setattr(run_study, "check_device", lambda device: None)
    monkeypatch.setattr(run_study, "run_cases", note)
    small_file.write_text(small_file.read_text(encoding="utf-8") + more, encoding="utf-8")
    command = ["run", str(small_file), f"--out={tmp_path / 'out'}", *options.split()]
    assert main(command) == 1  # nothing was computed
    assert {name: asked[name] for name in expected} == expected


def test_a_run_gives_dataset_and_pictures(
    small_file: Path, tmp_path: Path, command: Command
) -> None:
    compared = '[compare]\nreferences = ["lu_2004"]\nexperience = ["karlsrud_2005"]\n'
    small_file.write_text(small_file.read_text(encoding="utf-8") + compared, encoding="utf-8")
    out = tmp_path / "out"
    told = command("run", small_file, "--out", out)
    assert told.out.endswith(f"{out}/small.nc\n")
    assert "harness: small: 3 cases, 0 done already" in told.err
    assert "24 hours" not in told.err
    assert "[3/3] adhesion_factor=" in told.err
    with xr.open_dataset(out / "small.nc") as dataset:
        assert dataset.cone_factor.dims == ("adhesion_factor",)
        assert "deviation_lu_2004" in dataset
        assert dataset.experience_karlsrud_2005.dims == ("bound",)
        assert dataset.attrs["command_line"]
    pictures = sorted(out.glob("*.png"))
    assert pictures

    table = command("compare", out / "small.nc").out
    assert "lu_2004" in table
    assert "karlsrud_2005 Nkt" in table
    again = command("plot", out / "small.nc", "--out", out / "again").out.splitlines()
    assert [Path(line).name for line in again] == [path.name for path in pictures]


def test_a_run_goes_on_where_it_stopped(stub: Study, tmp_path: Path, command: Command) -> None:
    out, study = tmp_path / "out", stub
    folder = case_files.case_folder(out, study)
    run = ["run", stub.source, "--out", out]

    command(*run, "--set", "number=[0.5]")
    assert "stub: 3 cases, 1 done already" in command(*run).err
    first = written(study, out)
    assert len(first) == 3

    command(*run)
    assert written(study, out) == first

    damaged, failed, kept = study.cases
    file = case_files.case_file(folder, damaged)
    file.write_bytes(b"noise" + file.read_bytes()[5:])
    case_files.write_case(folder, failed, xr.Dataset(), "failed", "for the test")
    assert written(study, out) == {kept.key: first[kept.key]}
    told = command(*run).err
    assert f"{damaged.key}.nc: cannot be read: " in told
    assert "1 done already" in told
    again = written(study, out)
    assert [again[case.key] == first[case.key] for case in study.cases] == [False, False, True]
    assert study_files.read_study(out / "stub.nc").status.values.tolist() == [COMPLETED] * 3

    assert "0 done already" in command(*run, "--fresh").err
    assert case_files.read_case(folder, kept) is not None


def test_a_damaged_result_of_the_reference_study_is_told_before_a_case_is_run(
    small_file: Path, tmp_path: Path, refusal: Refusal
) -> None:
    small_file.write_text(
        f'{small_file.read_text(encoding="utf-8")}[compare]\nreference_study = "finest.toml"\n',
        encoding="utf-8",
    )
    (tmp_path / "finest.toml").write_text(HEAD)
    (tmp_path / "finest.nc").write_bytes(b"noise")
    line = refusal(["run", str(small_file), "--out", str(tmp_path / "out")])
    assert line.startswith(f"harness: {tmp_path / 'finest.nc'}: cannot be read: ")
    assert not (tmp_path / "out").exists()


def test_a_study_may_ask_for_timed_runs(stub: Study, tmp_path: Path, command: Command) -> None:
    out, source = tmp_path / "out", Path(stub.source)
    untimed = source.read_text(encoding="utf-8").replace("[0, 0.5, 1]", "[0, 1]")
    where = [source, "--out", out]

    def told_after(definition: str) -> Any:
        source.write_text(definition, encoding="utf-8")
        return command("run", *where).err

    assert "0 done already" in told_after(untimed)
    keys = [case.key for case in load_study(str(source)).cases]
    source.write_text(untimed + TIMED, encoding="utf-8")
    assert [case.key for case in load_study(str(source)).cases] == keys
    assert "2 cases: 2 untimed" in command("status", *where, code=1).out

    told = told_after(untimed + TIMED)
    assert "0 done already" in told
    assert "timed alone, 3 warm runs a case; load now " in told
    command("status", *where)
    dataset = study_files.read_study(out / "stub.nc")
    assert dataset.run_time_sample.dims == ("number", "repeat")
    assert dataset.run_time_sample.notnull().all()
    assert (dataset.run_time == dataset.run_time_sample.median("repeat")).all()
    assert (dataset.run_time_minimum == dataset.run_time_sample.min("repeat")).all()

    assert "2 done already" in told_after(untimed + "[timing]\nrepeats = 2\n")
    assert "2 done already" in told_after(untimed)
    assert "0 done already" in told_after(untimed + "[timing]\nrepeats = 4\n")


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("outcome", "told"),
    [
        (Outcome("failed", "why", seconds=1.25), "failed, why, 1.2 s"),
        (
            Outcome("completed", seconds=9.0, start_seconds=2.0, compile_seconds=4.5),
            "completed, 2.5 s (2.0 s to start, 4.5 s to compile)",
        ),
    ],
)
def test_elsewhere_than_on_a_terminal_there_is_a_line_a_case_with_its_times(
    outcome: Outcome, told: str, small: Study
) -> None:
    stream = io.StringIO()
    with Display(3, stream) as display:
        display.advanced(small.cases[1], 0.5)
        display.finished(small.cases[1], outcome)
    assert stream.getvalue() == f"[1/3] adhesion_factor=0.5: {told}\n"


def test_the_bar_shows_what_is_set_up_runs_and_is_done_and_the_time_left_and_is_removed(
    small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock of its own: that of the machine may be set back."""
    clock, stream = [100.0], Terminal()
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    monkeypatch.setattr("tqdm.std.time", lambda: -clock[0])
    first, second, third = small.cases
    with Display(4, stream) as display:
        display.advanced(first, 0.0)
        display.bar.refresh()
        assert "0/4 cases, 1 setting up, after" in stream.getvalue()
        display.finished(first, Outcome("completed", seconds=2.0))
        display.advanced(second, 0.75)
        clock[0] += 60  # half of four cases are done after a minute
        display.advanced(third, 0.25)
    shown = stream.getvalue()
    assert "\r[1/4] adhesion_factor=0.0: completed, 2.0 s\n" in shown
    bar, line = "█" * 12 + " " * 12, "1/4 cases, 2 running, at 50%, after 01:00, 01:00 left"
    assert f"\r{bar} {line}" in shown
    assert re.search(r"\r +\r$", shown)
