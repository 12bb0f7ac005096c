"""From a run to its dataset: samplers record what they watch, at the moments of a schedule."""

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np
import xarray as xr

from mpm_warp.errors import SimulationDiverged
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import PORE_PRESSURE, built_name
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.results import labelled, variable
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

PORE_PRESSURE_IS = (
    "of the law, or change of mean total stress: an elastic, perfectly plastic undrained clay has "
    "no other part"
)
"""What the excess pore pressure of results is."""


class Sampler(Protocol):
    """Records what it watches of a run."""

    def sample(self) -> None:
        """Record the run as it is now."""

    def dataset(self) -> xr.Dataset:
        """What has been recorded so far, as curves or scalars."""


class Samples:
    """Samples numbers of a run, a row each time; `curves` makes a dataset of their columns."""

    def __init__(
        self, take: Callable[[], Sequence[float] | None], curves: Callable[..., xr.Dataset]
    ) -> None:
        self._take = take
        self._curves = curves
        self._rows: list[Sequence[float]] = []

    def sample(self) -> None:
        """Take the numbers, if there are any."""
        if (row := self._take()) is not None:
            self._rows.append(row)

    def dataset(self) -> xr.Dataset:
        """The curves; no variables where there is no sample."""
        return self._curves(*np.array(self._rows).T) if self._rows else xr.Dataset()


def follow(
    simulation: Simulation,
    moments: Sequence[float],
    reach: Callable[[float], None],
    samplers: Sequence[Sampler],
    progress: Callable[[float], None] | None = None,
    is_over: Callable[[], bool] | None = None,
) -> xr.Dataset:
    """Run a simulation through some moments, and sample it at each.

    Args:
        simulation: the run.
        moments: in the order of time, as `reach` takes them: times, steps or travels.
        reach: advances the simulation to a moment.
        samplers: each takes a sample at every moment. A step may go past several moments, so that
            the simulation may not have moved since the sample before.
        progress: receives the fraction done, at last 1.
        is_over: asked after every sample whether the run may end there; never by default.

    Returns:
        What the samplers have recorded, and what the run has cost.

    Raises:
        SimulationDiverged: the run became unstable; its `curves` are those up to there.
    """
    try:
        for count, moment in enumerate(moments, start=1):
            reach(moment)
            for sampler in samplers:
                sampler.sample()
            if progress is not None and count < len(moments):
                progress(count / len(moments))
            if is_over is not None and is_over():
                break
        simulation.check()
    except SimulationDiverged as error:
        error.curves = _merged(samplers)
        raise
    result = _merged(samplers).assign(cost(simulation)).assign(built_of(simulation))
    if progress is not None:
        progress(1.0)
    return result


def evenly(end: float, count: int) -> list[float]:
    """So many moments at even distances, the last of them at the end."""
    return [end * number / count for number in range(1, count + 1)]


def even_steps(step_count: int) -> list[int]:
    """Steps at even distances, up to the last, at which a run of so many reports progress: 20."""
    steps = np.linspace(0, step_count, 21).round().astype(int)
    even: list[int] = np.unique(steps)[1:].tolist()
    return even


def soil_scene(simulation: Simulation) -> Scene:
    """What is run, where it is soil in a grid; else `TypeError`."""
    if not isinstance(simulation.scene, Scene):
        raise TypeError(f"a {type(simulation.scene).__name__} is not soil in a grid")
    return simulation.scene


def built_of(simulation: Simulation) -> Mapping[str, xr.Variable]:
    """What law the soil of a simulation has, and what contact; nothing where there is no soil.

    Whatever the parameters of a scene are called: a scene derived from another may build another.
    """
    if not isinstance(simulation.scene, Scene):
        return {}
    built = {"law": simulation.scene.material, "contact": simulation.scene.find(SurfaceContact)}
    return {
        f"built_{name}": variable(
            built_name(value), unit=None, meaning=f"{name} as built", role="built"
        )
        for name, value in built.items()
        if value is not None
    }


def cost(simulation: Simulation) -> dict[str, xr.Variable]:
    """Time and work of a simulation from its first step until now."""
    return labelled(
        role="measured",
        run_time=(simulation.run_time, "s", "wall-clock time of the time loop"),
        setup_time=(simulation.setup_time, "s", "wall-clock time to set up"),
        compile_time=(simulation.compile_time, "s", "wall-clock time to compile or load kernels"),
    ) | labelled(
        time_step=(simulation.plan.time_step, "s", "time step, the last one"),
        step_count=(simulation.step_count, "1", "time steps"),
        particle_count=(simulation.plan.particle_count, "1", "material points at the start"),
        particle_updates=(simulation.particle_updates, "1", "material points times steps"),
    )


class ContactForces:
    """The forces of the soil at the nodes of a scene's contact, mean values since the last ones."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._taken_at = simulation.time

    def take(self) -> Floats:
        """Normal and tangential force per radian [N], shape [contact node_count, 2].

        Raises:
            ValueError: no time has passed since they were taken before, so there is no mean.
        """
        simulation = self._simulation
        if simulation.time == self._taken_at:
            raise ValueError(
                f"contact forces: taken at t = {self._taken_at:.4g} s already; take steps before"
            )
        forces: Floats = simulation.array("contact.impulse") / (simulation.time - self._taken_at)
        simulation.assign("contact.impulse", 0.0)
        self._taken_at = simulation.time
        return forces


def transferred_energy(simulation: Simulation) -> float:
    """What the transfers have added to the kinetic energy per radian, dissipated if < 0 [J].

    Estimated from the steps that were audited.

    Raises:
        KeyError: the scene has no energy audit.
    """
    return AUDIT_INTERVAL * float(simulation.array("transfer.energy").sum())


def excess_pore_pressure(simulation: Simulation) -> Floats:
    """Excess pore pressure in the cells of a scene [Pa], compression positive, shape [cell_count].

    Of a law with effective stress it is the mean of the points in a cell, not a number where it has
    none. Otherwise it is the change of mean total stress, here in the last step: the effective mean
    stress of an elastic, perfectly plastic undrained clay stays.
    """
    scene = soil_scene(simulation)
    names = scene.material.state
    if PORE_PRESSURE in names:
        of_points = simulation.array("particle.state")[:, names.index(PORE_PRESSURE)]
        return mean_of_points(simulation, of_points)
    travel = simulation.travel if scene.find(MovingGrid) else 0.0
    middle = scene.grid.node_positions[scene.grid.cell_nodes].mean(axis=1)
    before = scene.stress_at_rest_at(middle - np.array([0.0, travel]))
    change = simulation.array("cell.stress") - before
    pressure: Floats = -change[:, [0, 1, 3]].mean(axis=1)
    return pressure


def mean_of_points(simulation: Simulation, values: Floats) -> Floats:
    """Means of values of all slots by mass in each cell, not a number where none, [cell_count]."""
    grid = soil_scene(simulation).grid
    cell = simulation.array("particle.cell")
    present = cell[:, 0] >= 0
    number = cell[present] @ np.array([1, grid.column_count])
    mass = simulation.array("particle.mass")[present]
    count = grid.cell_count
    in_cells = np.bincount(number, mass, count)
    sums = np.bincount(number, mass * values[present], count)
    mean: Floats = np.divide(sums, in_cells, out=np.full(count, np.nan), where=in_cells > 0.0)
    return mean


def _merged(samplers: Sequence[Sampler]) -> xr.Dataset:
    return xr.merge([sampler.dataset() for sampler in samplers])
