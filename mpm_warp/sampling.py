"""Stand-in until the merge: samplers, and the loop that calls them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol

import xarray as xr

from mpm_warp.results import cost
from mpm_warp.simulation import Simulation
from mpm_warp.watch.health import SimulationDiverged


class Sampler(Protocol):
    """Takes down a run."""

    def sample(self) -> None:
        """Take down the run as it is now."""

    def dataset(self) -> xr.Dataset:
        """The curves so far."""


def follow(
    simulation: Simulation,
    moments: Sequence[float],
    reach: Callable[[float], None],
    samplers: Sequence[Sampler],
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Reach each moment and sample."""
    begin = time.perf_counter()
    try:
        for number, moment in enumerate(moments, start=1):
            reach(moment)
            for sampler in samplers:
                sampler.sample()
            if progress is not None:
                progress(number / len(moments))
        simulation.check()
    except SimulationDiverged as error:
        error.history = xr.merge([sampler.dataset() for sampler in samplers])
        raise
    run_time = time.perf_counter() - begin
    curves = xr.merge([sampler.dataset() for sampler in samplers])
    return curves.assign(cost(simulation, run_time=run_time))
