"""A rigid body at the surface of the ground, whose strength may grow with depth."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.materials.variation import Variation
from mpm_warp.parameters import parameter
from mpm_warp.scenes.bearing.common import RADIUS, Bearing
from mpm_warp.scenes.bearing.slip_lines import SlipLines

LARGEST_DEPTH = 100.0 * RADIUS
"""Depth below which there is no soil in any grid [m]."""
SLIP_LINE_SOURCE = (
    "slip lines with the hypothesis of Haar and von Karman, integrated for this project to 0.2 %"
)


@dataclass(frozen=True, kw_only=True)
class OnGround(Bearing):
    """A rigid body at the surface of soil of strength su0 + k z, su0 that of the surface.

    Adhesion is in proportion to the strength of the soil beside it. The shear modulus is the same
    at all depths, on which no limit load depends.
    """

    uniform_exact_source: ClassVar[str]
    """Where the exact load on uniform soil comes from, and how exact it is."""

    strength_gradient_ratio: float = parameter(
        0.0,
        unit="1",
        meaning="growth of strength with depth, k R / su0, su0 the strength su at the surface",
        minimum=0,
        maximum=10,
    )

    @property
    @abstractmethod
    def uniform_exact_load(self) -> float:
        """Exact limit load over area and su on uniform soil; not a number where none is known."""

    @property
    @abstractmethod
    def slip_lines(self) -> SlipLines | None:
        """The slip lines of the problem; none where theirs is not the exact load."""

    @property
    def surface_height(self) -> float:
        """Height z of the surface of the ground in the grid [m]."""
        return 0.0

    @property
    def is_uniform(self) -> bool:
        """Whether strength is the same at all depths."""
        return self.strength_gradient_ratio == 0.0

    @property
    def exact_load(self) -> float:
        """Exact limit load over area and su0; not a number where none is known."""
        if self.is_uniform:
            return self.uniform_exact_load
        return math.nan if self.slip_lines is None else self.slip_lines.limit_load

    @property
    def exact_source(self) -> str:
        """Where the exact load comes from, and how exact it is."""
        return self.uniform_exact_source if self.is_uniform else SLIP_LINE_SOURCE

    @property
    def final_displacement(self) -> float:
        """How far the body is pressed [m]: in proportion to the strength half a radius deep."""
        return (1.0 + 0.5 * self.strength_gradient_ratio) * super().final_displacement

    @property
    def clay(self) -> PerfectlyPlastic:
        """The soil."""
        uniform = super().clay
        if self.is_uniform:
            return uniform
        deepest = 1.0 + self.strength_gradient_ratio * LARGEST_DEPTH / RADIUS
        growth = Variation(
            depth=np.array([0.0, LARGEST_DEPTH]),
            strength_ratio=np.array([1.0, deepest]),
            stiffness_ratio=np.ones(2),
            origin_depth=self.surface_height,
        )
        return replace(uniform, variation=growth)
