"""An elastic block in free flight, turning: what nothing acts on must not change."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import xarray

    from mpm_warp.bodies.planning import BodyPlan
    from mpm_warp.execution.execution import Execution
    from mpm_warp.grid.fitted import Floats
    from mpm_warp.simulation import TimeLoop

SIDE = 1.0
SHEAR_MODULUS = 1e6
POISSONS_RATIO = 0.3
DENSITY = 1000.0
DIRECTION = (0.8, 0.6)
"""Unit vector of the flight: along no line of the grid."""
TIME_STEP_FRACTION = 0.6
SAMPLE_COUNT = 100


@dataclass(frozen=True, kw_only=True)
class FlyingBlock(ReadyScene):
    """A square flies across the grid and turns about its middle; no force acts on it.

    Its linear momentum, its angular momentum and its shape stay what they were. Shape is taken
    from the distances between all of its material points.
    """

    summary: ClassVar[str] = "elastic block in free flight, turning; momentum, spin and shape stay"
    version: ClassVar[int] = 2
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="step_count",
            resolutions=(1_000_000,),
            bounds={"error": 1e-3, "momentum_error": 1e-9, "spin_error": 1e-3},
            extreme=True,
        ),
    )

    cells_per_side: int = parameter(
        4, unit="1", meaning="cells along a side of the block", minimum=2, maximum=100
    )
    step_count: int = parameter(
        10_000, unit="1", meaning="time steps of the flight", minimum=100, maximum=100_000_000
    )
    travel: float = parameter(
        10.0, unit="1", meaning="distance of the flight over side", above=0, maximum=100
    )
    rim_speed: float = parameter(
        0.01,
        unit="1",
        meaning="angular velocity times side, over the speed of shear waves",
        above=0,
        maximum=0.1,
    )

    @property
    def cell_size(self) -> float:
        """Side of a cell [m]."""
        return SIDE / self.cells_per_side

    def plan(self) -> BodyPlan:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.bodies.interface import InterfaceFrame
        from mpm_warp.bodies.planning import make_body_plan
        from mpm_warp.bodies.scene import BodyScene, UniformGrid
        from mpm_warp.materials.materials import LinearElastic

        half, cell = 0.5 * SIDE, self.cell_size
        material = LinearElastic(
            shear_modulus=SHEAR_MODULUS, poissons_ratio=POISSONS_RATIO, density=DENSITY
        )
        block = InterfaceFrame(angle=0.0).body((-half, half), (-half, half), 0.5 * cell, material)
        # The grid holds the circle through the corners, at both ends of the flight.
        reach = math.ceil(math.sqrt(0.5) * self.cells_per_side) + 2
        counts = 2 * reach + np.ceil(self.travel * self.cells_per_side * np.array(DIRECTION))
        grid = UniformGrid(
            lower=(-reach * cell, -reach * cell),
            cell_size=cell,
            cell_counts=(int(counts[0]), int(counts[1])),
        )
        return make_body_plan(
            BodyScene(grid=grid, bodies=(block,), time_step_fraction=TIME_STEP_FRACTION)
        )

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.results import cost, curves_kept, variable
        from mpm_warp.simulation import TimeLoop

        loop = TimeLoop(self.plan(), execution)
        begin = time.perf_counter()
        self._set_off(loop)
        samples = [self._sample(loop)]
        with curves_kept(lambda: _curves(samples)):
            for sample in range(1, SAMPLE_COUNT + 1):
                loop.advance(round(self.step_count * sample / SAMPLE_COUNT) - loop.step_count)
                samples.append(self._sample(loop))
                if progress is not None:
                    progress(sample / SAMPLE_COUNT)
            loop.check()
        run_time = time.perf_counter() - begin

        curves = _curves(samples)
        greatest = {
            name: variable(
                float(curves[curve].max()),
                unit="1",
                meaning=f"{curves[curve].attrs['long_name']}, at most",
            )
            for name, curve in (
                ("error", "shape_change"),
                ("momentum_error", "momentum_change"),
                ("spin_error", "spin_change"),
            )
        }
        turns = variable(
            self._angular_velocity * loop.time / (2.0 * math.pi), unit="1", meaning="turns"
        )
        return curves.assign(greatest).assign(turns=turns).assign(cost(loop, run_time=run_time))

    @property
    def _angular_velocity(self) -> float:
        return self.rim_speed * math.sqrt(SHEAR_MODULUS / DENSITY) / SIDE

    def _set_off(self, loop: TimeLoop) -> None:
        """Give the material points the velocity, and its gradient, of the flight."""
        import numpy as np

        flight = self.travel * SIDE / (self.step_count * loop.plan.time_step)
        turn = self._angular_velocity * np.array([[0.0, -1.0], [1.0, 0.0]])
        velocity = flight * np.array(DIRECTION) + loop.array("particle.position") @ turn.T
        loop.arrays["particle.velocity"].assign(velocity)
        loop.arrays["particle.affine"].assign(np.broadcast_to(turn, (len(velocity), 2, 2)))

    def _sample(self, loop: TimeLoop) -> tuple[Floats, float, Floats]:
        """Linear momentum, angular momentum about the middle, distances of all from all."""
        import numpy as np

        mass, affine = loop.array("particle.mass"), loop.array("particle.affine")
        position, velocity = loop.array("particle.position"), loop.array("particle.velocity")
        momentum = mass @ velocity
        arm = position - mass @ position / mass.sum()
        orbital = arm[:, 0] * velocity[:, 1] - arm[:, 1] * velocity[:, 0]
        # A point's own: that of its affine velocity, with the inertia m h^2 / 4 along each axis.
        own = 0.25 * self.cell_size**2 * (affine[:, 1, 0] - affine[:, 0, 1])
        distance = np.linalg.norm(position[:, None] - position, axis=-1)
        return momentum, float(mass @ (orbital + own)), distance


def _curves(samples: list[tuple[Floats, float, Floats]]) -> xarray.Dataset:
    """Changes since the first of the samples, see `FlyingBlock._sample`."""
    import numpy as np
    import xarray as xr

    from mpm_warp.results import variable

    momentum, spin, distance = (np.array(values) for values in zip(*samples, strict=True))
    curves = {
        "shape_change": (
            np.abs(distance - distance[0]).max(axis=(1, 2)) / distance[0].max(),
            "greatest change of a distance in the block, over its diagonal",
        ),
        "momentum_change": (
            np.linalg.norm(momentum - momentum[0], axis=1) / np.linalg.norm(momentum[0]),
            "change of linear momentum",
        ),
        "spin_change": (
            np.abs(spin / spin[0] - 1.0),
            "change of angular momentum about the middle",
        ),
    }
    variables = {
        name: variable(values[1:], unit="1", meaning=meaning, dims=("progress",))
        for name, (values, meaning) in curves.items()
    }
    fraction = np.arange(1, len(samples)) / SAMPLE_COUNT
    axis = variable(fraction, unit="1", meaning="time over duration", dims=("progress",))
    return xr.Dataset(variables, coords={"progress": axis})
