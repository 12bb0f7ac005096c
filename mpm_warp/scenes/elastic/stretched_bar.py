"""A bar stretched to many times its length, against a closed form."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.bodies.body import Body, Load, UniformGrid, critical_time_step
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import Samples, evenly, follow
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.limits import limited
from mpm_warp.scenes.run_size import RunSize, size_of_body
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

LENGTH = 1.0
"""Initial length of the bar [m]; it is one cell thick."""
YOUNGS_MODULUS = 2e6
DENSITY = 1000.0
POINTS_PER_CELL = 2
"""Material points per cell along and across at the end; with wider spacing the bar would part."""
SLOWNESS = 6.0
"""Retardation time over the time in which a wave travels along the stretched bar."""
DURATION = 2.0
"""Duration over retardation time."""
SAMPLE_COUNT = 100
TIME_STEP_FRACTION = 0.8


@dataclass(frozen=True, kw_only=True)
class StretchedBar(CatalogueScene):
    """A bar of Poisson's ratio 0, stretched by end forces F that rise linearly to F_1.

    The rate of strain is the rate of ln l, with the stretch l. Without rotation the Jaumann rate of
    the elastic stress s is its time derivative, so s = E ln l. The section A is constant. With the
    retardation time tau F / A = s + tau ds/dt. At the time t, for the duration T,

        ln l = F_1 / (E A T) (t - tau (1 - exp(-t / tau))).

    The test must be slow because of the elastic law. Beyond the tension 2 G, where l = e, a stress
    by the Jaumann rate has no stiffness against shear along the bar. A disturbance then grows by
    the factor e in the time tau / (ln l - 1) or longer.

    Example:
        >>> round(StretchedBar(stretch=2.0).duration, 2)  # [s]
        0.38
    """

    summary = "viscoelastic bar drawn out many times its length; closed form"
    version = 3
    method = ("cell_count",)
    verifications = compared(
        "cell_count", (4,), {"stretch": 20.0}, error=0.01, stress_error=0.01, extreme=True
    )
    limits = limited(error="more cell_count", stress_error="more cell_count")

    stretch: float = parameter(4.0, "length at the end over that at rest", above=1, maximum=50)
    cell_count: int = parameter(4, "cells along the bar at rest", minimum=2, maximum=20)

    @property
    def cell_size(self) -> float:
        """Side of a cell, the thickness of the bar [m]."""
        return LENGTH / self.cell_count

    @property
    def retardation_time(self) -> float:
        """Retardation time tau, in proportion to the final stretch [s]."""
        # The modulus is constant and the density falls, so waves become faster.
        wave_speed = math.sqrt(YOUNGS_MODULUS * self.stretch / DENSITY)
        return SLOWNESS * self.stretch * LENGTH / wave_speed

    @property
    def duration(self) -> float:
        """Time in which the forces rise [s]."""
        return DURATION * self.retardation_time

    @property
    def _half_count(self) -> int:
        """Cells of the grid from the middle of the bar to beyond its end."""
        return math.ceil(0.5 * self.stretch * self.cell_count) + 2

    def run_size(self) -> RunSize:
        """See `CatalogueScene`; with the time step of the end."""
        (bar,) = self.build().bodies
        at_end = critical_time_step(
            self.cell_size, bar.material, self.retardation_time, thinning=self.stretch
        )
        return size_of_body(
            cell_count=12 * self._half_count,
            particle_count=bar.particle_count,
            step_count=self.duration / (TIME_STEP_FRACTION * at_end),
        )

    def build(self) -> BodyScene:
        """The bar with the forces on its ends."""
        cell = self.cell_size
        along, across = np.meshgrid(self.lattice, cell * _middles(POINTS_PER_CELL))
        position = np.stack([along.ravel(), across.ravel()], axis=-1)
        growth = DURATION - 1.0 + math.exp(-DURATION)
        force = YOUNGS_MODULUS * cell * math.log(self.stretch) * DURATION / growth
        outward = (position[:, 0] == self.lattice[-1]) * 1.0 - (position[:, 0] == self.lattice[0])
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
        half = self._half_count
        grid = UniformGrid(
            lower=(-half * cell, -3.0 * cell), cell_size=cell, cell_counts=(2 * half, 6)
        )
        return BodyScene(grid=grid, bodies=(bar,), time_step_fraction=TIME_STEP_FRACTION)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Draw the bar out, and compare stretch and stress with the closed form."""
        at_rest = self.lattice
        middle = np.abs(at_rest) < 0.25 * LENGTH
        rows = (POINTS_PER_CELL, len(at_rest))

        def middle_half() -> tuple[float, ...]:
            """Time, stretch, least and greatest stress in the middle half, far from the ends."""
            along = simulation.array("particle.position")[:, 0].reshape(rows).mean(axis=0)
            stress = simulation.array("particle.stress")[:, 0].reshape(rows)[:, middle]
            stretch = np.polyfit(at_rest[middle], along[middle], 1)[0]
            return simulation.time, stretch, stress.min(), stress.max()

        samples = Samples(middle_half, self._curves)
        moments = evenly(self.duration, SAMPLE_COUNT)
        recorded = follow(simulation, moments, simulation.advance_to, [samples], progress)
        last = recorded.isel(progress=-1)
        at_end = np.array([last.stress_least, last.stress_greatest])
        at_end /= float(last.stress_greatest_exact)
        error = np.abs(recorded.stretch / recorded.stretch_exact - 1.0).max()
        meaning = "greatest error of the stretch of the middle half"
        of_stress = "greatest error of the stress of the middle half at its stretch, at the end"
        return recorded.assign(
            labelled(role="headline", error=(float(error), "1", meaning))
            | labelled(role="error", stress_error=(np.abs(at_end - 1.0).max(), "1", of_stress))
        )

    def _curves(self, time: Floats, stretch: Floats, least: Floats, greatest: Floats) -> xr.Dataset:
        """Stretch and stress of the middle half, and the closed form."""
        tau, until = self.retardation_time, np.append(time, self.duration)
        grown = until - tau * (1.0 - np.exp(-until / tau))
        exact = YOUNGS_MODULUS * np.log(stretch)
        return curves(
            "progress",
            (np.arange(1, len(time) + 1) / SAMPLE_COUNT, "1", "time over duration"),
            stretch=(stretch, "1", "stretch of the middle half"),
            stretch_exact=(self.stretch ** (grown[:-1] / grown[-1]), "1", "stretch, closed form"),
            stress_least=(least, "Pa", "least stress of the middle half"),
            stress_greatest=(greatest, "Pa", "greatest stress of the middle half"),
            stress_greatest_exact=(exact, "Pa", "elastic stress at the stretch, closed form"),
        )

    @property
    def lattice(self) -> Floats:
        """Coordinates of the points along the bar at rest, from its middle [m]."""
        return LENGTH * _middles(round(POINTS_PER_CELL * self.cell_count * self.stretch))


def _middles(count: int) -> Floats:
    """Midpoints of `count` equal parts of the interval from -1/2 to 1/2."""
    return (np.arange(count) + 0.5) / count - 0.5
