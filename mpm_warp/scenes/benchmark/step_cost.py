"""What a step costs: the speed of the simulator itself, by size, physics and threads."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.benchmark.clocks import ClockedExecution
from mpm_warp.benchmark.speed import LEAST_STEPS, Companion, Run, StageTimes, ThreadGain
from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.batch import Batch
from mpm_warp.execution.execution import Execution
from mpm_warp.materials.linear_elastic import LinearElastic
from mpm_warp.parameters import parameter, redefined
from mpm_warp.results import variable
from mpm_warp.sampling import cost, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import CatalogueScene, Progress
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetration import PenetrationCurves
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.simulation import Simulation

BLOCK = 10_000
"""Material points after which the random stresses are the same again."""


@dataclass(frozen=True, kw_only=True)
class StepCost(CatalogueScene):
    """The scene of a cone penetration at a size, or less of its physics, timed warm.

    The soil starts with random stresses about its strength, so that much of it yields. All results
    are measurements: they are never the same twice.
    """

    summary: ClassVar[str] = "speed of the simulator: particle updates per second, by stage"
    version: ClassVar[int] = 6
    runs_alone: ClassVar[bool] = True

    size: int = parameter(
        5000, unit="1", meaning="material points, about", minimum=500, maximum=10_000_000
    )
    physics: str = parameter(
        "cone",
        unit="1",
        meaning="all of a cone penetration, or soil alone: plastic (Tresca), or elastic",
        choices=("cone", "plastic", "elastic"),
    )
    threads: int = parameter(1, unit="1", meaning="threads of the processor", choices=THREAD_COUNTS)
    cases: int = parameter(
        1, unit="1", meaning="cases that are computed together", minimum=1, maximum=10_000
    )
    precision: str = redefined(ConePenetration, "precision")
    samples: int = parameter(7, unit="1", meaning="timed samples", minimum=1, maximum=1000)
    sample_time: float = parameter(
        0.3, unit="s", meaning="time of a sample, about", above=0, maximum=100
    )

    def cone(self) -> ConePenetration:
        """The cone penetration of the size, or of the nearest found that grids can have."""
        cells_per_radius = 2.0
        for _ in range(4):
            cone = ConePenetration(
                cells_per_radius=cells_per_radius, precision=self.precision, approach=0.0
            )
            count = cone.run_size().cell_count * cone.particles_per_cell
            finer = cells_per_radius * math.sqrt(self.size / count)
            cells_per_radius = min(max(1.0, finer), 100.0)
        return cone

    def run_size(self) -> RunSize:
        """Of all cases that are computed together, and those that the threads are compared with."""
        one = self.cone().run_size()
        count = self.cases + (self.threads if self.cases == 1 else 0)
        return RunSize(cell_count=count * one.cell_count, particle_count=count * one.particle_count)

    def build(self) -> Scene:
        """The scene of the cone penetration, or its soil alone."""
        scene = self.cone().build()
        if self.physics == "cone":
            return scene
        soil = dataclasses.replace(
            scene,
            bulk_viscosity=None,
            surroundings=None,
            contact=None,
            window=None,
            conservative_interpolation=False,
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

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """Time the steps of a case, or of several together.

        Args:
            progress: receives the fraction done after each sample.
            execution: the device alone is taken from it; the threads are those of the scene.
        """
        device = "cpu" if execution is None else execution.device
        if self.cases == 1:
            can_be_clocked = device == "cpu" and self.threads == 1
            kind = ClockedExecution if can_be_clocked else Execution
            return self._measured(kind(device, self.threads), progress)
        batch, results = Batch(device, self.threads), list[xr.Dataset]()

        def lead() -> None:
            results.append(self._measured(batch, progress))

        def accompany() -> None:
            case = self._stirred(Simulation(self.build(), batch))
            while not results:
                case.take(LEAST_STEPS)

        batch.run([lead] + [accompany] * (self.cases - 1))
        return results[0]

    def _measured(self, execution: Execution, progress: Progress) -> xr.Dataset:
        """The speed of a case, or of all that go along with it step by step."""
        simulation = Simulation(self.build(), execution)
        companion = self._companion(simulation, execution)
        progress(0.0)
        run = self._stirred(simulation)
        step_count = run.steps_within(self.sample_time)
        samples = []
        for number in range(self.samples):
            companion.before_sample()
            samples.append(run.sample(step_count))
            companion.after_sample(samples[-1])
            progress((number + 1) / self.samples)
        simulation.check()
        rates = [self.cases * it.rate for it in samples]
        byte_count = sum(array.byte_count for array in simulation.plan.arrays.values())
        result = xr.Dataset(
            {
                "update_rate": variable(
                    float(np.median(rates)),
                    unit="s-1",
                    meaning="particle updates per second",
                    description="of all cases together; median of the samples",
                    role="headline",
                ),
                "update_rate_lowest": variable(
                    min(rates),
                    unit="s-1",
                    meaning="least particle updates per second",
                    role="measured",
                ),
                "update_rate_highest": variable(
                    max(rates),
                    unit="s-1",
                    meaning="most particle updates per second",
                    role="measured",
                ),
                "array_bytes": variable(
                    byte_count / simulation.plan.particle_count,
                    unit="byte",
                    meaning="arrays on the device per material point",
                ),
                **cost(simulation),
            }
        )
        return result.merge(companion.dataset())

    def _companion(self, simulation: Simulation, execution: Execution) -> Companion:
        """What is measured after each sample, by how the case is computed."""
        if isinstance(execution, ClockedExecution):
            return StageTimes(simulation, execution)
        if self.cases > 1 or execution.device != "cpu":
            return Companion()
        runs = [self._stirred(Simulation(self.build(), Execution())) for _ in range(self.threads)]
        for run in runs:
            run.take(LEAST_STEPS)  # warm
        return ThreadGain(runs)

    def _stirred(self, simulation: Simulation) -> Run:
        """Give the soil its stresses and the window its speed."""
        scene = soil_scene(simulation)
        strength = 0.01 * scene.material.shear_modulus
        block = np.random.default_rng(0).uniform(-strength, strength, (BLOCK, 4))
        stress = simulation.arrays["particle.stress"]
        for first in range(0, len(stress), BLOCK):
            part = stress[first : min(first + BLOCK, len(stress))]
            part.assign(block[: len(part)])
        if scene.window is None:
            return Run(simulation, simulation.advance)
        window = scene.window
        simulation.assign("window.motion", np.array([window.ramp_time, window.speed, 0.0]))
        per_step = window.speed * simulation.plan.time_step
        cone = self.cone()
        curves = PenetrationCurves(
            simulation,
            radius=cone.cone_radius,
            unsteady=math.inf,  # as for all but the last radii of a test
            tolerance=cone.steady_tolerance,
        )

        def take(count: int) -> None:
            distance = simulation.travel + (count - 0.5) * per_step
            while curves.next_distance <= distance:
                simulation.travel_to(curves.next_distance)
                curves.sample()
                curves.is_steady()
            simulation.travel_to(distance)

        return Run(simulation, take)
