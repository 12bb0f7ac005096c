"""Waves along a column as they are sampled, beside the exact ones, and their errors."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, variable
from mpm_warp.scenes.waves.column import Column
from mpm_warp.simulation import Simulation

HEIGHT = 1.0
CONSTRAINED_MODULUS = 1e7
DENSITY = 1700.0
STRAIN = 1e-5
"""Greatest strain: small, since the exact solutions are those of small strain."""
PRESSURE = CONSTRAINED_MODULUS * STRAIN
"""Pressure of the sudden load [Pa]."""
WAVE_SPEED = math.sqrt(CONSTRAINED_MODULUS / DENSITY)
PERIOD = 4 * HEIGHT / WAVE_SPEED


class Front:
    """Samples a column under a sudden load: stress at the base and velocity at half height."""

    def __init__(self, column: Column, simulation: Simulation) -> None:
        self._column = column
        self._simulation = simulation
        self._samples: list[tuple[float, float, float]] = []

    def sample(self) -> None:
        """Record the time, the stress and the velocity."""
        mass, velocity = (self._simulation.array(f"particle.{it}") for it in ("mass", "velocity"))
        middle = self._column.mean_over_sections(velocity[:, 1], mass)[self._column.cell_count]
        stress = self._simulation.array("particle.stress")[0, 1]
        self._samples.append((self._simulation.time / PERIOD, float(stress), float(middle)))

    def dataset(self) -> xr.Dataset:
        """The curves beside the exact ones."""
        phase, stress, velocity = np.array(self._samples).reshape(-1, 3).T
        speed = STRAIN * WAVE_SPEED
        # Down, back from the base with the soil behind it at rest, back from the top rising.
        edges = np.array([0.125, 0.375, 0.625, 0.875])
        exact_velocity = np.array([0.0, -speed, 0.0, speed, 0.0])[np.searchsorted(edges, phase)]
        exact_stress = np.where((phase > 0.25) & (phase < 0.75), -2 * PRESSURE, 0.0)
        return curves(
            "phase",
            (phase, "1", "time over period"),
            base_stress=(stress, "Pa", "stress at the base"),
            base_stress_exact=(exact_stress, "Pa", "stress at the base, exact"),
            velocity=(velocity, "m s-1", "velocity at half height"),
            velocity_exact=(exact_velocity, "m s-1", "velocity at half height, exact"),
        )


class StandingWave:
    """Sets a standing wave off, and samples the displacement of the top and the energy."""

    def __init__(self, column: Column, simulation: Simulation) -> None:
        self._column = column
        self._simulation = simulation
        self._samples: list[tuple[float, float, float]] = []
        height = simulation.array("particle.position")[:, 1]
        velocity = STRAIN * WAVE_SPEED * np.sin(math.pi / (2 * HEIGHT) * height)
        simulation.assign("particle.velocity", np.stack([0.0 * velocity, velocity], axis=-1))

    def sample(self) -> None:
        """Record the time, the displacement and the energy."""
        position, velocity, stress, mass = (
            self._simulation.array(f"particle.{name}")
            for name in ("position", "velocity", "stress", "mass")
        )
        # Particles stand at a quarter of a cell below the top; strain vanishes there.
        height = self._column.mean_over_sections(position[:, 1], mass)[-1]
        top = height - HEIGHT * (1 - 0.25 / self._column.cell_count)
        strain_energy = np.sum(mass * stress[:, 1] ** 2) / (2 * CONSTRAINED_MODULUS * DENSITY)
        energy = 0.5 * np.sum(mass * velocity[:, 1] ** 2) + strain_energy
        self._samples.append((self._simulation.time / PERIOD, float(top), float(energy)))

    def dataset(self) -> xr.Dataset:
        """The curves, that of the displacement beside the exact one."""
        phase, displacement, energy = np.array(self._samples).reshape(-1, 3).T
        exact = STRAIN * 2 * HEIGHT / math.pi * np.sin(2 * math.pi * phase)
        return curves(
            "phase",
            (phase, "1", "time over period"),
            displacement=(displacement, "m", "displacement of the top"),
            displacement_exact=(exact, "m", "displacement of the top, exact"),
            energy=(energy, "J", "kinetic and strain energy per radian"),
        )


def period_of(phase: Floats, period_count: int) -> Floats:
    """Number of the period that a time over period is in; its end is still in the last."""
    period: Floats = np.minimum(np.floor(phase), period_count - 1)
    return period


def front_error(curves: xr.Dataset) -> xr.Variable:
    """Plateaus, arrival and reflection beside the exact ones."""
    speed = STRAIN * WAVE_SPEED
    phase = curves["phase"].values
    stress, velocity = curves["base_stress"].values, curves["velocity"].values
    plateaus = (
        (stress, 0.25, 0.75, -2 * PRESSURE),
        (velocity, 0.125, 0.375, -speed),
        (velocity, 0.625, 0.875, speed),
    )
    plateau_error = max(
        abs(_plateau(phase, values, start, end) / exact - 1)
        for values, start, end, exact in plateaus
    )
    crossings = phase[np.flatnonzero(np.diff(stress < -PRESSURE))]
    arrival_error = float(np.abs(crossings[[0, -1]] / [0.25, 0.75] - 1).max())
    return variable(
        max(plateau_error, arrival_error),
        unit="1",
        meaning="error of plateaus and arrivals",
        description="greatest relative error of the plateaus of stress at the base and of velocity "
        "at half height, each a mean over its middle half, and of the times at which the stress at "
        "the base passes half its plateau",
        role="headline",
    )


def _plateau(phase: Floats, values: Floats, start: float, end: float) -> float:
    quarter = 0.25 * (end - start)
    return float(values[(phase > start + quarter) & (phase < end - quarter)].mean())


def standing_wave_errors(curves: xr.Dataset, kept_per_second: float) -> dict[str, xr.Variable]:
    """Of the displacement over the first period, and of the energy over all.

    Args:
        curves: of the run.
        kept_per_second: the part of the energy that is left after a second, derived.
    """
    phase, energy = curves["phase"].values, curves["energy"].values
    exact = curves["displacement_exact"].values
    first = phase <= 1.0
    difference = np.linalg.norm((curves["displacement"].values - exact)[first])
    # Over whole periods: kinetic and strain energy are those of times half a step apart.
    period = period_of(phase, round(phase[-1]))
    numbers = np.unique(period)
    energies = np.array([energy[period == number].mean() for number in numbers])
    kept = energies / energies[0]
    derived = kept_per_second ** (numbers * PERIOD)
    quantities = {
        "error": (
            difference / np.linalg.norm(exact[first]),
            "error of displacement",
            "L2 norm over a period of the error of the top's displacement, over that of the exact",
            "headline",
        ),
        "energy_drift": (
            np.abs(kept - 1.0).max(),
            "change of energy",
            "mean over a period, over that of the first, less 1; the greatest of those sampled",
            "error",
        ),
        "energy_departure": (
            np.abs(kept - derived).max(),
            "departure of the energy from its derived decay",
            "mean over a period, over that of the first, less what is left by modal analysis",
            "error",
        ),
        "energy_decay": (
            1.0 - kept_per_second**PERIOD,
            "energy that a period takes, derived",
            "part of the energy that the transfers take in a period, by modal analysis of a step",
            None,
        ),
    }
    return {
        name: variable(float(value), unit="1", meaning=meaning, description=description, role=role)
        for name, (value, meaning, description, role) in quantities.items()
    }
