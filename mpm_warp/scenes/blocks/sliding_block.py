"""An elastic block on a base, which sticks or slides under friction and adhesion."""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.bodies.body import MARGIN, Body, InterfaceFrame, Load, critical_time_step
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.fields.declaration import Value
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import evenly, follow
from mpm_warp.scenes.blocks.block_on_base import BASE_CELLS, SAMPLE_COUNT, BlockOnBase
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.limits import LARGEST_ERROR, LARGEST_LACK, Limit, Limits
from mpm_warp.scenes.run_size import RunSize, size_of_bodies
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

VIOLENT: dict[str, Value] = {"height_ratio": 0.5, "drive": 2e4, "travel": 0.01}
LONG: dict[str, Value] = {"height_ratio": 0.5, "friction": 0.8, "rest_time": 860.0}
"""Settings of extreme checks, on a coarse grid."""
FINER = "more cells_per_length, a longer travel or rest_time, or a softer block"
"""What to try where an error or a balance is beyond its limit."""
_compared = partial(compared, "cells_per_length", (10, 20))
_extreme = partial(compared, "cells_per_length", (6,), extreme=True)


@dataclass(frozen=True, kw_only=True)
class SlidingBlock(BlockOnBase):
    """A block pressed on a base and driven along it, against the exact motion of a rigid block.

    The error is the relative error of its acceleration, or the creep of a block that sticks.
    """

    summary = "elastic block on a base, driven until it slides; exact solution"
    version = 4
    method = ("cells_per_length", "particles_per_cell", "time_step_fraction", "damping_ratio")
    verifications = (
        *_compared(error=0.01),
        *_compared({"grid_angle": 20.0, "grid_offset": 0.3, "stiffness_ratio": 1.0}, error=0.03),
        *_compared({"friction": 0.8}, error=1e-4),
        *_extreme(*({**VIOLENT, "stiffness_ratio": ratio} for ratio in (1e-6, 1e6)), error=0.01),
        *_extreme(*({**LONG, "grid_angle": angle} for angle in (0.0, 20.0)), error=1e-4),
    )
    limits: ClassVar[Limits] = {
        "error": Limit(LARGEST_ERROR, FINER),
        "momentum_error": Limit(LARGEST_LACK, FINER),
        "energy_error": Limit(LARGEST_LACK, FINER),
        "acceleration_error": "it is the error of a block that slides",
        "creep": "it is the error of a block that sticks",
        "base_shear_error": "it follows from the errors of acceleration and momentum",
    }

    @property
    def limits_of_run(self) -> Limits:
        """See `CatalogueScene`: a block that sticks does no work that its balance could be over."""
        own = {} if self.motion.slides else {"energy_error": "the block does no work"}
        return {**self.limits, **own}

    def run_size(self) -> RunSize:
        """See `CatalogueScene`."""
        travel = self.travel if self.motion.slides else 0.0
        along = self.cells_per_length * (1.0 + travel) + 2 * BASE_CELLS
        height = self.cells_per_length * self.height_ratio
        cos, sin = (abs(turned(math.radians(self.grid_angle))) for turned in (math.cos, math.sin))
        across, margin = height + BASE_CELLS, 2 * MARGIN + 1
        columns, rows = along * cos + across * sin + margin, along * sin + across * cos + margin
        block_count = self.cells_per_length * height * self.particles_per_cell
        time_step = self.time_step_fraction * min(
            critical_time_step(self.cell_size, material, self._retardation_time(material))
            for material in self._materials
        )
        return size_of_bodies(
            cell_count=round(columns * rows),
            particle_count=round(block_count + along * BASE_CELLS * self.particles_per_cell),
            step_count=(self.start + self.duration) / time_step,
            # Positions of the points of the block: samples, their stack, and three such arrays.
            curve_bytes=5.0 * 16.0 * (SAMPLE_COUNT + 1) * block_count,
        )

    def build(self) -> BodyScene:
        """The block is body 0, the base body 1."""
        frame = self._frame
        block_material, base_material = self._materials
        block = frame.body((0.0, self.length), (0.0, self.height), self.spacing, block_material)
        margin = thickness = BASE_CELLS * self.cell_size
        travel = self.travel * self.length if self.motion.slides else 0.0
        end = self.length + travel + margin
        base = frame.body((-margin, end), (-thickness, 0.0), self.spacing, base_material)
        is_rigid = self.stiffness_ratio is None
        held = (frame.height(base.position) < self.cell_size - thickness) | is_rigid
        bodies = (
            replace(
                block,
                loads=self._loads(block),
                retardation_time=self._retardation_time(block_material),
            ),
            replace(base, held=held, retardation_time=self._retardation_time(base_material)),
        )
        return BodyScene(
            grid=frame.grid_around(
                bodies, travel=travel, cell_size=self.cell_size, offset=self.grid_offset
            ),
            bodies=bodies,
            contact=BodyContact(friction=self.friction, adhesion=self.adhesion),
            time_step_fraction=self.time_step_fraction,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Let the block come to rest under its normal load, then drive it."""
        simulation.advance_to(self.start)
        sampler = SlidingCurves(simulation, self, self._frame.along)
        moments = [self.start + since for since in evenly(self.duration, SAMPLE_COUNT)]
        curves = follow(simulation, moments, simulation.advance_to, [sampler], progress)
        return curves.assign(sampler.comparison())

    @property
    def _frame(self) -> InterfaceFrame:
        return InterfaceFrame(
            angle=math.radians(self.grid_angle), interface_radius=self.interface_radius
        )

    @property
    def _materials(self) -> tuple[LinearElastic, LinearElastic]:
        """Materials of block and base; the softer has the shear modulus of the scene."""
        ratio = self.stiffness_ratio or 1.0
        block, base = (
            LinearElastic(
                shear_modulus=self.shear_modulus * factor,
                poissons_ratio=self.poissons_ratio,
                density=self.mass_scale * self.density,
            )
            for factor in (max(1.0, 1.0 / ratio), max(1.0, ratio))
        )
        return block, base

    def _loads(self, block: Body) -> tuple[Load, Load]:
        """The normal load, from weight and pressure, and then the driving force."""
        frame = self._frame
        share = block.volume / block.volume.sum()
        on_top = share * (frame.height(block.position) > self.height - self.spacing)
        pressure_force = self.normal_pressure * self.area
        pressed = (self.normal_force - pressure_force) * share
        pressed += pressure_force * on_top / on_top.sum()
        return (
            Load(forces=np.outer(-pressed, frame.outward), start=0.0, rise_time=0.5 * self.start),
            Load(
                forces=np.outer(self.driving_force * share, frame.along),
                start=self.start,
                rise_time=self.motion.rise_time or self.duration,
            ),
        )

    def _retardation_time(self, material: LinearElastic) -> float | None:
        # The slowest wave has four times the height, and so omega = pi / 2 / crossing time.
        crossing = self.height / material.shear_wave_speed
        return 4.0 / math.pi * self.damping_ratio * crossing if self.damping_ratio else None


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
