"""Curves of a sliding block, its balances of momentum and energy, and the exact motion beside."""

import math

import numpy as np
import xarray as xr

from mpm_warp.bodies.scene import BodyScene
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, labelled
from mpm_warp.scenes.blocks.block_on_base import SAMPLE_COUNT, BlockOnBase
from mpm_warp.simulation import Simulation

Variables = dict[str, xr.Variable]


class SlidingCurves:
    """Samples of a block, which is body 0, from the beginning of the drive on.

    All loads act on the block, and the contact is that with its base. The first sample is taken at
    once, at the start of the drive [s]; `along` is the unit vector along the interface.
    """

    def __init__(self, simulation: Simulation, scene: BlockOnBase, along: Floats) -> None:
        built = simulation.scene
        assert isinstance(built, BodyScene)
        self._simulation = simulation
        self._scene = scene
        self._block = built.bodies[0]
        self._along = along
        self._samples: list[dict[str, float | Floats]] = []
        self.sample()

    def sample(self) -> None:
        """Add a sample."""
        array, mass = self._simulation.array, self._block.mass
        position = array("particle.position")[: len(mass)].copy()
        velocity = array("particle.velocity")[: len(mass)].copy()
        total = array("contact.total")[0]
        damped = "particle.dissipated" in self._simulation.plan.arrays
        self._samples.append(
            {
                "time": self._simulation.time,
                "position": position,
                "momentum": mass @ velocity,
                "kinetic_energy": 0.5 * float(mass @ np.sum(velocity**2, axis=1)),
                "elastic_energy": _elastic_energy(self._simulation),
                "contact_impulse": total[:2].copy(),
                "slip_work": float(total[2]),
                "viscous_work": float(array("particle.dissipated").sum()) if damped else 0.0,
            }
        )

    @property
    def _recorded(self) -> dict[str, Floats]:
        """What the block has done, by name, over the samples; energies are changes but the kinetic.

        The contact force is the mean one on the base between two samples. What a balance lacks: of
        momentum [N s], in axisymmetry along the axis alone, because hoop stresses change the other;
        of energy [J], dissipated in the transfers between particles and grid.
        """
        mass = self._block.mass
        values = {
            name: np.array([sample[name] for sample in self._samples]) for name in self._samples[0]
        }
        change = {name: value - value[0] for name, value in values.items()}
        time = values["time"]
        moved = np.diff(values["position"], axis=0)
        work, given = np.zeros(len(moved)), np.zeros((len(time), 2))
        for load in self._block.loads:
            mean = np.diff(load.impulse_time(time)) / np.diff(time)
            work += mean * np.sum(load.forces * moved, axis=(1, 2))
            given += np.outer(load.impulse_time(time), load.forces.sum(axis=0))
        load_work = np.concatenate([[0.0], np.cumsum(work)])
        given -= given[0]
        lack = given - change["contact_impulse"] - change["momentum"]
        balanced = slice(0 if self._scene.interface_radius is None else 1, 2)
        stored = change["kinetic_energy"] + change["elastic_energy"]
        taken = change["slip_work"] + change["viscous_work"]
        displacement = np.einsum("p,tpi->ti", mass, change["position"]) / mass.sum()
        contact_force = np.diff(values["contact_impulse"], axis=0) / np.diff(time)[:, None]
        return {
            **change,
            "velocity": values["momentum"] / float(mass.sum()) @ self._along,
            "displacement": displacement @ self._along,
            "shear_force": contact_force @ self._along,
            "kinetic_energy": values["kinetic_energy"],
            "load_work": load_work,
            "impulse": given,
            "momentum_lack": np.linalg.norm(lack[:, balanced], axis=1),
            "energy_lack": load_work - stored - taken,
        }

    @property
    def _since(self) -> Floats:
        """Times since the beginning of the drive [s], shape [sample_count]."""
        return np.array([sample["time"] for sample in self._samples]) - self._scene.start

    def dataset(self) -> xr.Dataset:
        """The computed curves so far."""
        run, since = self._recorded, self._since

        def curve(name: str, unit: str, meaning: str) -> tuple[Floats, str, str]:
            return run[name][1:], unit, meaning

        return curves(
            "progress",
            (np.arange(1, len(since)) / SAMPLE_COUNT, "1", "time over duration"),
            time=(since[1:], "s", "time since the driving force began"),
            velocity=curve("velocity", "m s-1", "velocity of the block"),
            displacement=curve("displacement", "m", "displacement of the block"),
            shear_force=(run["shear_force"], "N", "base shear, mean since the sample before"),
            kinetic_energy=curve("kinetic_energy", "J", "kinetic energy"),
            elastic_energy=curve("elastic_energy", "J", "change of the elastic energy"),
            load_work=curve("load_work", "J", "work of the loads"),
            slip_work=curve("slip_work", "J", "work taken by slip"),
            viscous_work=curve("viscous_work", "J", "work taken by damping"),
        )

    def balances(self) -> Variables:
        """Errors of the momentum and the energy balance of a whole run, and the greatest ones.

        They are over the loads' impulse at the end, and over their greatest work.
        """
        run = self._recorded
        momentum = run["momentum_lack"] / np.linalg.norm(run["impulse"][-1])
        energy = run["energy_lack"] / float(np.abs(run["load_work"]).max())
        return labelled(
            dims=("progress",),
            momentum_balance=(momentum[1:], "1", "error of the momentum balance"),
            energy_balance=(energy[1:], "1", "error of the energy balance"),
        ) | labelled(
            role="error",
            momentum_error=(np.abs(momentum).max(), "1", "greatest error of the momentum balance"),
            energy_error=(np.abs(energy).max(), "1", "greatest error of the energy balance"),
        )

    def comparison(self) -> Variables:
        """Exact curves of a whole run, and scalars over its second half."""
        since, run, motion = self._since, self._recorded, self._scene.motion
        exact_velocity, exact_displacement, exact_shear = motion.at(since)
        exact_shear = 0.5 * (exact_shear[1:] + exact_shear[:-1])
        half = len(exact_shear) // 2
        acceleration, exact_acceleration = (
            float(v[-1] - v[half]) / float(since[-1] - since[half])
            for v in (run["velocity"], exact_velocity)
        )
        base_shear, exact_base_shear = (
            float(force[half:].mean()) for force in (run["shear_force"], exact_shear)
        )
        creep, acceleration_error, shear_error = math.nan, math.nan, math.nan
        if motion.slides:
            acceleration_error = abs(acceleration / exact_acceleration - 1.0)
        else:
            moved = run["displacement"]
            settled = np.flatnonzero(since >= self._scene.settled_time)[0]
            creep = float(abs(moved[-1] - moved[settled])) / self._scene.length
        if exact_base_shear > 0.0:
            shear_error = abs(base_shear / exact_base_shear - 1.0)
        error = (
            acceleration_error if motion.slides else creep,
            "1",
            "relative error of the acceleration, or the creep of a block that sticks",
        )
        return (
            labelled(
                dims=("progress",),
                velocity_exact=(exact_velocity[1:], "m s-1", "exact velocity"),
                displacement_exact=(exact_displacement[1:], "m", "exact displacement"),
                shear_force_exact=(exact_shear, "N", "exact base shear"),
            )
            | labelled(
                acceleration=(acceleration, "m s-2", "mean acceleration over the second half"),
                acceleration_exact=(exact_acceleration, "m s-2", "exact mean acceleration"),
                base_shear=(base_shear, "N", "mean base shear over the second half"),
                base_shear_exact=(exact_base_shear, "N", "exact mean base shear"),
            )
            | labelled(
                role="error",
                acceleration_error=(acceleration_error, "1", "relative error of the acceleration"),
                base_shear_error=(shear_error, "1", "relative error of the base shear"),
                creep=(creep, "1", "displacement over length of a block that sticks, once at rest"),
            )
            | labelled(role="headline", error=error)
        )


def _elastic_energy(simulation: Simulation) -> float:
    """s:s / 4 G + p^2 / 2 K over all bodies, s the deviator and p the mean stress [J]."""
    array = simulation.array
    stress, volume = array("particle.stress"), array("particle.volume")
    moduli = array("body.moduli")[array("particle.body")]
    normal = stress[:, [0, 1, 3]]
    mean = normal.mean(axis=1)
    square = np.sum((normal - mean[:, None]) ** 2, axis=1) + 2.0 * stress[:, 2] ** 2
    density = square / (4.0 * moduli[:, 0]) + mean**2 / (2.0 * moduli[:, 1])
    return float(np.sum(volume * density))
