"""Runs that take their steps together: the same bits as alone, whoever the others are."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp import Batch, Execution, Simulation, SimulationDiverged
from mpm_warp.scenes import CatalogueScene
from mpm_warp.scenes.blocks.sliding_block import SlidingBlock
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.elastic.columns import GravityColumn

pytestmark = pytest.mark.slow

SMALL = {
    "cells_per_radius": 1,
    "domain_radius": 10,
    "domain_above": 4,
    "domain_below": 4,
    "steady_tolerance": 0,
}


def cone(**parameters: Any) -> ConePenetration:
    return ConePenetration(**SMALL, **{"penetration": 2, **parameters})


DIFFERENT: list[CatalogueScene] = [
    GravityColumn(),
    SlidingBlock(),
    cone(adhesion_factor=0.2, rigidity_index=50, friction_coefficient=0.1),
    cone(adhesion_factor=0.8, rigidity_index=300, friction_coefficient=0.2, penetration=1),
    cone(time_step_fraction=0.4, friction_coefficient=0.3, undrained_shear_strength=5e3),
    cone(particles_per_cell=9, penetration=1),
]
"""Several kinds of scenes; cones of their own materials, contact, time steps and lengths."""


def assert_same(one: xr.Dataset, other: xr.Dataset) -> None:
    for name in one.variables:
        if not str(name).endswith("_time") or name == "time_step":
            np.testing.assert_array_equal(one[name], other[name], err_msg=str(name))


@pytest.fixture(scope="module")
def alone() -> list[xr.Dataset]:
    """The results of those scenes, each run by itself."""
    return [scene.run() for scene in DIFFERENT]


@pytest.mark.parametrize("threads", [1, 2])
def test_a_batch_does_not_change_a_bit(threads: int, alone: list[xr.Dataset]) -> None:
    batch = Batch(threads=threads)
    results = batch.run([partial(scene.run, execution=batch) for scene in DIFFERENT])
    for expected, result in zip(alone, results, strict=True):
        assert_same(expected, result)


def test_one_that_diverges_does_not_disturb_the_others() -> None:
    good, bad = cone(), cone(time_step_fraction=1.2)
    results: list[xr.Dataset] = []
    errors: list[Exception] = []
    execution = Batch()

    def survive() -> None:
        results.append(good.run(execution=execution))

    def fail() -> None:
        simulation = Simulation(bad.build(), execution)
        simulation.advance(10)
        simulation.array("particle.velocity")[0] = np.nan
        try:
            simulation.advance(1000)
        except SimulationDiverged as error:
            errors.append(error)

    execution.run([fail, survive, fail])
    assert len(errors) == 2
    assert "velocity of particle 0" in str(errors[0])
    assert_same(good.run(), results[0])


def test_an_exception_gives_up_the_others() -> None:
    execution = Batch()
    cleaned: list[int] = []

    def go_on(number: int) -> Callable[[], None]:
        def run() -> None:
            try:
                cone(penetration=200).run(execution=execution)
            finally:
                cleaned.append(number)

        return run

    def fail() -> None:
        Simulation(cone().build(), execution).advance(100)
        raise KeyError("as expected")

    with pytest.raises(KeyError, match="as expected"):
        execution.run([go_on(0), fail, go_on(2)])
    assert sorted(cleaned) == [0, 2]


def test_the_time_of_others_is_idle_time() -> None:
    execution = Batch()
    begin = time.perf_counter()
    spent: list[float] = []

    def work() -> None:
        start = time.perf_counter()
        cone().run(execution=execution)
        spent.append(time.perf_counter() - start - execution.idle_time)

    execution.run([work, work, work])
    # What the three spent themselves is at most what they took together.
    assert 0 < sum(spent) <= time.perf_counter() - begin
    assert execution.case_count == 3
    assert (Execution().case_count, Execution().idle_time) == (1, 0.0)
