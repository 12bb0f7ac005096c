"""A run of a scene: its arrays on a device, and the time loop."""

import time
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.errors import Fault, SimulationDiverged
from mpm_warp.execution.execution import Execution
from mpm_warp.execution.replay import DeviceRun
from mpm_warp.execution.threads import in_turn
from mpm_warp.fields.checks import Range, check_kind, check_number, check_whole
from mpm_warp.jupyter import html_table
from mpm_warp.parts.inflow import Inflow
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.scene import BetweenSteps, Scene
from mpm_warp.watch import make_watch

STEP_COUNTS = Range(minimum=0, maximum=10**12)
"""Allowed numbers of steps in one call; the greatest would take a small run days."""
CHECK_INTERVAL = 500
"""Steps between two checks of the watch."""
NOTHING_TRAVELS = "has no window: nothing travels"


class Simulation:
    """The state of a run and the methods that advance it; soil enters by itself.

    Args:
        scene: soil in a grid, or any other kind of scene that `make_plan` can plan.
        execution: device and number of threads; default: one thread of the processor.

    Attributes:
        scene: the scene that is run.
        step_count: steps taken.
        particle_updates: particles times steps.
        setup_time: wall-clock time to plan the run and to fill its arrays [s].
        compile_time: wall-clock time to compile kernels or to load them from the cache [s].

    Raises:
        SimulationDiverged: from every method that takes steps. The watch checks the run every
            `CHECK_INTERVAL` steps; the message says what is wrong, where, when and what may help.
        WindowOverfull: likewise: more soil has stayed in the window than it has slots for.

    Example:
        >>> simulation = Simulation(GravityColumn(cell_count=2).build())
        >>> simulation.advance(10)
        >>> simulation.step_count, simulation.array("particle.stress").shape
        (10, (8, 4))
    """

    @in_turn
    def __init__(self, scene: object, execution: Execution | None = None) -> None:
        check_kind("execution", execution, (Execution, type(None)))
        execution = execution or Execution()
        start = time.perf_counter()
        on_gpu = wp.get_device(execution.device).is_cuda
        self._share_count = 1 if on_gpu else SHARE_COUNT
        plan = make_plan(scene, share_count=self._share_count)
        self._execution, self._run = execution, DeviceRun(plan, execution.device)
        self.scene = scene
        self.compile_time = self._run.compile_time
        self.setup_time = time.perf_counter() - start - self.compile_time
        self.step_count = 0
        self.particle_updates = 0
        self._first_step_at: float | None = None
        self._is_interrupted = False  # within steps, as by Ctrl-C: arrays may be of several times
        self._healthy_step = 0
        self._changed_step, self._changed_time = 0, 0.0
        # These hold the run, not this object: so the arrays are freed when the run is over.
        self._watch = make_watch(scene, self._run)
        self._between_steps: list[BetweenSteps] = []
        if isinstance(scene, Scene):
            actors = [part.between_steps(self._run, scene) for part in scene.parts]
            self._between_steps += [actor for actor in actors if actor is not None]

    def __repr__(self) -> str:
        texts = ", ".join(f"{name} {value}" for name, value in self._shown())
        return f"Simulation({texts})"

    def _repr_html_(self) -> str:
        return html_table("Simulation", self._shown())

    def _shown(self) -> list[tuple[str, str]]:
        """Names and values that tell of the size of the run, and how far it is."""
        byte_count = sum(array.byte_count for array in self.plan.arrays.values())
        return [
            ("scene", type(self.scene).__name__),
            ("material points", f"{self.particle_count:,}"),
            ("memory", f"{byte_count / 1e6:.3g} MB"),
            ("step", f"{self.step_count:,}"),
            ("time", f"{self.time:.4g} s"),
        ]

    @property
    def plan(self) -> Plan:
        """Arrays and launches of the run."""
        return self._run.plan

    @property
    def arrays(self) -> dict[str, Any]:
        """The arrays on the device, by name."""
        return self._run.arrays

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        steps = self.step_count - self._changed_step
        return self._changed_time + steps * self.plan.time_step

    @property
    def run_time(self) -> float:
        """Wall-clock time since the start of the first step [s]; 0 before."""
        return 0.0 if self._first_step_at is None else time.perf_counter() - self._first_step_at

    @property
    def travel(self) -> float:
        """Distance that the window has moved down [m]; `ValueError` without a window."""
        if "window.motion" not in self.plan.arrays:
            raise ValueError(f"the scene {NOTHING_TRAVELS}")
        return float(self._run.array("window.motion")[2])

    @property
    def particle_count(self) -> int:
        """Particles in the grid at the last check of the watch."""
        return self._watch.particle_count

    def array(self, name: str) -> NDArray[Any]:
        """An array of the plan on the host; on a processor it is the array of the run itself.

        Values written to it are not checked: an index out of range, as in "particle.cell", ends the
        process. `assign` checks.

        Raises:
            KeyError: there is no array of that name; the message names the nearest.
        """
        self.plan.check_known(name)
        return self._run.array(name)

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Set the values of an array of the plan, or one value everywhere.

        Raises:
            KeyError: there is no array of that name; the message names the nearest.
            ValueError: the values are of another shape or type, not finite, or indices that are out
                of range.
        """
        self.plan.check_known(name)
        self.plan.arrays[name].check(name, values)
        self._run.assign(name, values)

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan; that the launch is of this plan is not checked."""
        check_kind("launch", launch, Launch)
        self._run.launch(launch)

    def advance(self, step_count: int) -> None:
        """Take steps.

        Raises:
            ValueError: `step_count` is not an integer of 0 to 10**12.
            RuntimeError: steps were interrupted before, as by Ctrl-C.
        """
        check_whole("step_count", step_count, STEP_COUNTS, error=ValueError)
        if self._is_interrupted:
            raise RuntimeError("the run was interrupted in its steps and cannot go on: begin anew")
        if self._first_step_at is None:
            self._first_step_at = time.perf_counter()
        last = self.step_count + step_count
        while self.step_count < last:
            next_check = self._healthy_step + CHECK_INTERVAL
            is_watched = self.step_count == next_check - 1
            if is_watched:
                self._watch.prepare()
            block = 1 if is_watched else min(last, next_check - 1) - self.step_count
            block = min([block, *(actor.steps_ahead for actor in self._between_steps)])
            self._is_interrupted = True
            try:
                self._take(block, is_watched=is_watched)
            except SimulationDiverged:
                self._is_interrupted = False
                raise
            self._is_interrupted = False

    def _take(self, block: int, *, is_watched: bool) -> None:
        steps = range(self.step_count, self.step_count + block)
        self._run.replay(steps, self._execution.threads)
        self.step_count += block
        self.particle_updates += block * self.particle_count
        if is_watched:
            self.check()
        for actor in self._between_steps:
            actor.act()

    def advance_to_step(self, step: float) -> None:
        """Take steps up to this number since the start; `ValueError` if it is not finite."""
        check_number("step", step, error=ValueError)
        self.advance(max(0, int(step) - self.step_count))

    def advance_to(self, time: float) -> None:
        """Take steps to the one nearest to a simulated time [s]; the time step may change.

        Raises:
            ValueError: `time` is not finite.
        """
        check_number("time", time, unit="s", error=ValueError)
        while True:
            since_change = round((time - self._changed_time) / self.plan.time_step)
            left = self._changed_step + since_change - self.step_count
            if left <= 0:
                return
            check_number("time: steps until then", left, STEP_COUNTS, error=ValueError)
            self.advance(min(left, self._healthy_step + CHECK_INTERVAL - self.step_count))

    def travel_to(self, travel: float) -> None:
        """Take steps until the window has this travel [m].

        Raises:
            ValueError: `travel` is not finite, or the scene has no window or a cyclic one.
        """
        check_number("travel", travel, unit="m", error=ValueError)
        inflow = next((actor for actor in self._between_steps if isinstance(actor, Inflow)), None)
        if inflow is None:
            travels = "window.motion" in self.plan.arrays
            why = "has a window that turns: advance to a time" if travels else NOTHING_TRAVELS
            raise ValueError(f"the scene {why}")
        while inflow.travel < travel:
            self.advance(inflow.steps_to(travel))

    def check(self) -> None:
        """Check that the run is sound, and adapt the time step where it may change.

        Raises:
            SimulationDiverged: the run is not sound; the message says what, where and when.
        """
        control, time_step = self.plan.control, self.plan.time_step
        try:
            self._watch.look()
            if control is not None:
                time_step = control.following(time_step, self._run.array)
        except Fault as fault:
            raise SimulationDiverged(
                f"{fault}, at step {self.step_count}, t = {self.time:.4g} s; healthy at step "
                f"{self._healthy_step}; {self.plan.remedy}"
            ) from None
        self._healthy_step = self.step_count
        if control is not None and time_step != self.plan.time_step:
            self._changed_step, self._changed_time = self.step_count, self.time
            self._run.change_time_step(make_plan(self.scene, self._share_count, time_step))
