"""What a step costs: the speed of the simulator itself, by size, physics and threads."""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene
from mpm_warp.scenes.cone_penetration import ConePenetration

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    import xarray

    from mpm_warp.execution import Execution
    from mpm_warp.scene import Scene
    from mpm_warp.simulation import Simulation
    from mpm_warp.timing import StepTimes

LEAST_STEPS = 16
"""Steps of a sample, at least."""
BLOCK = 10_000
"""Material points after which the random stresses are the same again."""


@dataclass(frozen=True, kw_only=True)
class StepCost(ReadyScene):
    """The scene of a cone penetration at a size, or less of its physics, timed warm.

    The soil starts with random stresses about its strength, so that much of it yields. All results
    are measurements: they are never the same twice.
    """

    summary: ClassVar[str] = "speed of the simulator: particle updates per second, by stage"
    version: ClassVar[int] = 3
    headline: ClassVar[str] = "update_rate"

    size: int = parameter(
        5000, unit="1", meaning="material points, about", minimum=500, maximum=10_000_000
    )
    physics: str = parameter(
        "cone",
        unit="1",
        meaning="all of a cone penetration, or soil alone: plastic (Tresca), or elastic",
        choices=("cone", "plastic", "elastic"),
    )
    threads: int = parameter(1, unit="1", meaning="threads of the processor", choices=(1, 2, 4))
    cases: int = parameter(
        1, unit="1", meaning="cases that are computed together", minimum=1, maximum=10_000
    )
    precision: str = parameter(
        "float64",
        unit="1",
        meaning="floating point numbers of the simulation",
        choices=("float64", "float32"),
    )
    samples: int = parameter(7, unit="1", meaning="timed samples", minimum=1, maximum=1000)
    sample_time: float = parameter(
        0.3, unit="s", meaning="least time of a sample", above=0, maximum=100
    )

    def cone(self) -> ConePenetration:
        """The cone penetration of the size, or of the nearest found that grids can have."""
        cells_per_radius = 2.0
        for _ in range(4):
            cone = ConePenetration(
                cells_per_radius=cells_per_radius, precision=self.precision, approach=0.0
            )
            scene = cone.build()[0]
            count = scene.grid.cell_count * scene.particles_per_side**2
            cells_per_radius = max(1.0, cells_per_radius * math.sqrt(self.size / count))
        return cone

    def build(self) -> Scene:
        """The scene."""
        from mpm_warp.materials import LinearElastic

        scene = self.cone().build()[0]
        if self.physics == "cone":
            return scene
        soil = dataclasses.replace(
            scene,
            bulk_viscosity=None,
            far_field=None,
            contact=None,
            window=None,
            even_flow=False,
            energy_audit=False,
        )
        if self.physics == "plastic":
            return soil
        material = LinearElastic(
            shear_modulus=soil.material.shear_modulus,
            poissons_ratio=soil.material.poissons_ratio,
            density=soil.material.density,
        )
        return dataclasses.replace(soil, material=material)

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`; the threads are those of the scene."""
        from mpm_warp.batch import Batch
        from mpm_warp.execution import Execution
        from mpm_warp.simulation import Simulation

        device = "cpu" if execution is None else execution.device
        if self.cases == 1:
            return self._measured(Execution(device, self.threads), progress)
        batch, results = Batch(device, self.threads), list["xarray.Dataset"]()

        def lead() -> None:
            results.append(self._measured(batch, progress))

        def accompany() -> None:
            take = self._stirred(Simulation(self.build(), batch))
            while not results:
                take(LEAST_STEPS)

        batch.run([lead] + [accompany] * (self.cases - 1))
        return results[0]

    def _measured(self, execution: Execution, progress: Progress | None) -> xarray.Dataset:
        """The speed of a case, or of all that go along with it step by step."""
        import numpy as np
        import xarray as xr

        from mpm_warp.history import cost, variable
        from mpm_warp.simulation import Simulation
        from mpm_warp.timing import StageClock

        simulation = Simulation(self.build(), execution)
        can_be_clocked = execution.device == "cpu" and self.threads == self.cases == 1
        clock = StageClock(simulation) if can_be_clocked else None
        take = self._stirred(simulation)
        begun = time.perf_counter()
        take(LEAST_STEPS)  # warm
        first = _timed(simulation, take, LEAST_STEPS)
        step_count = max(LEAST_STEPS, math.ceil(LEAST_STEPS * self.sample_time / first.seconds))
        samples, clocked = [], []
        for number in range(self.samples):
            samples.append(_timed(simulation, take, step_count))
            if clock is not None:
                clocked.append(clock.time_steps(LEAST_STEPS))
            if progress is not None:
                progress((number + 1) / self.samples)
        simulation.check()
        rates = [self.cases * sample.updates / sample.seconds for sample in samples]
        byte_count = sum(array.byte_count for array in simulation.plan.arrays.values())
        result = xr.Dataset(
            {
                "update_rate": variable(
                    float(np.median(rates)),
                    unit="s-1",
                    meaning="particle updates per second",
                    description="of all cases together; median of the samples",
                ),
                "update_rate_lowest": variable(
                    min(rates), unit="s-1", meaning="least particle updates per second"
                ),
                "update_rate_highest": variable(
                    max(rates), unit="s-1", meaning="most particle updates per second"
                ),
                "array_bytes": variable(
                    byte_count / simulation.plan.particle_count,
                    unit="byte",
                    meaning="arrays on the device per material point",
                ),
                **cost(simulation, run_time=time.perf_counter() - begun),
            }
        )
        if clock is None:
            return result
        outside = [
            1.0 - times.kernels * sample.steps / sample.thread_seconds
            for times, sample in zip(clocked, samples, strict=True)
        ]
        return result.merge(_stages(simulation, clocked)).assign(
            {
                "overhead_share": variable(
                    float(np.median(outside)),
                    unit="1",
                    meaning="share of the processor's time outside the kernels of the steps",
                    description="launches, Python, watch, audit, history and soil that enters: all "
                    "but what the kernels take, by a clock between them after each sample; median",
                ),
            }
        )

    def _stirred(self, simulation: Simulation) -> Callable[[int], None]:
        """Give the soil its stresses and the window its speed; returns what takes steps."""
        import numpy as np

        from mpm_warp.penetration import Penetration
        from mpm_warp.travel import Travel

        scene = simulation.scene
        strength = 0.01 * scene.material.shear_modulus
        block = np.random.default_rng(0).uniform(-strength, strength, (BLOCK, 4))
        stress = simulation.arrays["particle.stress"]
        for first in range(0, len(stress), BLOCK):
            part = stress[first : min(first + BLOCK, len(stress))]
            part.assign(block[: len(part)])
        if scene.window is None:
            return simulation.advance
        window, travel = scene.window, Travel(simulation)
        simulation.arrays["window.motion"].assign([window.ramp_time, window.speed, 0.0])
        per_step = window.speed * simulation.plan.time_step
        cone = self.cone()
        penetration = Penetration(
            surface=cone.build()[1],
            greatest=math.inf,
            unsteady=0.0,
            tolerance=cone.steady_tolerance,
        )

        def take(count: int) -> None:
            penetration.push_to(travel.distance + (count - 0.5) * per_step, travel, simulation)

        return take


@dataclass(frozen=True)
class _Sample:
    """Steps that were taken together.

    Attributes:
        steps: their number.
        updates: particle updates.
        seconds: wall-clock time [s].
        thread_seconds: time of the processor for this thread [s].
    """

    steps: int
    updates: int
    seconds: float
    thread_seconds: float


def _timed(simulation: Simulation, take: Callable[[int], None], count: int) -> _Sample:
    """About `count` steps."""
    steps, updates = simulation.step_count, simulation.particle_updates
    start, thread_start = time.perf_counter(), time.thread_time()
    take(count)
    simulation.array("particle.mass")  # waits for a GPU
    return _Sample(
        steps=simulation.step_count - steps,
        updates=simulation.particle_updates - updates,
        seconds=time.perf_counter() - start,
        thread_seconds=time.thread_time() - thread_start,
    )


def _stages(simulation: Simulation, clocked: Sequence[StepTimes]) -> xarray.Dataset:
    """Time and work of each stage, on one thread, and what the machine gives to bare loops."""
    import numpy as np
    import xarray as xr

    from mpm_warp.counting import stage_work
    from mpm_warp.history import variable
    from mpm_warp.timing import yardsticks

    work, machine = stage_work(simulation), yardsticks()
    count = simulation.particle_count
    spent = {name: float(np.median([it.stages[name] for it in clocked])) for name in work}

    def by_stage(values: Iterable[float], unit: str, meaning: str) -> xr.Variable:
        per_point = np.array(list(values)) / count
        return variable(
            per_point, unit=unit, meaning=f"{meaning} per material point", dims=("stage",)
        )

    return xr.Dataset(
        {
            "stage_time": by_stage((1e9 * it for it in spent.values()), "ns", "time of a stage"),
            "stage_bytes": by_stage(
                (it.traffic for it in work.values()), "byte", "bytes that a stage reads and writes"
            ),
            "stage_operations": by_stage(
                (it.operations for it in work.values()), "1", "floating point operations of a stage"
            ),
            "stage_divisions": by_stage(
                (it.divisions for it in work.values()), "1", "divisions and roots of a stage"
            ),
            "streaming_rate": variable(
                machine.streaming, unit="byte s-1", meaning="memory traffic of a bare loop"
            ),
            "arithmetic_rate": variable(
                machine.arithmetic, unit="s-1", meaning="operations per second of a bare loop"
            ),
            "division_rate": variable(
                machine.division, unit="s-1", meaning="divisions per second of a bare loop"
            ),
        },
        coords={"stage": list(work)},
    )
