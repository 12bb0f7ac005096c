"""Of Dask, xarray loads nothing here that takes long, and who needs Dask has it afterwards."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from harness.archive.without_dask import without_dask

LOADED = 'print([name for name in ("dask.array", "distributed") if name in sys.modules])'
SCRIPT = f"""
import sys
from pathlib import Path

from harness.archive.case_files import write_case, read_case
from harness.archive.without_dask import without_dask
from harness.study.study import load_study

import xarray as xr

case = load_study("cone_factor_map").cases[0]
folder = Path(sys.argv[1])
with without_dask():
    result = xr.Dataset({{"curve": ("x", [1.0, 2.0])}}, {{"x": [0.0, 1.0]}})
write_case(folder, case, result, "failed", "no run")
assert read_case(folder, case).curve.values.tolist() == [1.0, 2.0]
{LOADED}

import dask.array
import distributed

chunked = xr.Dataset({{"curve": ("x", dask.array.ones(3))}})
assert float(chunked.curve.sum().compute()) == 3.0
write_case(folder, case, result, "failed", "no run")
{LOADED}
"""


def test_a_case_is_written_and_read_without_dask_which_works_afterwards(tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert run.stdout.splitlines() == ["[]", "['dask.array', 'distributed']"], run.stderr


def test_what_was_loaded_before_stays() -> None:
    import dask.array
    import distributed

    with without_dask():
        assert sys.modules["dask.array"] is dask.array
        assert sys.modules["distributed"] is distributed
    assert sys.modules["distributed"] is distributed


def test_an_error_inside_leaves_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("dask.array", "distributed"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    with pytest.raises(ModuleNotFoundError), without_dask():
        importlib.import_module("distributed")
    assert not {"dask.array", "distributed"} & sys.modules.keys()
