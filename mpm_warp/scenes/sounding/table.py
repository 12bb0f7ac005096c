"""The text of a profile, the ground by depth: a table of columns with units.

The text has a header with names and units of the columns, and a row for each depth. Lines or
semicolons separate rows, commas separate values:

    depth [m], strength [kPa], rigidity_index [1], unit_weight [kN/m3]
    0, 40, 100, 18
    2, 15, 100, 17
    12, 35, 100, 17
    12, 80, 150, 19
    20, 90, 150, 19

Two rows of the same depth are a border of layers. A row that begins with # is a comment. Parameters
of a material law may be columns too, by their names.

Instead of stress_anisotropy a table may have K0 [1], effective horizontal over vertical stress, and
ground_water [m], the depth of the water table. At each row they give

    Delta = (1 - K0) (sigma_v0 - u0) / (2 su),   u0 = 9.81 kN/m3 below the table

The effective stress is linear between rows; a row is added at a water table between two rows. A law
of effective stress also takes p0' = (1 + 2 K0) (sigma_v0 - u0) / 3 from them.
"""

import re
from collections.abc import Mapping

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import NOT_NEGATIVE, POSITIVE, Range
from mpm_warp.fields.flat import own_of_variants
from mpm_warp.fields.names import nearest_parameter
from mpm_warp.fields.plain_numbers import plain_number
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.clay_law import LAWS, PARAMETER

PRESSURES = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6}
UNITS: Mapping[str, Mapping[str, float]] = {
    "depth": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "strength": PRESSURES,
    "rigidity_index": {"1": 1.0},
    "shear_modulus": PRESSURES,
    "unit_weight": {"N/m3": 1.0, "kN/m3": 1e3},
    "adhesion_factor": {"1": 1.0},
    "stress_anisotropy": {"1": 1.0},
    "K0": {"1": 1.0},
    "ground_water": {"m": 1.0},
}
"""Allowed units of each column, with their values in SI units."""
OTHER_NAMES = {"overconsolidation_ratio": "isotropic_overconsolidation_ratio"}
"""Aliases of columns."""
OF_EFFECTIVE_STRESS = ("K0", "ground_water")
"""Columns that together give the stress anisotropy."""
MEAN_STRESS, EARTH_PRESSURE = "mean_effective_stress", "earth_pressure_at_rest"
"""Parameters p0' and K0 of a law of effective stress; K0 and ground_water also give them."""
GIVING_ANISOTROPY = ("K0", EARTH_PRESSURE, "vertical_overconsolidation_ratio")
"""Columns from which a stress anisotropy follows."""
OWN = tuple(name for name in UNITS if name not in ("rigidity_index", *OF_EFFECTIVE_STRESS))
"""Fields of a profile that are columns."""
STIFFNESS = ("rigidity_index", "shear_modulus")
UNIT_WEIGHT, UNIT_WEIGHT_OF_WATER = 17e3, 9.81e3
"""Default unit weight of the ground, and that of water [N/m3]."""
PROFILE = "profile"
"""Name of the parameter of a sounding with such a text, and of the table in a study."""
REPLACED = (
    "undrained_shear_strength",
    "rigidity_index",
    "unit_weight",
    "strength_gradient",
    "layer_top",
    "layer_thickness",
    "layer_strength_ratio",
)
"""Parameters of a sounding that any table replaces."""
ALLOWED = {
    "depth": NOT_NEGATIVE,
    "unit_weight": NOT_NEGATIVE,
    "adhesion_factor": Range(minimum=0.0, maximum=1.0),
    "stress_anisotropy": Range(above=-1.0, below=1.0),
    "ground_water": NOT_NEGATIVE,
}
"""Allowed values by column; all others must be positive."""


def refused(problem: str) -> ParameterError:
    """The error for a problem of the profile, to be raised."""
    return ParameterError(PROFILE, f"{PROFILE}: {problem}")


def check_rows(name: str, values: Floats, allowed: Range | None = None) -> None:
    """Check the values of a column, by default as `ALLOWED` says."""
    allowed = allowed or ALLOWED.get(name, POSITIVE)
    for row, value in enumerate(values.tolist(), 1):
        if not allowed.holds(value, value):
            raise refused(f"{name} in row {row} is {value:g}, must be {allowed.allowed}")


def columns_of(text: str) -> dict[str, Floats]:
    """The columns of a table, by name, in SI units, each of shape [row_count].

    Raises:
        ParameterError: header or rows are malformed.
    """
    lines = [piece.strip() for piece in re.split(r"[;\n]", text)]
    header, *lines = [line for line in lines if line and not line.startswith("#")] or [""]
    factors = _header(header)
    if not lines:
        raise refused("has no rows below its header")
    table = np.array([_row(number, line, factors) for number, line in enumerate(lines, 1)])
    columns = dict(zip(factors, (table * list(factors.values())).T, strict=True))
    if not columns.keys() & {*OF_EFFECTIVE_STRESS}:
        return columns
    columns = _with_row_at_water_table(columns)
    vertical = effective_vertical_stress(columns)
    if "strength" not in columns:  # of a law that has its own; see `with_strength`
        return columns
    check_rows("strength", columns["strength"])
    return with_anisotropy(columns, (1.0 - columns["K0"]) * vertical)


