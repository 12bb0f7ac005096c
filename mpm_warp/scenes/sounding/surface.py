"""A sounding that starts with the tip at the surface of the ground.

Soil fills the grid up to the surface only. The cone goes in, soil heaves beside it, the surface
moves up through the window and leaves it above. From then on the scene is that of the deep cone.

The soil is weightless. Its weight is in the in-situ stress, and acts on the cone as sigma_v0. The
weight of the heave is left out: it is some gamma R / su, about 0.01, of the strength.
"""

from __future__ import annotations

from dataclasses import replace

from mpm_warp.grid.fitted import GroundGrid
from mpm_warp.grid.seeding import seed_rows
from mpm_warp.parts.free_surface import PassingSurface
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene

LAYER = 1.0
"""Thickness of the layer of soil that counts as near the surface, over the cone's radius; when it
has left the window above, nothing of the surface is in it."""
PIC_FRACTION = 0.02
"""Share of the velocity that material points in that layer take from the grid as it is, in a step.
Without it soil is thrown off the surface. At 0.01 and 0.03, 3 cells per radius, the resistance
differs by 10 % two radii below the surface, and by 1 % from three radii on."""
TIME_STEP_FRACTION = 0.7
"""Greatest time step over the critical one: cells near the surface have no mass-matrix correction,
without which 0.76 is stable."""


def from_surface(scene: Scene, *, level: float, radius: float) -> Scene:
    """The scene of a cone test, with soil up to a level only.

    Args:
        scene: of a cone in undisturbed, endless ground.
        level: height of the surface above the tip at the start [m], <= 0.
        radius: of the cone [m].
    """
    grid, window = GroundGrid.of(scene.grid, level), scene[Window]
    points_of_cell = scene.particles_per_side**2
    seeded = seed_rows(grid, 0, grid.row_count, scene.particles_per_side).particle_count
    slots = (1.0 + window.spare_fraction) * grid.cell_count * points_of_cell
    return replace(scene, grid=grid).with_parts(
        replace(window, spare_fraction=slots / seeded - 1.0),
        PassingSurface(level=level, layer=LAYER * radius, pic_fraction=PIC_FRACTION),
    )
