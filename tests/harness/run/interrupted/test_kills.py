"""A study killed again and again: nothing lost, nothing done twice, the same bits in the end."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.archive import case_files, study_files
from harness.compare.differences import differing
from harness.study.study import Study, load_study

pytestmark = pytest.mark.slow

LIMIT = 600
"""Seconds after which a run is taken to hang: it needs less than a minute."""


def definition(path: Path, case_count: int) -> Path:
    """A study of small cases."""
    values = [0.4 * i / case_count for i in range(case_count)]
    path.write_text(
        'title = "Many small cases"\nscene = "gravity_column"\n'
        f"[fixed]\ncell_count = 10\n[vary]\npoissons_ratio = {values}\n"
    )
    return path


def command(study: Path, out: Path) -> list[str]:
    return [
        *(sys.executable, "-m", "harness", "run", str(study), "--out", str(out)),
        *("--workers", "2"),
    ]


def kill_when(command: list[str], folder: Path, done: int, delay: float) -> int:
    """Run a command, and kill its group of processes a moment after `done` case files are there."""
    with subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            deadline = time.monotonic() + LIMIT
            while len(list(folder.glob("*.nc"))) < done:
                assert process.poll() is None
                assert time.monotonic() < deadline
                time.sleep(0.005)
            time.sleep(delay)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL  # it had not ended by itself
    return process.pid


@pytest.mark.parametrize(("case_count", "kills"), [(200, 10)])
def test_a_study_killed_at_random_moments_ends_as_if_undisturbed(
    case_count: int,
    kills: int,
    tmp_path: Path,
    written: Callable[[Study, Path], dict[str, tuple[int, int]]],
    wait_for_end: Callable[[int], None],
) -> None:
    study_file = definition(tmp_path / "many.toml", case_count)
    study = load_study(str(study_file))
    undisturbed = command(study_file, tmp_path / "whole")
    subprocess.run(undisturbed, check=True, capture_output=True, timeout=LIMIT)

    out = tmp_path / "killed"
    folder = case_files.case_folder(out, study)
    moments = random.Random(20260101)
    seen: dict[str, tuple[int, int]] = {}
    # Half of the cases are left at the last kill, so that it does not come too late.
    for done in sorted(moments.sample(range(case_count // 2), kills)):
        delay = moments.uniform(0, 0.1)
        wait_for_end(kill_when(command(study_file, out), folder, done, delay))
        now = written(study, out)
        assert seen.items() <= now.items()
        seen = now
    assert 0 < len(seen) < case_count
    subprocess.run(command(study_file, out), check=True, capture_output=True, timeout=LIMIT)

    assert seen.items() <= written(study, out).items()
    assert {path.name for path in folder.iterdir()} == {f"{case.key}.nc" for case in study.cases}
    assert not list(out.rglob(".*"))
    killed, whole = (
        study_files.read_study(folder / "many.nc") for folder in (out, tmp_path / "whole")
    )
    assert set(killed.status.values.tolist()) == {"completed"}
    assert differing(killed, whole) == []
