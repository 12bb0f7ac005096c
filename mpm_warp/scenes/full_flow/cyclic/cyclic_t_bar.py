"""A T-bar pushed down and pulled up, time after time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import xarray as xr

from mpm_warp.results import labelled
from mpm_warp.scenes.full_flow.cyclic.cyclic_penetration import BEYOND, CyclicPenetration
from mpm_warp.scenes.full_flow.cyclic.degradation import T_BAR_STRAIN, Degradation
from mpm_warp.scenes.full_flow.t_bar import TBar


@dataclass(frozen=True, kw_only=True)
class CyclicTBar(TBar, CyclicPenetration):
    """A T-bar in plane strain that goes down and up again in the same soil.

    Its first passage is that of `t_bar_penetration`.
    """

    summary: ClassVar[str] = "T-bar pushed down and pulled up in undrained clay, plane strain"
    version: ClassVar[int] = 3

    def fitted(self, fit: Degradation) -> dict[str, xr.Variable]:
        """The fit of practice, and the ductility that it tells."""
        fitted = super().fitted(fit)
        return fitted | labelled(
            fitted_ductility=(
                2.0 * T_BAR_STRAIN * float(fitted["fitted_cycles"]),
                "1",
                "ductility xi_95, fitted",
                f"by a plastic shear strain of {T_BAR_STRAIN:g} in a passage of a T-bar; {BEYOND}",
            )
        )
