"""Workers whose parent is killed, at any moment and however long their steps: none is left.

``HARNESS_ORPHANS=20 python -m pytest tests/harness/run/interrupted/test_orphans.py`` kills that
many parents.
"""

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

COUNT = int(os.environ.get("HARNESS_ORPHANS", "2"))
LATEST = 12.0
"""Seconds after which the parent is killed at the latest: workers compute by then."""
LONG_STEPS = """
title = "steps of a second"
scene = "cone_penetration"
vary = { adhesion_factor = [0, 1] }
fixed = { cells_per_radius = 40 }
"""


@pytest.mark.parametrize("number", range(COUNT))
def test_no_worker_outlives_its_parent(
    number: int, tmp_path: Path, wait_for_end: Callable[[int], None]
) -> None:
    study = tmp_path / "long.toml"
    study.write_text(LONG_STEPS)
    command = [sys.executable, "-m", "harness", "run", str(study), "--out", str(tmp_path / "out")]
    with subprocess.Popen(
        [*command, "--workers", "2"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    ) as process:
        try:
            time.sleep(random.Random(number).uniform(0.0, LATEST))
            process.kill()
            process.wait()
            wait_for_end(process.pid)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    assert not list((tmp_path / "out").rglob("*.nc"))
