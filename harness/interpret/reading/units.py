"""Units of lengths, areas, pressures and angles as files of tests write them."""

import math
from collections.abc import Mapping

LENGTHS: Mapping[str, float] = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}
"""Units of length [m]."""
AREAS: Mapping[str, float] = {"cm2": 1.0, "mm2": 1e-2, "m2": 1e4}
"""Units of area [cm2]."""
PRESSURES: Mapping[str, float] = {
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "bar": 1e5,
    "kN/m2": 1e3,
    "MN/m2": 1e6,
    "N/mm2": 1e6,
    "kg/cm2": 98066.5,
    "kgf/cm2": 98066.5,
    "mH2O": 9806.65,
    "mwc": 9806.65,
    "tsf": 95760.52,
    "ksf": 47880.26,
    "psi": 6894.757,
}
"""Units of pressure [Pa]; mwc is a metre of water column."""
ANGLES: Mapping[str, float] = dict.fromkeys(
    ("deg", "degrees", "grad", "graden", "\N{DEGREE SIGN}"), math.pi / 180.0
) | {"rad": 1.0}
"""Units of angle [rad]; Grad is German for a degree."""


def size_of(unit: str, sizes: Mapping[str, float]) -> float | None:
    """The size of a unit in any letters, with words after it or in brackets; None if unknown."""
    small = {name.lower(): size for name, size in sizes.items()}
    plain = unit.replace("\N{SUPERSCRIPT TWO}", "2").replace("^2", "2").lower()
    plain = plain.partition("(")[0].strip()  # as mm2 (square millimetre)
    return small.get(plain.replace(" ", ""), small.get(plain.partition(" ")[0]))
