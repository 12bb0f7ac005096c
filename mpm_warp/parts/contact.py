"""Where and how strongly the contact law acts; the law itself is in `mpm_warp.parts.contact_law`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.materials.materials import LinearElastic, PerfectlyPlastic

PARTED = 1e-3
"""Mean pressure over the in-situ stress below which nothing has pressed: that of rounding."""


def nodal_areas(weight: Floats, length: Floats) -> Floats:
    """Integrals of N w over a line of nodes, shape [node_count].

    Args:
        weight: w at the nodes, linear between them: r for areas per radian [m], 1 in plane strain.
        length: of the edges between them [m], shape [node_count - 1].
    """
    to_lower = length * (weight[:-1] / 3.0 + weight[1:] / 6.0)
    to_upper = length * (weight[:-1] / 6.0 + weight[1:] / 3.0)
    return np.append(to_lower, 0.0) + np.insert(to_upper, 0, 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceContact:
    """Contact of nodes of the grid with a rigid body whose surface goes through them.

    Areas are integrals of the nodes' shape functions over the surface, times r: per radian. In
    plane strain they are lengths, without the r.

    Attributes:
        nodes: flat indices of the nodes in contact, each once, shape [node_count].
        normals: unit normals, outward from the soil, shape [node_count, 2].
        normal_areas: areas on which the normal traction acts [m2], shape [node_count].
        adhesion_forces: greatest adhesive force, adhesion times area [N], shape [node_count].
        friction: Coulomb coefficient, dimensionless, >= 0.
        in_situ_stress: pressure that the simulated stress leaves out [Pa], >= 0; soil and surface
            part where the simulated traction pulls by more.
        speed: at which the body sinks into the grid [m/s]; where the grid travels with the body,
            the window has the speed and this one is not used.
    """

    nodes: Integers
    normals: Floats
    normal_areas: Floats
    adhesion_forces: Floats
    friction: float
    in_situ_stress: float
    speed: float = 0.0

    def share_in_touch(self, forces: Floats) -> float:
        """Share of the area on which something has pressed.

        Args:
            forces: mean normal forces of the simulated stress over some time [N], [node_count].
        """
        touching = forces > self._parting_forces
        return float(self.normal_areas @ touching) / self._area

    @cached_property
    def _parting_forces(self) -> Floats:
        parting: Floats = (PARTED - 1.0) * self.in_situ_stress * self.normal_areas
        return parting

    @cached_property
    def _area(self) -> float:
        # Added up as the parts in touch are, so that all of it is exactly 1.
        return float(self.normal_areas @ np.ones(len(self.normal_areas), dtype=bool))

    def can_part(self, material: LinearElastic, speed: float) -> bool:
        """Whether the soil may pull at the surface by more than the in-situ stress presses.

        Nothing draws it together by more than the limit pressure of a spherical cavity,
        4/3 su (1 + ln G/su) (Hill 1950), and rho v^2 where it has to follow; twice that is taken.

        Args:
            material: the soil's.
            speed: of the body through the soil [m/s].
        """
        if not isinstance(material, PerfectlyPlastic):
            return True
        strength = material.strength
        limit = 4.0 / 3.0 * strength * (1.0 + math.log(material.shear_modulus / strength))
        return self.in_situ_stress < 2.0 * (limit + material.density * speed**2)
