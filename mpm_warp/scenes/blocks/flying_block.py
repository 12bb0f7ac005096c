"""An elastic block that flies and turns without forces; momentum, spin and shape must stay."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.bodies.body import InterfaceFrame, UniformGrid
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import Samples, evenly, follow
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.limits import LARGEST_LACK, Limit, limited
from mpm_warp.scenes.run_size import RunSize, size_of_body
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

SIDE = 1.0
SHEAR_MODULUS = 1e6
POISSONS_RATIO = 0.3
DENSITY = 1000.0
DIRECTION = (0.8, 0.6)
"""Direction of the flight, oblique to the grid."""
TIME_STEP_FRACTION = 0.6
SAMPLE_COUNT = 100
SHAPE_SIDE = 8
"""Side of the lattice of reference points, in points. The distances of all points from these define
the shape. The default block has as many points; in a large one all distances would take longer than
the flight."""


@dataclass(frozen=True, kw_only=True)
class FlyingBlock(CatalogueScene):
    """A square that flies across the grid and turns about its centre; no force acts on it.

    Example:
        >>> FlyingBlock(cells_per_side=2).run_size().particle_count
        16
    """

    summary = "elastic block in free flight, turning; momentum, spin and shape stay"
    version = 3
    verifications = compared(
        "step_count", (1_000_000,), error=1e-3, momentum_error=1e-9, spin_error=1e-3, extreme=True
    )
    limits = limited(error="a lower rim_speed") | {
        name: Limit(LARGEST_LACK, "more step_count") for name in ("momentum_error", "spin_error")
    }

    cells_per_side: int = parameter(4, "cells along a side of the block", minimum=2, maximum=100)
    step_count: int = parameter(
        10_000, "time steps of the flight", minimum=100, maximum=100_000_000
    )
    travel: float = parameter(10.0, "distance of the flight over side", above=0, maximum=100)
    rim_speed: float = parameter(
        0.01, "angular velocity times side, over the speed of shear waves", above=0, maximum=0.1
    )

    def run_size(self) -> RunSize:
        """See `CatalogueScene`."""
        columns, rows = self.build().grid.cell_counts
        count = 4 * self.cells_per_side**2
        return size_of_body(
            cell_count=columns * rows,
            particle_count=count,
            step_count=self.step_count,
            # Distances from the lattice: the initial ones, and three copies of the present along
            # both axes.
            curve_bytes=7.0 * 8.0 * count * min(count, SHAPE_SIDE**2),
        )

    def build(self) -> BodyScene:
        """The block, in a grid that contains the circle around it at both ends of the flight."""
        half, cell = 0.5 * SIDE, SIDE / self.cells_per_side
        material = LinearElastic(
            shear_modulus=SHEAR_MODULUS, poissons_ratio=POISSONS_RATIO, density=DENSITY
        )
        block = InterfaceFrame(angle=0.0).body((-half, half), (-half, half), 0.5 * cell, material)
        reach = math.ceil(math.sqrt(0.5) * self.cells_per_side) + 2  # cells to beyond a corner
        flight = np.ceil(self.travel * self.cells_per_side * np.array(DIRECTION))
        columns, rows = (2 * reach + flight).astype(int).tolist()
        lower = (-reach * cell, -reach * cell)
        grid = UniformGrid(lower=lower, cell_size=cell, cell_counts=(columns, rows))
        return BodyScene(grid=grid, bodies=(block,), time_step_fraction=TIME_STEP_FRACTION)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Give the points their velocity and its gradient, and let the block fly."""
        flight = self.travel * SIDE / (self.step_count * simulation.plan.time_step)
        angular_velocity = self.rim_speed * math.sqrt(SHEAR_MODULUS / DENSITY) / SIDE
        turn = angular_velocity * np.array([[0.0, -1.0], [1.0, 0.0]])
        velocity = flight * np.array(DIRECTION) + simulation.array("particle.position") @ turn.T
        simulation.assign("particle.velocity", velocity)
        simulation.assign("particle.affine", np.broadcast_to(turn, (len(velocity), 2, 2)))
        sampler = free_flight(simulation, SIDE / self.cells_per_side)
        steps = [round(step) for step in evenly(self.step_count, SAMPLE_COUNT)]
        recorded = follow(simulation, steps, simulation.advance_to_step, [sampler], progress)
        shape, momentum, spin = (
            (float(recorded[curve].max()), "1", f"{recorded[curve].attrs['long_name']}, at most")
            for curve in ("shape_change", "momentum_change", "spin_change")
        )
        turns = angular_velocity * simulation.time / (2.0 * math.pi)
        return recorded.assign(
            labelled(role="headline", error=shape)
            | labelled(role="error", momentum_error=momentum, spin_error=spin)
            | labelled(turns=(turns, "1", "turns"))
        )


def free_flight(simulation: Simulation, cell_size: float) -> Samples:
    """Samples the changes of shape, momentum and spin of a square body since this call."""
    side = math.isqrt(simulation.plan.particle_count)
    step = math.ceil(side / SHAPE_SIDE)
    lattice = np.arange(side**2).reshape(side, side)[::step, ::step].ravel()

    def state() -> tuple[Floats, Floats, float]:
        """Distances from the lattice, linear momentum, angular momentum about the centre."""
        array = simulation.array
        mass, affine = array("particle.mass"), array("particle.affine")
        position, velocity = array("particle.position"), array("particle.velocity")
        arm = position - mass @ position / mass.sum()
        orbital = arm[:, 0] * velocity[:, 1] - arm[:, 1] * velocity[:, 0]
        # The affine velocity of a point has the inertia m h^2 / 4 along each axis.
        own = 0.25 * cell_size**2 * (affine[:, 1, 0] - affine[:, 0, 1])
        distance = np.linalg.norm(position[:, None] - position[lattice], axis=-1)
        return distance, mass @ velocity, float(mass @ (orbital + own))

    first_distance, first_momentum, first_spin = state()

    def changes() -> tuple[float, float, float]:
        distance, momentum, spin = state()
        return (
            np.abs(distance - first_distance).max() / first_distance.max(),
            np.linalg.norm([momentum - first_momentum], axis=1)[0] / np.linalg.norm(first_momentum),
            abs(spin / first_spin - 1.0),
        )

    def over_time(shape: Floats, momentum: Floats, spin: Floats) -> xr.Dataset:
        of_shape = "greatest change of a distance in the block, over the greatest"
        return curves(
            "progress",
            (np.arange(1, len(shape) + 1) / SAMPLE_COUNT, "1", "time over duration"),
            shape_change=(shape, "1", of_shape),
            momentum_change=(momentum, "1", "change of linear momentum"),
            spin_change=(spin, "1", "change of angular momentum about the middle"),
        )

    return Samples(changes, over_time)
