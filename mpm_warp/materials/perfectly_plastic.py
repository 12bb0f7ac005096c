"""Soil with an undrained shear strength: the base of all materials that yield."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

from mpm_warp.arguments import POSITIVE, check_number
from mpm_warp.materials.material import Material
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True)
class PerfectlyPlastic(Material):
    """Elastic up to an undrained shear strength, then perfectly plastic and isochoric.

    Attributes:
        strength: undrained shear strength in pure shear su [Pa], > 0.
    """

    strength: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number("material: strength", self.strength, POSITIVE, unit="Pa")

    @property
    def properties(self) -> tuple[float, ...]:
        """The strength su [Pa]."""
        return (self.strength,)

    @property
    def limit_pressure(self) -> float:
        """Of a spherical cavity: 4/3 su (1 + ln(G / su)) [Pa] (Hill 1950)."""
        return 4.0 / 3.0 * self.strength * (1.0 + math.log(self.shear_modulus / self.strength))


class YieldCriterion(PerfectlyPlastic):
    """Perfect plasticity whose yield surface another material may take, as large as it needs it."""

    @abstractmethod
    def within(self, precision: Precision) -> Any:
        """The function (stress, strength) -> whether the stress is within the yield surface.

        It is asked of every point in every step, and takes no root.
        """
