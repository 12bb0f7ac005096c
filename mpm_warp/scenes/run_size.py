"""Size of a run, from its parameters, before anything large is allocated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Grid
from mpm_warp.materials.material import Material
from mpm_warp.parts.window import MovingGrid
from mpm_warp.scene import Scene
from mpm_warp.simulation import STEP_COUNTS

CELL_BYTES, POLAR_BYTES = 664.0, 104.0
"""Memory of a cell with its nodes [byte], including 40 numbers of partial sums and 48 bytes of the
watch; memory of the further integrals of a polar grid."""
POINT_BYTES, NUMBER_BYTES = 104.0, 8.0
"""Memory of the slot of a point, with 24 bytes of the watch, and of each further number of its law
[byte]. Set-up needs less at a time."""


@dataclass(frozen=True, kw_only=True)
class RunSize:
    """Approximate cells, material points and steps of a run, and their memory.

    Attributes:
        cell_count: cells of the grid.
        particle_count: slots of material points, those for points that enter included.
        step_count: time steps; 0 where it is not known beforehand.
        bytes_per_cell, bytes_per_particle: memory of a cell and of a slot [byte].
        curve_bytes: memory of samples, curves and their comparison [byte].

    Raises:
        SceneError: the steps are more than can be counted.

    Example:
        >>> size = ConePenetration().run_size()
        >>> size.cell_count, size.particle_count, round(size.byte_count / 1e6, 1)
        (1826, 8400, 2.8)
    """

    cell_count: int
    particle_count: int
    step_count: float = 0.0
    bytes_per_cell: float = CELL_BYTES
    bytes_per_particle: float = POINT_BYTES
    curve_bytes: float = 0.0

    def __post_init__(self) -> None:
        if not STEP_COUNTS.holds(self.step_count, self.step_count):
            raise SceneError(
                f"needs {self.step_count:.3g} time steps, where at most {STEP_COUNTS.maximum:.0e} "
                "can be counted: try a longer time step, a higher speed, or a shorter run"
            )

    @property
    def byte_count(self) -> float:
        """Memory of a run [byte], beyond that of a process that has loaded the package.

        `python -m studies.laboratory.memory` compares it with the memory of random cases.
        """
        in_grid = self.cell_count * self.bytes_per_cell
        return in_grid + self.particle_count * self.bytes_per_particle + self.curve_bytes

    @property
    def particle_updates(self) -> float:
        """Material points times steps."""
        return self.particle_count * self.step_count


def size_in_grid(scene: Scene, duration: float) -> RunSize:
    """The size of a run of soil in a grid for a duration [s]; all cells may hold soil."""
    grid, window = scene.grid, scene.find(MovingGrid)
    slots, wave_speed = 1.0, scene.material.pressure_wave_speed
    if window is not None:
        slots += window.spare_fraction_in(grid)
        wave_speed += window.first_speed
    time_step = scene.time_step_fraction * shortest_crossing(grid) / wave_speed
    polar = POLAR_BYTES if grid.polar else 0.0
    return RunSize(
        cell_count=grid.cell_count,
        particle_count=round(grid.cell_count * scene.particles_per_side**2 * slots),
        step_count=duration / time_step,
        bytes_per_cell=CELL_BYTES + polar + sum(part.cell_bytes for part in scene.parts),
        bytes_per_particle=POINT_BYTES
        + law_bytes(scene.material)
        + sum(part.point_bytes for part in scene.parts),
    )


def law_bytes(material: Material) -> float:
    """Memory of the state of a point, and of properties that vary in the ground [byte]."""
    varying = 0 if material.variation is None else len(material.properties) + 1
    return NUMBER_BYTES * (len(material.state) + varying)


size_of_body = partial(RunSize, bytes_per_cell=53.0, bytes_per_particle=260.0)
size_of_bodies = partial(RunSize, bytes_per_cell=210.0, bytes_per_particle=260.0)
"""The size of a run of one body, and of bodies in contact.

The memory is from peaks of up to 7 million cells and 114,000 points.
"""


def of_several(sizes: Sequence[RunSize]) -> RunSize:
    """The size of consecutive runs: the largest, with its steps increased to the work of all."""
    largest = max(sizes, key=lambda size: size.byte_count)
    updates = sum(size.particle_updates for size in sizes)
    return replace(largest, step_count=updates / largest.particle_count)


def shortest_crossing(grid: Grid) -> float:
    """Length that a wave crosses in the critical time step [m].

    The cells at the inner surface determine it: they are the narrowest and the most oblique of
    their rows. So the others need not be built.
    """
    if grid.column_count == 1:
        return float(grid.cell_lengths.min())
    inner = replace(grid, columns=np.array([0.0, grid.columns[1], 1.0]))
    return float(inner.cell_lengths[::2].min())