def _with_row_at_water_table(columns: dict[str, Floats]) -> dict[str, Floats]:
    """Columns with a row at the water table, where the effective stress has a kink."""
    depth, water = columns["depth"], columns.get("ground_water", np.zeros(len(columns["depth"])))
    if "rigidity_index" in columns and "strength" in columns:  # G is linear between rows, not Ir
        columns["shear_modulus"] = columns.pop("rigidity_index") * columns["strength"]
    between = (depth[:-1] < water[:-1]) & (water[:-1] == water[1:]) & (water[1:] < depth[1:])
    for row in np.flatnonzero(between)[:1]:  # a horizontal water table lies between two rows only
        ends = slice(row, row + 2)
        return {
            name: np.insert(column, row + 1, np.interp(water[row], depth[ends], column[ends]))
            for name, column in columns.items()
        }
    return columns


def effective_vertical_stress(columns: Mapping[str, Floats]) -> Floats:
    """Effective vertical stress sigma_v0 - u0 [Pa] at the rows of a table with K0."""
    for name in OF_EFFECTIVE_STRESS:
        if name not in columns:
            raise refused(f"column {name} is missing; K0 and ground_water go together")
    if "stress_anisotropy" in columns:
        raise refused("has K0 and stress_anisotropy; keep one of them")
    columns = {"unit_weight": np.full_like(columns["depth"], UNIT_WEIGHT)} | dict(columns)
    for name in ("depth", "unit_weight", *OF_EFFECTIVE_STRESS):
        check_rows(name, columns[name])
    depth, weight = columns["depth"], columns["unit_weight"]
    between = np.diff(depth) * 0.5 * (weight[1:] + weight[:-1])
    stress = weight[0] * depth[0] + np.concatenate([[0.0], np.cumsum(between)])
    pressure = UNIT_WEIGHT_OF_WATER * np.maximum(0.0, depth - columns["ground_water"])
    effective: Floats = stress - pressure
    if effective.min() < 0.0:
        raise refused(
            f"u0 is above sigma_v0 at {depth[int(effective.argmin())]:g} m; unit_weight is that of "
            "soil with its water, 14 to 22 kN/m3"
        )
    return effective


def without_effective_stress(columns: Mapping[str, Floats]) -> dict[str, Floats]:
    """The columns other than K0 and ground water."""
    return {name: column for name, column in columns.items() if name not in OF_EFFECTIVE_STRESS}


def with_anisotropy(columns: Mapping[str, Floats], deviator: Floats) -> dict[str, Floats]:
    """Columns with the stress anisotropy instead of K0 and ground water.

    They have the strength; `deviator` is vertical less horizontal stress at the rows [Pa].
    """
    anisotropy = deviator / (2.0 * columns["strength"])
    check_rows("stress_anisotropy by K0", anisotropy, ALLOWED["stress_anisotropy"])
    return without_effective_stress(columns) | {"stress_anisotropy": anisotropy}


def units_of(name: str) -> Mapping[str, float]:
    """Units of a column, which may be a parameter of a law; the first is the SI unit."""
    if name in UNITS:
        return UNITS[name]
    of_laws = {
        key.removeprefix(f"{PARAMETER}."): definition.unit
        for key, definition in own_of_variants(LAWS).items()
    }
    if name not in of_laws:
        raise refused(f"unknown column {name!r}{nearest_parameter(name, [*UNITS, *of_laws])}")
    return PRESSURES if of_laws[name] == "Pa" else {of_laws[name]: 1.0}


def text_of(columns: Mapping[str, Floats]) -> str:
    """The table of columns in SI units, in one line; the inverse of `columns_of`."""
    header = [f"{name} [{next(iter(units_of(name)))}]" for name in columns]
    rows = [", ".join(map(repr, row)) for row in np.stack(list(columns.values()), -1).tolist()]
    return "; ".join([", ".join(header), *rows])


def replaced_by(text: str) -> set[str]:
    """Parameters of a sounding that a table replaces: `REPLACED` and those that are its columns."""
    columns = columns_of(text).keys()
    has_anisotropy = columns & {*GIVING_ANISOTROPY}
    of_law = [*(columns - UNITS.keys()), *([MEAN_STRESS] if has_anisotropy else [])]
    names = [*(columns & UNITS.keys()), *(f"{PARAMETER}.{name}" for name in of_law)]
    return {*names, *REPLACED, *(["stress_anisotropy"] if has_anisotropy else [])}


def _header(line: str) -> dict[str, float]:
    """The columns of a header, with the factors from their units to SI units."""
    factors: dict[str, float] = {}
    for cell in line.split(","):
        match = re.fullmatch(r"\s*([A-Za-z_]\w*)\s*(?:\[\s*([^\]]*?)\s*\])?\s*", cell)
        if match is None:
            raise refused("header: must name columns with units, as in 'depth [m], strength [kPa]'")
        name, unit = match.groups()
        name = OTHER_NAMES.get(name, name)
        units = units_of(name)
        if unit not in units:
            given = f"has the unit [{unit}]" if unit else "has no unit"
            known = " or ".join(f"[{known_unit}]" for known_unit in units)
            raise refused(f"column {name} {given}, must have {known}")
        if name in factors:
            raise refused(f"column {name} is there twice")
        factors[name] = units[unit]
    if "depth" not in factors:
        raise refused("column depth is missing")
    if all(name in factors for name in STIFFNESS):
        raise refused("has rigidity_index and shear_modulus; keep one of them")
    return factors


def _row(number: int, line: str, columns: Mapping[str, float]) -> list[float]:
    cells = line.split(",")
    if len(cells) != len(columns):
        raise refused(f"row {number} {line!r} has {len(cells)} values, must have {len(columns)}")
    numbers = [value for cell in cells if (value := plain_number(cell)) is not None]
    if len(numbers) < len(cells):
        raise refused(f"row {number} {line!r}: must be numbers, as 1.5 or 1.5e-3")
    return numbers
