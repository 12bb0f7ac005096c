"""Expansion of a cylindrical cavity in undrained clay, at large strain."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.material import Material
from mpm_warp.parameters import parameter
from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.scene import Part
from mpm_warp.scenes.catalogue import Verification
from mpm_warp.scenes.cavity.common import RADIUS, STRENGTH, Cavity
from mpm_warp.scenes.cavity.verifications import HURRIED, LATE, SOON, verifications


@dataclass(frozen=True, kw_only=True)
class CavityCylinder(Cavity):
    """One row of cells between smooth ends, around a cylinder whose wall moves outward.

    The axis is vertical. The pressure is that over the horizontal stress before. While the vertical
    stress stays between the others it does not matter to soil of Tresca, which is so for any stress
    anisotropy that is allowed.
    """

    summary: ClassVar[str] = "pressure of an expanding cylindrical cavity in undrained clay"
    version: ClassVar[int] = 6
    verifications: ClassVar[tuple[Verification, ...]] = verifications(
        0.015, (4, 8), HURRIED, LATE, SOON
    )
    exponent: ClassVar[int] = 2
    factor: ClassVar[float] = 1.0
    von_mises_strength: ClassVar[float] = 1.0

    stress_anisotropy: float = parameter(
        0.0,
        unit="1",
        meaning="stress anisotropy Delta in the ground before: vertical less horizontal stress "
        "over 2 su; of Tresca soil alone",
        minimum=-0.5,
        maximum=0.5,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value, known in (
            ("material", self.material, "tresca"),
            ("remoulded_strength_ratio", self.remoulded_strength_ratio, 1.0),
        ):
            if self.stress_anisotropy != 0.0 and value != known:
                raise ParameterError(
                    "stress_anisotropy",
                    f"stress_anisotropy = {self.stress_anisotropy:g} must be 0 where {name} is "
                    f"{value}: there is no exact pressure",
                )

    @property
    def stress_at_rest(self) -> Floats:
        """See `Cavity`: the vertical stress differs from the horizontal one."""
        over_horizontal = 2.0 * self.stress_anisotropy * STRENGTH
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
        vertical = np.ones((2, len(grid.columns)), dtype=bool)
        fixed = Fixed.where(radial=np.zeros_like(vertical), vertical=vertical)
        far_field = FarField.around(grid, material)
        # Dashpots would push against the flow of soil that never stops: no waves, no dashpots.
        return fixed, dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot)

    def wall_area(self, grid: Grid, radius: float) -> float:
        """Area of the wall per radian [m2] when the cavity has a radius [m]."""
        return radius * float(grid.rows[-1] - grid.rows[0])
