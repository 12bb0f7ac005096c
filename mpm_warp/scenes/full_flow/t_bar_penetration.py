"""A T-bar pushed down until soil flows round it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import xarray as xr

from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.results import labelled
from mpm_warp.scenes.catalogue import Verification
from mpm_warp.scenes.full_flow.limit_load.full_flow_cylinder import LIMIT_LOAD_SOURCE, limit_load
from mpm_warp.scenes.full_flow.penetration import FullFlowPenetration
from mpm_warp.scenes.full_flow.t_bar import TBar


@dataclass(frozen=True, kw_only=True)
class TBarPenetration(TBar, FullFlowPenetration):
    """A T-bar in plane strain, pushed through uniform clay to steady flow.

    In perfectly plastic clay its resistance is the limit load of `full_flow_cylinder`.
    """

    summary: ClassVar[str] = "T-bar pushed through undrained clay to steady flow, plane strain"
    version: ClassVar[int] = 3
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(3, 4),
            bounds={"error": 0.02},
            settings={"adhesion_factor": adhesion_factor},
        )
        for adhesion_factor in (0.0, 0.5, 1.0)
    )

    def with_exact_value(self, results: xr.Dataset) -> xr.Dataset:
        """The results beside the limit load, in perfectly plastic clay."""
        if isinstance(self.clay, EinavRandolph):
            return results
        exact = limit_load(self.adhesion_factor)
        error = abs(float(results.resistance_factor) / exact - 1.0)
        return results.assign(
            labelled(
                resistance_factor_exact=(
                    exact,
                    "1",
                    "limit load over projected area and su",
                    LIMIT_LOAD_SOURCE,
                )
            )
            | labelled(
                role="error",
                error=(error, "1", "error of the resistance", "relative to the limit load"),
            )
        )
