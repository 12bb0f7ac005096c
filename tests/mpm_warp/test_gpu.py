"""The same code on a GPU: every kernel compiles for one, and runs where there is one."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from mpm_warp.batch import Batch
from mpm_warp.execution import Execution
from mpm_warp.kernels.over_cases import make_over_cases
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.scenes.cone_penetration import ConePenetration

HOPPER = 90
"""A generation of GPUs, by its compute capability."""
GPU = "cuda:0"
needs_gpu = pytest.mark.skipif(not wp.is_cuda_available(), reason="no GPU here")


@pytest.mark.skipif(sys.platform == "darwin", reason="Warp compiles for no GPU there")
def test_every_kernel_compiles_for_a_gpu_alone_and_over_cases(tmp_path: Path) -> None:
    plans = [scene_class(name)().plan() for name in scene_names()]
    kernels = {launch.kernel for plan in plans if plan is not None for launch in plan.launches}
    modules = {kernel.module for kernel in kernels}
    modules |= {make_over_cases(kernel).module for kernel in kernels}
    for module in modules:
        (compiled,) = wp.compile_aot_module(
            module, arch=HOPPER, module_dir=tmp_path / module.name, use_ptx=True
        )
        assert ".entry" in compiled.read_text()


def cone(precision: str, adhesion_factor: float = 0.5) -> ConePenetration:
    return ConePenetration(
        cells_per_radius=2, penetration=16, precision=precision, adhesion_factor=adhesion_factor
    )


@needs_gpu
@pytest.mark.parametrize(("precision", "tolerance"), [("float64", 0.001), ("float32", 0.005)])
def test_a_gpu_gives_the_cone_factor_of_the_processor(precision: str, tolerance: float) -> None:
    on_processor = cone("float64").run()
    on_gpu = cone(precision).run(execution=Execution(GPU))
    assert float(on_gpu.cone_factor) == pytest.approx(float(on_processor.cone_factor), tolerance)


@needs_gpu
def test_a_batch_on_a_gpu_gives_the_cone_factors_of_the_processor() -> None:
    cones = [cone("float64", factor) for factor in (0.0, 0.5, 1.0)]
    execution = Batch(GPU)
    results = execution.run([partial(it.run, execution=execution) for it in cones])
    together = [float(result.cone_factor) for result in results]
    np.testing.assert_allclose(together, [float(it.run().cone_factor) for it in cones], rtol=0.001)
