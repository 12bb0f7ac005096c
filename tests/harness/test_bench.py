"""What a step costs: the table, and its place among the other results."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr

from harness.bench import bench_rows
from harness.cli import main
from mpm_warp.scenes.step_cost import StepCost
from mpm_warp.simulation import Simulation
from mpm_warp.timing import StageClock, yardsticks

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


def test_less_physics_has_fewer_stages() -> None:
    stages = {
        physics: {
            launch.kernel.key.split("__")[-1]
            for launch in StepCost(physics=physics, size=600).plan().step  # type: ignore[union-attr]
        }
        for physics in ("cone", "plastic", "elastic")
    }
    left_out = {"surface_contact", "far_field", "advance_window"}
    assert stages["cone"] - stages["plastic"] == left_out
    assert stages["plastic"] == stages["elastic"]


def test_the_clock_tells_where_the_time_of_a_step_goes() -> None:
    simulation = Simulation(StepCost(physics="elastic", size=5000).build())
    before = simulation.array("particle.position").copy()
    times = StageClock(simulation).time_steps(20)
    stages = times.stages
    assert list(stages) == [it.kernel.key.split("__")[-1] for it in simulation.plan.step]
    assert 0 < times.launching < sum(stages.values())
    assert (simulation.array("particle.position") == before).all()  # at rest


def test_yardsticks_are_within_what_processors_do() -> None:
    machine = yardsticks()
    assert 1e8 < machine.streaming < 1e12
    assert 1e8 < machine.arithmetic < 1e12
    assert 1e7 < machine.division < machine.arithmetic


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


def test_cases_that_are_computed_together_are_measured_together() -> None:
    result = StepCost(size=600, cases=3, samples=2, sample_time=0.01).run()
    assert float(result.update_rate) > 0
    # Of one of them; no stage is clocked, because other cases share its launches.
    assert float(result.particle_updates) < 3 * float(result.particle_count * result.step_count)
    assert "stage_time" not in result
