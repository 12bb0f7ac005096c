"""Limit loads of a cylinder and a sphere deep in soil, moved by a small part of their radius."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import parameter, redefined
from mpm_warp.grid.fitted import Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials import CRITERIA
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.results import labelled
from mpm_warp.scenes.bearing.bearing import NO_PARTING, RADIUS, STRENGTH, Bearing, Exact
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.cone.groups import Cone
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

OUTER_RADIUS = 6.0
"""Outer radius of the soil, where it is fixed, over that of the body; the mechanism reaches 3."""
LIMIT_LOAD_SOURCE = (
    "lower bound of Randolph & Houlsby 1984, Geotechnique 34(4):613-623, exact for a rough "
    "cylinder; upper bounds for others are at most 0.65 % higher (Martin & Randolph 2006, "
    "Geotechnique 56(2):141-145)"
)
ROUGH_VON_MISES = 2.0 / 0.143
"""Limit load of a rough sphere over (pi R^2 su): below 2 pi R^2 su / 0.143 it does not move."""
BOUNDS_OF_TRESCA = {0.0: (11.0, 11.8), 1.0: (15.1, 15.5)}
"""Lower and upper bound for Tresca soil by adhesion factor, as commonly quoted."""


def limit_load(adhesion_factor: float) -> float:
    """Exact limit load of a cylinder in full flow over diameter and su; see `LIMIT_LOAD_SOURCE`."""
    delta = math.asin(adhesion_factor)
    fans = math.cos(0.5 * delta) + math.sin(0.5 * delta)
    return math.pi + 2.0 * delta + 2.0 * math.cos(delta) + 4.0 * fans


@dataclass(frozen=True, kw_only=True)
class FullFlow(Bearing):
    """Half a round body in a polar grid, moved by a small part of its radius.

    Soil surrounds the body, so the limit load of a small displacement is that of steady flow.
    """

    adhesion_factor: float = redefined(
        Cone, "adhesion_factor", meaning="adhesion factor of the body"
    )

    def grid(self) -> PolarGrid:
        """Half a ring around the body."""
        size, span = RADIUS / self.cells_per_radius, (OUTER_RADIUS - 1.0) * RADIUS
        row_count = round(np.pi * self.cells_per_radius)
        return PolarGrid(
            columns=graded(size, span, 1.0 + 0.3 * size / RADIUS) / span,
            rows=np.linspace(0.0, np.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            fitted_radius=OUTER_RADIUS * RADIUS,
            planar=self.planar,
        )

    def fixed(self, grid: Grid) -> Fixed:
        """Nodes on the line of travel, and those on the outer edge."""
        return Fixed.on(grid, radial=["bottom", "top", "side"], vertical=["side"])

    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact all around the body."""
        return SurfaceContact.on(
            grid,
            np.arange(grid.row_count + 1),
            adhesion=self.adhesion_factor * STRENGTH,
            in_situ_stress=NO_PARTING,
            speed=self.speed,
        )


@dataclass(frozen=True, kw_only=True)
class FullFlowCylinder(FullFlow):
    """Half a cylinder in plane strain.

    The limit load is the force over (diameter times su), with D = asin(adhesion factor):
    pi + 2 D + 2 cos D + 4 (cos(D/2) + sin(D/2)); see `LIMIT_LOAD_SOURCE`.

    Example:
        >>> round(FullFlowCylinder(adhesion_factor=1.0).exact[0], 2)
        11.94
    """

    summary = "force on a cylinder that soil flows around (T-bar), plane strain"
    version = 3
    planar = True
    verifications = compared(
        "cells_per_radius",
        (4, 8),
        *({"adhesion_factor": factor} for factor in (0.0, 0.25, 0.5, 0.75, 1.0)),
        error=0.01,
    )

    @property
    def exact(self) -> Exact:
        """See `Bearing`; over diameter and su."""
        return limit_load(self.adhesion_factor), LIMIT_LOAD_SOURCE


@dataclass(frozen=True, kw_only=True)
class FullFlowSphere(FullFlow):
    """A sphere, the axisymmetric counterpart of `full_flow_cylinder`.

    The limit load over (pi R^2 su) is known for a rough sphere in von Mises soil. For Tresca soil
    there are bounds for a smooth and a rough sphere, commonly quoted from Randolph, Martin & Hu
    (2000, GeoEng2000, Melbourne).

    Example:
        >>> round(FullFlowSphere(material="von_mises", adhesion_factor=1.0).exact[0], 2)
        13.99
    """

    summary = "force on a sphere that soil flows around (ball penetrometer)"
    version = 1
    verifications = compared(
        "cells_per_radius",
        (4, 8),
        {"adhesion_factor": 1.0, "material": "von_mises"},
        {"adhesion_factor": 0.0, "material": "tresca"},
        {"adhesion_factor": 1.0, "material": "tresca"},
        error=0.01,  # the bounds of Tresca are given to a tenth
    )

    material: str = parameter("tresca", "yield criterion", choices=tuple(CRITERIA))

    @property
    def exact(self) -> Exact | None:
        """See `Bearing`; over projected area and su."""
        if self.material != "von_mises" or self.adhesion_factor != 1.0:
            return None
        return ROUGH_VON_MISES, (
            "critical yield number 0.143 of a sphere in a Bingham fluid, Beris, Tsamopoulos, "
            "Armstrong & Brown 1985, J. Fluid Mech. 158:219-244; its last digit is worth 0.35 %"
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Results of `Bearing`, and where bounds are known the distance of the load from them."""
        results = super().record(simulation, progress)
        if self.material != "tresca" or self.adhesion_factor not in BOUNDS_OF_TRESCA:
            return results
        lowest, highest = BOUNDS_OF_TRESCA[self.adhesion_factor]
        load = float(results.bearing_capacity)
        what = f"distance from its bounds over the load; 0 from {lowest:g} to {highest:g}"
        error = (max(lowest - load, load - highest, 0.0) / load, "1", "error of the load", what)
        return results.assign(labelled(role="error", error=error))
