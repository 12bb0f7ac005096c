"""Curves of a sliding block, and their comparison with the exact motion."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from mpm_warp.bodies.history import BodyHistory
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, labelled
from mpm_warp.scenes.blocks.sliding_motion import SlidingMotion
from mpm_warp.simulation import Simulation

SAMPLE_COUNT = 100
"""Samples of the curves, after the moment when the driving force begins."""
OVER_PROGRESS = ("progress",)
"""Dimension of the curves: the time as a share of the duration."""

Variables = dict[str, xr.Variable]


class SlidingCurves:
    """Samples of a block, which is body 0, from the beginning of the drive on.

    Args:
        simulation: at the beginning of the drive.
        start: time at which the drive begins [s].
        along: unit vector along the interface, shape [2].
    """

    def __init__(self, simulation: Simulation, *, start: float, along: Floats) -> None:
        self._history = BodyHistory(simulation)
        self._start = start
        self._along = along

    def sample(self) -> None:
        """Add a sample."""
        self._history.sample()

    def dataset(self) -> xr.Dataset:
        """The computed curves so far."""
        history, along = self._history, self._along
        return curves(
            "progress",
            (np.arange(1, len(history.time)) / SAMPLE_COUNT, "1", "time over duration"),
            time=(history.time[1:] - self._start, "s", "time since the driving force began"),
            velocity=(history.velocity[1:] @ along, "m s-1", "velocity of the block"),
            displacement=(history.displacement[1:] @ along, "m", "displacement of the block"),
            shear_force=(
                history.contact_force @ along,
                "N",
                "base shear, mean since the sample before",
            ),
            kinetic_energy=(history.kinetic_energy[1:], "J", "kinetic energy"),
            elastic_energy=(history.elastic_energy[1:], "J", "change of the elastic energy"),
            load_work=(history.load_work[1:], "J", "work of the loads"),
            slip_work=(history.slip_work[1:], "J", "work taken by slip"),
            viscous_work=(history.viscous_work[1:], "J", "work taken by damping"),
        )

    def balances(self) -> Variables:
        """Errors of the momentum and the energy balance of a whole run, and the greatest ones."""
        momentum, energy = self._history.momentum_error, self._history.energy_error
        return labelled(
            dims=OVER_PROGRESS,
            momentum_balance=(momentum[1:], "1", "error of the momentum balance"),
            energy_balance=(energy[1:], "1", "error of the energy balance"),
        ) | labelled(
            role="error",
            momentum_error=(
                np.abs(momentum).max(),
                "1",
                "greatest error of the momentum balance",
            ),
            energy_error=(np.abs(energy).max(), "1", "greatest error of the energy balance"),
        )

    def comparison(self, motion: SlidingMotion, *, length: float, settled_time: float) -> Variables:
        """Exact curves of a whole run, and scalars over its second half.

        Args:
            motion: the exact one.
            length: length of the block [m].
            settled_time: time from the beginning of the drive until a block that sticks is at rest
                again [s].
        """
        since = self._history.time - self._start
        exact_velocity, exact_displacement, exact_shear = motion.at(since)
        exact_shear = 0.5 * (exact_shear[1:] + exact_shear[:-1])
        half = len(exact_shear) // 2
        acceleration, exact_acceleration = (
            float(v[-1] - v[half]) / float(since[-1] - since[half])
            for v in (self._history.velocity @ self._along, exact_velocity)
        )
        base_shear, exact_base_shear = (
            float(force[half:].mean())
            for force in (self._history.contact_force @ self._along, exact_shear)
        )
        creep, acceleration_error, shear_error = math.nan, math.nan, math.nan
        if motion.slides:
            acceleration_error = abs(acceleration / exact_acceleration - 1.0)
        else:
            moved = self._history.displacement @ self._along
            settled = np.flatnonzero(since >= settled_time)[0]
            creep = float(abs(moved[-1] - moved[settled])) / length
        if exact_base_shear > 0.0:
            shear_error = abs(base_shear / exact_base_shear - 1.0)
        error = (
            acceleration_error if motion.slides else creep,
            "1",
            "relative error of the acceleration, or the creep of a block that sticks",
        )
        return {
            **labelled(
                dims=OVER_PROGRESS,
                velocity_exact=(exact_velocity[1:], "m s-1", "exact velocity"),
                displacement_exact=(exact_displacement[1:], "m", "exact displacement"),
                shear_force_exact=(exact_shear, "N", "exact base shear"),
            ),
            **labelled(
                acceleration=(acceleration, "m s-2", "mean acceleration over the second half"),
                acceleration_exact=(exact_acceleration, "m s-2", "exact mean acceleration"),
                base_shear=(base_shear, "N", "mean base shear over the second half"),
                base_shear_exact=(exact_base_shear, "N", "exact mean base shear"),
            ),
            **labelled(
                role="error",
                acceleration_error=(
                    acceleration_error,
                    "1",
                    "relative error of the acceleration",
                ),
                base_shear_error=(shear_error, "1", "relative error of the base shear"),
                creep=(creep, "1", "displacement over length of a block that sticks, once at rest"),
            ),
            **labelled(role="headline", error=error),
        }
