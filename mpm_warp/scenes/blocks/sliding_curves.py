"""Curves of a sliding block, and their comparison with the exact motion."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from mpm_warp.bodies.history import BodyHistory
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import variable
from mpm_warp.scenes.blocks.sliding_motion import SlidingMotion
from mpm_warp.simulation import Simulation

SAMPLE_COUNT = 100
"""Samples of the curves, after the moment when the driving force begins."""
OVER_PROGRESS = ("progress",)
"""Dimension of the curves: the time as a share of the duration."""

Table = Mapping[str, tuple[Floats | float, str, str]]
"""Value, unit and meaning of variables, by name."""
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
        curves: Table = {
            "time": (history.time[1:] - self._start, "s", "time since the driving force began"),
            "velocity": (history.velocity[1:] @ along, "m s-1", "velocity of the block"),
            "displacement": (history.displacement[1:] @ along, "m", "displacement of the block"),
            "shear_force": (
                history.contact_force @ along,
                "N",
                "base shear, mean since the sample before",
            ),
            "kinetic_energy": (history.kinetic_energy[1:], "J", "kinetic energy"),
            "elastic_energy": (history.elastic_energy[1:], "J", "change of the elastic energy"),
            "load_work": (history.load_work[1:], "J", "work of the loads"),
            "slip_work": (history.slip_work[1:], "J", "work taken by slip"),
            "viscous_work": (history.viscous_work[1:], "J", "work taken by damping"),
        }
        fraction = np.arange(1, len(history.time)) / SAMPLE_COUNT
        axis = variable(fraction, unit="1", meaning="time over duration", dims=OVER_PROGRESS)
        return xr.Dataset(_variables(curves, OVER_PROGRESS), coords={"progress": axis})

    def balances(self) -> Variables:
        """Errors of the momentum and the energy balance of a whole run, and the greatest ones."""
        momentum, energy = self._history.momentum_error, self._history.energy_error
        curves: Table = {
            "momentum_balance": (momentum[1:], "1", "error of the momentum balance"),
            "energy_balance": (energy[1:], "1", "error of the energy balance"),
        }
        greatest: Table = {
            "momentum_error": (
                np.abs(momentum).max(),
                "1",
                "greatest error of the momentum balance",
            ),
            "energy_error": (np.abs(energy).max(), "1", "greatest error of the energy balance"),
        }
        return _variables(curves, OVER_PROGRESS) | _variables(greatest, role="error")

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
        curves: Table = {
            "velocity": (exact_velocity[1:], "m s-1", "exact velocity"),
            "displacement": (exact_displacement[1:], "m", "exact displacement"),
            "shear_force": (exact_shear, "N", "exact base shear"),
        }

        half = len(exact_shear) // 2
        acceleration, exact_acceleration = (
            float(v[-1] - v[half]) / float(since[-1] - since[half])
            for v in (self._history.velocity @ self._along, exact_velocity)
        )
        base_shear, exact_base_shear = (
            float(force[half:].mean())
            for force in (self._history.contact_force @ self._along, exact_shear)
        )
        scalars: Table = {
            "acceleration": (acceleration, "m s-2", "mean acceleration over the second half"),
            "base_shear": (base_shear, "N", "mean base shear over the second half"),
        }
        exact_scalars: Table = {
            "acceleration": (exact_acceleration, "m s-2", "exact mean acceleration"),
            "base_shear": (exact_base_shear, "N", "exact mean base shear"),
        }

        creep, acceleration_error, shear_error = math.nan, math.nan, math.nan
        if motion.slides:
            acceleration_error = abs(acceleration / exact_acceleration - 1.0)
        else:
            moved = self._history.displacement @ self._along
            settled = np.flatnonzero(since >= settled_time)[0]
            creep = float(abs(moved[-1] - moved[settled])) / length
        if exact_base_shear > 0.0:
            shear_error = abs(base_shear / exact_base_shear - 1.0)
        errors: Table = {
            "acceleration_error": (acceleration_error, "1", "relative error of the acceleration"),
            "base_shear_error": (shear_error, "1", "relative error of the base shear"),
            "creep": (creep, "1", "displacement over length of a block that sticks, once at rest"),
        }
        error = variable(
            acceleration_error if motion.slides else creep,
            unit="1",
            meaning="relative error of the acceleration, or the creep of a block that sticks",
            role="headline",
        )
        return (
            _exact(curves, OVER_PROGRESS)
            | _variables(scalars)
            | _exact(exact_scalars)
            | _variables(errors, role="error")
            | {"error": error}
        )


def _variables(table: Table, dims: tuple[str, ...] = (), role: str | None = None) -> Variables:
    return {
        name: variable(value, unit=unit, meaning=meaning, dims=dims, role=role)
        for name, (value, unit, meaning) in table.items()
    }


def _exact(table: Table, dims: tuple[str, ...] = ()) -> Variables:
    """Exact values, by the names of the variables that they belong to."""
    return {
        f"{name}_exact": variable(value, unit=unit, meaning=meaning, dims=dims, exact_of=name)
        for name, (value, unit, meaning) in table.items()
    }
