"""What ball and T-bar have in common, however they are moved: soil, grid, contact."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid, growing
from mpm_warp.materials.material import Material
from mpm_warp.parameters import parameter, redefined
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.parts.energy import EnergyAudit
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.surrounding_ground import SurroundingGround
from mpm_warp.parts.window import Window
from mpm_warp.results import curves
from mpm_warp.sampling import ContactForces, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.clay import FieldClayScene
from mpm_warp.scenes.cone.parameters import ConeGrid, ConeInGround
from mpm_warp.scenes.cone.penetration import penetration_axis
from mpm_warp.scenes.full_flow.round_body import RoundBody, upward_force
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

NO_PARTING = 1000.0
"""In-situ stress over su, above any that the soil can pull with: it closes behind the body."""


@dataclass(frozen=True, kw_only=True)
class FullFlowPenetrometer(FieldClayScene):
    """A round body that moves through uniform, weightless, undrained clay.

    It starts in place, deep in undisturbed ground, and the soil never leaves it. Excess stresses
    are simulated: those over the isotropic in-situ stress, which balances itself.
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
        "penetration speed over shear wave speed (default: 0.3 / sqrt(Ir))",
        minimum=1e-4,
        maximum=0.1,
    )
    cells_per_radius: int = parameter(4, "cells per radius of the body", minimum=2, maximum=40)
    cell_growth: float = redefined(ConeGrid, "cell_growth")
    particles_per_cell: int = parameter(9, "material points per cell", choices=(4, 9, 16))
    domain_extent: int = parameter(
        8,
        "extent of the grid below, above and beside the centre over radius",
        minimum=3,
        maximum=100,
    )

    relative_speed = 0.3
    """Speed over sqrt(su / rho), by default: rho V^2 is 9 % of su."""

    def derived(self) -> Mapping[str, float]:
        """The stiffer the clay, the faster its waves, and the slower the body against them."""
        return {"speed_ratio": self.relative_speed / math.sqrt(self.rigidity_index)}

    @property
    @abstractmethod
    def body(self) -> RoundBody:
        """Its outline, and the grid fitted to it."""

    def surroundings(self, grid: Grid) -> SurroundingGround | None:
        """The ground around the window; none where it rests.

        It rests unless a shaft follows: as much soil closes behind the body as it pushes aside.
        """
        return None

    @property
    @abstractmethod
    def window(self) -> Window | CyclicWindow:
        """How the grid travels with the body."""

    @property
    def speed(self) -> float:
        """Of the body in the run [m/s]."""
        shear_modulus = self.rigidity_index * self.undrained_shear_strength
        return self.speed_ratio * math.sqrt(shear_modulus / self.density)

    @property
    def clay(self) -> Material:
        """The soil."""
        return self.clay_with(
            strength=self.undrained_shear_strength,
            density=self.density,
            speed_up=self.speed / self.penetration_speed,
        )

    @property
    def grid(self) -> Grid:
        """The grid around the body, which travels with it."""
        radius = self.body.radius
        size = radius / self.cells_per_radius
        growth = 1.0 + self.cell_growth / self.cells_per_radius
        return self.body.fitted_grid(
            cells_per_radius=self.cells_per_radius,
            columns=growing(size, (self.domain_extent - 1.0) * radius, growth),
            extent=self.domain_extent,
        )

    def build(self) -> Scene:
        """The soil around the body."""
        grid, strength = self.grid, self.undrained_shear_strength
        surroundings = self.surroundings(grid)
        at_rest = ["bottom", "top", "side"] if surroundings is None else []
        return Scene(
            grid=grid,
            material=self.clay,
            particles_per_side=math.isqrt(self.particles_per_cell),
            bulk_viscosity=0.2,
            parts=(
                # Around a window that rests nothing moves.
                Fixed.on(grid, radial=["axis", *at_rest], vertical=at_rest),
                *([] if surroundings is None else [surroundings]),
                self.body.contact(
                    grid,
                    adhesion=self.adhesion_factor * strength,
                    in_situ_stress=NO_PARTING * strength,
                ),
                self.window,
                ConservativeInterpolation(),
                EnergyAudit(),
            ),
        )


@dataclass(frozen=True, kw_only=True)
class Ball(FullFlowPenetrometer):
    """A ball without a shaft."""

    ball_radius: float = parameter(
        0.0565, "radius of the ball", unit="m", minimum=1e-6, maximum=1e3
    )

    @property
    def body(self) -> RoundBody:
        """The ball."""
        return RoundBody(radius=self.ball_radius)


@dataclass(frozen=True, kw_only=True)
class TBar(FullFlowPenetrometer):
    """A bar that moves across its axis, in plane strain."""

    bar_radius: float = parameter(0.02, "radius of the T-bar", unit="m", minimum=1e-6, maximum=1e3)

    @property
    def body(self) -> RoundBody:
        """The T-bar."""
        return RoundBody(radius=self.bar_radius, planar=True)


class ResistanceSamples:
    """Samples the resistance of a body at every `SAMPLE_SPACING` radii, means between samples.

    `forces` of the soil on the body are upward positive [N], on half a cylinder of unit length or
    on a radian of a ball; one a sample.
    """

    def __init__(self, simulation: Simulation, body: RoundBody) -> None:
        self._contact = soil_scene(simulation)[SurfaceContact]
        self._radius = body.radius
        self._area = body.radius if body.planar else 0.5 * body.radius**2
        self._contact_forces = ContactForces(simulation)
        self.forces: list[float] = []

    def sample(self) -> None:
        """Record the mean force since the sample before."""
        self.forces.append(upward_force(self._contact, self._contact_forces.take()))

    @property
    def resistance(self) -> Floats:
        """Force over projected area [Pa], shape [sample_count]."""
        return np.array(self.forces) / self._area

    @property
    def work(self) -> float:
        """Of the body so far [J], per radian or per unit length of half of it."""
        return math.fsum(self.forces) * SAMPLE_SPACING * self._radius

    def dataset(self) -> xr.Dataset:
        """The resistance over penetration."""
        what = "resistance over projected area"
        return curves(
            "penetration",
            penetration_axis(len(self.forces), over="radius of the body"),
            penetration_resistance=(self.resistance, "Pa", what, "excess over the in-situ stress"),
        )
