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
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.sampling import evenly, follow
from mpm_warp.scenes.blocks.block_on_base import BASE_CELLS, SAMPLE_COUNT, BlockOnBase
from mpm_warp.scenes.blocks.sliding_curves import SlidingCurves
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

    Example:
        >>> block = SlidingBlock(slope=30, friction=0.3)
        >>> round(block.normal_force), round(block.driving_force)  # [N]
        (5097, 2943)
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
