"""An elastic block on a base, which sticks or slides under friction and adhesion."""

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import xarray as xr

from mpm_warp.bodies.body import Body, InterfaceFrame, Load
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parameters import Value
from mpm_warp.sampling import evenly, follow
from mpm_warp.scenes.blocks.block_on_base import BASE_CELLS, SAMPLE_COUNT, BlockOnBase
from mpm_warp.scenes.blocks.curves import SlidingCurves
from mpm_warp.scenes.catalogue import Progress, compared
from mpm_warp.simulation import Simulation

VIOLENT: dict[str, Value] = {"height_ratio": 0.5, "drive": 2e4, "travel": 0.01}
LONG: dict[str, Value] = {"height_ratio": 0.5, "friction": 0.8, "rest_time": 860.0}
"""Of checks on a coarse grid."""


_compared = partial(compared, "cells_per_length", (10, 20))
_extreme = partial(compared, "cells_per_length", (6,), extreme=True)


@dataclass(frozen=True, kw_only=True)
class SlidingBlock(BlockOnBase):
    """A block is pressed on a base and driven along it, and its motion compared with the exact one.

    The error is that of its acceleration, or the creep of a block that sticks.
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
        return curves.assign(sampler.balances()).assign(sampler.comparison())

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
        """Weight and pressure, which rise first, and the driving force."""
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
        # The slowest wave, a quarter of it over the height, has omega = pi / 2 / crossing time.
        crossing = self.height / material.shear_wave_speed
        return 4.0 / math.pi * self.damping_ratio * crossing if self.damping_ratio else None
