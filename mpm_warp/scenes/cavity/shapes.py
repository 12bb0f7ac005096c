"""A cylinder and a sphere that expand in undrained clay."""

import dataclasses
import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from mpm_warp.fields.checked import refuse
from mpm_warp.fields.declaration import Value, group, redefined
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
from mpm_warp.scene import Part
from mpm_warp.scenes.cavity.cavity import Cavity
from mpm_warp.scenes.cavity.exact import RADIUS
from mpm_warp.scenes.clay_scene import StressAtRest
from mpm_warp.scenes.verification import Verification, compared

MOST_ANISOTROPY = 0.5
"""Largest |Delta| of Tresca soil around a cylinder. Up to it the vertical stress stays between the
radial and the hoop stress."""


def verifications(largest_error: float, resolutions: tuple[int, ...]) -> tuple[Verification, ...]:
    """Perfectly plastic soils, and clays with a rate effect or softening, at two resolutions."""
    perfectly_plastic: tuple[dict[str, Value], ...] = (
        {"rigidity_index": 50.0, "material": "tresca"},
        {"rigidity_index": 500.0, "material": "tresca"},
        {"rigidity_index": 50.0, "material": "von_mises"},
    )
    changing: tuple[dict[str, Value], ...] = (
        {"rate_factor": 0.1, "reference_strain_rate": 0.01},
        {"remoulded_strength_ratio": 0.2, "ductility": 10.0},
        {"remoulded_strength_ratio": 0.2, "ductility": 1.0},
    )
    at = partial(compared, "cells_per_radius", resolutions, pore_pressure_error=0.02)
    return at(*perfectly_plastic, error=largest_error) + at(*changing, error=0.01)


@dataclass(frozen=True, kw_only=True)
class StressAroundCylinder(StressAtRest):
    """The stress around a cylinder with a vertical axis, in excess of the horizontal stress."""

    stress_anisotropy: float = redefined(
        StressAtRest,
        "stress_anisotropy",
        meaning="stress anisotropy Delta of the ground at rest: vertical less horizontal stress "
        "over 2 su; 0 in von Mises soil, -0.5 to 0.5 in Tresca soil",
    )

    def at_rest(self, strength: float) -> Floats:
        """See `StressAtRest`."""
        over_horizontal = 2.0 * self.stress_anisotropy * strength
        return np.array([0.0, -over_horizontal, 0.0, 0.0])


@dataclass(frozen=True, kw_only=True, init=False)
class CavityCylinder(Cavity):
    """A cylinder with a vertical axis, in one row of cells between smooth ends.

    The pressure is in excess of the initial horizontal stress. The vertical stress does not affect
    Tresca soil while it is the intermediate principal stress; the limits of the stress anisotropy
    ensure this.

    Example:
        >>> round(CavityCylinder(rigidity_index=50).plastic_radius, 1)  # [m]
        28.3
    """

    summary = "pressure of an expanding cylindrical cavity in undrained clay"
    version = 6
    verifications = verifications(0.015, (4, 8))
    exponent = 2
    von_mises_strength = 1.0

    stress: StressAroundCylinder = group()

    def __post_init__(self) -> None:
        super().__post_init__()
        delta, ratio = self.stress.stress_anisotropy, self.clay.remoulded_strength_ratio
        material = self.clay.material.name
        unknown = "there is no exact pressure"
        is_beyond = material in CRITERIA and abs(delta) > MOST_ANISOTROPY
        for refused, allowed in (
            (delta and material == "von_mises", f"0 where material is {material}: {unknown}"),
            (delta and ratio != 1.0, f"0 where remoulded_strength_ratio is {ratio}: {unknown}"),
            (is_beyond, f">= {-MOST_ANISOTROPY:g} and <= {MOST_ANISOTROPY:g} in Tresca soil"),
        ):
            if refused:
                refuse(self, "stress_anisotropy", f": must be {allowed}")

    @property
    def stress_at_rest(self) -> Floats:
        """See `ClayScene`; in excess of the horizontal stress."""
        return self.stress.at_rest(self.clay.undrained_shear_strength)

    def grid(self) -> Grid:
        """One row of cells, to twice the plastic radius: `FarField` assumes elastic soil."""
        outer = 2.0 * self.plastic_radius
        return Grid(
            columns=self.columns(outer),
            rows=np.array([0.0, self.cell_size]),
            surface_radius=np.full(2, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves along the axis; springs stand for the elastic ground around the grid."""
        fixed = Fixed.on(grid, vertical=["everywhere"])
        far_field = FarField.around(grid, material)
        # Dashpots would resist the steady outward flow, and there are no waves to absorb.
        return fixed, dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot)


@dataclass(frozen=True, kw_only=True, init=False)
class CavitySphere(Cavity):
    """A sphere in a polar grid of the quarter plane from the axis to the equator.

    The grid ends without traction at six times the radius of the plastic zone. The missing ground
    lowers the pressure by 4/3 su / 6^3, a thousandth of the limit.

    The initial stress is isotropic. With stress anisotropy soil would not move along the rays, and
    no exact pressure is known.

    Where the clay softens, soil is guided along the rays, as the exact pressure assumes. Softening
    Tresca soil that is free to flow leaves them and resists less.

    Example:
        >>> round(CavitySphere(rigidity_index=50).plastic_radius, 1)  # [m]
        14.7
    """

    summary = "pressure of an expanding spherical cavity in clay under equal stress"
    version = 6
    verifications = verifications(0.02, (4, 6))
    exponent = 3
    von_mises_strength = math.sqrt(0.75)

    def grid(self) -> PolarGrid:
        """Rays from the axis to the equator, to six times the plastic radius."""
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
        return (RadialMotion(), fixed) if self.clay.remoulded_strength_ratio < 1.0 else (fixed,)
