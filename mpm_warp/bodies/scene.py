"""A scene of bodies in contact: particles of several bodies on one uniform grid.

Each body has a velocity field of its own. In every step the particles determine where two bodies
touch, and the normal. A field that is None or empty costs nothing in the run. SI units, in plane
strain per unit thickness, in axisymmetry per radian.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np

from mpm_warp.bodies.body import Body, Load, UniformGrid, critical_time_step
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats

TOUCHING = 0.9
"""Bodies overlap where particles are nearer to each other than this times their mean spacing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BodyScene(Checked):
    """Bodies on a grid, and contact between them.

    Attributes:
        grid: the background grid.
        bodies: one or more.
        contact: between two bodies; None: bodies pass through each other.

    Raises:
        SceneError: a value is not allowed, a body is not within the grid, or two overlap.

    Example:
        >>> scene = SlidingBlock().build()
        >>> [body.particle_count for body in scene.bodies], scene.contact.friction
        ([120, 240], 0.3)
    """

    grid: UniformGrid
    bodies: tuple[Body, ...]
    time_step_fraction: float = parameter(
        0.6, "time step over the critical one, the least of all bodies", above=0
    )
    contact: BodyContact | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.bodies:
            raise SceneError("bodies: there is none; give one or more")
        lower, upper = self.grid.particle_bounds
        for index, body in enumerate(self.bodies):
            outside = ~np.all((body.position >= lower) & (body.position <= upper), axis=1)
            if outside.any():
                where = np.array2string(body.position[outside][0], precision=4)
                raise SceneError(
                    f"body {index}: {outside.sum()} particles, one at {where} m, are outside the "
                    f"grid or within half a cell of its edge, which allows {lower} to {upper} m; "
                    "widen it"
                )
        if self.contact is not None and len(self.bodies) != 2:
            raise SceneError(f"contact: needs two bodies, the scene has {len(self.bodies)}")
        for (first, body), (second, other) in itertools.combinations(enumerate(self.bodies), 2):
            _check_overlap(first, body, second, other)

    @property
    def is_damped(self) -> bool:
        """Whether any body has damping."""
        return any(body.retardation_time is not None for body in self.bodies)

    @property
    def loads(self) -> tuple[tuple[slice, Load], ...]:
        """All loads, each with the particles of its body."""
        each = zip(self.particles_of_bodies, self.bodies, strict=True)
        return tuple((particles, load) for particles, body in each for load in body.loads)

    @property
    def particles_of_bodies(self) -> tuple[slice, ...]:
        """Slices of the particles of each body in arrays of all particles."""
        ends = np.cumsum([body.particle_count for body in self.bodies]).tolist()
        return tuple(slice(begin, end) for begin, end in itertools.pairwise([0, *ends]))

    @property
    def field_shape(self) -> tuple[int, int]:
        """Shape of arrays over fields: a row for each body, a column for each node."""
        return len(self.bodies), self.grid.node_count

    def critical_time_step(self, volume: Floats | None = None) -> float:
        """The least of all bodies [s], for given volumes of all particles; None: at rest."""
        least = math.inf
        for particles, body in zip(self.particles_of_bodies, self.bodies, strict=True):
            thinning = 1.0 if volume is None else float(np.max(volume[particles] / body.volume))
            of_body = critical_time_step(
                self.grid.cell_size, body.material, body.retardation_time, thinning
            )
            least = min(least, of_body)
        return least


def _check_overlap(first: int, one: Body, second: int, other: Body) -> None:
    nearest = TOUCHING * 0.5 * (one.spacing + other.spacing)
    lower, upper = other.position.min(axis=0) - nearest, other.position.max(axis=0) + nearest
    near = np.all((one.position > lower) & (one.position < upper), axis=1)
    for position in one.position[near]:
        if np.min(np.hypot(*(other.position - position).T)) < nearest:
            where = np.array2string(position, precision=4)
            raise SceneError(f"bodies {first} and {second} overlap at {where} m; move them apart")
