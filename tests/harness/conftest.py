"""Studies that run in no time."""

import contextlib
import io
import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from textwrap import dedent
from typing import Any

import numpy as np
import pytest
import xarray as xr

from harness.archive import case_files
from harness.archive.atomic_files import prepare
from harness.archive.conventions import COMPLETED
from harness.archive.netcdf_files import write_netcdf
from harness.cli.main import main
from harness.compare.finest_error import with_finest_error
from harness.errors import LONGEST_LINE
from harness.run.pool import Watcher
from harness.run.resources import RunOptions
from harness.run.worker import run_case
from harness.study.cases import Case
from harness.study.study import Study, load_study
from mpm_warp.scenes import catalogue
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

SMALL = """
    title = "A study for tests"
    scene = "cone_penetration"

    [fixed]
    penetration = 1
    steady_tolerance = 0
    cells_per_radius = 1
    particles_per_cell = 4

    [vary]
    adhesion_factor = [0, 0.5, 1]
"""

STUB_FOLDER = Path(__file__).parent / "stub"
STUB = """
    title = "Three cases that take no time"
    scene = "stub"

    [vary]
    number = [0, 0.5, 1]
"""

HEAD = 'title = "t"\nscene = "cone_penetration"\n'

Command = Callable[..., Any]
"""Runs a command of these words, which ends with `code`, 0 by default: what it says."""
Refusal = Callable[[list[str]], str]
"""Runs a command that is to be refused, and gives the one line with which it is."""
Depth = Callable[[int, int], int]
"""Chooses between the number of cases by default and that with ``--deep``."""

DONE = xr.Dataset(
    {"cone_factor": ((), 10.0, {"role": "headline", "units": "1", "long_name": "cone factor"})}
)
"""What a case has at the least that has completed: a headline."""


def study_in(folder: Path, text: str, *settings: str, name: str = "s") -> Study:
    """The study of a definition, which is written into a folder."""
    path = folder / f"{name}.toml"
    path.write_text(text)
    return load_study(str(path), settings)


def values(study: Study, *names: str) -> list[tuple[object, ...]]:
    """Parameters of each case of a study."""
    return [tuple(case.parameters.get(name) for name in names) for case in study.cases]


def prepared(study: Study, out: Path) -> Path:
    """The folder of a study's cases in `out`, ready to be written to."""
    folder = case_files.case_folder(out, study)
    prepare(folder)
    return folder


