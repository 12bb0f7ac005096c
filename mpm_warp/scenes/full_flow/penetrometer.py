"""What all tests of ball and T-bar share: outline, soil, grid and contact."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import parameter, redefined
from mpm_warp.grid.fitted import Floats, Grid, growing, nodal_areas
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.parts.enclosed_soil import EnclosedSoil
from mpm_warp.parts.energy import EnergyAudit
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.parts.window import Window
from mpm_warp.results import curves
from mpm_warp.sampling import ContactForces, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.bearing import upward_force
from mpm_warp.scenes.clay_tower import FieldClayScene
from mpm_warp.scenes.cone.parameters import ConeInGround
from mpm_warp.scenes.cone.penetration import RESISTANCE_OVER_STRENGTH, penetration_axis
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

NO_PARTING = 1000.0
"""In-situ stress over su: more than any tension of the soil, so that it closes behind the body."""
FITTED_RADIUS = 3.0
"""Approximate radius up to which the columns of nodes follow the surface, over that of the body.
The mechanism reaches about as far."""
POLE_ROW = 0.5
"""Height of the rows beside the poles over that of the rows beyond the body. Full rows would leave
one long chord at a pole, and an error of first order in their height."""
T_BAR_STRAIN = 3.7
"""Plastic shear strain xi_p of one passage of a T-bar, for xi_95 = 2 xi_p n_95.

