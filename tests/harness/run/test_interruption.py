"""Runs that are interrupted, lose their reader or are killed: no process, no half file is left."""

import os
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil
import pytest
import xarray as xr

from harness.archive import case_files, study_files
from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.compare.differences import differing
from harness.study.study import Study
from tests.conftest import LIMIT, wait_until
from tests.harness.conftest import Depth, study_in, written

pytestmark = pytest.mark.slow

INTERRUPTED = re.compile(
    r"harness: (\d.*); the same command goes on with the rest\nharness: interrupted\n$"
)


def has_ended(group: int) -> bool:
    """Whether all processes of a group have ended."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


def run_of(study: Path, out: Path, workers: int, *more: str) -> list[str]:
    run = [sys.executable, "-m", "harness", "run", str(study), "--out", str(out)]
    return [*run, "--workers", str(workers), *more]


@contextmanager
def group(command: list[str], **streams: Any) -> Iterator[subprocess.Popen[str]]:
    """A command in a group of processes of its own, which is killed where the test fails."""
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(
        command, **(silent | streams), text=True, start_new_session=True
    ) as process:
        try:
            yield process
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise


@contextmanager
def running(
    stub: Study, out: Path, until: str, seconds: str = "[0, 1000]"
) -> Iterator[subprocess.Popen[str]]:
    """A command that has said `until`; its last case does not end."""
    settings = ["--set", "number=1", "--set", f"seconds={seconds}"]
    # A process in the background of a shell ignores SIGINT, one under nohup SIGHUP, and so would
    # whatever it starts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    before_of_terminal = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    command = run_of(stub.source, out, 1, *settings)
    with group(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        signal.signal(signal.SIGINT, before)
        signal.signal(signal.SIGHUP, before_of_terminal)
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith(until):
                break
        yield process
        process.wait(timeout=LIMIT)


def statuses_left(out: Path) -> list[str]:
    """Statuses of the case files that there are."""
    files = [path for path in out.rglob("*") if path.is_file() and path != out / "stub.nc"]
    return [xr.load_dataset(path).attrs["status"] for path in files]


def assert_born_deaf_to_ctrl_c(worker: psutil.Process) -> None:
    """Held signals are inherited: at no instant of its start would a worker be interrupted."""
    status = Path(f"/proc/{worker.pid}/status")
    lines = status.read_text(encoding="utf-8").splitlines() if status.exists() else []
    for line in lines:
        if line.startswith(("SigBlk:", "SigIgn:")):  # where none can be held, it is ignored soon
            assert int(line.split()[1], 16) & 1 << (signal.SIGINT - 1)


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_an_interrupted_run_keeps_what_is_finished_and_nothing_else(
    stub: Study, tmp_path: Path, number: signal.Signals, code: int
) -> None:
    out = tmp_path / "out"
    with running(stub, out, until="[1/2]") as process:
        children = psutil.Process(process.pid).children()
        (worker,) = (it for it in children if "spawn_main" in " ".join(it.cmdline()))
        assert_born_deaf_to_ctrl_c(worker)
        # A terminal sends Ctrl-C, and that it is closed, to the whole group, workers included.
        send = os.kill if number is signal.SIGTERM else os.killpg
        send(process.pid, number)
        told = process.communicate(timeout=LIMIT)[1]
    assert process.returncode == code
    interrupted = INTERRUPTED.search(told)
    assert interrupted[1].startswith("2 cases: 1 completed, 1 missing; ")
    assert "Traceback" not in told
    wait_until(lambda: has_ended(process.pid))
    assert statuses_left(out) == [COMPLETED]
    dataset = study_files.read_study(out / "stub.nc")
    assert dataset.status.values.ravel().tolist() == [COMPLETED, "missing"]
    assert dataset.answer.notnull().values.ravel().tolist() == [True, False]


@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_an_interrupt_of_starting_workers_is_quiet(
    stub: Study, tmp_path: Path, delay: float
) -> None:
    out = tmp_path / "out"
    with running(stub, out, until="harness: stub: ", seconds="1000") as process:
        time.sleep(delay)
        os.killpg(process.pid, signal.SIGINT)
        told = process.communicate(timeout=LIMIT)[1]
    assert process.returncode == 130
    assert INTERRUPTED.search(told)
    assert "Traceback" not in told
    wait_until(lambda: has_ended(process.pid))
    assert statuses_left(out) == []


def test_a_run_whose_reader_has_gone_ends_quietly(stub: Study, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with running(stub, out, until="harness: stub: ") as process:
        process.stderr.close()
    assert process.returncode == 141
    wait_until(lambda: has_ended(process.pid))
    assert statuses_left(out) == [COMPLETED]


@pytest.mark.usefixtures("in_this_process")
def test_a_study_killed_at_random_goes_on(stub_offered: None, tmp_path: Path, depth: Depth) -> None:
    case_count, kills = depth(60, 200), depth(4, 10)
    text = f"[fixed]\nseconds = 0.02\n[vary]\nnumber = {list(range(case_count))}\n"
    study = study_in(tmp_path, f'title = "t"\nscene = "stub"\n{text}', name="many")
    assert main(["run", str(study.source), "--out", str(tmp_path / "whole")]) == 0

    out = tmp_path / "killed"
    folder = case_files.case_folder(out, study)
    moments = random.Random(20260101)
    seen: dict[str, tuple[int, int]] = {}
    # Half of the cases are left at the last kill, so that it does not come too late.
    for done in sorted(moments.sample(range(case_count // 2), kills)):
        delay = moments.uniform(0, 0.1)
        with group(run_of(study.source, out, 2)) as process:
            wait_until(lambda count=done: len(list(folder.glob("*.nc"))) >= count)
            time.sleep(delay)
            os.killpg(process.pid, signal.SIGKILL)
        assert process.returncode == -signal.SIGKILL  # it had not ended by itself
        wait_until(lambda: has_ended(process.pid))
        now = written(study, out)
        assert seen.items() <= now.items()
        seen = now
    assert 0 < len(seen) < case_count
    assert main(["run", str(study.source), "--out", str(out)]) == 0

    assert seen.items() <= written(study, out).items()
    assert {path.name for path in folder.iterdir()} == {f"{case.key}.nc" for case in study.cases}
    assert not list(out.rglob(".*"))
    killed, whole = (
        study_files.read_study(folder / "many.nc") for folder in (out, tmp_path / "whole")
    )
    assert set(killed.status.values.tolist()) == {"completed"}
    assert differing(killed, whole) == []


LATEST = 2.0
"""Seconds after the birth of the workers at which the parent is killed at the latest."""
LONG_STEPS = ["--set=seconds=1000", "--set=interval=1"]


def busy_workers(parent: int) -> int:
    """Children of a process that import or compute."""
    try:
        return sum(sum(it.cpu_times()[:2]) > 0.2 for it in psutil.Process(parent).children())
    except psutil.NoSuchProcess:  # has ended meanwhile
        return 0


def test_no_worker_outlives_its_parent(stub: Study, tmp_path: Path, depth: Depth) -> None:
    moments = random.Random(0)
    for _ in range(depth(2, 20)):
        with group(run_of(stub.source, tmp_path / "out", 2, *LONG_STEPS)) as process:
            wait_until(lambda: busy_workers(process.pid) >= 2)
            time.sleep(moments.uniform(0.0, LATEST))
            process.kill()
            process.wait()
            wait_until(lambda: has_ended(process.pid))
    assert not list((tmp_path / "out").rglob("*.nc"))
