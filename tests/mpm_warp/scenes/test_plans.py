"""What a run consists of: nothing that its scene does not need."""

import pytest

from mpm_warp.plan.plan import Plan
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.scenes.elastic.column_wave import ElasticColumnWave
from mpm_warp.scenes.elastic.columns import GravityColumn

STEP = ["particles_to_grid", "cell_stress", "momentum", "cell_rates", "grid_to_particles"]


def kernels(plan: Plan) -> list[str]:
    return [launch.name for launch in plan.step]


@pytest.mark.parametrize("name", scene_names())
def test_every_array_is_used(name: str) -> None:
    plan = scene_class(name)().plan()
    used = {array for launch in plan.launches for array in launch.arrays}
    assert set(plan.arrays) == used


def test_wave_column_has_no_part_that_it_does_not_need() -> None:
    plan = ElasticColumnWave().plan()
    assert kernels(plan) == [*STEP[:3], "fixed", *STEP[3:]]
    parts = {name.split(".")[0] for name in plan.arrays}
    assert parts == {"particle", "grid", "cell", "node", "fixed"}
    assert not {"cell.viscosity", "cell.dilation_rate"} & set(plan.arrays)
    assert plan.between_steps == {}
    modules = " ".join(launch.kernel.module.name for launch in plan.step)
    assert "LinearElastic.2.0.bilinear.resting" in modules
    assert "inviscid" in modules


def test_a_part_adds_its_kernel_and_arrays_alone() -> None:
    free = ElasticColumnWave().plan()
    loaded = ElasticColumnWave(excitation="sudden_load").plan()
    assert set(kernels(loaded)) - set(kernels(free)) == {"nodal_load"}
    assert set(loaded.arrays) - set(free.arrays) == {"load.nodes", "load.forces"}
    heavy = GravityColumn().plan()
    assert set(kernels(heavy)) - set(kernels(free)) == {"gravity", "damping"}
    assert set(kernels(free)) - set(kernels(heavy)) == set()
    assert set(heavy.arrays) == set(free.arrays)
