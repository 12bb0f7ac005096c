"""Bearing capacity of a circular footing on the surface of the ground."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.scenes.families.footing import Footing


@dataclass(frozen=True, kw_only=True)
class CircularFooting(Footing):
    """A rigid disc on weightless Tresca soil; see `exact_source` for the sources."""

    summary: ClassVar[str] = "limit load of a circular footing, smooth and rough"
    version: ClassVar[int] = 3
    exact_source: ClassVar[str] = (
        "smooth: Shield 1955, Proc. R. Soc. A 233:267-287; rough: Eason & Shield 1960, "
        "Z. angew. Math. Phys. 11:33-43"
    )
    planar: ClassVar[bool] = False
    exact: ClassVar[Mapping[float, float]] = {0.0: 5.69, 1.0: 6.05}
