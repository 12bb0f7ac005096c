"""Boundary conditions on nodes of the grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.materials.materials import LinearElastic

Booleans = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Fixed:
    """Nodes that rest relative to undisturbed soil, in r, z or both.

    Attributes:
        nodes: flat indices, each once, shape [node_count].
        free: 1 where the velocity component is free, 0 where it is held, shape [node_count, 2].
    """

    nodes: Integers
    free: Floats

    @classmethod
    def axis_and_ends(cls, grid: Grid) -> Fixed:
        """No radial velocity on the axis, none at all at the bottom, no vertical one at the top."""
        free = np.ones((grid.row_count + 1, grid.column_count + 1, 2))
        free[grid.surface_radius == 0.0, 0, 0] = 0.0
        free[0] = 0.0
        free[-1, :, 1] = 0.0
        return cls.where(radial=free[..., 0] == 0.0, vertical=free[..., 1] == 0.0)

    @classmethod
    def where(cls, *, radial: Booleans, vertical: Booleans) -> Fixed:
        """Nodes held where a mask says so, one mask a component.

        Args:
            radial: where the radial velocity is held, shape [row_count + 1, column_count + 1].
            vertical: the same for the vertical velocity.
        """
        free = np.where(np.stack([radial, vertical], axis=-1), 0.0, 1.0).reshape(-1, 2)
        nodes = np.flatnonzero(free.min(axis=-1) == 0.0)
        return cls(nodes=nodes, free=free[nodes])


QUIET_SPEED_RATIO = 3.3
"""That of a Poisson's ratio of 0.45."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FarField:
    """The infinite elastic medium beyond the outer radius of the grid.

    Statically a spring of 2 G / r per area (the elastic cavity, u = p r / 2 G); for waves the quiet
    dashpots rho c of Lysmer & Kuhlemeyer (1969, J. Eng. Mech. Div. 95(4):859-877). They resist flow
    that never stops too, in proportion to c; so the speed of the pressure waves is taken as at most
    `QUIET_SPEED_RATIO` times that of the shear waves. In clay that hardly changes its volume it is
    more, and part of these waves comes back.

    Attributes:
        nodes: flat indices of the nodes on the side, from below to above, shape [node_count].
        spring: stiffness of each node per radian [N/m], shape [node_count].
        dashpot: viscosity of each node along r and z per radian [N s/m], shape [node_count, 2].
    """

    nodes: Integers
    spring: Floats
    dashpot: Floats

    @classmethod
    def around(cls, grid: Grid, material: LinearElastic) -> FarField:
        """The medium around all of the grid's outer side."""
        half_heights = 0.5 * np.diff(grid.rows)
        heights = np.append(half_heights, 0.0) + np.insert(half_heights, 0, 0.0)
        area = grid.outer_radius * heights
        shear_speed = material.shear_wave_speed
        quiet_speed = min(material.pressure_wave_speed, QUIET_SPEED_RATIO * shear_speed)
        speeds = np.array([quiet_speed, shear_speed])
        return cls(
            nodes=grid.node(grid.column_count, np.arange(grid.row_count + 1)),
            spring=2.0 * material.shear_modulus / grid.outer_radius * area,
            dashpot=material.density * area[:, None] * speeds,
        )
