"""A run of a scene: its arrays on a device, and the time loop."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.execution.execution import Execution
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.watch.health import (
    Fault,
    SimulationDiverged,
    check_particles,
    check_time_step,
    check_yield,
)
from mpm_warp.execution.host_arrays import HostArrays
from mpm_warp.execution.next_step import AUDIT_INTERVAL
from mpm_warp.materials.materials import PerfectlyPlastic
from mpm_warp.plan.plan import Launch, Plan, StepPlan
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.scene import Scene
from mpm_warp.watch.soil import SoilWatch

LOOKED_AT_ONCE = 4_000
"""Particles that the watch looks at together; the memory of more would be fetched each time."""
CHECK_INTERVAL = 500
"""Steps between two looks of the watch."""


class TimeLoop:
    """The state of a run of a plan, and the ways to advance it.

    Attributes:
        plan: its arrays and launches.
        arrays: the arrays on the device, by the names of the plan.
        step_count: steps taken.
        particle_count: particles in the grid at the last look of the watch.
        particle_updates: particles times steps.
        setup_time: wall-clock time to fill the arrays [s].
        compile_time: wall-clock time to compile its kernels or to load them from the cache [s].
    """

    def __init__(self, plan: StepPlan, execution: Execution | None = None) -> None:
        """Fill the arrays of the plan, which is for this run alone, and compile its kernels."""
        execution = execution or Execution()
        self.plan = plan
        self.step_count = 0
        self.particle_count = plan.particle_count
        self.particle_updates = 0
        self._healthy_step = 0
        self._changed_step, self._changed_time = 0, 0.0
        self._execution = execution

        start = time.perf_counter()
        self.arrays = {
            name: array.allocate(execution.device) for name, array in plan.arrays.items()
        }
        self._on_host = HostArrays(self.arrays)
        self.setup_time = time.perf_counter() - start

        start = time.perf_counter()
        self._steps = execution.steps(plan, self.arrays)
        self.compile_time = time.perf_counter() - start

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        steps = self.step_count - self._changed_step
        return self._changed_time + steps * self.plan.time_step

    def array(self, name: str) -> np.ndarray:
        """An array of the plan on the host: the device's own memory where they share it."""
        return self._on_host(name)

    def assign(self, name: str, values: Floats | Integers | float) -> None:
        """Give an array of the plan other values, or one value everywhere."""
        self._on_host.assign(name, values)

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan."""
        self._steps.launch(launch)

    def advance(self, step_count: int) -> None:
        """Take steps.

        Raises:
            SimulationDiverged: noticed by the watch, which looks every `CHECK_INTERVAL` steps.
        """
        last = self.step_count + step_count
        while self.step_count < last:
            next_check = self._healthy_step + CHECK_INTERVAL
            is_watched = self.step_count == next_check - 1
            if is_watched:
                self._prepare_look()
            block = 1 if is_watched else min(last, next_check - 1) - self.step_count
            steps = range(self.step_count, self.step_count + block)
            self._steps.play(steps, self._execution.threads)
            self.step_count += block
            self.particle_updates += block * self.particle_count
            if is_watched:
                self.check()

    def advance_to(self, time: float) -> None:
        """Take steps until a simulated time [s], to the nearest, whatever becomes of the time step.

        Raises:
            SimulationDiverged: see `advance`.
        """
        while (left := self._steps_until(time)) > 0:
            self.advance(min(left, self._healthy_step + CHECK_INTERVAL - self.step_count))

    def advance_to_step(self, number: float) -> None:
        """Take steps until so many have been taken."""
        self.advance(int(number) - self.step_count)

    def _steps_until(self, time: float) -> int:
        since_change = round((time - self._changed_time) / self.plan.time_step)
        return self._changed_step + since_change - self.step_count

    def check(self) -> None:
        """Look whether the run is sound, and whether its time step is still the right one.

        Raises:
            SimulationDiverged: it is not; the message names what, where, when and what may help.
        """
        control, time_step = self.plan.control, self.plan.time_step
        try:
            self._look(self._present())
            if control is not None:
                time_step = control.following(time_step, self._on_host)
        except Fault as fault:
            raise SimulationDiverged(
                f"{fault}, at step {self.step_count}, t = {self.time:.4g} s; healthy at step "
                f"{self._healthy_step}; {self.plan.remedy}"
            ) from None
        self._healthy_step = self.step_count
        if control is not None and time_step != self.plan.time_step:
            self._go_on_with(control.replan(time_step))

    def _go_on_with(self, changed: StepPlan) -> None:
        """Take the launches of a plan of the same run with another time step."""
        self._changed_step, self._changed_time = self.step_count, self.time
        self.plan.time_step = changed.time_step
        self.plan.step, self.plan.audited_step = changed.step, changed.audited_step
        self._steps = self._execution.steps(self.plan, self.arrays)

    def _prepare_look(self) -> None:
        """Note what is to be seen before the last step that a look is at."""

    def _look(self, present: Integers) -> None:
        """Look whether the particles in these places are sound."""
        check_time_step(time_step=self.plan.time_step, longest=self.plan.longest_time_step)
        names = ("position", "velocity", "stress", "mass")
        particles = {name: self.array(f"particle.{name}") for name in names}
        self.particle_count = len(present)
        for first in range(0, len(present), LOOKED_AT_ONCE):
            part = present[first : first + LOOKED_AT_ONCE]
            self._look_at(part, {name: it.take(part, axis=0) for name, it in particles.items()})

    def _look_at(self, number: Integers, particles: dict[str, Floats]) -> None:
        check_particles(
            number=number,
            **particles,
            speed_limit=self.plan.speed_limit,
            bounds=self.plan.particle_bounds,
        )

    def _present(self) -> Integers:
        """The places of particles that are in the grid."""
        return np.arange(self.plan.particle_count, dtype=np.int32)


class Simulation(TimeLoop):
    """A run of a scene of soil that fills its grid.

    Attributes:
        scene: what is run.
    """

    def __init__(self, scene: Any, execution: Execution | None = None) -> None:
        """Plan the scene, fill its arrays and compile its kernels."""
        execution = execution or Execution()
        start = time.perf_counter()
        on_gpu = wp.get_device(execution.device).is_cuda
        plan = make_plan(scene, share_count=1 if on_gpu else SHARE_COUNT)
        planning_time = time.perf_counter() - start
        super().__init__(plan, execution)
        self.plan: Plan = plan
        self.scene: Any = scene
        self.setup_time += planning_time
        self._forces_taken_at = 0.0
        soil = isinstance(scene, Scene)
        self._watch = SoilWatch(plan, self._on_host, self._present()) if soil else None

    def _prepare_look(self) -> None:
        if self._watch is not None:
            self._watch.prepare(self._present())

    def _look(self, present: Integers) -> None:
        super()._look(present)
        if self._watch is not None:
            self._watch.look(present)

    def _look_at(self, number: Integers, particles: dict[str, Floats]) -> None:
        super()._look_at(number, particles)
        if isinstance(getattr(self.scene, "material", None), PerfectlyPlastic):
            check_yield(
                number=number,
                position=particles["position"],
                stress=particles["stress"],
                material=self.scene.material,
            )

    def _present(self) -> Integers:
        if getattr(self.scene, "window", None) is None:
            return super()._present()
        places = np.flatnonzero(self.array("particle.cell")[:, 0] >= 0)
        return places.astype(np.int32)

    @property
    def transfer_energy(self) -> float:
        """What the transfers have added to the kinetic energy per radian, dissipated if < 0 [J].

        A sample of the steps.

        Raises:
            KeyError: the scene has no energy audit.
        """
        return AUDIT_INTERVAL * float(self.array("transfer.energy").sum())

    def take_contact_forces(self) -> Floats:
        """Mean forces of the soil at the contact nodes since they were last taken.

        Returns:
            Normal and tangential force per radian [N], shape [contact node_count, 2].
        """
        forces: Floats = self.array("contact.impulse") / (self.time - self._forces_taken_at)
        self.assign("contact.impulse", 0.0)
        self._forces_taken_at = self.time
        return forces
