"""The motion and the balances of a block on a base, sampled and compared with the exact motion."""

import math

import numpy as np
import xarray as xr

from mpm_warp.bodies.scene import BodyScene
from mpm_warp.fields.declaration import Value
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, labelled
from mpm_warp.scenes.blocks.block_on_base import SAMPLE_COUNT, BlockOnBase
from mpm_warp.simulation import Simulation

VIOLENT: dict[str, Value] = {"height_ratio": 0.5, "drive": 2e4, "travel": 0.01}
LONG: dict[str, Value] = {"height_ratio": 0.5, "friction": 0.8, "rest_time": 860.0}
"""Settings of extreme checks, on a coarse grid."""


class SlidingCurves:
    """Samples the block, which is body 0, from the start of the drive, when this is constructed.

    All loads act on the block. `along` is the unit vector along the interface.
    """

    def __init__(self, simulation: Simulation, scene: BlockOnBase, along: Floats) -> None:
        built = simulation.scene
        assert isinstance(built, BodyScene)
        self._simulation, self._scene = simulation, scene
        self._block, self._along = built.bodies[0], along
        self._samples: list[dict[str, float | Floats]] = []
        self.sample()

    def sample(self) -> None:
        """Add a sample."""
        array, mass = self._simulation.array, self._block.mass
        velocity, total = array("particle.velocity")[: len(mass)].copy(), array("contact.total")[0]
        damped = "particle.dissipated" in self._simulation.plan.arrays
        self._samples.append(
            {
                "time": self._simulation.time,
                "position": array("particle.position")[: len(mass)].copy(),
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
        """Quantities by name, over the samples; all energies but the kinetic are changes.

        The shear force is that on the base, a mean between two samples. `momentum_lack` is what the
        balance of momentum lacks [N s]; in axisymmetry only that along the axis, since hoop
        stresses change the radial momentum. `energy_lack` is the energy that the transfers between
        particles and grid dissipate [J].
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
            "since": time - self._scene.start,
            "velocity": values["momentum"] / float(mass.sum()) @ self._along,
            "displacement": displacement @ self._along,
            "shear_force": contact_force @ self._along,
            "kinetic_energy": values["kinetic_energy"],
            "load_work": load_work,
            "impulse": given,
            "momentum_lack": np.linalg.norm(lack[:, balanced], axis=1),
            "energy_lack": load_work - stored - taken,
        }

    def dataset(self) -> xr.Dataset:
        """The computed curves so far."""
        run = self._recorded

        def curve(name: str, unit: str, meaning: str) -> tuple[Floats, str, str]:
            return run[name][1:], unit, meaning

        return curves(
            "progress",
            (np.arange(1, len(self._samples)) / SAMPLE_COUNT, "1", "time over duration"),
            time=curve("since", "s", "time since the driving force began"),
            velocity=curve("velocity", "m s-1", "velocity of the block"),
            displacement=curve("displacement", "m", "displacement of the block"),
            shear_force=(run["shear_force"], "N", "base shear, mean since the sample before"),
            kinetic_energy=curve("kinetic_energy", "J", "kinetic energy"),
            elastic_energy=curve("elastic_energy", "J", "change of the elastic energy"),
            load_work=curve("load_work", "J", "work of the loads"),
            slip_work=curve("slip_work", "J", "work taken by slip"),
            viscous_work=curve("viscous_work", "J", "work taken by damping"),
        )

    def comparison(self) -> dict[str, xr.Variable]:
        """Exact curves, scalars over the second half of the run, and errors of the balances.

        The error of momentum is over the impulse of the loads at the end, that of energy over their
        greatest work.
        """
        run, motion = self._recorded, self._scene.motion
        since = run["since"]
        momentum = run["momentum_lack"] / np.linalg.norm(run["impulse"][-1])
        energy = run["energy_lack"] / float(np.abs(run["load_work"]).max())
        of_momentum, of_energy = (np.abs(lack).max() for lack in (momentum, energy))
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
            error = acceleration_error = abs(acceleration / exact_acceleration - 1.0)
        else:
            moved = run["displacement"]
            settled = np.flatnonzero(since >= self._scene.settled_time)[0]
            error = creep = float(abs(moved[-1] - moved[settled])) / self._scene.length
        if exact_base_shear > 0.0:
            shear_error = abs(base_shear / exact_base_shear - 1.0)
        which = "relative error of the acceleration, or the creep of a block that sticks"
        return (
            labelled(
                dims=("progress",),
                momentum_balance=(momentum[1:], "1", "error of the momentum balance"),
                energy_balance=(energy[1:], "1", "error of the energy balance"),
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
                momentum_error=(of_momentum, "1", "greatest error of the momentum balance"),
                energy_error=(of_energy, "1", "greatest error of the energy balance"),
                acceleration_error=(acceleration_error, "1", "relative error of the acceleration"),
                base_shear_error=(shear_error, "1", "relative error of the base shear"),
                creep=(creep, "1", "displacement over length of a block that sticks, once at rest"),
            )
            | labelled(role="headline", error=(error, "1", which))
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
