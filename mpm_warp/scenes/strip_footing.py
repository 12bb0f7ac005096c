"""Bearing capacity of a strip footing on the surface of the ground."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.scenes.families.footing import Footing


@dataclass(frozen=True, kw_only=True)
class StripFooting(Footing):
    """A rigid strip on weightless Tresca soil, half of it: r is the distance from its middle."""

    summary: ClassVar[str] = "limit load of a strip footing in plane strain, smooth and rough"
    version: ClassVar[int] = 3
    exact_source: ClassVar[str] = (
        "2 + pi, smooth or rough: Prandtl 1921, Z. angew. Math. Mech. 1:15-20"
    )
    planar: ClassVar[bool] = True
    exact: ClassVar[Mapping[float, float]] = {0.0: 2 + math.pi, 1.0: 2 + math.pi}
