"""The groups of parameters of ball and T-bar: clay, body, and the flow of soil around it."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

from mpm_warp.fields.checked import Group
from mpm_warp.fields.declaration import parameter, redefined
from mpm_warp.grid.fitted import growing
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.parts.enclosed_soil import EnclosedSoil
from mpm_warp.parts.energy import EnergyAudit
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene
from mpm_warp.scenes.clay import FieldClay
from mpm_warp.scenes.cone.groups import Domain
from mpm_warp.scenes.full_flow.round_body import RoundBody

NO_PARTING = 1000.0
"""In-situ stress over su: more than any tension of the soil, so that it closes behind the body."""


@dataclass(frozen=True, kw_only=True)
class ClayAroundBody(FieldClay):
    """Clay that flows around a body."""

    rigidity_index: float = redefined(FieldClay, "rigidity_index", minimum=20)
    poissons_ratio: float = redefined(FieldClay, "poissons_ratio", minimum=0.4)


@dataclass(frozen=True, kw_only=True)
class Body(Group, ABC):
    """A round body; `Ball` and `TBar` are such."""

    @property
    @abstractmethod
    def shape(self) -> RoundBody:
        """Its outline."""


@dataclass(frozen=True, kw_only=True)
class Ball(Body):
    """A ball without a shaft."""

    ball_radius: float = parameter(
        0.0565, "radius of the ball", unit="m", minimum=1e-6, maximum=1e3
    )
    shaft_radius_ratio = 0.0

    @property
    def shape(self) -> RoundBody:
        """The ball and its shaft."""
        shaft_radius = self.shaft_radius_ratio * self.ball_radius
        return RoundBody(radius=self.ball_radius, shaft_radius=shaft_radius)


@dataclass(frozen=True, kw_only=True)
class BallOnShaft(Ball):
    """A ball below a smooth shaft."""

    shaft_radius_ratio: float = parameter(
        0.316,
        "radius of the shaft over that of the ball: 10 cm2 below 100 cm2; 0: no shaft",
        minimum=0,
        maximum=0.8,
    )


@dataclass(frozen=True, kw_only=True)
class TBar(Body):
    """A bar that moves across its axis, in plane strain."""

    bar_radius: float = parameter(0.02, "radius of the T-bar", unit="m", minimum=1e-6, maximum=1e3)

    @property
    def shape(self) -> RoundBody:
        """The T-bar."""
        return RoundBody(radius=self.bar_radius, planar=True)


@dataclass(frozen=True, kw_only=True)
class Flow(Group):
    """The speed of a body, and the grid that travels with it.

    The body starts in place, deep in undisturbed ground, and soil and body do not part. Stresses
    are those in excess of the isotropic in-situ stress, which is in equilibrium by itself.
    """

    speed_ratio: float = parameter(
        None,
        "penetration speed over shear wave speed (default: 0.3 / sqrt(Ir), 0.15 / sqrt(Ir) in "
        "cyclic tests)",
        minimum=1e-4,
        maximum=0.1,
    )
    cells_per_radius: int = parameter(4, "cells per radius of the body", minimum=2, maximum=40)
    cell_growth: float = redefined(Domain, "cell_growth")
    particles_per_cell: int = parameter(9, "material points per cell", choices=(4, 9, 16))
    domain_extent: int = parameter(
        8,
        "extent of the grid below, above and beside the centre over radius",
        minimum=3,
        maximum=100,
    )

    def speed(self, clay: FieldClay, soil: Material) -> float:
        """Speed of the body in the run [m/s], by the stiffness that the law has."""
        return self.speed_ratio * math.sqrt(soil.ground_shear_modulus / clay.density)

    def around(
        self,
        body: RoundBody,
        soil: Material,
        window: Window | CyclicWindow,
        *,
        strength: float,
        adhesion: float,
    ) -> Scene:
        """The soil around a body, in a grid that travels with it.

        Strength su of the soil and adhesion of the body are in Pa.
        """
        radius = body.radius
        size = radius / self.cells_per_radius
        growth = 1.0 + self.cell_growth / self.cells_per_radius
        grid = body.fitted_grid(
            cells_per_radius=self.cells_per_radius,
            columns=growing(size, (self.domain_extent - 1.0) * radius, growth),
            extent=self.domain_extent,
        )
        around = list[SurroundingGround]()
        if body.shaft_radius > 0.0:
            # Without a shaft as much soil closes behind the body as it pushes aside, so the ground
            # around the window rests. Seen from afar a growing shaft is a travelling source.
            source = TravellingSource(
                radius=body.shaft_radius, height=0.0, shear_modulus=soil.ground_shear_modulus
            )
            around = [SurroundingGround(grid=grid, material=soil, source=source, strength=strength)]
        at_rest = [] if around else ["bottom", "top", "side"]
        in_situ = NO_PARTING * strength
        return Scene(
            grid=grid,
            material=soil,
            particles_per_side=math.isqrt(self.particles_per_cell),
            bulk_viscosity=0.2,
            parts=(
                Fixed.on(grid, radial=["axis", *at_rest], vertical=at_rest),
                *around,
                body.contact(grid, adhesion=adhesion, in_situ_stress=in_situ),
                window,
                EnclosedSoil(),
                ConservativeInterpolation(),
                EnergyAudit(),
            ),
        )
