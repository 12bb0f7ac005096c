from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import xarray as xr

from harness import archive, case_files
from harness.cases import COMPLETED, cases_of
from harness.cli import main
from harness.definition import study_names
from harness.study import load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import scene_names
from mpm_warp.scenes.cone_penetration import ConePenetration

GOOD = 'title = "t"\nscene = "cone_penetration"\n'
ALLOWED = {name: it.allowed for name, it in parameters_of(ConePenetration).items()}
SCENE_ONLY = 'scene = "cone_penetration"\n'

MANY = list(range(1001, 2001))

# What is wrong: the definition, and what the message must contain.
MALFORMED: dict[str, tuple[str | bytes, str]] = {
    "misspelt parameter": (
        GOOD + "[fixed]\nadhesion_factr = 1",
        "[fixed] adhesion_factr = 1: unknown parameter 'adhesion_factr'; did you mean 'adhesion_",
    ),
    "above the range": (GOOD + "[fixed]\nadhesion_factor = 1.5", "adhesion_factor = 1.5 is not"),
    "at an open bound": (
        GOOD + "[fixed]\npoissons_ratio = 0.5",
        f"must be {ALLOWED['poissons_ratio']}",
    ),
    "one of a list": (GOOD + "[vary]\nadhesion_factor = [0, 2]", "[vary] adhesion_factor = 2"),
    "not finite": (GOOD + "[fixed]\ndensity = inf", "density = inf is not allowed"),
    "not a number": (GOOD + "[fixed]\ndensity = nan", "density = nan is not allowed"),
    "text for a number": (GOOD + '[fixed]\ndensity = "1"', "density = '1' is not allowed"),
    "truth for a number": (GOOD + "[fixed]\ndensity = true", "density = True is not allowed"),
    "date for a number": (GOOD + "[fixed]\ndensity = 2026-01-01", f"must be {ALLOWED['density']}"),
    "table for a number": (GOOD + "[fixed.density]\na = 1", f"must be {ALLOWED['density']}"),
    "fraction for an integer": (
        GOOD + "[fixed]\nparticles_per_cell = 4.5",
        f"must be {ALLOWED['particles_per_cell']}",
    ),
    "choice misspelt": (GOOD + '[fixed]\nmaterial = "treska"', "did you mean 'tresca'?"),
    "integer of 80 bits": (GOOD + f"[fixed]\ndensity = {2**80}", f"must be {ALLOWED['density']}"),
    "integer of 20000 digits": (GOOD + "[fixed]\ndensity = 0x" + "f" * 20000, "too long to show"),
    "decimal of 5000 digits": (GOOD + "[fixed]\ndensity = " + "1" * 5000, "not valid TOML"),
    "list among the fixed": (GOOD + "[fixed]\ndensity = [1, 2]", "belongs under [vary]"),
    "scalar among the varied": (GOOD + "[vary]\ndensity = 1", "must be a list"),
    "empty list": (GOOD + "[vary]\ndensity = []", "must be a list of one value or more"),
    "a value twice": (GOOD + "[vary]\ndensity = [1, 2, 1.0]", "1.0 is there twice"),
    "nested list": (GOOD + "[vary]\ndensity = [[1]]", "density = [1]"),
    "fixed and varied": (GOOD + "[fixed]\ndensity = 1\n[vary]\ndensity = [1]", "as well"),
    "unknown table": (GOOD + "[varry]\ndensity = [1]", "unknown key; did you mean 'vary'?"),
    "unknown key": (GOOD + "scenne = 1", "unknown key; did you mean 'scene'?"),
    "unknown key to compare": (GOOD + "[compare]\nreference = []", "did you mean 'references'?"),
    "unknown reference": (GOOD + '[compare]\nreferences = ["lu_2005"]', "did you mean 'lu_2004'?"),
    "reference of wrong type": (GOOD + "[compare]\nreferences = [{}]", "unknown reference {}"),
    "references not a list": (GOOD + '[compare]\nreferences = "lu_2004"', "must be a list"),
    "reference twice": (
        GOOD + '[compare]\nreferences = ["lu_2004", "lu_2004"]',
        "names a reference twice",
    ),
    "table that is none": ("fixed = 1\n" + GOOD, "must be a table [fixed]"),
    "unknown scene": ('title = "t"\nscene = "cone_penetratoin"', "did you mean 'cone_penetration'"),
    "scene of wrong type": ('title = "t"\nscene = 1', "scene = 1: must be a text"),
    "no scene": ('title = "t"', "scene: is missing; known: "),
    "no title": (SCENE_ONLY, "title: is missing"),
    "title of two lines": (SCENE_ONLY + 'title = "a\\nb"', "must be a text of one line"),
    "timing of wrong type": (GOOD + "[timing]\nrepeats = 2.0", "repeats = 2.0: must be an integer"),
    "truth for repeats": (GOOD + "[timing]\nrepeats = true", "must be an integer, 1 to 1000"),
    "no repeats": (GOOD + "[timing]\nrepeats = 0", "must be an integer, 1 to 1000"),
    "unknown key to timing": (GOOD + "[timing]\nrepeat = 2", "did you mean 'repeats'?"),
    "empty": ("", "is missing"),
    "syntax error": (GOOD + "[fixed\n", "not valid TOML: Expected"),
    "key twice": (GOOD + 'title = "again"', "not valid TOML: Cannot overwrite"),
    "line break in a key": (GOOD + '[fixed]\n"a\\nb" = 1', r"a\nb"),
    "not UTF-8": (b'title = "\xff"', "not UTF-8 at byte 9"),
    "nested deeply": ("a = " + "[" * 20000, "nested too deeply"),
    "dotted deeply": (GOOD + "fixed.density" + ".a" * 3000 + " = 1", "too long to show"),
    "too large": (GOOD + "#" * 2_000_000, "a study has at most"),
    "too many cases": (
        GOOD + f"[vary]\ndensity = {MANY}\nundrained_shear_strength = {MANY}",
        "gives 1000000 cases",
    ),
}
BAD_SETTINGS = {
    "misspelt": ("adhesion_factr=1", "did you mean 'adhesion_factor'?"),
    "out of range": ("adhesion_factor=1.5", "--set adhesion_factor = 1.5 is not allowed"),
    "no value": ("adhesion_factor=", "must be key=value"),
    "no key": ("=1", "must be key=value"),
    "no equals sign": ("adhesion_factor", "must be key=value"),
    "not TOML": ("adhesion_factor=[0", "not a TOML value"),
    "two values": ("adhesion_factor=1\ndensity=2", "not a TOML value"),
    "word for a number": ("adhesion_factor=high", "adhesion_factor = 'high' is not allowed"),
    "empty list": ("adhesion_factor=[]", "must be a list of one value or more"),
}


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The one line with which a command is refused."""
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    return line


@pytest.mark.parametrize("mistake", MALFORMED)
def test_a_malformed_study_is_one_line_and_nothing_written(
    mistake: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content, expected = MALFORMED[mistake]
    path = tmp_path / "study.toml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = refusal(["run", str(path), "--out", str(tmp_path / "out")], capsys)
    assert line.startswith(f"harness: {path}: ")
    assert expected in line
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mistake", BAD_SETTINGS)
def test_a_malformed_setting_is_one_line_and_nothing_written(
    mistake: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    setting, expected = BAD_SETTINGS[mistake]
    out = tmp_path / "out"
    line = refusal(["run", "mesh_size", "--set", setting, "--out", str(out)], capsys)
    assert expected in line
    assert not out.exists()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mesh_sizes", "no such study; did you mean 'mesh_size'?"),
        ("there/mesh_sizes.toml", "no such file; did you mean 'mesh_size'?"),
        ("folder.toml", "not a file"),
        ("x" * 5000, "name too long"),
        ("file.txt", "no such study"),
        ("./file.txt", "is called NAME.toml"),
        ("../x/./.toml", "no such file"),
        ("..toml", "is called NAME.toml"),
    ],
)
def test_a_study_that_cannot_be_found_is_one_line(
    name: str,
    expected: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.toml").mkdir()
    for file in ("file.txt", "..toml"):
        (tmp_path / file).write_text(GOOD)
    assert expected in refusal(["run", name], capsys)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("--threads=3", "choose from 1, 2, 4"),
        ("--device=cuda:7", "--device cuda:7: there is none here; known: cpu"),
        ("--device=gpu", "--device gpu: there is none here; known: cpu"),
    ],
)
def test_threads_and_devices_that_are_not_to_be_had_are_one_line(
    option: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code: str | int | None = main(["run", "mesh_size", option, f"--out={tmp_path}"])
    except SystemExit as end:
        code = end.code
    captured = capsys.readouterr()
    assert code == 2
    assert message in captured.err
    assert captured.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["workers", "batch"])
@pytest.mark.parametrize("count", ["0", "-1", "two", "1.5", "9" * 5000])
def test_a_wrong_number_of_workers_or_cases_is_one_line(
    option: str, count: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["run", "mesh_size", f"--{option}={count}"])
    assert len(capsys.readouterr().err.splitlines()) == 1


@pytest.mark.parametrize(
    ("more", "option", "message"),
    [
        ("", "--dask=tcp://127.0.0.1:1", "leave them out with --dask"),
        ("[timing]\nrepeats = 3\n", "--workers=1", "timed one at a time, without --batch"),
    ],
)
def test_a_batch_where_there_can_be_none_is_refused(
    more: str,
    option: str,
    message: str,
    small_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    small_file.write_text(small_file.read_text() + more)
    out = tmp_path / "out"
    assert message in refusal(["run", str(small_file), "--batch=2", f"--out={out}", option], capsys)
    assert not out.exists()


@pytest.mark.parametrize("limit", ["0", "-1", "soon", "nan", "inf"])
def test_a_wrong_time_limit_is_one_line(limit: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["run", "mesh_size", f"--case-timeout={limit}"])
    (line,) = capsys.readouterr().err.splitlines()
    assert f"'{limit}' is not allowed: must be a number > 0" in line


def test_a_case_that_timed_out_is_listed_and_tried_again(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    long = ["--set", "adhesion_factor=0", "--set", "penetration=200", "--set", "speed_ratio=0.0001"]
    run = ["run", str(small_file), "--out", str(tmp_path / "out"), *long, "--case-timeout=0.5"]
    for _ in range(2):
        assert main(run) == 1
        told = capsys.readouterr().err
        assert "1 cases, 0 done already" in told
        assert "harness: cone_penetration: timed_out: ended after 0.5 s, at 0% of the case" in told


def test_a_folder_that_cannot_be_made_is_one_line(
    small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = refusal(["run", str(small_file), "--out", str(small_file)], capsys)
    assert f"{small_file}/small/cases: cannot be made: Not a directory" in line


@pytest.mark.parametrize("command", ["compare", "plot"])
def test_a_result_that_is_none_is_one_line(
    command: str, small_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "cannot be read" in refusal([command, str(small_file)], capsys)
    assert "no such file" in refusal([command, str(small_file.with_suffix(".nc"))], capsys)


def test_describe_of_an_unknown_scene_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal(["describe", "cone_penetratoin"], capsys)
    assert line.endswith("unknown scene 'cone_penetratoin'; did you mean 'cone_penetration'?")


def test_list_names_studies_and_scenes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    listed = capsys.readouterr().out
    for name in study_names():
        assert f"{name:24} {load_study(name).title}" in listed
    for name in scene_names():
        assert f"  {name} " in listed


def test_describe_gives_unit_default_range_and_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["describe", "cone_penetration"]) == 0
    described = capsys.readouterr().out
    assert ConePenetration.summary in described
    (line,) = (line for line in described.splitlines() if line.startswith("cone_radius "))
    assert line.split(maxsplit=3) == [
        "cone_radius",
        "0.01785",
        "m",
        f"radius of the cone's base; {ALLOWED['cone_radius']}",
    ]


def test_help_loads_nothing_that_computes() -> None:
    script = (
        "import sys, harness.cli as cli; cli.make_parser().format_help(); cli.main(['list'])\n"
        "sys.exit(str({'numpy', 'xarray', 'warp', 'matplotlib'} & sys.modules.keys()))"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert result.stderr.strip() == "set()"


def test_run_gives_a_dataset_a_table_and_pictures(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small_file.write_text(small_file.read_text() + '[compare]\nreferences = ["lu_2004"]\n')
    out = tmp_path / "out"
    assert main(["run", str(small_file), "--out", str(out)]) == 0
    captured = capsys.readouterr()
    assert captured.out.endswith(f"{out}/small.nc\n")
    assert "harness: small: 3 cases, 0 done already" in captured.err
    assert "[3/3] adhesion_factor=" in captured.err
    with xr.open_dataset(out / "small.nc") as dataset:
        assert dataset.cone_factor.dims == ("adhesion_factor",)
        assert "deviation_lu_2004" in dataset
        assert dataset.attrs["command_line"]
    pictures = sorted(out.glob("*.png"))
    assert pictures

    assert main(["compare", str(out / "small.nc")]) == 0
    assert "lu_2004" in capsys.readouterr().out
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

    def inodes() -> list[int]:
        return [case_files.case_file(folder, case).stat().st_ino for case in cases_of(study)]

    assert main([*command, "--set", "adhesion_factor=[0.5]"]) == 0
    assert main(command) == 0
    assert "small: 3 cases, 1 done already" in capsys.readouterr().err
    first = inodes()

    assert main(command) == 0
    assert inodes() == first

    damaged, failed, kept = cases_of(study)
    case_files.case_file(folder, damaged).write_bytes(b"noise")
    case_files.write_case(folder, failed, xr.Dataset(), "failed", "for the test")
    before = inodes()
    capsys.readouterr()
    assert main(command) == 0
    told = capsys.readouterr().err
    assert f"{damaged.key}.nc: cannot be read: " in told
    assert "1 done already" in told
    assert [old == new for old, new in zip(before, inodes(), strict=True)] == [False, False, True]
    assert archive.read_study(out / "small.nc").status.values.tolist() == [COMPLETED] * 3

    assert main([*command, "--fresh"]) == 0
    assert "0 done already" in capsys.readouterr().err
    assert case_files.read_case(folder, kept) is not None


def test_a_study_may_ask_for_timed_runs(
    small_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    untimed = small_file.read_text()
    run = ["run", str(small_file), "--out", str(out)]
    status = ["status", *run[1:]]

    def told_after(definition: str) -> str:
        small_file.write_text(definition)
        capsys.readouterr()
        assert main(run) == 0
        return capsys.readouterr().err

    assert "0 done already" in told_after(untimed)
    keys = [case.key for case in cases_of(load_study(str(small_file)))]
    small_file.write_text(untimed + "[timing]\nrepeats = 3\n")
    assert [case.key for case in cases_of(load_study(str(small_file)))] == keys
    assert main(status) == 1
    assert "3 cases: 3 untimed" in capsys.readouterr().out

    told = told_after(untimed + "[timing]\nrepeats = 3\n")
    assert "0 done already" in told
    assert "timed alone, 3 warm runs a case; load now " in told
    assert main(status) == 0
    dataset = archive.read_study(out / "small.nc")
    assert dataset.run_time_sample.dims == ("adhesion_factor", "repeat")
    assert dataset.run_time_sample.notnull().all()
    assert (dataset.run_time == dataset.run_time_sample.median("repeat")).all()
    assert (dataset.run_time_minimum == dataset.run_time_sample.min("repeat")).all()

    assert "3 done already" in told_after(untimed + "[timing]\nrepeats = 2\n")
    assert "3 done already" in told_after(untimed)
    assert "0 done already" in told_after(untimed + "[timing]\nrepeats = 4\n")


INTERRUPTED = re.compile(r"harness: interrupted; (.*); the same command goes on with the rest\n$")


@contextmanager
def running(small_file: Path, out: Path, until: str) -> Iterator[subprocess.Popen[str]]:
    """A command in a group of its own, that has said `until`; its second case is long."""
    settings = ["--set", "adhesion_factor=0", "--set", "penetration=[1, 200]"]
    command = [sys.executable, "-m", "harness", "run", str(small_file), "--out", str(out)]
    # A process in the background of a shell ignores SIGINT, and so would whatever it starts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(
        [*command, *settings, "--workers", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        signal.signal(signal.SIGINT, before)
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith(until):
                break
        yield process


def statuses_left(out: Path) -> list[str]:
    """Statuses of the case files that there are."""
    files = [path for path in out.rglob("*") if path.is_file() and path != out / "small.nc"]
    return [xr.load_dataset(path).attrs["status"] for path in files]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_run_keeps_what_is_finished_and_nothing_else(
    small_file: Path,
    tmp_path: Path,
    number: signal.Signals,
    code: int,
    wait_for_end: Callable[[int], None],
) -> None:
    out = tmp_path / "out"
    with running(small_file, out, until="[1/2]") as process:
        # A terminal sends Ctrl-C to the whole group, workers included.
        send = os.killpg if number is signal.SIGINT else os.kill
        send(process.pid, number)
        told = process.communicate()[1]
    assert process.returncode == code
    interrupted = INTERRUPTED.search(told)
    assert interrupted is not None
    assert interrupted[1].startswith("2 cases: 1 completed, 1 missing; ")
    assert "Traceback" not in told
    wait_for_end(process.pid)
    assert statuses_left(out) == [COMPLETED]
    dataset = archive.read_study(out / "small.nc")
    assert dataset.status.values.tolist() == [COMPLETED, "missing"]
    assert dataset.cone_factor.notnull().values.tolist() == [True, False]


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.1])
def test_an_interrupt_while_workers_start_is_as_quiet(
    small_file: Path, tmp_path: Path, delay: float, wait_for_end: Callable[[int], None]
) -> None:
    out = tmp_path / "out"
    with running(small_file, out, until="harness: small: ") as process:
        time.sleep(delay)
        os.killpg(process.pid, signal.SIGINT)
        told = process.communicate()[1]
    assert process.returncode == 130
    assert INTERRUPTED.search(told)
    assert "Traceback" not in told
    wait_for_end(process.pid)
    assert statuses_left(out) == []


def test_a_run_whose_reader_has_gone_ends_quietly(
    small_file: Path, tmp_path: Path, wait_for_end: Callable[[int], None]
) -> None:
    out = tmp_path / "out"
    with running(small_file, out, until="harness: small: ") as process:
        assert process.stderr is not None
        process.stderr.close()
    assert process.returncode == 141
    wait_for_end(process.pid)
    assert statuses_left(out) == [COMPLETED]


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="reads Linux's /proc")
def test_a_worker_is_born_deaf_to_ctrl_c(small_file: Path, tmp_path: Path) -> None:
    """Held signals are inherited: at no instant of its start would a worker be interrupted."""
    with running(small_file, tmp_path / "out", until="[1/2]") as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        folders = [Path("/proc", child) for child in children]
        (worker,) = (it for it in folders if "spawn_main" in (it / "cmdline").read_text())
        status = (worker / "status").read_text()
        process.terminate()
    (held,) = (line.split()[1] for line in status.splitlines() if line.startswith("SigBlk:"))
    assert int(held, 16) & 1 << (signal.SIGINT - 1)


def test_workers_end_with_a_parent_that_was_killed(
    small_file: Path, tmp_path: Path, wait_for_end: Callable[[int], None]
) -> None:
    out = tmp_path / "out"
    with running(small_file, out, until="[1/2]") as process:
        process.kill()
    wait_for_end(process.pid)
    assert statuses_left(out) == [COMPLETED]
