"""Where and how strongly the contact law acts; the law itself is in `mpm_warp.kernels.contact`."""

from __future__ import annotations

from dataclasses import dataclass

from mpm_warp.grids import Floats, Integers


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceContact:
    """Contact with a rigid body whose surface is the first column of the grid's nodes.

    Areas are per radian: integrals of the nodes' shape functions over the surface, times r.

    Attributes:
        nodes: flat indices of the nodes in contact, shape [node_count].
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
