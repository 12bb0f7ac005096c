"""Variation of the ground with depth: strength, stiffness and adhesion as ratios, in-situ stress.

Laws with further parameters that vary have a material at each depth.

The place of soil in the ground is its position (r, z) before anything moved, in the coordinates of
the grid at the start. After the grid has travelled down by T, soil at rest at x in the grid has the
place x - T e_z. Soil keeps the properties of its place wherever it moves.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.checks import check_rising
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats


@dataclass(frozen=True, kw_only=True, eq=False)
class Variation(Checked):
    """Strength, stiffness and adhesion over those of a material, and stress, linear between depths.

    Two equal depths make a jump: soil at this depth and below has the second values. Above the
    first depth and below the last the values are constant.

    Attributes:
        rows: the `Material` at each depth, n of one law. Between depths properties and initial
            state are linear; of a law with constant moduli only `shape`. None: only ratios vary.

    Example:
        >>> growing = Variation(
        ...     depth=np.array([0.0, 10.0]),
        ...     strength_ratio=np.array([0.5, 1.0]),
        ...     stiffness_ratio=np.array([0.5, 1.0]),
        ... )
        >>> growing.at(np.array([[0.1, -4.0]]), growing.strength_ratio)  # at (r, z)
        array([0.7])
    """

    depth: Floats = parameter(
        meaning="depth below the surface of the ground, not falling", unit="m", shape=("depth",)
    )
    strength_ratio: Floats = parameter(
        meaning="strength over that of the material", shape=("depth",), above=0
    )
    # the material is as stiff as the stiffest soil: its waves are the fastest
    stiffness_ratio: Floats = parameter(
        meaning="shear modulus over that of the material", shape=("depth",), above=0, maximum=1
    )
    adhesion_ratio: Floats | None = parameter(
        None,
        "adhesion factor beside the soil over that of the surface; None: 1 everywhere",
        shape=("depth",),
        minimum=0,
        maximum=1,
    )
    rows: tuple[Any, ...] | None = None
    # tension positive
    horizontal_stress: Floats | None = parameter(
        None,
        "horizontal less vertical in-situ stress; None: as the scene has it",
        unit="Pa",
        shape=("depth",),
    )
    origin_depth: float = parameter(0.0, "depth of z = 0", unit="m")

    def __post_init__(self) -> None:
        super().__post_init__()
        check_rising("Variation: depth", self.depth, may_stay=True)
        if not len(self.depth):
            raise SceneError("Variation: depth has no rows, must have one or more")
        if self.rows is not None and len(self.rows) != len(self.depth):
            raise SceneError(
                f"Variation: rows has {len(self.rows)} materials, must have {len(self.depth)}"
            )

    def at(self, place: Floats, values: Floats) -> Floats:
        """Values given by depth, interpolated at places (r, z) in the ground [m], [..., 2]."""
        return np.interp(self.origin_depth - place[..., 1], self.depth, values)
