"""Workers whose parent is killed, at any moment and however long their steps: none is left."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

LATEST = 6.0
"""Seconds after the birth of the workers at which the parent is killed at the latest."""
LONG_STEPS = """
title = "steps of a second"
scene = "cone_penetration"
vary = { adhesion_factor = [0, 1] }
fixed = { cells_per_radius = 40 }
"""


def worker_count(group: int) -> int:
    """Processes of a group that import or compute: its first has started them."""
    stats = []
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            stats.append(file.read_text().rpartition(")")[2].split())
        except (FileNotFoundError, ProcessLookupError):  # has ended meanwhile
            continue
    ticks = [int(it[11]) + int(it[12]) for it in stats if int(it[2]) == group]
    return sum(it > os.sysconf("SC_CLK_TCK") / 5 for it in ticks) - 1


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads Linux's /proc")
def test_no_worker_outlives_its_parent(
    tmp_path: Path, wait_for_end: Callable[[int], None], depth: Callable[[int, int], int]
) -> None:
    study, moments = tmp_path / "long.toml", random.Random(0)
    study.write_text(LONG_STEPS)
    command = [sys.executable, "-m", "harness", "run", str(study), "--out", str(tmp_path / "out")]
    for _ in range(depth(2, 20)):
        with subprocess.Popen(
            [*command, "--workers", "2"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        ) as process:
            try:
                deadline = time.monotonic() + 60
                while worker_count(process.pid) < 2:
                    assert time.monotonic() < deadline
                    time.sleep(0.05)
                time.sleep(moments.uniform(0.0, LATEST))
                process.kill()
                process.wait()
                wait_for_end(process.pid)
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGKILL)
    assert not list((tmp_path / "out").rglob("*.nc"))
