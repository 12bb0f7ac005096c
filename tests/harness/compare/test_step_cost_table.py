"""What a step costs: the table, and its place among the other results."""

from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path

import pytest
import xarray as xr

from harness.cli.main import main
from harness.compare.costs import bench_rows
from tests.harness.conftest import Command

pytestmark = pytest.mark.slow

SPEED = "million updates/s, median (least to most)"
GAIN = "times as fast as one thread"
MEMORY = "arrays, bytes a point"
QUICK = ["--set", "samples=2", "--set", "sample_time=0.01", "--set", "size=600"]


def table(rows: Sequence[str], title: str) -> dict[str, str]:
    """What stands in the table of that title, by whatever varies besides the size."""
    first = rows.index(f"| {title} | 600 points |") + 2
    cells = [row.strip("| ").split(" | ") for row in takewhile(bool, rows[first:])]
    return dict(cells)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("one")
    assert main(["bench", *QUICK, "--out", str(folder)]) == 0
    return folder / "bench.nc"


def test_bench_measures_every_case_and_shows_the_stages_of_the_fullest(result: Path) -> None:
    dataset = xr.open_dataset(result)
    assert dict(dataset.update_rate.sizes) == {"physics": 3, "threads": 2}
    assert (dataset.update_rate_lowest <= dataset.update_rate).all()
    assert (dataset.update_rate <= dataset.update_rate_highest).all()
    rows = bench_rows(dataset)
    assert len(table(rows, SPEED)) == 6
    case = dataset.sel(physics="cone", threads=1)
    assert {"particles_to_grid", "grid_to_particles", "cell_rates"} <= set(case.stage.values)
    stages = {row.split("`")[1]: row.split("|")[2:-1] for row in rows if row.startswith("| `")}
    assert stages
    times = case.stage_time.dropna("stage")
    for name, (time, share) in stages.items():
        assert time.strip() == f"{times.sel(stage=name):.2f}"
        assert share.strip() == f"{times.sel(stage=name) / times.sum():.1%}"
    assert list(table(rows, MEMORY).values()) == [
        f"{case:.0f}" for case in dataset.array_bytes.values.flat
    ]
    assert (dataset.thread_gain.sel(threads=2) > 0).all()
    assert dataset.thread_gain.sel(threads=1).isnull().all()
    assert list(table(rows, GAIN).values()) == [
        f"{gain:.2f}" for gain in dataset.thread_gain.sel(threads=2).values
    ]


def test_of_cases_that_are_computed_together_the_table_shows_speed_and_memory_alone(
    tmp_path: Path, command: Command
) -> None:
    settings = ["--set", "physics=elastic", "--set", "threads=[1, 2]", "--set", "cases=[1, 2]"]
    rows = command("bench", *QUICK, *settings, "--out", tmp_path).out.splitlines()
    each = {f"threads {threads}, cases {cases}" for threads in (1, 2) for cases in (1, 2)}
    assert table(rows, SPEED).keys() == table(rows, MEMORY).keys() == each
    assert all(float(cell.split()[0]) > 0 for cell in table(rows, SPEED).values())
    assert table(rows, GAIN).keys() == {"threads 2, cases 1"}


def test_two_benches_can_be_compared(result: Path, tmp_path: Path, command: Command) -> None:
    command("bench", *QUICK, "--out", tmp_path)
    told = command("compare", result, tmp_path / "bench.nc", "--tolerance", "1e6").out
    assert "update_rate " in told
