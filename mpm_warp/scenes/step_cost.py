"""The speed of the simulator, by size, physics and threads."""

import dataclasses
import math
import time
from dataclasses import dataclass

import numpy as np
import warp as wp
import xarray as xr

from mpm_warp.errors import SceneError
from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.declaration import parameter
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.window import Window
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.results import labelled
from mpm_warp.sampling import cost, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.simulation import Simulation

RANDOM_COUNT = 10_000
"""Number of random stresses, which repeat over the material points."""
LEAST_STEPS = 16
"""Least number of steps of a sample."""
CLOCKED_STEPS = 51
"""Steps whose stages are timed."""
REACH = 16
"""Most items of an array that one thread of a launch looks at: nodes, or points of its cell."""
WARM_FRACTION = 0.5
"""Least duration of the warm-up over that of a sample."""


def sample(simulation: Simulation, step_count: int) -> tuple[float, float]:
    """Take steps; return the wall-clock time [s] and the particle updates per second."""
    updates = simulation.particle_updates
    start = time.perf_counter()
    simulation.advance(step_count)
    wp.synchronize()
    seconds = time.perf_counter() - start
    return seconds, (simulation.particle_updates - updates) / seconds


def steps_within(simulation: Simulation, seconds: float) -> int:
    """Warm the run up; return the number of steps that take about `seconds`."""
    count, taken = LEAST_STEPS // 2, 0.0
    # The first steps load kernels and record launches, so only many give the time of one.
    while taken < WARM_FRACTION * seconds:
        count *= 2
        taken, _ = sample(simulation, count)
    return max(LEAST_STEPS, math.ceil(count * seconds / taken))


def stage_times(simulation: Simulation, step_count: int) -> dict[str, float]:
    """Median time of each launch of a step, by the name of its kernel [s].

    The host waits for each launch, so each time is that of one thread or of a whole GPU, and has
    some microseconds of the launch in it. The simulation does not count these steps.
    """
    step = simulation.plan.step
    seconds = np.zeros((step_count, len(step)))
    for number, place in np.ndindex(seconds.shape):
        start = time.perf_counter()
        simulation.launch(step[place])
        wp.synchronize()
        seconds[number, place] = time.perf_counter() - start
    medians = np.median(seconds, axis=0).tolist()
    return {launch.name: taken for launch, taken in zip(step, medians, strict=True)}


def stage_bytes(plan: Plan) -> dict[str, float]:
    """Bytes of the arrays that each launch of a step reads or writes, by the name of its kernel.

    Each item counts once, as if a cache held all that is used again: the least traffic there is.
    """

    def touched(name: str, launch: Launch) -> float:
        array = plan.arrays[name]
        return array.byte_count * min(1.0, REACH * launch.item_count / math.prod(array.shape))

    return {
        launch.name: sum(touched(name, launch) for name in set(launch.arrays))
        for launch in plan.step
    }