def damage(path: Path) -> None:
    """Flip a bit of a file of the harness, which is written first if there is none."""
    if not path.exists():
        write_netcdf(DONE, path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def keep(study: Study, out: Path, *results: xr.Dataset) -> Path:
    """Write a result of each case, or the same of all; the folder of the study's cases."""
    folder = prepared(study, out)
    for case, result in zip(study.cases, results or itertools.repeat(DONE), strict=False):
        case_files.write_case(folder, case, result, COMPLETED)
    return folder


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder, which a command is run in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def small_file(tmp_path: Path) -> Path:
    """The definition of three cases of next to no cost."""
    path = tmp_path / "small.toml"
    path.write_text(dedent(SMALL))
    return path


@pytest.fixture
def small(small_file: Path) -> Study:
    """Three cases of next to no cost."""
    return load_study(str(small_file))


@pytest.fixture
def stub_offered(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The stub is a scene, here and in processes that are started from here."""
    monkeypatch.syspath_prepend(STUB_FOLDER)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(STUB_FOLDER), str(Path.cwd())]))
    catalogue._all_scenes.cache_clear()
    yield
    catalogue._all_scenes.cache_clear()


@pytest.fixture
def stub(stub_offered: None, tmp_path: Path) -> Study:
    """Three cases of the stub, in a file `stub.toml`."""
    return study_in(tmp_path, dedent(STUB), name="stub")


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cases are run here, one after another: a worker process takes seconds to start."""

    def run_cases(
        cases: Sequence[Case], folder: Path, count: int, watcher: Watcher, options: RunOptions
    ) -> None:
        for case in cases:
            watcher.finished(case, run_case(case, folder, options=options))

    monkeypatch.setattr("harness.run.run_study.run_cases", run_cases)


@pytest.fixture
def folder(small: Study, tmp_path: Path) -> Path:
    """Where the results of these cases are kept."""
    return prepared(small, tmp_path)


def as_collected(
    made: xr.Dataset, dims: str | Sequence[str], status: Any, **attributes: object
) -> xr.Dataset:
    """A made-up dataset with what the result of every study has; the status is over the cases."""
    values = np.asarray(status)
    keys = np.char.add("key ", np.arange(values.size).astype(str)).reshape(values.shape)
    scene = {"scene": "cone_penetration", "scene_version": ConePenetration.version}
    known = {**scene, "study": "made", "title": "Made <up>"}
    return made.assign(
        status=(dims, values, {"long_name": "outcome of the case"}),
        message=(dims, np.where(values == COMPLETED, "", "velocity of <particle 3>")),
        case_key=(dims, keys),
    ).assign_attrs(known, **attributes)


@pytest.fixture
def two_soils() -> xr.Dataset:
    """Two soils on three meshes with errors; the finest case of the second soil has failed."""
    shape = ("rigidity_index", "cells_per_radius")
    factor = np.array([[9.9, 9.18, 9.0], [11.0, 10.1, np.nan]])
    seconds = np.array([[1.0, 2.0, 8.0], [1.0, 2.5, np.nan]])
    status = np.array([["completed"] * 3, ["completed", "completed", "diverged"]])
    made = xr.Dataset(
        {
            "cone_factor": (shape, factor, {"long_name": "cone factor", "role": "headline"}),
            "run_time": (shape, seconds),
            "case_time": (shape, np.nan_to_num(seconds, nan=3.0)),
            "particle_updates": (shape, 1e6 * seconds),
            "adhesion_factor": ((), 0.0, {"role": "parameter", "units": "1"}),
            "apex_angle": 60.0,
            "poissons_ratio": 0.49,
            "material": "tresca",
        },
        coords={
            "rigidity_index": ("rigidity_index", [50.0, 100.0], {"role": "parameter"}),
            "cells_per_radius": ("cells_per_radius", [1.5, 2.0, 4.0], {"role": "parameter"}),
        },
    )
    return with_finest_error(as_collected(made, shape, status), ["cells_per_radius"])


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    return partial(_ended, capsys)


@pytest.fixture
def refusal(capsys: pytest.CaptureFixture[str]) -> Refusal:
    def refused(arguments: list[str]) -> str:
        told = _ended(capsys, *arguments, code=2)
        assert told.out == ""
        (line,) = told.err.splitlines()
        return line

    return refused


def answered(arguments: list[str]) -> tuple[int, str]:
    """The exit code of a command that may be refused, and what it says on standard error.

    Nothing that it says controls a terminal or is an error of the program.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = _exit_code(arguments)
    told = err.getvalue()
    assert code in (0, 1, 2), told
    assert all(it.isprintable() for it in (*out.getvalue(), *told) if it != "\n")
    assert not any(it in told for it in ("Error:", "Exception", "Errno", "Traceback")), told
    if code == 2:
        assert out.getvalue() == ""
        assert len(told.splitlines()[-1]) < LONGEST_LINE + 100
    return code, told


def _exit_code(arguments: list[str]) -> int:
    try:
        return main(arguments)
    except SystemExit as end:  # of the command line's own errors, and of --help
        return int(end.code or 0)


def _ended(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> Any:
    capsys.readouterr()
    ended = _exit_code([str(word) for word in words])
    told = capsys.readouterr()
    assert ended == code, told.err
    return told


def written(study: Study, out: Path) -> dict[str, tuple[int, int]]:
    """What tells the file of each completed case from one written later, by the cases' keys."""
    folder = case_files.case_folder(out, study)
    done = [case for case in study.cases if case_files.is_complete(folder, case)]
    stats = {case.key: case_files.case_file(folder, case).stat() for case in done}
    return {key: (stat.st_ino, stat.st_mtime_ns) for key, stat in stats.items()}
