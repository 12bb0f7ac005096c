"""Runs on a GPU, where there is one: the results of the processor."""

from functools import partial

import numpy as np
import pytest
import warp as wp

from mpm_warp.execution.batch import Batch
from mpm_warp.execution.execution import Execution
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

GPU = "cuda:0"
pytestmark = pytest.mark.skipif(not wp.is_cuda_available(), reason="no GPU here")


def cone(adhesion_factor: float = 0.5) -> ConePenetration:
    return ConePenetration(cells_per_radius=2, penetration=16, adhesion_factor=adhesion_factor)


def test_a_gpu_gives_the_cone_factor_of_the_processor() -> None:
    on_processor = cone().run()
    on_gpu = cone().run(execution=Execution(GPU))
    assert float(on_gpu.cone_factor) == pytest.approx(float(on_processor.cone_factor), 0.001)


def test_a_batch_on_a_gpu_gives_the_cone_factors_of_the_processor() -> None:
    cones = [cone(factor) for factor in (0.0, 0.5, 1.0)]
    execution = Batch(GPU)
    results = execution.run([partial(it.run, execution=execution) for it in cones])
    together = [float(result.cone_factor) for result in results]
    np.testing.assert_allclose(together, [float(it.run().cone_factor) for it in cones], rtol=0.001)
