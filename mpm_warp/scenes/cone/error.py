"""What the error of a cone resistance depends on: clay, cone and domain."""

import math
from collections.abc import Mapping
from typing import Any

from mpm_warp.scenes.clay import FieldClay
from mpm_warp.scenes.cone.groups import Domain, StandardCone
from mpm_warp.uncertainty.laws import ErrorLaws, slope_ratio


def error_laws(
    clay: FieldClay,
    cone: StandardCone,
    domain: Domain,
    *,
    cells_per_radius: float,
    extents: Mapping[str, float],
    **others: Any,
) -> ErrorLaws:
    """The laws of the error in a domain, whose `extents` by default are given.

    The `others` are the other fields of `ErrorLaws`, of clay and penetration.
    """
    strain_rate = clay.penetration_speed / cone.cone_radius
    fastest = strain_rate / (clay.reference_strain_rate or strain_rate)
    return ErrorLaws(
        cell_size=cone.cell_size(cells_per_radius) / cone.cone_radius,
        cell_growth=domain.cell_growth,
        outer=domain.domain_radius,
        above=domain.domain_above,
        below=domain.domain_below,
        extent_ratio=domain.extent_ratio(extents),
        above_ratio=domain.domain_above / extents["domain_above"],
        slope_ratio=slope_ratio(
            cone.apex_angle,
            strengthening=clay.rate_factor * math.log10(max(1.0, fastest)),
            brittleness=(1.0 - clay.remoulded_strength_ratio) / (clay.ductility or 1.0),
        ),
        **others,
    )
