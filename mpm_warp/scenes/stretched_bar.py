"""A bar drawn out to many times its length, at a stress that has a closed form."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
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

LENGTH = 1.0
"""Length of the bar before it is drawn [m]; it is a cell thick."""
YOUNGS_MODULUS = 2e6
DENSITY = 1000.0
POINTS_PER_CELL = 2
"""Material points per cell along and across, at the end: further apart they would be no bar."""
SLOWNESS = 6.0
"""Retardation time over that in which a wave runs along the bar that has been drawn out."""
DURATION = 2.0
"""Duration over retardation time."""
SAMPLE_COUNT = 100


@dataclass(frozen=True, kw_only=True)
class StretchedBar(ReadyScene):
    """A bar of Poisson's ratio 0 is drawn by forces F on its ends, which rise steadily to F_1.

    With the stretch l the rate of strain is the rate of ln l. Nothing turns, so the Jaumann rate of
    the elastic stress s is its rate, s = E ln l; the section A stays; with the retardation time tau
    F / A = s + tau ds/dt. At the time t of the duration T then

        ln l = F_1 / (E A T) (t - tau (1 - exp(-t / tau))).

    The bar is slow for the sake of its law: beyond the tension 2 G, l = e, an elastic stress by the
    Jaumann rate has no stiffness left against shear along the bar. What then grows by itself grows
    by e in the time tau / (ln l - 1) at the fastest.
    """

    summary: ClassVar[str] = "viscoelastic bar drawn out many times its length; closed form"
    version: ClassVar[int] = 3
    method: ClassVar[tuple[str, ...]] = ("cell_count",)
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cell_count",
            resolutions=(4,),
            bounds={"error": 0.01, "stress_error": 0.01},
            settings={"stretch": 20.0},
            extreme=True,
        ),
    )

    stretch: float = parameter(
        4.0, unit="1", meaning="length at the end over that at rest", above=1, maximum=50
    )
    cell_count: int = parameter(
        4, unit="1", meaning="cells along the bar at rest", minimum=2, maximum=20
    )

    @property
    def cell_size(self) -> float:
        """Side of a cell, the thickness of the bar [m]."""
        return LENGTH / self.cell_count

    @property
    def retardation_time(self) -> float:
        """The time tau [s]."""
        # The modulus stays as the density falls: the wave becomes faster.
        wave_speed = math.sqrt(YOUNGS_MODULUS * self.stretch / DENSITY)
        return SLOWNESS * self.stretch * LENGTH / wave_speed

    @property
    def duration(self) -> float:
        """Time in which the forces rise [s]."""
        return DURATION * self.retardation_time

    def stretch_at(self, time: Floats) -> Floats:
        """The closed form; 0 <= time [s] <= duration."""
        import numpy as np

        def growth(since: Floats | float) -> Floats:
            tau = self.retardation_time
            grown: Floats = since - tau * (1.0 - np.exp(-np.asarray(since) / tau))
            return grown

        stretch: Floats = self.stretch ** (growth(time) / growth(self.duration))
        return stretch

    def plan(self) -> BodyPlan:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.bodies.planning import make_body_plan
        from mpm_warp.bodies.scene import Body, BodyScene, Load, UniformGrid
        from mpm_warp.materials.materials import LinearElastic

        cell = self.cell_size
        along, across = np.meshgrid(self._places, cell * _middles(POINTS_PER_CELL))
        position = np.stack([along.ravel(), across.ravel()], axis=-1)
        growth = DURATION - 1.0 + math.exp(-DURATION)
        force = YOUNGS_MODULUS * cell * math.log(self.stretch) * DURATION / growth
        outward = (position[:, 0] == self._places[-1]) * 1.0 - (position[:, 0] == self._places[0])
        forces = np.outer(outward * force / POINTS_PER_CELL, [1.0, 0.0])
        bar = Body(
            position=position,
            volume=np.full(len(position), LENGTH * cell / len(position)),
            spacing=cell / POINTS_PER_CELL,
            material=LinearElastic(
                shear_modulus=0.5 * YOUNGS_MODULUS, poissons_ratio=0.0, density=DENSITY
            ),
            retardation_time=self.retardation_time,
            loads=(Load(forces=forces, start=0.0, rise_time=self.duration),),
        )
        half = math.ceil(0.5 * self.stretch * self.cell_count) + 2
        grid = UniformGrid(
            lower=(-half * cell, -3.0 * cell), cell_size=cell, cell_counts=(2 * half, 6)
        )
        return make_body_plan(BodyScene(grid=grid, bodies=(bar,), time_step_fraction=0.8))

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.results import cost, curves_kept
        from mpm_warp.simulation import TimeLoop

        loop = TimeLoop(self.plan(), execution)
        begin = time.perf_counter()
        samples: list[tuple[float, ...]] = []
        with curves_kept(lambda: self._curves(samples)):
            for sample in range(1, SAMPLE_COUNT + 1):
                loop.advance_to(self.duration * sample / SAMPLE_COUNT)
                samples.append((loop.time, *self._sample(loop)))
                if progress is not None:
                    progress(sample / SAMPLE_COUNT)
            loop.check()
        run_time = time.perf_counter() - begin
        return self._with_errors(self._curves(samples)).assign(cost(loop, run_time=run_time))

    def _sample(self, loop: TimeLoop) -> tuple[float, float, float]:
        """Stretch of the middle half, least and greatest stress in it."""
        import numpy as np

        start = self._places
        middle = np.abs(start) < 0.25 * LENGTH
        lattice = (POINTS_PER_CELL, len(start))
        along = loop.array("particle.position")[:, 0].reshape(lattice).mean(axis=0)
        stress = loop.array("particle.stress")[:, 0].reshape(lattice)[:, middle]
        stretch = np.polyfit(start[middle], along[middle], 1)[0]
        return float(stretch), float(stress.min()), float(stress.max())

    def _curves(self, samples: Sequence[tuple[float, ...]]) -> xarray.Dataset:
        """Stretch and stress of the middle half, and the closed form."""
        import numpy as np
        import xarray as xr

        from mpm_warp.results import variable

        times, stretch, least, greatest = np.array(samples).reshape(-1, 4).T
        middle = "of the middle half"
        curves = {
            "stretch": (stretch, "1", f"stretch {middle}"),
            "stretch_exact": (self.stretch_at(times), "1", "stretch, closed form"),
            "stress_least": (least, "Pa", f"least stress {middle}"),
            "stress_greatest": (greatest, "Pa", f"greatest stress {middle}"),
            "stress_exact": (
                YOUNGS_MODULUS * np.log(stretch),
                "Pa",
                "elastic stress at the stretch, closed form",
            ),
        }
        fraction = np.arange(1, len(samples) + 1) / SAMPLE_COUNT
        axis = variable(fraction, unit="1", meaning="time over duration", dims=("progress",))
        variables = {
            name: variable(values, unit=unit, meaning=meaning, dims=("progress",))
            for name, (values, unit, meaning) in curves.items()
        }
        return xr.Dataset(variables, coords={"progress": axis})

    def _with_errors(self, curves: xarray.Dataset) -> xarray.Dataset:
        import numpy as np

        from mpm_warp.results import variable

        last = curves.isel(progress=-1)
        at_end = np.array([last.stress_least, last.stress_greatest]) / float(last.stress_exact)
        error = variable(
            float(np.abs(curves.stretch / curves.stretch_exact - 1.0).max()),
            unit="1",
            meaning="greatest error of the stretch of the middle half",
        )
        stress_error = variable(
            np.abs(at_end - 1.0).max(),
            unit="1",
            meaning="greatest error of the stress of the middle half at its stretch, at the end",
        )
        return curves.assign(error=error, stress_error=stress_error)

    @property
    def _places(self) -> Floats:
        """Places of the points along the bar at rest, from its middle [m]."""
        return LENGTH * _middles(round(POINTS_PER_CELL * self.cell_count * self.stretch))


def _middles(count: int) -> Floats:
    """Middles of `count` equal parts of a length 1 about the origin."""
    import numpy as np

    middles: Floats = (np.arange(count) + 0.5) / count - 0.5
    return middles
