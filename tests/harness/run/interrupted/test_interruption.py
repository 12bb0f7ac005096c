"""Runs that are interrupted, lose their reader or are killed: no process, no half file is left."""

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

from harness.archive import study_files
from harness.archive.conventions import COMPLETED

pytestmark = pytest.mark.slow

INTERRUPTED = re.compile(r"harness: interrupted; (.*); the same command goes on with the rest\n$")


LIMIT = 120
"""Seconds after which what is waited for does not come."""


@contextmanager
def running(
    small_file: Path, out: Path, until: str, speeds: str = "[0.03, 0.0001]"
) -> Iterator[subprocess.Popen[str]]:
    """A command in a group of its own, that has said `until`; its last case takes a minute."""
    settings = ["--set", "adhesion_factor=0", "--set", "penetration=20"]
    settings += ["--set", f"speed_ratio={speeds}"]
    command = [sys.executable, "-m", "harness", "run", str(small_file), "--out", str(out)]
    # A process in the background of a shell ignores SIGINT, one under nohup SIGHUP, and so would
    # whatever it starts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    before_of_terminal = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    with subprocess.Popen(
        [*command, *settings, "--workers", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        signal.signal(signal.SIGINT, before)
        signal.signal(signal.SIGHUP, before_of_terminal)
        try:
            assert process.stderr is not None
            for line in process.stderr:
                if line.startswith(until):
                    break
            yield process
            process.wait(timeout=LIMIT)
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise


def statuses_left(out: Path) -> list[str]:
    """Statuses of the case files that there are."""
    files = [path for path in out.rglob("*") if path.is_file() and path != out / "small.nc"]
    return [xr.load_dataset(path).attrs["status"] for path in files]


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_an_interrupted_run_keeps_what_is_finished_and_nothing_else(
    small_file: Path,
    tmp_path: Path,
    number: signal.Signals,
    code: int,
    wait_for_end: Callable[[int], None],
) -> None:
    out = tmp_path / "out"
    with running(small_file, out, until="[1/2]") as process:
        # A terminal sends Ctrl-C, and that it is closed, to the whole group, workers included.
        send = os.kill if number is signal.SIGTERM else os.killpg
        send(process.pid, number)
        told = process.communicate(timeout=LIMIT)[1]
    assert process.returncode == code
    interrupted = INTERRUPTED.search(told)
    assert interrupted is not None
    assert interrupted[1].startswith("2 cases: 1 completed, 1 missing; ")
    assert "Traceback" not in told
    wait_for_end(process.pid)
    assert statuses_left(out) == [COMPLETED]
    dataset = study_files.read_study(out / "small.nc")
    assert dataset.status.values.tolist() == [COMPLETED, "missing"]
    assert dataset.cone_factor.notnull().values.tolist() == [True, False]


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.1])
def test_an_interrupt_while_workers_start_is_as_quiet(
    small_file: Path, tmp_path: Path, delay: float, wait_for_end: Callable[[int], None]
) -> None:
    out = tmp_path / "out"
    with running(small_file, out, until="harness: small: ", speeds="0.0001") as process:
        time.sleep(delay)
        os.killpg(process.pid, signal.SIGINT)
        told = process.communicate(timeout=LIMIT)[1]
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
        time.sleep(1)  # the worker is told of the next case only now
        process.kill()
    wait_for_end(process.pid)
    assert statuses_left(out) == [COMPLETED]
