"""What this machine has, and a machine that lacks what POSIX gives."""

import os
import sys
from pathlib import Path

import numpy as np
import psutil
import pytest

from harness import machine
from harness.archive.conventions import COMPLETED
from harness.archive.study_files import read_study
from harness.run.resources import SHARE_OF_MACHINE, Measurement, default_memory_limit
from tests.conftest import finished
from tests.harness.interpret.conftest import DEPTH, LAYER, SITE, STRENGTH, measured_rows

MIB = 2**20


@pytest.mark.parametrize(("allowed", "usable"), [([3, 5], 2), (None, 8)])
def test_given_allowed_cores_they_are_counted_otherwise_all(
    allowed: list[int] | None, usable: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(psutil, "cpu_count", lambda: 8)
    if allowed is None:
        monkeypatch.delattr(psutil.Process, "cpu_affinity", raising=False)
    else:
        monkeypatch.setattr(psutil.Process, "cpu_affinity", lambda process: allowed, raising=False)
    assert machine.usable_cores() == usable


def test_given_a_container_its_memory_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = tmp_path / "memory.max"
    monkeypatch.setattr(machine, "CONTAINER_LIMITS", (told, tmp_path / "none"))
    for text in ("max\n", f"{2**62}\n"):  # as cgroup 2 and 1 state that there is no limit
        told.write_text(text)
        assert machine.memory_of_machine() == psutil.virtual_memory().total
    told.write_text("400000000\n")
    assert default_memory_limit() == SHARE_OF_MACHINE * 400e6


def test_given_memory_in_between_and_before_the_peak_is_that_of_between() -> None:
    before = Measurement()
    memory = np.ones(100 * MIB, np.uint8)
    between = int(before.variables()["peak_memory"])
    del memory
    after = int(Measurement().variables()["peak_memory"])
    assert between - after > 90 * MIB


@pytest.mark.parametrize("lacking", [("RESET",), ("RESET", "PEAK")])
def test_where_the_peak_cannot_be_reset_it_is_said_whose_it_is(
    lacking: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in lacking:
        monkeypatch.setattr(machine, name, tmp_path / "none" / name)
    peak = Measurement().variables()["peak_memory"]
    assert peak.attrs["description"].endswith("since it was started, maybe for earlier cases")
    assert int(peak) > 10 * MIB


WITHOUT_POSIX = """
import os, signal, sys
import psutil  # has other ways on other systems, and may use these here

for name in ("SIGHUP", "SIGPIPE", "pthread_sigmask"):
    delattr(signal, name)
for name in ("sysconf", "getloadavg", "sched_getaffinity", "getuid", "fork", "killpg"):
    delattr(os, name)
sys.modules["resource"] = None  # an import of it fails


def refused(event, arguments):
    if event in ("os.rename", "os.remove"):
        own = {opened.path for opened in psutil.Process().open_files()}
        if own & {os.path.realpath(it) for it in arguments if isinstance(it, str | os.PathLike)}:
            raise PermissionError(13, "The file is open", arguments[0])
    if event == "open" and str(arguments[0]).startswith(("/proc", "/sys")):
        frame = sys._getframe(1)
        while frame is not None:
            if "psutil" in frame.f_code.co_filename:
                return
            frame = frame.f_back
        raise FileNotFoundError(arguments[0])


sys.addaudithook(refused)
"""
"""Takes from Python and from Linux what other systems lack; no open file is renamed or removed."""


EVERYTHING = """
import importlib, pkgutil, signal, sys
import mpm_warp, harness
from harness.cli.main import main

if __name__ == "__main__":
    assert not hasattr(signal, "SIGHUP")
    for package in (mpm_warp, harness):
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not found.name.endswith("__main__"):
                importlib.import_module(found.name)
    for line in sys.argv[1:]:
        assert main(line.split()) == 0, line
"""
"""Imports every module and runs some commands."""


@pytest.mark.slow
def test_given_a_machine_without_posix_modules_commands_and_a_run_work(tmp_path: Path) -> None:
    """Its texts are ASCII unless said otherwise."""
    test = measured_rows(DEPTH, 11.5 * STRENGTH, 0.4 * STRENGTH)
    tiny = 'title = "tiny"\nscene = "material_point"\n[fixed]\nstep_count = 64\n'
    for name, text in (
        ("sitecustomize.py", WITHOUT_POSIX),
        ("everything.py", EVERYTHING),
        ("tiny.toml", tiny),
        ("test.csv", test),
        ("site.toml", SITE + LAYER),
    ):
        (tmp_path / name).write_text(text)
    commands = (
        "list",
        "describe cone_penetration",
        "run tiny.toml --workers 1",
        "interpret site.toml",
    )
    path = os.pathsep.join([str(tmp_path), str(Path(__file__).parents[2])])
    everything = [sys.executable, "everything.py", *commands]
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    end = finished(everything, cwd=tmp_path, env=os.environ | ascii_only | {"PYTHONPATH": path})
    assert end.returncode == 0, end.stderr
    assert not list(tmp_path.rglob("*.part"))
    assert read_study(tmp_path / "results" / "tiny.nc")["status"].item() == COMPLETED
