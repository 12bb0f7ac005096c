"""From a run to its dataset: samplers record the run at the moments of a schedule."""

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
"""Description of the excess pore pressure in results."""


class Sampler(Protocol):
    """Records some quantities of a run."""

    def sample(self) -> None:
        """Record the present state of the run."""

    def dataset(self) -> xr.Dataset:
        """The records so far, as curves or scalars."""


class Samples:
    """Samples a row of numbers each time; `curves` makes a dataset of the columns.

    Example:
        >>> simulation = Simulation(GravityColumn(cell_count=2).build())
        >>> times = Samples(
        ...     lambda: [simulation.time],
        ...     lambda time: curves("sample", (np.arange(len(time)), "1", ""), at=(time, "s", "")),
        ... )
        >>> times.sample()
        >>> times.dataset()["at"].values
        array([0.])
    """

    def __init__(
        self, take: Callable[[], Sequence[float] | None], curves: Callable[..., xr.Dataset]
    ) -> None:
        self._take = take
        self._curves = curves
        self._rows: list[Sequence[float]] = []

    def sample(self) -> None:
        """Add a row, if there is one."""
        if (row := self._take()) is not None:
            self._rows.append(row)

    def dataset(self) -> xr.Dataset:
        """The curves; no variables without samples."""
        return self._curves(*np.array(self._rows).T) if self._rows else xr.Dataset()


def follow(
    simulation: Simulation,
    moments: Sequence[float],
    reach: Callable[[float], None],
    samplers: Sequence[Sampler],
    progress: Callable[[float], None] | None = None,
    is_over: Callable[[], bool] | None = None,
) -> xr.Dataset:
    """Run a simulation to a sequence of moments and sample it at each.

    Args:
        simulation: the run.
        moments: arguments of `reach` in the order of time: times, steps or travels.
        reach: advances the simulation to a moment.
        samplers: each takes a sample at every moment. A step may pass several moments, so the
            simulation may not have moved since the last sample.
        progress: receives the fraction done, at last 1.
        is_over: called after every sample: whether the run may end; default: at the last moment.

    Returns:
        The records of the samplers, and the cost of the run.

    Raises:
        SimulationDiverged: the run became unstable; `curves` has the records up to then.

    Example:
        >>> simulation = Simulation(GravityColumn(cell_count=2).build())
        >>> cost = follow(simulation, [5, 10], simulation.advance_to_step, [])
        >>> int(cost.step_count)
        10
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
    """This number of moments at equal distances, the last at the end."""
    return [end * number / count for number in range(1, count + 1)]


def even_steps(step_count: int) -> list[int]:
    """Up to 20 steps at about equal distances, up to the last, at which a run reports progress."""
    steps = np.linspace(0, step_count, 21).round().astype(int)
    even: list[int] = np.unique(steps)[1:].tolist()
    return even


def soil_scene(simulation: Simulation) -> Scene:
    """The scene of a simulation of soil in a grid; else `TypeError`."""
    if not isinstance(simulation.scene, Scene):
        raise TypeError(f"a {type(simulation.scene).__name__} is not soil in a grid")
    return simulation.scene


def built_of(simulation: Simulation) -> Mapping[str, xr.Variable]:
    """Names of the law and the contact as built, which parameters may not tell; else nothing."""
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
    """Time and work of a simulation so far."""
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
    """Mean forces of the soil at the nodes of a contact since they were last taken, or made.

    Each of several in one run has means of its own.

    Raises:
        SceneError: the scene has no contact.

    Example:
        >>> simulation = Simulation(StripFooting(cells_per_radius=2).build())
        >>> forces = ContactForces(simulation)
        >>> simulation.advance(10)
        >>> forces.take().shape  # of the normal and the tangential force [N]
        (3, 2)
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        soil_scene(simulation)[SurfaceContact]  # it has one
        self._begin(simulation.array("contact.impulse").copy())

    def _begin(self, impulse: Floats) -> None:
        self._impulse = impulse
        self._taken_at = self._simulation.time

    def take(self) -> Floats:
        """Normal and tangential force per radian [N], shape [contact node_count, 2].

        Raises:
            ValueError: no time has passed since they were last taken, so there is no mean.
        """
        simulation = self._simulation
        if simulation.time == self._taken_at:
            raise ValueError(
                f"contact forces: taken at t = {self._taken_at:.4g} s already; take steps before"
            )
        impulse = simulation.array("contact.impulse").copy()
        forces: Floats = (impulse - self._impulse) / (simulation.time - self._taken_at)
        self._begin(impulse)
        return forces


def transferred_energy(simulation: Simulation) -> float:
    """Change of the kinetic energy by the transfers per radian, < 0 if dissipated [J].

    It is estimated from the audited steps; `KeyError` if the scene has no energy audit.
    """
    return AUDIT_INTERVAL * float(simulation.array("transfer.energy").sum())


def excess_pore_pressure(simulation: Simulation) -> Floats:
    """Excess pore pressure in the cells [Pa], compression positive, shape [cell_count].

    In a law with effective stress it is the mean over the points of a cell, NaN without points.
    Otherwise it is the change of mean total stress by the last step, because the effective mean
    stress of an elastic, perfectly plastic undrained clay does not change.
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
    """Means of values over the points of each cell by mass, NaN without points, [cell_count]."""
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
