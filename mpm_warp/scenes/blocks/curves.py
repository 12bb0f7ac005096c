"""Curves of a sliding block, its balances of momentum and energy, and the exact motion beside."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from mpm_warp.bodies.scene import BodyScene
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, labelled
from mpm_warp.scenes.blocks.block_on_base import SlidingMotion
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


class BodyHistory:
    """Samples of body 0 and of contact 0; changes are those since the first sample, taken at once.

    Args:
        simulation: a run of bodies in contact. All loads act on body 0, which is the body of
            contact 0.
    """

    def __init__(self, simulation: Simulation) -> None:
        scene = simulation.scene
        assert isinstance(scene, BodyScene)
        self._simulation = simulation
        self._loads = scene.bodies[0].loads
        self._mass = scene.bodies[0].mass
        self._axisymmetric = scene.grid.axisymmetric
        self._samples: dict[str, list[float | Floats]] = {}
        self.sample()

    def sample(self) -> None:
        """Add a sample."""
        position, velocity = (
            self._simulation.array(f"particle.{name}")[: len(self._mass)].copy()
            for name in ("position", "velocity")
        )
        total = self._simulation.array("contact0.total")[0]
        values: dict[str, float | Floats] = {
            "time": self._simulation.time,
            "position": position,
            "momentum": self._mass @ velocity,
            "kinetic_energy": 0.5 * float(self._mass @ np.sum(velocity**2, axis=1)),
            "elastic_energy": self._elastic_energy(),
            "contact_impulse": total[:2].copy(),
            "slip_work": float(total[2]),
            "viscous_work": self._viscous_work(),
        }
        for name, value in values.items():
            self._samples.setdefault(name, []).append(value)

    @property
    def time(self) -> Floats:
        """Simulated time [s], shape [sample_count]."""
        return self._all("time")

    @property
    def velocity(self) -> Floats:
        """Mean velocity of the body [m/s], shape [sample_count, 2]."""
        return self._all("momentum") / float(self._mass.sum())

    @property
    def displacement(self) -> Floats:
        """Mean displacement [m], shape [sample_count, 2]."""
        moved = self._change("position")
        mean: Floats = np.einsum("p,tpi->ti", self._mass, moved) / self._mass.sum()
        return mean

    @property
    def contact_force(self) -> Floats:
        """Mean force on the base between samples [N], shape [sample_count - 1, 2]."""
        force: Floats = np.diff(self._all("contact_impulse"), axis=0)
        return force / np.diff(self.time)[:, None]

    @property
    def kinetic_energy(self) -> Floats:
        """Kinetic energy of the body [J], shape [sample_count]."""
        return self._all("kinetic_energy")

    @property
    def elastic_energy(self) -> Floats:
        """Change of the elastic energy of all bodies [J], shape [sample_count]."""
        return self._change("elastic_energy")

    @property
    def slip_work(self) -> Floats:
        """Work dissipated by slip at the interface [J], shape [sample_count]."""
        return self._change("slip_work")

    @property
    def viscous_work(self) -> Floats:
        """Work dissipated by damping in all bodies [J], shape [sample_count]."""
        return self._change("viscous_work")

    @property
    def load_work(self) -> Floats:
        """Work of the loads [J], shape [sample_count]."""
        moved = np.diff(self._all("position"), axis=0)
        work = np.zeros(len(moved))
        for load in self._loads:
            mean = np.diff(load.impulse_time(self.time)) / np.diff(self.time)
            work += mean * np.sum(load.forces * moved, axis=(1, 2))
        return np.concatenate([[0.0], np.cumsum(work)])

    @property
    def momentum_error(self) -> Floats:
        """Error of the momentum balance over the loads' impulse at the end, shape [sample_count].

        In axisymmetry only the momentum along the axis is balanced: hoop stresses change the other.
        """
        given = np.zeros((len(self.time), 2))
        for load in self._loads:
            given += np.outer(load.impulse_time(self.time), load.forces.sum(axis=0))
        given -= given[0]
        lack = given - self._change("contact_impulse") - self._change("momentum")
        balanced = slice(1 if self._axisymmetric else 0, 2)
        error: Floats = np.linalg.norm(lack[:, balanced], axis=1) / np.linalg.norm(given[-1])
        return error

    @property
    def energy_error(self) -> Floats:
        """Error of the energy balance over the loads' greatest work, shape [sample_count].

        It is what the transfer between particles and grid has dissipated.
        """
        work = self.load_work
        stored = self._change("kinetic_energy") + self.elastic_energy
        taken = self.slip_work + self.viscous_work
        return (work - stored - taken) / float(np.abs(work).max())

    def _viscous_work(self) -> float:
        if "particle.dissipated" not in self._simulation.plan.arrays:
            return 0.0
        return float(self._simulation.array("particle.dissipated").sum())

    def _elastic_energy(self) -> float:
        """s:s / 4 G + p^2 / 2 K over all bodies, s the deviator and p the mean stress [J]."""
        array = self._simulation.array
        stress, volume = array("particle.stress"), array("particle.volume")
        moduli = array("body.moduli")[array("particle.body")]
        normal = stress[:, [0, 1, 3]]
        mean = normal.mean(axis=1)
        square = np.sum((normal - mean[:, None]) ** 2, axis=1) + 2.0 * stress[:, 2] ** 2
        density = square / (4.0 * moduli[:, 0]) + mean**2 / (2.0 * moduli[:, 1])
        return float(np.sum(volume * density))

    def _all(self, name: str) -> Floats:
        return np.array(self._samples[name])

    def _change(self, name: str) -> Floats:
        values = self._all(name)
        change: Floats = values - values[0]
        return change
