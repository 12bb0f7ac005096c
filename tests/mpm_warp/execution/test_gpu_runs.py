"""Runs on a GPU, where there is one: the results of the processor."""

from functools import partial

import numpy as np
import pytest
import warp as wp

from mpm_warp.execution.execution import Batch, Execution
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

GPU = "cuda:0"
pytestmark = pytest.mark.skipif(not wp.is_cuda_available(), reason="no GPU here")


def cone(adhesion_factor: float = 0.5) -> ConePenetration:
    return ConePenetration(cells_per_radius=2, penetration=16, adhesion_factor=adhesion_factor)


def test_a_gpu_gives_the_cone_factors_of_the_processor_alone_and_in_a_batch() -> None:
    cones, batch = [cone(factor) for factor in (0.0, 0.5, 1.0)], Batch(GPU)
    expected = [float(it.run().cone_factor) for it in cones]
    alone = [float(it.run(execution=Execution(GPU)).cone_factor) for it in cones]
    together = batch.run([partial(it.run, execution=batch) for it in cones])
    np.testing.assert_allclose(alone, expected, rtol=0.001)
    np.testing.assert_allclose([float(it.cone_factor) for it in together], expected, rtol=0.001)
