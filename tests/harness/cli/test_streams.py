"""Standard streams: what a file holds is safe to print; a stream that is full is no traceback."""

import errno
import io
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

import pytest

from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.errors import LONGEST_LINE, say
from harness.study.study import Study
from tests.conftest import finished
from tests.harness.conftest import Refusal

pytestmark = pytest.mark.slow

FULL = Path("/dev/full")


@pytest.fixture
def full() -> Iterator[TextIO]:
    """A stream that takes nothing, as on a full disk."""
    if not FULL.exists():
        pytest.skip("there is no device here that is always full")
    with FULL.open("w", encoding="utf-8", buffering=1) as stream:
        yield stream


def test_output_cannot_control_a_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    say("a\x1b[2Jb\u202e\tc", "ä 中 \x1b[31m")
    assert capsys.readouterr().out == "a\\x1b[2Jb\\u202e\tc\nä 中 \\x1b[31m\n"


def test_a_closed_pipe_of_windows_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    class Closed(io.StringIO):
        def flush(self) -> None:
            raise OSError(errno.EINVAL, "Invalid argument")

    monkeypatch.setattr(sys, "stdout", Closed())
    with pytest.raises(BrokenPipeError):
        say("a line")


@pytest.mark.parametrize("words", ["schema", "--help"])
def test_output_to_a_full_disk_is_one_line_and_code_2(words: str) -> None:
    end = finished(["sh", "-c", f"'{sys.executable}' -m harness {words} >/dev/full"])
    told = "harness: standard output: cannot be written: No space left on device\n"
    assert (end.returncode, end.stderr) == (2, told)


def test_remarks_that_cannot_be_written_change_nothing(
    small: Study, full: TextIO, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stderr", full)
    assert main(["status", "no_such_study"]) == 2
    assert main(["clean", str(small.source), "--out", str(folder.parents[1])]) == 0


@pytest.mark.parametrize(
    "arguments", ["describe ", "plan ", "status ", "compare ", "list --"], ids=str.strip
)
def test_a_word_of_100_kilobytes_is_a_short_line(arguments: str, refusal: Refusal) -> None:
    command, before = arguments.split(" ")
    line = refusal([command, before + 50_000 * "x\x1b"])
    assert len(line) < LONGEST_LINE + 100
    assert line.isprintable()


@pytest.mark.parametrize("streams", ["2>&-", "2>/dev/full", "<&- >&- 2>&-"])
def test_a_closed_or_full_stream_is_no_error(streams: str, stub: Study, tmp_path: Path) -> None:
    run = f"'{sys.executable}' -m harness run '{stub.source}' --out '{tmp_path}' --set number=0"
    end = finished(["sh", "-c", f"{run} {streams}"])
    assert end.returncode == 0
    assert (tmp_path / "stub.nc").exists()
    assert (str(tmp_path / "stub.nc") in end.stdout) == (">&- " not in streams)
    assert (COMPLETED in end.stderr) == ("2>" not in streams)
