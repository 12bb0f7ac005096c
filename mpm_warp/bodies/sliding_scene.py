"""Block and base of the sliding block, as bodies in contact with their loads."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mpm_warp.bodies.interface import InterfaceFrame
from mpm_warp.bodies.scene import Body, BodyContact, BodyScene, Load
from mpm_warp.materials.materials import LinearElastic

if TYPE_CHECKING:
    from mpm_warp.scenes.families.block_on_base import BlockOnBase

BASE_CELLS = 3
"""Thickness of the base in cells."""


def sliding_scene(scene: BlockOnBase, frame: InterfaceFrame) -> BodyScene:
    """The scene: the block is body 0, the base body 1; `frame` is that of their interface."""
    block_material, base_material = _materials(scene)
    block = frame.body((0.0, scene.length), (0.0, scene.height), scene.spacing, block_material)
    margin, thickness = 3.0 * scene.cell_size, BASE_CELLS * scene.cell_size
    travel = scene.travel * scene.length if scene.motion.slides else 0.0
    end = scene.length + travel + margin
    base = frame.body((-margin, end), (-thickness, 0.0), scene.spacing, base_material)
    is_rigid = scene.stiffness_ratio is None
    held = (frame.height(base.position) < scene.cell_size - thickness) | is_rigid
    bodies = tuple(
        replace(body, retardation_time=_retardation_time(scene, body.material))
        for body in (
            replace(block, loads=_loads(scene, frame, block)),
            replace(base, held=held),
        )
    )
    contact = BodyContact(body=0, base=1, friction=scene.friction, adhesion=scene.adhesion)
    return BodyScene(
        grid=frame.grid_around(
            bodies, travel=travel, cell_size=scene.cell_size, offset=scene.grid_offset
        ),
        bodies=bodies,
        contacts=(contact,),
        time_step_fraction=scene.time_step_fraction,
    )


def _materials(scene: BlockOnBase) -> tuple[LinearElastic, LinearElastic]:
    """Those of block and base; the softer has the scene's shear modulus."""
    ratio = scene.stiffness_ratio or 1.0
    block, base = (
        LinearElastic(
            shear_modulus=scene.shear_modulus * factor,
            poissons_ratio=scene.poissons_ratio,
            density=scene.mass_scale * scene.density,
        )
        for factor in (max(1.0, 1.0 / ratio), max(1.0, ratio))
    )
    return block, base


def _loads(scene: BlockOnBase, frame: InterfaceFrame, block: Body) -> tuple[Load, Load]:
    """Weight and pressure, which rise first, and the driving force."""
    share = block.volume / block.volume.sum()
    on_top = share * (frame.height(block.position) > scene.height - scene.spacing)
    pressure_force = scene.normal_pressure * scene.area
    pressed = (scene.normal_force - pressure_force) * share
    pressed += pressure_force * on_top / on_top.sum()
    return (
        Load(forces=np.outer(-pressed, frame.outward), start=0.0, rise_time=0.5 * scene.start),
        Load(
            forces=np.outer(scene.driving_force * share, frame.along),
            start=scene.start,
            rise_time=scene.motion.rise_time or scene.duration,
        ),
    )


def _retardation_time(scene: BlockOnBase, material: LinearElastic) -> float | None:
    # The slowest wave, a quarter of it over the height, has omega = pi / 2 / crossing time.
    crossing = scene.height / material.shear_wave_speed
    return 4.0 / math.pi * scene.damping_ratio * crossing if scene.damping_ratio else None
