"""A run of a scene: its arrays on a device, and the time loop."""

from __future__ import annotations

import time

import numpy as np
import warp as wp

from mpm_warp.grids import Floats
from mpm_warp.health import check_inside, check_particles
from mpm_warp.plan import Launch, Plan, StepPlan
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene

CHECK_INTERVAL = 250
"""Steps between two checks of the particles."""


class TimeLoop:
    """The state of a run of a plan, and the ways to advance it.

    Attributes:
        plan: its arrays and launches.
        arrays: the arrays on the device, by the names of the plan.
        step_count: steps taken.
        particle_updates: particles times steps.
        setup_time: wall-clock time to fill the arrays [s].
        compile_time: wall-clock time to compile its kernels or to load them from the cache [s].
    """

    def __init__(self, plan: StepPlan, *, device: str = "cpu") -> None:
        """Fill the arrays of the plan on `device` and compile its kernels."""
        self.plan = plan
        self.step_count = 0
        self.particle_updates = 0
        self._healthy_step = 0
        self._device = wp.get_device(device)

        start = time.perf_counter()
        self.arrays = {name: array.allocate(device) for name, array in self.plan.arrays.items()}
        self.setup_time = time.perf_counter() - start

        start = time.perf_counter()
        modules = [launch.kernel.module for launch in self.plan.launches]
        wp.force_load(self._device, modules=modules)
        # Recorded once: replaying a step costs no Python beyond one call.
        with wp.ScopedCapture(device=self._device) as capture:
            for launch in self.plan.step:
                self.launch(launch)
        self._step = capture.graph
        self.compile_time = time.perf_counter() - start

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.step_count * self.plan.time_step

    @property
    def particle_count(self) -> int:
        """Number of particles in the grid now."""
        return self.plan.particle_count

    def array(self, name: str) -> np.ndarray:
        """An array of the plan on the host: the device's own memory where they share it."""
        values: np.ndarray = self.arrays[name].numpy()
        return values

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan."""
        arguments = [
            self.arrays[item] if isinstance(item, str) else item for item in launch.arguments
        ]
        wp.launch(launch.kernel, launch.dim, arguments, device=self._device)

    def advance(self, step_count: int) -> None:
        """Take steps.

        Raises:
            SimulationDiverged: noticed by the watch, which looks every `CHECK_INTERVAL` steps.
        """
        last = self.step_count + step_count
        while self.step_count < last:
            next_check = self._healthy_step + CHECK_INTERVAL
            block = min(last, next_check) - self.step_count
            for _ in range(block):
                wp.capture_launch(self._step)
            self.step_count += block
            self.particle_updates += block * self.particle_count
            if self.step_count == next_check:
                self.check()

    def check(self) -> None:
        """Check the particles.

        Raises:
            SimulationDiverged: see `mpm_warp.health.check_particles`.
            ParticleOutside: see `mpm_warp.health.check_inside`.
        """
        check_particles(
            position=self.array("particle.position"),
            velocity=self.array("particle.velocity"),
            stress=self.array("particle.stress"),
            speed_limit=self.plan.speed_limit,
            step=self.step_count,
            healthy_step=self._healthy_step,
            time=self.time,
        )
        if self.plan.particle_bounds is not None:
            check_inside(
                position=self.array("particle.position"),
                bounds=self.plan.particle_bounds,
                step=self.step_count,
                time=self.time,
            )
        self._healthy_step = self.step_count


class Simulation(TimeLoop):
    """A run of a scene of soil that fills its grid.

    Attributes:
        scene: what is run.
    """

    def __init__(self, scene: Scene, *, device: str = "cpu") -> None:
        """Plan the scene, fill its arrays on `device` and compile its kernels."""
        start = time.perf_counter()
        plan = make_plan(scene)
        planning_time = time.perf_counter() - start
        super().__init__(plan, device=device)
        self.plan: Plan = plan
        self.scene = scene
        self.setup_time += planning_time
        self._forces_taken_at = 0.0

    @property
    def particle_count(self) -> int:
        """Number of particles in the grid now."""
        places = self.plan.arrays["particle.mass"].shape[0]
        return places if self.scene.window is None else places - int(self.array("free.count")[0])

    def take_contact_forces(self) -> Floats:
        """Mean forces of the soil at the contact nodes since they were last taken.

        Returns:
            Normal and tangential force per radian [N], shape [contact node_count, 2].
        """
        forces: Floats = self.array("contact.impulse") / (self.time - self._forces_taken_at)
        self.arrays["contact.impulse"].zero_()
        self._forces_taken_at = self.time
        return forces
