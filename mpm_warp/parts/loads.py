"""Forces that act on the soil from outside."""

from __future__ import annotations

from dataclasses import dataclass

from mpm_warp.grid.fitted import Floats, Integers


@dataclass(frozen=True, kw_only=True, eq=False)
class NodalLoad:
    """Constant forces on nodes, there from the first step on.

    Attributes:
        nodes: flat indices, each once, shape [node_count].
        forces: (r, z) per radian, or in plane strain per thickness [N], shape [node_count, 2].
    """

    nodes: Integers
    forces: Floats
