"""Symbols of the field, by the names of variables, and how a quantity is written in a picture.

A symbol is written as in ``I_r``: what follows the underscore is its subscript. A variable without
a symbol is called by its name.
"""

from __future__ import annotations

import re
from collections.abc import Hashable

import xarray as xr

from harness.archive.conventions import spoken

SYMBOLS = {
    "cone_factor": "N_c",
    "cone_factor_uncertainty": "U_95",
    "rigidity_index": "I_r",
    "adhesion_factor": "α",
    "shaft_adhesion_factor": "α_s",
    "friction_coefficient": "μ_f",
    "friction": "μ",
    "undrained_shear_strength": "s_u",
    "in_situ_stress": "σ_v0",
    "stress_anisotropy": "Δ",
    "remoulded_strength_ratio": "δ_rem",
    "ductility": "ξ_95",
    "poissons_ratio": "ν",
    "poissons_ratio_bound": "ν_max",
    "density": "ρ",
    "cone_radius": "R",
    "apex_angle": "β",
    "penetration": "z/R",
    "cells_per_radius": "R/h",
    "cells_per_length": "L/h",
    "speed_ratio": "v/v_s",
    "time_step_fraction": "Δt/Δt_c",
}
"""R is the radius and h the width of a cell; v_s is the shear wave speed."""

_UNITS = {"degree": "°", "kg m-3": "kg/m³", "m s-1": "m/s", "m s-2": "m/s²", "s-1": "1/s"}
"""Units as readers write them."""
_SPELT = {"poissons ratio": "Poisson's ratio", "in situ stress": "in-situ stress"}
_PREFIXES = {"Pa": ((1e9, "G"), (1e6, "M"), (1e3, "k"))}
"""Larger units that readers expect, by the unit."""
_SUBSCRIPT = re.compile(r"_(\w+)")


def symbol(name: Hashable) -> str:
    """The symbol of a variable in matplotlib's mathematics, "" where it has none."""
    written = SYMBOLS.get(str(name).removesuffix("_parameter"), "")
    subscripted = _SUBSCRIPT.sub(r"_{\\mathrm{\1}}", written)
    return f"${subscripted}$" if written else ""


def plain(text: object) -> str:
    """A text in which matplotlib finds no mathematics."""
    return str(text).replace("$", r"\$")


def named(dataset: xr.Dataset, name: Hashable) -> str:
    """Name and symbol of a variable."""
    told = str(dataset[name].attrs.get("long_name", spoken(name)))
    return f"{plain(spelt(told))} {symbol(name)}".rstrip()


def unit_of(dataset: xr.Dataset, name: Hashable) -> str:
    """The unit of a variable as readers write it; "" where it has none."""
    unit = str(dataset[name].attrs.get("units", "1"))
    return "" if unit == "1" else _UNITS.get(unit, unit)


def spelt(told: str) -> str:
    """Words of a name as readers write them."""
    for name, spelling in _SPELT.items():
        told = told.replace(name, spelling)
    return told


def axis_label(dataset: xr.Dataset, name: Hashable) -> str:
    """Name, symbol and unit of a variable; a text has no unit."""
    is_number = dataset[name].dtype.kind in "biuf"
    unit = unit_of(dataset, name)
    return f"{named(dataset, name)} [{plain(unit) or '-'}]" if is_number else (named(dataset, name))


def number(value: float) -> str:
    """A number with the digits that a reader needs: four."""
    return f"{value:.4g}"


def quantity(value: object, unit: str = "") -> str:
    """A value with its unit, as a reader would write it: 20 kPa."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return plain(value).replace("_", " ")
    for factor, prefix in _PREFIXES.get(unit, ()):
        if abs(value) >= factor:
            return f"{number(value / factor)} {prefix}{unit}"
    return f"{number(value)} {plain(unit)}".rstrip().replace(" °", "°")


def assigned(dataset: xr.Dataset, name: Hashable, value: object) -> str:
    """A parameter and its value, by its symbol where it has one: I_r = 100."""
    told = quantity(value, unit_of(dataset, name))
    own = symbol(name)
    return f"{own} = {told}" if own else f"{plain(spelt(spoken(name)))} = {told}"
