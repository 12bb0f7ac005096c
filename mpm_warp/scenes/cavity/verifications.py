"""How cavities are compared with their exact pressures: soils, meshes and bounds."""

from __future__ import annotations

from collections.abc import Mapping

from mpm_warp.parameters import Value
from mpm_warp.scenes.catalogue import Verification

LARGEST_PORE_PRESSURE_ERROR = 0.02
"""Of the profile of excess pore pressure, over that at the wall."""
SOILS: tuple[dict[str, Value], ...] = (
    {"rigidity_index": 50.0, "material": "tresca"},
    {"rigidity_index": 500.0, "material": "tresca"},
    {"rigidity_index": 50.0, "material": "von_mises"},
)
"""Soft and stiff soil, and soil of von Mises."""
SOON: dict[str, Value] = {"remoulded_strength_ratio": 0.2, "ductility": 1.0}
LATE: dict[str, Value] = {"remoulded_strength_ratio": 0.2, "ductility": 10.0}
HURRIED: dict[str, Value] = {"rate_factor": 0.1, "reference_strain_rate": 0.01}
"""Clay that softens, sooner and later, and clay with a rate effect."""


LARGEST_ERROR_OF_CHANGING_CLAY = 0.01
"""Of the pressure over the whole curve, over the exact one at the end."""


def verifications(
    largest_error: float, resolutions: tuple[int, ...], *changing: Mapping[str, Value]
) -> tuple[Verification, ...]:
    """Perfectly plastic soils, and clays whose strength changes, at two resolutions.

    Args:
        largest_error: bound of the finer one's in perfectly plastic soils.
        resolutions: cells per radius, rising.
        changing: parameters of the clays.
    """
    bounds = (
        *((soil, largest_error) for soil in SOILS),
        *((clay, LARGEST_ERROR_OF_CHANGING_CLAY) for clay in changing),
    )
    return tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=resolutions,
            bounds={"error": bound, "pore_pressure_error": LARGEST_PORE_PRESSURE_ERROR},
            settings=settings,
        )
        for settings, bound in bounds
    )
