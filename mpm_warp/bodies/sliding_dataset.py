"""A sliding block, computed and exact, as a dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from mpm_warp.bodies.history import BodyHistory
from mpm_warp.bodies.sliding import SlidingMotion
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import variable


def sliding_curves(
    history: BodyHistory, *, along: Floats, start: float, sample_count: int
) -> xr.Dataset:
    """Computed curves, of a run to its end or not.

    Args:
        history: of a block that is body 0; its first sample is the beginning of the drive.
        along: unit vector along the interface, shape [2].
        start: time at which the drive begins [s].
        sample_count: samples of the whole run after the first.
    """
    curves = {
        "time": (history.time[1:] - start, "s", "time since the driving force began"),
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
    fraction = np.arange(1, len(history.time)) / sample_count
    axis = variable(fraction, unit="1", meaning="time over duration", dims=("progress",))
    return xr.Dataset(_along_progress(curves), coords={"progress": axis})


def sliding_dataset(
    history: BodyHistory,
    motion: SlidingMotion,
    *,
    along: Floats,
    length: float,
    start: float,
    settled_time: float,
) -> xr.Dataset:
    """Computed and exact curves of a whole run, and what they come to.

    Args:
        history: of a block that is body 0; its first sample is the beginning of the drive.
        motion: the exact one.
        along: unit vector along the interface, shape [2].
        length: of the block [m].
        start: time at which the drive begins [s].
        settled_time: time from then until a block that sticks is at rest again [s].
    """
    since = history.time - start
    middle = 0.5 * (since[1:] + since[:-1])
    velocity = history.velocity @ along
    displacement = history.displacement @ along
    shear = history.contact_force @ along
    exact_velocity, exact_displacement, exact_shear = motion.at(since)
    exact_shear = 0.5 * (exact_shear[1:] + exact_shear[:-1])
    late = len(middle) // 2
    acceleration, exact_acceleration = (
        float(v[-1] - v[late]) / float(since[-1] - since[late]) for v in (velocity, exact_velocity)
    )
    creep, acceleration_error = math.nan, math.nan
    if motion.slides:
        acceleration_error = abs(acceleration / exact_acceleration - 1.0)
    else:
        settled = np.flatnonzero(since >= settled_time)[0]
        creep = float(abs(displacement[-1] - displacement[settled])) / length
    mean_shear, exact_mean_shear = float(shear[late:].mean()), float(exact_shear[late:].mean())
    shear_error = math.nan
    if exact_mean_shear > 0.0:
        shear_error = abs(mean_shear / exact_mean_shear - 1.0)
    scalars = {
        "error": (
            acceleration_error if motion.slides else creep,
            "1",
            "relative error of the acceleration, or the creep of a block that sticks",
        ),
        "acceleration": (acceleration, "m s-2", "mean acceleration over the second half"),
        "acceleration_exact": (exact_acceleration, "m s-2", "exact mean acceleration"),
        "acceleration_error": (acceleration_error, "1", "relative error of the acceleration"),
        "creep": (creep, "1", "displacement over length of a block that sticks, once at rest"),
        "base_shear": (mean_shear, "N", "mean base shear over the second half"),
        "base_shear_exact": (exact_mean_shear, "N", "exact mean base shear"),
        "base_shear_error": (shear_error, "1", "relative error of the base shear"),
        "momentum_error": (
            float(np.abs(history.momentum_error).max()),
            "1",
            "greatest error of the momentum balance",
        ),
        "energy_error": (
            float(np.abs(history.energy_error).max()),
            "1",
            "greatest error of the energy balance",
        ),
    }
    exact_and_balances = {
        "velocity_exact": (exact_velocity[1:], "m s-1", "exact velocity"),
        "displacement_exact": (exact_displacement[1:], "m", "exact displacement"),
        "shear_force_exact": (exact_shear, "N", "exact base shear"),
        "momentum_balance": (history.momentum_error[1:], "1", "error of the momentum balance"),
        "energy_balance": (history.energy_error[1:], "1", "error of the energy balance"),
    }
    variables = {
        name: variable(value, unit=unit, meaning=meaning)
        for name, (value, unit, meaning) in scalars.items()
    }
    curves = sliding_curves(history, along=along, start=start, sample_count=len(middle))
    return curves.assign(_along_progress(exact_and_balances)).assign(variables)


def _along_progress(curves: Mapping[str, tuple[Floats, str, str]]) -> dict[str, xr.Variable]:
    return {
        name: variable(values, unit=unit, meaning=meaning, dims=("progress",))
        for name, (values, unit, meaning) in curves.items()
    }
