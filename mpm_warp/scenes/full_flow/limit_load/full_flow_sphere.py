"""A sphere (ball penetrometer) that soil flows around on all sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import xarray as xr

from mpm_warp.materials import CRITERIA
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.parameters import redefined
from mpm_warp.results import labelled
from mpm_warp.scenes.catalogue import Progress, Verification
from mpm_warp.scenes.clay import ClayScene
from mpm_warp.scenes.full_flow.limit_load.common import FullFlow
from mpm_warp.simulation import Simulation

ROUGH_VON_MISES = 2.0 / 0.143
"""Load over (pi R^2 su): a sphere rests where its load is less than 2 pi R^2 su / 0.143."""
BOUNDS_OF_TRESCA = {0.0: (11.0, 11.8), 1.0: (15.1, 15.5)}
"""The same for Tresca by adhesion factor: bounds as commonly quoted, about."""


@dataclass(frozen=True, kw_only=True)
class FullFlowSphere(FullFlow):
    """Force over (pi R^2 su) of a sphere: the axisymmetric sibling of `full_flow_cylinder`.

    It is known for a rough sphere in soil of von Mises. For Tresca there are bounds of a smooth and
    of a rough one, commonly quoted from Randolph, Martin & Hu (2000, GeoEng2000, Melbourne).
    """

    summary: ClassVar[str] = "force on a sphere that soil flows around (ball penetrometer)"
    version: ClassVar[int] = 1
    planar: ClassVar[bool] = False
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cells_per_radius",
            resolutions=(4, 8),
            bounds={"error": 0.01},
            settings={"adhesion_factor": 1.0, "material": "von_mises"},
        ),
        *(
            Verification(
                resolution="cells_per_radius",
                resolutions=(4, 8),
                bounds={"error": 0.01},  # they are given to a tenth
                settings={"adhesion_factor": adhesion_factor},
            )
            for adhesion_factor in BOUNDS_OF_TRESCA
        ),
    )

    material: str = redefined(ClayScene, "material")

    @property
    def clay(self) -> PerfectlyPlastic:
        """The soil."""
        tresca = super().clay
        return CRITERIA[self.material](
            shear_modulus=tresca.shear_modulus,
            poissons_ratio=tresca.poissons_ratio,
            density=tresca.density,
            strength=tresca.strength,
        )

    @property
    def exact_load(self) -> float:
        """Exact limit load over projected area and su; not a number where none is known."""
        is_known = self.material == "von_mises" and self.adhesion_factor == 1.0
        return ROUGH_VON_MISES if is_known else math.nan

    @property
    def exact_source(self) -> str:
        """Where the exact load comes from, and how exact it is."""
        return (
            "critical yield number 0.143 of a sphere in a Bingham fluid, Beris, Tsamopoulos, "
            "Armstrong & Brown 1985, J. Fluid Mech. 158:219-244; its last digit is worth 0.35 %"
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """See `Bearing`; where there are bounds, how far the load is outside them too."""
        results = super().record(simulation, progress)
        if self.material != "tresca" or self.adhesion_factor not in BOUNDS_OF_TRESCA:
            return results
        lowest, highest = BOUNDS_OF_TRESCA[self.adhesion_factor]
        load = float(results.bearing_capacity)
        outside = (
            max(lowest - load, load - highest, 0.0) / load,
            "1",
            "error of the load",
            f"distance from its bounds over the load; 0 from {lowest:g} to {highest:g}",
        )
        return results.assign(labelled(role="error", error=outside))