It comes from upper bounds of Einav & Randolph 2005 and is usual since (Zhou & Randolph 2009,
Geotechnique 59(2):79-86). That of a ball is about as large.
"""
SANE_INERTIA, GREATEST_INERTIA = 1.0, 5.0
"""Inertia, rho V^2 over the remaining strength: most cases complete below the first, few above the
second."""
BRITTLE_STRENGTH, BRITTLE_STRAIN = 0.15, 5.0
"""Remoulded strength ratio and ductility of brittle clay. Where both are less, soil shears in
layers thinner than cells: 3 of 20 random balls complete, of the others 37 of 62."""


@dataclass(frozen=True, kw_only=True)
class RoundBody:
    """A ball below a thin smooth shaft, or a cylinder in plane strain, with its centre at z = 0."""

    radius: float  # R [m], > 0
    shaft_radius: float = 0.0  # [m], 0 (no shaft) to less than R
    planar: bool = False  # True: a cylinder in plane strain; False: a ball

    def surface_radius(self, height: Floats) -> Floats:
        """Radius of the surface at heights [m]; 0 above and below the body."""
        body = np.sqrt(np.clip(self.radius**2 - height**2, 0.0, None))
        return np.maximum(body, np.where(height > 0.0, self.shaft_radius, 0.0))

    def fitted_grid(self, *, cells_per_radius: int, columns: Floats, extent: int) -> Grid:
        """A grid whose rows meet both poles and whose first column follows the surface.

        Columns far from the body are upright, so that the cells near it do not depend on the size
        of the grid. Columns are at given distances from the equator, rising from 0 [m]. The grid
        reaches `extent` radii above and below the centre, >= 2.
        """
        size = self.radius / cells_per_radius
        at_body = np.linspace(0.0, self.radius - POLE_ROW * size, cells_per_radius + 1)
        beyond = self.radius + size * np.arange((extent - 1) * cells_per_radius + 1)
        above = np.append(at_body, beyond)
        rows = np.append(-above[:0:-1], above)
        last_fitted = int(np.argmin(np.abs(columns - (FITTED_RADIUS - 1.0) * self.radius)))
        fitted, upright = np.split(columns, [last_fitted + 1])
        fitted_radius = self.radius + float(fitted[-1])
        return Grid(
            columns=np.append(fitted / fitted[-1], (self.radius + upright) / fitted_radius),
            rows=rows,
            surface_radius=self.surface_radius(rows),
            fitted_radius=fitted_radius,
            planar=self.planar,
        )

    def contact(self, grid: Grid, *, adhesion: float, in_situ_stress: float) -> SurfaceContact:
        """Contact at all nodes of the surface of a fitted grid, from the lower pole upward.

        Normals are those of the consistent area vectors, so that no net flow passes through the
        surface. The nodes of the poles are on the axis too: both hold the soil there, of which the
        flow leaves few material points. The adhesion of ball or bar and the in-situ stress are in
        Pa, >= 0; the shaft is smooth.
        """
        off_axis = np.flatnonzero(grid.surface_radius > 0.0)
        upper_end = min(off_axis[-1] + 1, grid.row_count)
        rows = np.arange(off_axis[0] - 1, upper_end + 1, dtype=np.int32)
        radius, height = grid.surface_radius[rows], grid.rows[rows]
        weight = grid.weight(radius)
        rise, lean = np.diff(height), np.diff(radius)
        vectors = -grid.wall_vectors[rows]
        vectors[radius == 0.0, 0] = 0.0
        normal_areas = np.linalg.norm(vectors, axis=1)
        of_body = np.where(lean != 0.0, np.hypot(lean, rise), 0.0)
        return SurfaceContact(
            nodes=grid.node(0, rows),
            normals=vectors / normal_areas[:, None],
            normal_areas=normal_areas,
            adhesion_forces=adhesion * nodal_areas(weight, of_body),
            in_situ_stress=in_situ_stress,
        )


@dataclass(frozen=True, kw_only=True)
class FullFlowPenetrometer(FieldClayScene):
    """A round body that moves through uniform, weightless, undrained clay.

    It starts in place, deep in undisturbed ground, and soil and body do not part. Stresses are
    those in excess of the isotropic in-situ stress, which is in equilibrium by itself.
    """

    method: ClassVar[tuple[str, ...]] = (
        "cells_per_radius",
        "cell_growth",
        "particles_per_cell",
        "speed_ratio",
        "domain_extent",
    )

    rigidity_index: float = redefined(FieldClayScene, "rigidity_index", minimum=20)
    adhesion_factor: float = redefined(
        ConeInGround, "adhesion_factor", meaning="adhesion factor of the body"
    )
    poissons_ratio: float = redefined(FieldClayScene, "poissons_ratio", minimum=0.4)
    speed_ratio: float = parameter(
        None,
        "penetration speed over shear wave speed (default: 0.3 / sqrt(Ir), 0.15 / sqrt(Ir) in "
        "cyclic tests)",
        minimum=1e-4,
        maximum=0.1,
    )
    cells_per_radius: int = parameter(4, "cells per radius of the body", minimum=2, maximum=40)
    cell_growth: float = redefined(ConeInGround, "cell_growth")
    particles_per_cell: int = parameter(9, "material points per cell", choices=(4, 9, 16))
    domain_extent: int = parameter(
        8,
        "extent of the grid below, above and beside the centre over radius",
        minimum=3,
        maximum=100,
    )

    relative_speed = 0.3
    """Default speed over sqrt(su / rho): rho V^2 is 9 % of su."""

    def derived(self) -> Mapping[str, float]:
        """The default speed over that of shear waves, which rises with sqrt(Ir)."""
        return {"speed_ratio": self.relative_speed / math.sqrt(self.rigidity_index)}

    @property
    @abstractmethod
    def body(self) -> RoundBody:
        """The penetrometer."""

    @property
    @abstractmethod
    def window(self) -> Window | CyclicWindow:
        """The window, which travels with the body."""

    @property
    def speed(self) -> float:
        """Speed of the body in the run [m/s], by the stiffness that the law has."""
        return self.speed_ratio * math.sqrt(self.clay.ground_shear_modulus / self.density)

    @property
    @abstractmethod
    def last_cycle(self) -> float:
        """Number n of the last passage: soil has then borne a plastic strain of 2 n xi_p."""

    @property
    def strength_left(self) -> float:
        """Strength in the last passage over su, by the formula of `cyclic`."""
        if self.ductility is None:
            return 1.0
        decay = math.exp(-6.0 * self.last_cycle * T_BAR_STRAIN / self.ductility)
        return self.remoulded_strength_ratio + (1.0 - self.remoulded_strength_ratio) * decay

    @property
    def inertia(self) -> float:
        """Inertia: rho V^2 over the strength in the last passage."""
        return self.rigidity_index * self.speed_ratio**2 / self.strength_left

    @property
    def brittle(self) -> str:
        """Why a push in brittle clay is likely to fail; "" where the clay is not brittle."""
        strain = math.inf if self.ductility is None else self.ductility
        if self.remoulded_strength_ratio >= BRITTLE_STRENGTH or strain >= BRITTLE_STRAIN:
            return ""
        return (
            "the clay is brittle, and shears in layers thinner than the cells; no choice of the "
            f"method is known to help below a ductility of {BRITTLE_STRAIN:g} with a "
            f"remoulded_strength_ratio below {BRITTLE_STRENGTH:g}"
        )

    def thrown_off(self, limit: float) -> str:
        """Message for an inertia above `limit`: why the run fails, and the speed to take."""
        speed_ratio = math.sqrt(SANE_INERTIA * self.strength_left / self.rigidity_index)
        return (
            f"rho V^2 is {self.inertia:.3g} of the strength that is left in the end, and above "
            f"{limit:g} soil is thrown off; try speed_ratio = {speed_ratio:.2g} or less"
        )

    @property
    def clay(self) -> Material:
        """The soil, with strain rates as at the real speed."""
        shear_modulus = self.rigidity_index * self.undrained_shear_strength
        speed = self.speed_ratio * math.sqrt(shear_modulus / self.density)
        return self.clay_with(density=self.density, speed_up=speed / self.penetration_speed)

    def build(self) -> Scene:
        """The soil around the body, in a grid that travels with it."""
        radius, su = self.body.radius, self.undrained_shear_strength
        size = radius / self.cells_per_radius
        growth = 1.0 + self.cell_growth / self.cells_per_radius
        grid = self.body.fitted_grid(
            cells_per_radius=self.cells_per_radius,
            columns=growing(size, (self.domain_extent - 1.0) * radius, growth),
            extent=self.domain_extent,
        )
        clay, around = self.clay, list[SurroundingGround]()
        if self.body.shaft_radius > 0.0:
            # Without a shaft as much soil closes behind the body as it pushes aside, so the ground
            # around the window rests. Seen from afar a growing shaft is a travelling source.
            shaft, stiffness = self.body.shaft_radius, clay.ground_shear_modulus
            source = TravellingSource(radius=shaft, height=0.0, shear_modulus=stiffness)
            around = [SurroundingGround(grid=grid, material=clay, source=source, strength=su)]
        at_rest = [] if around else ["bottom", "top", "side"]
        return Scene(
            grid=grid,
            material=clay,
            particles_per_side=math.isqrt(self.particles_per_cell),
            bulk_viscosity=0.2,
            parts=(
                Fixed.on(grid, radial=["axis", *at_rest], vertical=at_rest),
                *around,
                self.body.contact(
                    grid, adhesion=self.adhesion_factor * su, in_situ_stress=NO_PARTING * su
                ),
                self.window,
                EnclosedSoil(),
                ConservativeInterpolation(),
                EnergyAudit(),
            ),
        )


@dataclass(frozen=True, kw_only=True)
class Ball(FullFlowPenetrometer):
    """A ball without a shaft, unless a scene gives it one."""

    shaft_radius_ratio = 0.0
    ball_radius: float = parameter(
        0.0565, "radius of the ball", unit="m", minimum=1e-6, maximum=1e3
    )

    @property
    def body(self) -> RoundBody:
        """The ball and its shaft."""
        shaft_radius = self.shaft_radius_ratio * self.ball_radius
        return RoundBody(radius=self.ball_radius, shaft_radius=shaft_radius)


@dataclass(frozen=True, kw_only=True)
class TBar(FullFlowPenetrometer):
    """A bar that moves across its axis, in plane strain."""

    bar_radius: float = parameter(0.02, "radius of the T-bar", unit="m", minimum=1e-6, maximum=1e3)

    @property
    def body(self) -> RoundBody:
        """The T-bar."""
        return RoundBody(radius=self.bar_radius, planar=True)


class ResistanceSamples:
    """Samples the resistance every `SAMPLE_SPACING` radii, each the mean since the sample before.

    `forces` are those of the soil on half a cylinder of unit length or on a radian of a ball,
    upward positive [N], shape [sample_count].
    """

    def __init__(self, simulation: Simulation, body: RoundBody) -> None:
        self._contact = soil_scene(simulation)[SurfaceContact]
        self._radius = body.radius
        self._area = body.radius if body.planar else 0.5 * body.radius**2
        self._contact_forces = ContactForces(simulation)
        self.forces: list[float] = []

    def sample(self) -> None:
        """Append the mean force since the sample before."""
        self.forces.append(upward_force(self._contact, self._contact_forces.take()))

    @property
    def resistance(self) -> Floats:
        """Force over projected area [Pa], shape [sample_count]."""
        return np.array(self.forces) / self._area

    @property
    def work(self) -> float:
        """Work of the body so far [J], per radian or of half a cylinder of unit length."""
        return math.fsum(self.forces) * SAMPLE_SPACING * self._radius

    def dataset(self) -> xr.Dataset:
        """The curve of resistance over penetration."""
        what = "resistance over projected area"
        over = "excess over the in-situ stress, as simulated: not corrected for mesh and speed"
        return curves(
            "penetration",
            penetration_axis(len(self.forces), over="radius of the body"),
            penetration_resistance=(self.resistance, "Pa", what, over, RESISTANCE_OVER_STRENGTH),
        )
