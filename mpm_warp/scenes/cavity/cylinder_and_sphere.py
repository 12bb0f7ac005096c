"""Expansion of a cylindrical and of a spherical cavity in undrained clay, at large strain."""

import dataclasses
import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.parameters import Value, redefined
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
from mpm_warp.scene import Part
from mpm_warp.scenes.catalogue import Verification, compared
from mpm_warp.scenes.cavity.cavity import Cavity
from mpm_warp.scenes.cavity.exact import RADIUS
from mpm_warp.scenes.cone.parameters import ConeInGround

MOST_ANISOTROPY = 0.5
"""Of Tresca soil around a cylinder: the vertical stress then stays between the others."""
SOILS: tuple[dict[str, Value], ...] = (
    {"rigidity_index": 50.0, "material": "tresca"},
    {"rigidity_index": 500.0, "material": "tresca"},
    {"rigidity_index": 50.0, "material": "von_mises"},
)
"""Soft and stiff soil, and soil of von Mises."""
CHANGING: tuple[dict[str, Value], ...] = (
    {"rate_factor": 0.1, "reference_strain_rate": 0.01},
    {"remoulded_strength_ratio": 0.2, "ductility": 10.0},
    {"remoulded_strength_ratio": 0.2, "ductility": 1.0},
)
"""Clay with a rate effect, and clay that softens, later and sooner."""


def verifications(largest_error: float, resolutions: tuple[int, ...]) -> tuple[Verification, ...]:
    """Perfectly plastic soils, and clays whose strength changes, at two resolutions."""
    at = partial(compared, "cells_per_radius", resolutions, pore_pressure_error=0.02)
    return at(*SOILS, error=largest_error) + at(*CHANGING, error=0.01)


@dataclass(frozen=True, kw_only=True)
class CavityCylinder(Cavity):
    """One row of cells between smooth ends, around a cylinder whose wall moves outward.

    The axis is vertical. The pressure is that over the horizontal stress before. While the vertical
    stress stays between the others it does not matter to soil of Tresca, which is so for any stress
    anisotropy that is allowed there.
    """

    summary = "pressure of an expanding cylindrical cavity in undrained clay"
    version = 6
    verifications = verifications(0.015, (4, 8))
    exponent = 2
    von_mises_strength = 1.0

    stress_anisotropy: float = redefined(
        ConeInGround,
        "stress_anisotropy",
        meaning="stress anisotropy Delta in the ground before: vertical less horizontal stress "
        "over 2 su; not of von Mises soil, of Tresca -0.5 to 0.5",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        delta, ratio = self.stress_anisotropy, self.remoulded_strength_ratio
        material = self.material
        unknown = "there is no exact pressure"
        is_beyond = material in CRITERIA and abs(delta) > MOST_ANISOTROPY
        for refused, allowed in (
            (delta and material == "von_mises", f"0 where material is {material}: {unknown}"),
            (delta and ratio != 1.0, f"0 where remoulded_strength_ratio is {ratio}: {unknown}"),
            (is_beyond, f">= {-MOST_ANISOTROPY:g} and <= {MOST_ANISOTROPY:g} in Tresca soil"),
        ):
            if refused:
                name = "stress_anisotropy"
                raise ParameterError(name, f"{name} = {delta:g} must be {allowed}")

    @property
    def stress_at_rest(self) -> Floats:
        """See `ClayScene`; over the horizontal stress, which the vertical one differs from."""
        over_horizontal = 2.0 * self.stress_anisotropy * self.undrained_shear_strength
        return np.array([0.0, -over_horizontal, 0.0, 0.0])

    def grid(self) -> Grid:
        """One row of cells, to twice the radius of the plastic zone."""
        # Beyond the plastic zone, so that the far field is elastic as it takes it to be.
        outer = 2.0 * self.plastic_radius
        return Grid(
            columns=self.columns(outer),
            rows=np.array([0.0, self.cell_size]),
            surface_radius=np.full(2, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves along the axis; around the grid is the elastic medium, as springs."""
        fixed = Fixed.on(grid, vertical=["everywhere"])
        far_field = FarField.around(grid, material)
        # Dashpots would push against the flow of soil that never stops: no waves, no dashpots.
        return fixed, dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot)


@dataclass(frozen=True, kw_only=True)
class CavitySphere(Cavity):
    """A quarter of the half plane, from the axis to the equator, on rays.

    The grid ends, without traction, at six times the radius of the plastic zone: what is missing
    beyond lowers the pressure by 4/3 su / 6^3, a thousandth of the limit.

    The stress before is the same in all directions, so there is no stress anisotropy: with it soil
    does not move along the rays, and neither the strain path of a point nor any pressure is known.

    Where the clay softens, soil moves along the rays alone, as the exact pressure takes it to: a
    free flow of Tresca soil parts from that and bears less.
    """

    summary = "pressure of an expanding spherical cavity in clay under equal stress"
    version = 6
    verifications = verifications(0.02, (4, 6))
    exponent = 3
    von_mises_strength = math.sqrt(0.75)

    def grid(self) -> PolarGrid:
        """Rays from the axis to the equator, to six times the radius of the plastic zone."""
        outer = 6.0 * self.plastic_radius
        row_count = max(2, round(0.5 * math.pi * self.cells_per_radius))
        return PolarGrid(
            columns=self.columns(outer),
            rows=np.linspace(0.0, 0.5 * math.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves across the axis or the equator; the grid ends without traction."""
        fixed = Fixed.on(grid, radial=["bottom"], vertical=["top"])
        return (RadialMotion(), fixed) if self.remoulded_strength_ratio < 1.0 else (fixed,)
