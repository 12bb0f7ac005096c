"""Files that are whole under their name or not there, whoever writes them."""

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from harness.archive import atomic_files
from harness.archive.atomic_files import ArchiveError, abandoned, prepare, write_csv, write_whole

KILLED_AS_IT_WRITES = """
import os, sys
from pathlib import Path
from harness.archive.atomic_files import write_whole
os.fsync = lambda descriptor: os.kill(os.getpid(), 9)
write_whole(b"later", Path(sys.argv[1]))
"""


def test_a_process_killed_as_it_writes_leaves_the_earlier_file_and_one_to_be_removed(
    tmp_path: Path,
) -> None:
    path = tmp_path / "picture.png"
    path.write_bytes(b"earlier")
    command = [sys.executable, "-c", KILLED_AS_IT_WRITES, str(path)]
    assert subprocess.run(command, check=False).returncode == -signal.SIGKILL
    assert path.read_bytes() == b"earlier"
    (half_written,) = abandoned(tmp_path)
    assert set(tmp_path.iterdir()) == {path, half_written}


def test_no_name_that_is_guessed_leads_a_file_elsewhere(
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


def test_names_of_half_written_files_are_not_to_be_guessed(
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
