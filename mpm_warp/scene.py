"""What a user declares: a composition of parts. A part that is None costs nothing in the run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from mpm_warp.arguments import (
    FROM_ONE,
    POSITIVE,
    check_array,
    check_kind,
    check_number,
    check_whole,
)
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries.far_field import FarField
from mpm_warp.parts.boundaries.fixed import Fixed
from mpm_warp.parts.boundaries.moving_wall import MovingWall
from mpm_warp.parts.contact.contact import SurfaceContact
from mpm_warp.parts.part import FitsGrid, NodeAction
from mpm_warp.parts.window.cyclic_window import CyclicWindow
from mpm_warp.parts.window.passing_surface import PassingSurface
from mpm_warp.parts.window.surrounding_ground import SurroundingGround
from mpm_warp.parts.window.window import Window
from mpm_warp.precision import PRECISIONS

REQUIRED = {"grid": Grid, "material": Material, "forces": tuple, "precision": str} | dict.fromkeys(
    ("free_surface", "conservative_interpolation", "energy_audit", "energy_balance", "history"),
    bool,
)
"""Of what type a value of a scene has to be."""
OPTIONAL = {
    "fixed": (Fixed,),
    "far_field": (FarField,),
    "surroundings": (SurroundingGround,),
    "contact": (SurfaceContact,),
    "moving_wall": (MovingWall,),
    "window": (Window, CyclicWindow),
    "passing_surface": (PassingSurface,),
}
"""Of what type it has to be where it is not None."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """Soil in a grid, and what acts on it. SI units; stress is the excess over in-situ.

    Attributes:
        grid: the background grid; every cell that it says holds soil is full of it.
        material: the soil's constitutive model.
        particles_per_side: particles along each side of a cell, >= 1.
        time_step_fraction: time step over the critical one, dimensionless, > 0.
        bulk_viscosity: coefficient of the viscous pressure, dimensionless, > 0, or none.
        stress_at_rest: stress (rr, zz, rz, tt) of the soil at the start [Pa], shape [4]; none by
            default. It rests where it has no shear, its radial part is the hoop part, and what
            bounds the grid holds it: fixed nodes, or the surroundings, which start with it. Where
            the material varies it is none: the variation has the horizontal stress.
        forces: parts that act on nodes before all others, in this order: loads, gravity, damping,
            radial motion, or a user's own.
        fixed: nodes held at rest, or none.
        far_field: the medium around the grid, or none.
        surroundings: the ground around a window that travels with a body, or none; it takes the
            place of a far field.
        contact: contact with a rigid body, or none.
        moving_wall: inner wall that moves and takes the grid along, or none; it is a cylinder or a
            sphere, and there is no window then.
        window: travel of the grid through the soil, or none; around a cyclic one the ground rests,
            so there is neither a far field nor surroundings then.
        free_surface: whether the surface of the ground passes through cells: their stress then acts
            as far as they are filled.
        passing_surface: the free surface that a window leaves behind, or none; the scene has a
            window and a free surface then.
        conservative_interpolation: whether particles follow a flow that changes volume alike all
            over a cell; for soil that streams along a wall for long. The grid has horizontal rows.
        energy_audit: whether to sample what energy the transfers create or dissipate.
        energy_balance: whether to sample where the work of the body goes; the scene has a window, a
            contact, a bulk viscosity and an energy audit then.
        history: whether particles keep where they entered, and add up their plastic shear strain.
        precision: floating point numbers of the run, "float64" or "float32".

    Raises:
        SceneError: a value is not allowed, or two parts do not go together.
    """

    grid: Grid
    material: Material
    particles_per_side: int
    time_step_fraction: float
    bulk_viscosity: float | None = None
    stress_at_rest: Floats = field(default_factory=lambda: np.zeros(4))
    forces: tuple[NodeAction, ...] = ()
    fixed: Fixed | None = None
    far_field: FarField | None = None
    surroundings: SurroundingGround | None = None
    contact: SurfaceContact | None = None
    moving_wall: MovingWall | None = None
    window: Window | CyclicWindow | None = None
    free_surface: bool = False
    passing_surface: PassingSurface | None = None
    conservative_interpolation: bool = False
    energy_audit: bool = False
    energy_balance: bool = False
    history: bool = False
    precision: str = "float64"

    def __post_init__(self) -> None:
        check_whole("particles_per_side", self.particles_per_side, FROM_ONE)
        check_number("time_step_fraction", self.time_step_fraction, POSITIVE)
        if self.bulk_viscosity is not None:
            check_number("bulk_viscosity", self.bulk_viscosity, POSITIVE)
        check_array("stress_at_rest", self.stress_at_rest, (4,))
        for name, kind in REQUIRED.items():
            check_kind(name, getattr(self, name), kind)
        for name, kinds in OPTIONAL.items():
            check_kind(name, getattr(self, name), (*kinds, type(None)))
        for number, force in enumerate(self.forces):
            if not isinstance(force, NodeAction):
                raise SceneError(f"forces[{number}]: a {type(force).__name__} has no `add_to`")
        if self.precision not in PRECISIONS:
            raise SceneError(
                f"precision = {self.precision!r} must be one of {', '.join(PRECISIONS)}"
            )
        self._check_together()
        for part in self.node_actions:
            if isinstance(part, FitsGrid):
                part.check(self)

    def stress_at_rest_at(self, place: Floats) -> Floats:
        """Stress (rr, zz, rz, tt) of the ground before, at places in it [Pa], shape [..., 4].

        Args:
            place: (r, z) in the ground [m], shape [..., 2]; see `Variation`.
        """
        stress = np.tile(self.stress_at_rest, (*place.shape[:-1], 1))
        if self.material.variation is not None:
            horizontal = self.material.variation.horizontal_stress_at(place)
            stress[..., [0, 3]] += horizontal[..., None]
        return stress

    def _check_together(self) -> None:
        """Check that what there is goes together."""
        leans = np.ptp(self.grid.surface_radius) > 0.0
        varies = self.material.variation is not None
        turns = isinstance(self.window, CyclicWindow)
        for name, does_not_go_with, why in (
            ("moving_wall", leans or self.grid.planar, "a grid that leans or is plane"),
            ("moving_wall", self.grid.columns[-1] > 1.0, "columns beyond the fitted radius"),
            ("moving_wall", self.window, "a window"),
            ("window", self.grid.polar, "a grid of rays"),
            ("window", turns and varies, "a material that varies, where it is cyclic"),
            ("far_field", turns, "a cyclic window; hold the nodes around the grid"),
            ("surroundings", turns, "a cyclic window; hold the nodes around the grid"),
            ("surroundings", self.far_field, "a far field"),
            (
                "passing_surface",
                self.window is None or turns,
                "a grid that stays; give it a window",
            ),
            ("passing_surface", not self.free_surface, "full cells; set free_surface"),
            ("surroundings", self.window is None, "a grid at rest; give it a window"),
            ("conservative_interpolation", self.grid.polar, "a grid of rays"),
            ("far_field", varies, "a material that varies; around a window give it surroundings"),
            ("moving_wall", varies, "a material that varies"),
        ):
            if getattr(self, name) and does_not_go_with:
                raise SceneError(f"{name}: not together with {why}")
        if varies and np.any(self.stress_at_rest):
            raise SceneError("stress_at_rest: not together with a material that varies")
        if self.energy_balance:
            for name in ("window", "contact", "bulk_viscosity", "energy_audit"):
                if not getattr(self, name):
                    raise SceneError(f"energy_balance: not without {name}")

    @property
    def node_actions(self) -> Iterator[NodeAction]:
        """The parts that act on nodes, in their order, or that follow the window beside them.

        The push of a moving wall comes after.
        """
        yield from self.forces
        for part in (
            self.fixed,
            self.far_field,
            self.surroundings,
            self.contact,
            self.passing_surface,
        ):
            if part is not None:
                yield part

    @property
    def has_mass_matrix_correction(self) -> bool:
        """Whether nodes are given back what the transfers take from their velocity at the least.

        The correction is that of full cells. Where a surface passes only those far below it have
        it. A single particle in the middle of a cell takes nothing of what it gives back.
        """
        has_full_cells = not self.free_surface or self.passing_surface is not None
        return self.particles_per_side > 1 and has_full_cells