def copy_rate(byte_count: int, device: wp.Device) -> float:
    """Bytes read and written per second where a device copies half of `byte_count` to the other.

    On a processor one thread copies. It is the most that memory, or a cache of that size, gives.
    """
    source, target = (wp.zeros(byte_count // 2, dtype=wp.uint8, device=device) for _ in range(2))
    seconds = []
    for _ in range(CLOCKED_STEPS):
        start = time.perf_counter()
        wp.copy(target, source)
        wp.synchronize()
        seconds.append(time.perf_counter() - start)
    return byte_count / float(np.median(seconds))


@dataclass(frozen=True, kw_only=True)
class StepCost(CatalogueScene):
    """Timed steps of a cone penetration of any size, or of its soil only.

    The soil starts with random stresses of the order of its strength, so that much of it yields.
    All results are measurements and differ from run to run.

    Example:
        >>> StepCost(size=1000).build().grid.cell_count
        297
    """

    summary = "speed of the simulator: particle updates per second, by stage"
    version = 11
    runs_alone = True

    size: int = parameter(5000, "material points, about", minimum=500, maximum=10_000_000)
    physics: str = parameter(
        "cone",
        "all of a cone penetration, or soil only: plastic (Tresca), or elastic",
        choices=("cone", "plastic", "elastic"),
    )
    threads: int = parameter(1, "threads of the processor", choices=THREAD_COUNTS)
    samples: int = parameter(7, "timed samples", minimum=1, maximum=1000)
    sample_time: float = parameter(0.3, "time of a sample, about", unit="s", above=0, maximum=100)

    def cone(self) -> ConePenetration:
        """A cone penetration of about the size."""
        cells_per_radius = 2.0
        for _ in range(4):
            cone = ConePenetration(cells_per_radius=cells_per_radius, approach=0.0)
            count = cone.run_size().cell_count * cone.resolution.particles_per_cell
            cells_per_radius = min(max(1.0, cells_per_radius * math.sqrt(self.size / count)), 100.0)
        return cone

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; several threads are compared with a second run on one thread."""
        one = self.cone().run_size()
        count = 2 if self.threads > 1 else 1
        return RunSize(cell_count=count * one.cell_count, particle_count=count * one.particle_count)

    def build(self) -> Scene:
        """The scene of the cone penetration, or its soil only."""
        scene = self.cone().build()
        if self.physics == "cone":
            return scene
        soil = dataclasses.replace(scene, bulk_viscosity=None, parts=(scene[Fixed],))
        if self.physics == "plastic":
            return soil
        shared = (own.name for own in dataclasses.fields(LinearElastic))
        elastic = LinearElastic(**{name: getattr(soil.material, name) for name in shared})
        return dataclasses.replace(soil, material=elastic)

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """Time the steps on the device of the execution, with the threads of the case."""
        device = "cpu" if execution is None else execution.device
        if device != "cpu" and self.threads > 1:
            raise SceneError(f"threads = {self.threads} must be 1 on a GPU")
        simulation = self._with_random_stress(Execution(device, self.threads))
        return self.record(simulation, progress)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Measure the speed, and with several threads the gain over one thread."""
        # The speed of a machine changes from second to second. So each sample is followed by one on
        # one thread, with which it is compared.
        single = self._with_random_stress(Execution()) if self.threads > 1 else None
        progress(0.0)
        step_count = steps_within(simulation, self.sample_time)
        if single is not None:
            single.advance(LEAST_STEPS)  # warm
        rates, gains = [], []
        for number in range(self.samples):
            _, rate = sample(simulation, step_count)
            rates.append(rate)
            if single is not None:
                gains.append(rate / sample(single, step_count)[1])
            progress((number + 1) / self.samples)
        simulation.check()
        per_second = "particle updates per second"
        of_samples = "median of the samples"
        byte_count = sum(array.byte_count for array in simulation.plan.arrays.values())
        per_point = byte_count / simulation.plan.particle_count
        result = labelled(
            role="headline", update_rate=(float(np.median(rates)), "s-1", per_second, of_samples)
        )
        result |= labelled(
            role="measured",
            update_rate_lowest=(min(rates), "s-1", f"least {per_second}"),
            update_rate_highest=(max(rates), "s-1", f"most {per_second}"),
        )
        in_arrays = (per_point, "byte", "arrays on the device per material point")
        result |= labelled(array_bytes=in_arrays) | cost(simulation)
        if gains:
            how = "median over the samples, each compared with one on one thread right after it"
            gain = float(np.median(gains)), "1", "times as fast as on one thread", how
            result |= labelled(thread_gain=gain)
        else:
            times = stage_times(simulation, CLOCKED_STEPS)
            result["stage"] = xr.Variable("stage", list(times))
            moved = stage_bytes(simulation.plan)
            count = simulation.particle_count
            result |= labelled(
                dims=("stage",),
                stage_time=(
                    1e9 * np.array(list(times.values())) / count,
                    "ns",
                    "time of a stage per material point",
                ),
                stage_bytes=(
                    np.array([moved[name] for name in times]) / count,
                    "byte",
                    "arrays of a stage per material point",
                ),
            )
            rate = copy_rate(byte_count, simulation.arrays["particle.stress"].device)
            copied = "bytes read and written per second by a copy of that size"
            result |= labelled(role="measured", copy_rate=(rate, "byte s-1", copied))
        return xr.Dataset(result)

    def _with_random_stress(self, execution: Execution) -> Simulation:
        """A run that starts with random stresses in the soil, and the window at its full speed."""
        simulation = Simulation(self.build(), execution)
        scene = soil_scene(simulation)
        strength = 0.01 * scene.material.ground_shear_modulus
        random = np.random.default_rng(0).uniform(-strength, strength, (RANDOM_COUNT, 4))
        stress = simulation.arrays["particle.stress"]
        for first in range(0, len(stress), RANDOM_COUNT):
            part = stress[first : min(first + RANDOM_COUNT, len(stress))]
            part.assign(random[: len(part)])
        if (window := scene.find(Window)) is not None:
            simulation.assign("window.motion", np.array([window.ramp_time, window.speed, 0.0]))
        return simulation
