"""Files that are whole or not there, whoever writes them, on disks that are full or read-only."""

import csv
import os
import resource
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from harness.archive import atomic_files, case_files, study_files
from harness.archive.atomic_files import ArchiveError, abandoned, prepare, write_csv, write_whole
from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.run.collect_and_clean import collect_and_write
from harness.study.cases import Case
from harness.study.study import Study
from tests.conftest import LIMIT, finished
from tests.harness.conftest import keep, study_in, written

KILLED_AS_IT_WRITES = """
import os, sys
from pathlib import Path
from harness.archive.atomic_files import write_whole
os.fsync = lambda descriptor: os.kill(os.getpid(), 9)
write_whole(b"later", Path(sys.argv[1]))
"""


def test_a_process_killed_as_it_writes_leaves_the_earlier_file(
    tmp_path: Path,
) -> None:
    path = tmp_path / "picture.png"
    path.write_bytes(b"earlier")
    command = [sys.executable, "-c", KILLED_AS_IT_WRITES, str(path)]
    assert subprocess.run(command, check=False).returncode == -signal.SIGKILL
    assert path.read_bytes() == b"earlier"
    (half_written,) = abandoned(tmp_path)
    assert set(tmp_path.iterdir()) == {path, half_written}
    prepare(tmp_path)
    assert set(tmp_path.iterdir()) == {path}


def test_no_guessed_link_leads_a_file_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "results"
    folder.mkdir()
    outside.write_bytes(b"another's")
    names = iter(["first", "second", "first", "second"])
    monkeypatch.setattr("secrets.token_hex", lambda _: next(names))
    for name in ("first", "second"):
        (folder / f".{name}{atomic_files.partial_ending(os.getpid())}").symlink_to(outside)
    with pytest.raises(ArchiveError, match="cannot be written: File exists"):
        write_whole(b"result", folder / "result.nc")
    with pytest.raises(ArchiveError, match="cannot be written to: File exists"):
        prepare(folder)
    assert outside.read_bytes() == b"another's"
    assert len(list(folder.iterdir())) == 2  # nor is it removed


def test_half_written_files_have_random_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = list[str]()
    monkeypatch.setattr(os, "fsync", lambda _: seen.extend(it.name for it in tmp_path.iterdir()))
    write_whole(b"1", tmp_path / "1.nc")
    (tmp_path / "1.nc").unlink()
    write_whole(b"1", tmp_path / "1.nc")
    assert len(set(seen)) == 2
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "1.nc").stat().st_mode & 0o777 == 0o666 & ~umask


def test_no_cell_of_a_table_is_a_formula_of_a_spreadsheet(tmp_path: Path) -> None:
    numbers = ["-0.5", "+1.2%", "-1e-05", "-3", "1", ""]
    formulas = ["=1+1", "=cmd|'/c calc'!A0", "@SUM(A1)", "+1+1", "-2+3"]
    lines = ["a\n=1", "\r=1", "\t=1"]
    write_csv([numbers, formulas, lines], tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    escaped = ["a\\n=1", "\\r=1", "\\t=1"]
    assert rows == [numbers, [f"'{it}" for it in formulas], escaped]


def arguments(study: Study, out: Path) -> list[str]:
    return ["run", str(study.source), "--out", str(out), "--workers", "1"]


def harness(
    arguments: list[str], before: list[str] | None = None, file_size: int = 0
) -> tuple[int, list[str]]:
    """Run the command in a process of its own; its exit code and what it said.

    `before` is a command that runs it, `file_size` bounds every file that it writes [byte].
    """

    def bound() -> None:
        if file_size:
            resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))

    # -B: bytecode of the program would be cut as well, and stay so.
    command = [*(before or []), sys.executable, "-B", "-m", "harness", *arguments]
    result = finished(command, preexec_fn=bound)
    assert "Traceback" not in result.stderr
    return result.returncode, result.stderr.splitlines()


def completed(out: Path, study: Study) -> list[Case]:
    """Cases whose files are whole; there are no other files."""
    folder = case_files.case_folder(out, study)
    done = [case for case in study.cases if case_files.read_case(folder, case) is not None]
    assert {path.name for path in folder.iterdir()} == {f"{case.key}.nc" for case in done}
    return done


@pytest.mark.slow
@pytest.mark.usefixtures("in_this_process")
def test_on_a_full_disk_a_run_ends_and_loses_nothing(stub: Study, tmp_path: Path) -> None:
    folder, run = keep(stub, tmp_path), arguments(stub, tmp_path)
    case_files.discard(folder, stub.cases[1:])
    before, first = collect_and_write(stub, tmp_path), written(stub, tmp_path)
    (case,) = completed(tmp_path, stub)
    size = case_files.case_file(folder, case).stat().st_size

    code, told = harness(run, file_size=size // 2)
    assert code == 2
    assert told[-1].endswith(".nc: cannot be written: File too large")
    assert "3 cases: 2 missing, 1 completed; " in told[-2]
    assert completed(tmp_path, stub) == [case]
    assert study_files.read_study(tmp_path / "stub.nc").equals(before)

    told_of_none = f"harness: {tmp_path}: cannot be written to: File too large"
    assert harness(run, file_size=1) == (2, [told_of_none])
    assert main(run) == 0
    assert first.items() <= written(stub, tmp_path).items()
    assert len(completed(tmp_path, stub)) == 3


@pytest.mark.slow
def test_a_folder_that_is_read_only_is_one_line(stub: Study, tmp_path: Path) -> None:
    before: list[str] = []
    if os.geteuid() == 0:  # root may write everywhere, unless it gives that up
        setpriv = shutil.which("setpriv")
        if setpriv is None:
            pytest.skip("root cannot give up its rights here")
        before = [setpriv, "--bounding-set=-dac_override", "--inh-caps=-dac_override"]
    folder = keep(stub, tmp_path)
    case_files.discard(folder, stub.cases[1:])
    folder.chmod(0o555)
    code, told = harness(arguments(stub, tmp_path), before)
    folder.chmod(0o755)
    assert (code, told) == (2, [f"harness: {folder}: cannot be written to: Permission denied"])
    assert len(completed(tmp_path, stub)) == 1


@pytest.mark.slow
def test_two_runs_in_one_folder_do_not_harm_each_other(stub_offered: None, tmp_path: Path) -> None:
    text = f'title = "t"\nscene = "stub"\n[vary]\nnumber = {list(range(40))}\n'
    study, out = study_in(tmp_path, text, name="forty"), tmp_path / "out"
    command = [sys.executable, "-m", "harness", *arguments(study, out)]
    silent, pipe = subprocess.DEVNULL, subprocess.PIPE
    runs = [subprocess.Popen(command, stdout=silent, stderr=pipe, text=True) for _ in range(2)]
    try:
        told = [run.communicate(timeout=LIMIT)[1] for run in runs]
    finally:
        for run in runs:
            run.kill()
    assert [run.returncode for run in runs] == [0, 0], told
    assert len(completed(out, study)) == 40
    assert set(study_files.read_study(out / "forty.nc").status.values.flat) == {COMPLETED}
    assert not list(out.rglob(".*"))
