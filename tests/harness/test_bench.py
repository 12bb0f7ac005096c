"""What a step costs: the table, and its place among the other results."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr

from harness.bench import bench_rows
from harness.cli import main

GAIN_HEADER = "| times as fast as one thread, turn about | 600 points |"
QUICK = ["--set", "samples=2", "--set", "sample_time=0.01", "--set", "size=600"]


@pytest.fixture
def result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    assert main(["bench", *QUICK, "--out", str(tmp_path / "one")]) == 0
    capsys.readouterr()
    return tmp_path / "one" / "bench.nc"


def test_bench_measures_every_case_and_shows_the_stages_of_the_fullest(result: Path) -> None:
    dataset = xr.open_dataset(result)
    assert dict(dataset.update_rate.sizes) == {"physics": 3, "threads": 2}
    assert (dataset.update_rate_lowest <= dataset.update_rate).all()
    assert (dataset.update_rate <= dataset.update_rate_highest).all()
    rows = bench_rows(dataset)
    first = rows[: rows.index("")]
    assert sum(row.startswith("| physics ") for row in first) == 6
    case = dataset.sel(physics="cone", threads=1)
    assert {"particles_to_grid", "grid_to_particles", "cell_rates"} <= set(case.stage.values)
    stages = {row.split("`")[1]: row.split("|")[3:-1] for row in rows if row.startswith("| `")}
    assert stages
    for name, cells in stages.items():
        operations, *_, over = map(float, cells)
        stage = case.sel(stage=name)
        assert operations == round(float(stage.stage_operations))
        by_memory = stage.stage_bytes / case.streaming_rate
        by_arithmetic = (
            stage.stage_operations / case.arithmetic_rate
            + stage.stage_divisions / case.division_rate
        )
        larger = 1e9 * max(float(by_memory), float(by_arithmetic))
        assert over == pytest.approx(float(stage.stage_time) / larger, abs=0.051)
    assert float(dataset.array_bytes.max()) < 300
    assert (dataset.thread_gain.sel(threads=2) > 0).all()
    assert dataset.thread_gain.sel(threads=1).isnull().all()
    gains = rows[rows.index(GAIN_HEADER) + 2 :]
    assert [row.split("|")[2].strip() for row in gains[: gains.index("")]] == [
        f"{case:.2f}" for case in dataset.thread_gain.sel(threads=2).values.flat
    ]


def test_two_benches_can_be_compared(
    result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["bench", *QUICK, "--out", str(tmp_path / "two")]) == 0
    other = tmp_path / "two" / "bench.nc"
    capsys.readouterr()
    assert main(["compare", str(result), str(other), "--tolerance", "1e6"]) == 0
    assert "update_rate " in capsys.readouterr().out
    # A measurement that came out the same to the last bit would be no measurement.
    assert main(["compare", str(result), str(other), "--tolerance", "0"]) == 1
