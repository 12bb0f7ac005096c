"""The ground by depth as a text: a table of its properties, linear between its rows.

It has a header that names columns and units, and a row for each depth; rows are parted by
new lines or by semicolons, values by commas:

    depth [m], strength [kPa], rigidity_index [1], unit_weight [kN/m3]
    0, 40, 100, 18
    2, 15, 100, 17
    12, 35, 100, 17
    12, 80, 150, 19
    20, 90, 150, 19

Two rows of one depth make the border of two layers. A row that begins with # is a remark.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats
from mpm_warp.parameters import nearest_name

UNITS: Mapping[str, Mapping[str, float]] = {
    "depth": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "strength": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "rigidity_index": {"1": 1.0},
    "shear_modulus": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "unit_weight": {"N/m3": 1.0, "kN/m3": 1e3},
    "adhesion_factor": {"1": 1.0},
    "stress_anisotropy": {"1": 1.0},
}
"""Units of each column, and what they are in SI units."""
REQUIRED = ("depth", "strength")
STIFFNESS = ("rigidity_index", "shear_modulus")
PROFILE = "profile"
"""The parameter of a sounding that holds such a text, and the table of a study that gives it."""


def columns_of(text: str) -> dict[str, Floats]:
    """The columns of a table, by name, in SI units, each of shape [row_count].

    Raises:
        ParameterError: header or rows are malformed.
    """
    lines = [it.strip() for it in re.split(r"[;\n]", text)]
    header, *lines = [it for it in lines if it and not it.startswith("#")] or [""]
    factors = _header(header)
    if not lines:
        raise refused("has no rows below its header")
    table = np.array([_row(number, it, factors) for number, it in enumerate(lines, 1)])
    return dict(zip(factors, (table * list(factors.values())).T, strict=True))


def text_of(columns: Mapping[str, Floats]) -> str:
    """A table of one line of columns in SI units; `columns_of` gives the same columns."""
    header = [f"{name} [{next(iter(UNITS[name]))}]" for name in columns]
    rows = [", ".join(map(repr, row)) for row in np.stack(list(columns.values()), -1).tolist()]
    return "; ".join([", ".join(header), *rows])


def replaced_by(text: str) -> set[str]:
    """Parameters of a sounding whose place a table takes: its columns and the stiffness.

    Raises:
        ParameterError: header or rows are malformed.
    """
    return {*columns_of(text), *STIFFNESS}


def _header(line: str) -> dict[str, float]:
    """The columns of a header, and what their units are in SI units."""
    factors: dict[str, float] = {}
    for cell in line.split(","):
        match = re.fullmatch(r"\s*([A-Za-z_]+)\s*(?:\[\s*([^\]]*?)\s*\])?\s*", cell)
        if match is None:
            raise refused("header: must name columns with units, as in 'depth [m], strength [kPa]'")
        name, unit = match.groups()
        if name not in UNITS:
            raise refused(f"unknown column {name!r}{nearest_name(name, UNITS)}")
        if unit not in UNITS[name]:
            given = f"has the unit [{unit}]" if unit else "has no unit"
            known = " or ".join(f"[{it}]" for it in UNITS[name])
            raise refused(f"column {name} {given}, must have {known}")
        if name in factors:
            raise refused(f"column {name} is there twice")
        factors[name] = UNITS[name][unit]
    for name in REQUIRED:
        if name not in factors:
            raise refused(f"column {name} is missing")
    if all(name in factors for name in STIFFNESS):
        raise refused("has rigidity_index and shear_modulus; keep one of them")
    return factors


def _row(number: int, line: str, columns: Mapping[str, float]) -> list[float]:
    cells = line.split(",")
    if len(cells) != len(columns):
        raise refused(f"row {number} {line!r} has {len(cells)} values, must have {len(columns)}")
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        raise refused(f"row {number} {line!r}: must be numbers") from None


def refused(problem: str) -> ParameterError:
    """The error of a profile, in one line."""
    return ParameterError(PROFILE, f"{PROFILE}: {problem}")
