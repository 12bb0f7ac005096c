"""What a user declares: a composition of parts. A part that is None costs nothing in the run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.grid.fitted import Grid
from mpm_warp.precision import PRECISIONS
from mpm_warp.parts.loads import NodalLoad
from mpm_warp.materials.materials import LinearElastic
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.parts.window import Window


class SceneError(ValueError):
    """A scene is not one that can be run; the message is one line.

    Attributes:
        status: how a harness files the case.
    """

    status = "refused"


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """Soil in a grid, and what acts on it. SI units; stress is the excess over in-situ.

    Attributes:
        grid: the background grid; every cell that it says holds soil is full of it.
        material: the soil's constitutive model.
        particles_per_side: particles along each side of a cell, >= 1.
        time_step_fraction: time step over the critical one, dimensionless, > 0.
        bulk_viscosity: coefficient of the viscous pressure, dimensionless, > 0, or none.
        load: forces on nodes, or none.
        gravity: acceleration downward [m/s2], > 0, or none.
        damping: rate at which all motion dies out, force over momentum [1/s], > 0, or none: for
            states of rest.
        fixed: nodes held at rest, or none.
        far_field: the medium around the grid, or none.
        contact: contact with a rigid body, or none.
        moving_wall: inner wall that moves and takes the grid along, or none; it is a cylinder or a
            sphere, and there is no window then.
        window: travel of the grid through the soil, or none.
        free_surface: whether the surface of the ground passes through cells: their stress then acts
            as far as they are filled.
        even_flow: whether flow is made even within cells, see `mpm_warp.parts.even_flow_kernel`; for
            soil that streams along a wall for long. The grid is axisymmetric, of horizontal rows.
        consistent_mass: whether momentum is that of the consistent mass matrix, so that waves keep
            their energy, see `mpm_warp.step.consistent_mass`; on a grid with horizontal rows
            and without a window.
        energy_audit: whether to sample what energy the transfers create or dissipate.
        precision: floating point numbers of the run, by a name of `PRECISIONS`.

    Raises:
        SceneError: a value is not allowed, or two parts do not go together.
    """

    grid: Grid
    material: LinearElastic
    particles_per_side: int
    time_step_fraction: float
    bulk_viscosity: float | None = None
    load: NodalLoad | None = None
    gravity: float | None = None
    damping: float | None = None
    fixed: Fixed | None = None
    far_field: FarField | None = None
    contact: SurfaceContact | None = None
    moving_wall: MovingWall | None = None
    window: Window | None = None
    free_surface: bool = False
    even_flow: bool = False
    consistent_mass: bool = False
    energy_audit: bool = False
    precision: str = "float64"

    def __post_init__(self) -> None:
        for name in ("particles_per_side", "time_step_fraction"):
            if not getattr(self, name) > 0:
                raise SceneError(f"{name} = {getattr(self, name):g} must be > 0")
        for name in ("bulk_viscosity", "gravity", "damping"):
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise SceneError(f"{name} = {value:g} must be > 0, or none")
        if self.precision not in PRECISIONS:
            raise SceneError(
                f"precision = {self.precision!r} must be one of {', '.join(PRECISIONS)}"
            )
        leans = np.ptp(self.grid.surface_radius) > 0.0
        for part, does_not_go_with, why in (
            ("moving_wall", leans or self.grid.planar, "a grid that leans or is plane"),
            ("moving_wall", self.window, "a window"),
            ("even_flow", self.grid.polar or self.grid.planar, "a grid of rays or that is plane"),
            ("consistent_mass", self.grid.polar, "a grid of rays"),
            ("consistent_mass", self.window, "a window"),
        ):
            if getattr(self, part) and does_not_go_with:
                raise SceneError(f"{part}: not together with {why}")

    @property
    def sharpened(self) -> bool:
        """Whether nodes are given back what the transfers take from their velocity at the least.

        See `mpm_warp.step.mass_matrix_correction`: it is that of full cells, and a part of what the
        consistent mass matrix gives back. A single particle in the middle of a cell takes nothing
        of what is sharpened.
        """
        return self.particles_per_side > 1 and not (self.consistent_mass or self.free_surface)
