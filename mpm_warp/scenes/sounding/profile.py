"""The ground by depth: its properties in rows, linear between them; and the text of such a table.

The text has a header that names columns and units, and a row for each depth; rows are parted by
new lines or by semicolons, values by commas:

    depth [m], strength [kPa], rigidity_index [1], unit_weight [kN/m3]
    0, 40, 100, 18
    2, 15, 100, 17
    12, 35, 100, 17
    12, 80, 150, 19
    20, 90, 150, 19

Two rows of one depth make the border of two layers. A row that begins with # is a remark. Ground of
a law with parameters of its own may have these as columns too, by their names.

In place of stress_anisotropy a table may have K0 [1], effective horizontal over vertical stress,
and ground_water [m], the depth of the water table. At each row they give

    Delta = (1 - K0) (sigma_v0 - u0) / (2 su),   u0 = 9.81 kN/m3 below the table

and its effective stress is linear between rows; where the water table lies between two rows, a row
is added there. A law of effective stress takes p0' = (1 + 2 K0) (sigma_v0 - u0) / 3 from them too.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from mpm_warp.arguments import FINITE, NOT_NEGATIVE, POSITIVE, Range, as_array, in_words
from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.materials.other_laws import loaded_laws, other_law
from mpm_warp.materials.variation import Variation
from mpm_warp.parameters import nearest_parameter

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
"""Units of each column, and what they are in SI units."""
OTHER_NAMES = {"overconsolidation_ratio": "isotropic_overconsolidation_ratio"}
"""What a column may be called too."""
OF_EFFECTIVE_STRESS = ("K0", "ground_water")
"""Columns that give the stress anisotropy together."""
MEAN_STRESS, EARTH_PRESSURE = "mean_effective_stress", "earth_pressure_at_rest"
"""What a law of effective stress calls its p0' and K0; these columns give them too."""
OF_REST = ("K0", EARTH_PRESSURE, "vertical_overconsolidation_ratio")
"""Columns by which there is a stress anisotropy."""
OWN = tuple(name for name in UNITS if name not in ("rigidity_index", *OF_EFFECTIVE_STRESS))
"""Columns that all ground may have."""
FILLED_IN: Any = None
"""Default of a column that all ground has."""
STIFFNESS = ("rigidity_index", "shear_modulus")
UNIT_WEIGHT, UNIT_WEIGHT_OF_WATER = 17e3, 9.81e3
"""Of ground where no column has it, and of water [N/m3]."""
PROFILE = "profile"
"""The parameter of a sounding that holds such a text, and the table of a study that gives it."""
ALLOWED = {
    "depth": NOT_NEGATIVE,
    "unit_weight": NOT_NEGATIVE,
    "adhesion_factor": Range(minimum=0.0, maximum=1.0),
    "stress_anisotropy": Range(above=-1.0, below=1.0),
    "ground_water": NOT_NEGATIVE,
}
"""What the values of a column must be; the others are positive."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Ground by depth, in SI units; all arrays of shape [n], n >= 1.

    Attributes:
        depth: below the surface of the ground [m], >= 0, not falling, no depth more than twice.
        strength: undrained shear strength su [Pa], > 0.
        shear_modulus: G [Pa], > 0; default: 100 su.
        unit_weight: total unit weight [N/m3], >= 0; default: 17 kN/m3.
        adhesion_factor: of the cone's face beside the soil, dimensionless, 0 to 1; none where it is
            not of the ground.
        stress_anisotropy: Delta = (sigma_v0 - sigma_h0) / (2 su), dimensionless, > -1 and < 1, in
            the ground before; none where it is not of the ground. Between rows the stress is
            linear.
        of_law: parameters of the law of the ground that vary with depth, by name, in SI units.

    Raises:
        ParameterError: a column is unknown, or a value is not allowed; the message names column,
            row and value.
    """

    depth: Floats
    strength: Floats
    shear_modulus: Floats = FILLED_IN
    unit_weight: Floats = FILLED_IN
    adhesion_factor: Floats | None = None
    stress_anisotropy: Floats | None = None
    of_law: Mapping[str, Floats] = field(default_factory=dict)

    def __new__(cls, **columns: object) -> Self:  # noqa: D102 - the class says it
        for name in columns:
            if name not in (*OWN, "of_law"):
                raise refused(f"unknown column {name!r}{nearest_parameter(name, OWN)}")
        return super().__new__(cls)

    def __post_init__(self) -> None:
        strength = _numbers("strength", self.strength)
        given = {name: getattr(self, name) for name in OWN}
        if self.shear_modulus is FILLED_IN:
            given["shear_modulus"] = 100.0 * strength
        if self.unit_weight is FILLED_IN:
            given["unit_weight"] = np.full_like(strength, UNIT_WEIGHT)
        columns = {
            name: _numbers(name, value) for name, value in given.items() if value is not None
        }
        for name, values in columns.items():
            object.__setattr__(self, name, values)
        of_law = {name: _numbers(name, values) for name, values in self.of_law.items()}
        object.__setattr__(self, "of_law", of_law)
        for name, values in (columns | of_law).items():
            if values.ndim != 1 or values.size == 0 or values.shape != self.depth.shape:
                raise refused(f"{name} has shape {values.shape}, must have that of depth, [n]")
            _check_rows(name, values, FINITE if name in of_law else ALLOWED.get(name, POSITIVE))
        falls = np.flatnonzero(np.diff(self.depth) < 0.0)
        if len(falls):
            row = falls[0] + 1
            raise refused(
                f"depth in row {row + 1} is {self.depth[row]:g} m, must not be above that of the "
                f"row before, {self.depth[row - 1]:g} m"
            )
        thrice = np.flatnonzero(self.depth[2:] == self.depth[:-2])
        if len(thrice):
            raise refused(f"depth {self.depth[thrice[0]]:g} m is in three rows, must be in two")

    @classmethod
    def read(cls, text: str) -> Self:
        """A profile from its text; columns beside `depth` and `strength` may be left out.

        Without a stiffness the rigidity index is 100, without a unit weight it is 17 kN/m3. Without
        an adhesion factor or a stress anisotropy the ground has none of its own.

        Raises:
            ParameterError: something in it is not allowed.
        """
        return cls.of(columns_of(text))

    @classmethod
    def of(cls, columns: Mapping[str, Floats]) -> Self:
        """A profile of the columns of a table; see `read`."""
        if "strength" not in columns:
            raise refused("column strength is missing")
        own = {name: column for name, column in columns.items() if name in OWN}
        if "rigidity_index" in columns:
            own["shear_modulus"] = columns["rigidity_index"] * columns["strength"]
        of_law = {name: column for name, column in columns.items() if name not in UNITS}
        return cls(**own, of_law=of_law)

    @property
    def text(self) -> str:
        """The profile as a text of one line, in SI units; `read` gives the same profile."""
        return text_of(self._columns)

    @property
    def is_uniform(self) -> bool:
        """Whether all but the unit weight is the same everywhere."""
        others = ("depth", "unit_weight")
        return all(
            np.ptp(numbers) == 0.0 for name, numbers in self._columns.items() if name not in others
        )

    def between(self, begin: float, end: float) -> Self:
        """The ground from one depth to another [m], `begin` < `end`; beyond it goes on as there."""
        inside = (self.depth > begin) & (self.depth < end)

        def column(values: Floats) -> Floats:
            first, last = np.interp([begin, end], self.depth, values)
            return np.concatenate([[first], values[inside], [last]])

        depth = np.concatenate([[begin], self.depth[inside], [end]])
        others = {name: column(numbers) for name, numbers in self._columns.items()} | {
            "depth": depth
        }
        if self.stress_anisotropy is not None:
            others["stress_anisotropy"][[0, -1]] = self.stress_anisotropy_at(depth[[0, -1]], 0.0)
        return self.of(others)

    def variation(
        self,
        origin_depth: float,
        elsewhere: float = 0.0,
        *,
        strength: float | None = None,
        rows: tuple[Material, ...] | None = None,
    ) -> Variation | None:
        """Strength, stiffness and adhesion over the greatest of them, and the horizontal stress.

        There is none in uniform ground. z = 0 in the grid is at the origin's depth [m]. Elsewhere
        is the stress anisotropy where it is not of the ground. Strength is that of the material
        [Pa], by default the greatest; a law whose parameters vary has a material in each row.
        """
        if self.is_uniform:
            return None
        anisotropy = elsewhere if self.stress_anisotropy is None else self.stress_anisotropy
        horizontal = 2.0 * anisotropy * self.strength
        return Variation(
            depth=self.depth,
            strength_ratio=self.strength / (strength or self.strength.max()),
            stiffness_ratio=self.shear_modulus / self.shear_modulus.max(),
            adhesion_ratio=self._adhesion_ratio,
            rows=rows,
            horizontal_stress=horizontal if horizontal.any() else None,
            origin_depth=origin_depth,
        )

    @property
    def _columns(self) -> dict[str, Floats]:
        """The columns that there are, by name."""
        own = {name: getattr(self, name) for name in OWN}
        return {name: value for name, value in own.items() if value is not None} | dict(self.of_law)

    @property
    def _adhesion_ratio(self) -> Floats | None:
        """The adhesion factor over its greatest; none where that is the same everywhere."""
        if self.adhesion_factor is None or np.ptp(self.adhesion_factor) == 0.0:
            return None
        ratio: Floats = self.adhesion_factor / self.adhesion_factor.max()
        return ratio

    def strength_at(self, depth: Floats) -> Floats:
        """Strength at depths [Pa]."""
        return np.interp(depth, self.depth, self.strength)

    def adhesion_factor_at(self, depth: Floats, elsewhere: float) -> Floats:
        """Adhesion factor of the face at depths; `elsewhere` where it is not of the ground."""
        if self.adhesion_factor is None:
            return np.full_like(depth, elsewhere)
        return np.interp(depth, self.depth, self.adhesion_factor)

    def stress_anisotropy_at(self, depth: Floats, elsewhere: float) -> Floats:
        """Stress anisotropy at depths; `elsewhere` where it is not of the ground."""
        if self.stress_anisotropy is None:
            return np.full_like(depth, elsewhere)
        half = np.interp(depth, self.depth, self.stress_anisotropy * self.strength)
        return half / self.strength_at(depth)

    def greatest_adhesion_factor(self, elsewhere: float) -> float:
        """Greatest adhesion factor of the face; `elsewhere` where it is not of the ground."""
        return float(self.adhesion_factor_at(self.depth, elsewhere).max())

    def shear_modulus_at(self, depth: Floats) -> Floats:
        """Shear modulus at depths [Pa]."""
        return np.interp(depth, self.depth, self.shear_modulus)

    def mean_strength_around(self, depth: Floats, span: float) -> Floats:
        """Mean strength from `span` [m] above depths to `span` below them [Pa]."""
        return self._integral(self.strength, depth - span, depth + span) / (2.0 * span)

    def vertical_stress_at(self, depth: Floats) -> Floats:
        """In-situ vertical total stress at depths [Pa], 0 at the surface."""
        return self._integral(self.unit_weight, np.zeros_like(depth), depth)

    @property
    def thinnest_layer(self) -> float:
        """Thickness of the thinnest layer between two borders [m]; infinite without one."""
        borders = self.depth[1:][np.diff(self.depth) == 0.0]
        return float(np.diff(borders).min()) if len(borders) > 1 else math.inf

    def _integral(self, values: Floats, begin: Floats, end: Floats) -> Floats:
        """Integral of what is linear between the rows, and constant beyond them, over depth."""
        areas = np.diff(self.depth) * 0.5 * (values[1:] + values[:-1])
        until_row = np.append(0.0, np.cumsum(areas))

        def until(depth: Floats) -> Floats:
            inside = np.clip(depth, self.depth[0], self.depth[-1])
            last = np.clip(np.searchsorted(self.depth, inside, "right") - 1, 0, len(values) - 1)
            mean = 0.5 * (values[last] + np.interp(inside, self.depth, values))
            beyond = values[-1] * (depth - inside).clip(min=0.0)
            above = values[0] * (depth - inside).clip(max=0.0)
            whole: Floats = until_row[last] + mean * (inside - self.depth[last]) + beyond + above
            return whole

        return until(end) - until(begin)


def _check_rows(name: str, values: Floats, allowed: Range) -> None:
    sound = [allowed.holds(value, value) for value in values.tolist()]
    if not all(sound):
        row = sound.index(False)
        raise refused(f"{name} in row {row + 1} is {values[row]:g}, must be {allowed.allowed}")


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
    _check_rows("strength", columns["strength"], POSITIVE)
    return with_anisotropy(columns, (1.0 - columns["K0"]) * vertical)


def _with_row_at_water_table(columns: dict[str, Floats]) -> dict[str, Floats]:
    """Columns with a row where the water begins, as the effective stress has a kink there."""
    depth, water = columns["depth"], columns.get("ground_water", np.zeros(len(columns["depth"])))
    if "rigidity_index" in columns and "strength" in columns:  # what is linear between rows is G
        modulus = columns["rigidity_index"] * columns["strength"]
        columns = {name: column for name, column in columns.items() if name != "rigidity_index"}
        columns["shear_modulus"] = modulus
    between = (depth[:-1] < water[:-1]) & (water[:-1] == water[1:]) & (water[1:] < depth[1:])
    for row in np.flatnonzero(between)[:1]:  # a level table is at one depth
        ends = slice(row, row + 2)
        return {
            name: np.insert(column, row + 1, np.interp(water[row], depth[ends], column[ends]))
            for name, column in columns.items()
        }
    return columns


def effective_vertical_stress(columns: Mapping[str, Floats]) -> Floats:
    """sigma_v0 - u0 at the rows [Pa], of columns that have K0 and ground water."""
    for name in OF_EFFECTIVE_STRESS:
        if name not in columns:
            raise refused(f"column {name} is missing; K0 and ground_water go together")
    if "stress_anisotropy" in columns:
        raise refused("has K0 and stress_anisotropy; keep one of them")
    columns = {"unit_weight": np.full_like(columns["depth"], UNIT_WEIGHT)} | dict(columns)
    for name in ("depth", "unit_weight", *OF_EFFECTIVE_STRESS):
        _check_rows(name, columns[name], ALLOWED.get(name, POSITIVE))
    depth, weight = columns["depth"], columns["unit_weight"]
    between = np.diff(depth) * 0.5 * (weight[1:] + weight[:-1])
    stress = weight[0] * depth[0] + np.concatenate([[0.0], np.cumsum(between)])
    pressure = UNIT_WEIGHT_OF_WATER * np.maximum(0.0, depth - columns["ground_water"])
    effective: Floats = stress - pressure
    return effective


def with_anisotropy(columns: Mapping[str, Floats], deviator: Floats) -> dict[str, Floats]:
    """Columns with the stress anisotropy in the place of K0 and ground water.

    Args:
        columns: with the strength.
        deviator: vertical less horizontal stress at the rows [Pa].
    """
    anisotropy = deviator / (2.0 * columns["strength"])
    _check_rows("stress_anisotropy by K0", anisotropy, ALLOWED["stress_anisotropy"])
    rest = {name: column for name, column in columns.items() if name not in OF_EFFECTIVE_STRESS}
    return rest | {"stress_anisotropy": anisotropy}


def units_of(name: str) -> Mapping[str, float]:
    """Units of a column: of the ground, or a parameter of a law; the first is that of SI."""
    if name in UNITS:
        return UNITS[name]
    of_laws = {
        key: definition.unit
        for law in loaded_laws()
        for key, definition in other_law(law).parameters.items()
    }
    if name not in of_laws:
        raise refused(f"unknown column {name!r}{nearest_parameter(name, [*UNITS, *of_laws])}")
    return PRESSURES if of_laws[name] == "Pa" else {of_laws[name]: 1.0}


def text_of(columns: Mapping[str, Floats]) -> str:
    """A table of one line of columns in SI units; `columns_of` gives the same columns."""
    header = [f"{name} [{next(iter(units_of(name)))}]" for name in columns]
    rows = [", ".join(map(repr, row)) for row in np.stack(list(columns.values()), -1).tolist()]
    return "; ".join([", ".join(header), *rows])


def replaced_by(text: str) -> set[str]:
    """Parameters of a sounding whose place a table takes: its columns and the stiffness."""
    columns = columns_of(text).keys()
    by_rest = {"stress_anisotropy", MEAN_STRESS} if columns & {*OF_REST} else set()
    return {*columns, *STIFFNESS} | by_rest


def _header(line: str) -> dict[str, float]:
    """The columns of a header, and what their units are in SI units."""
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
    try:
        return [float(cell) for cell in cells]
    except ValueError:
        raise refused(f"row {number} {line!r}: must be numbers") from None


def _numbers(name: str, values: object) -> Floats:
    """A column as an array; anything but numbers is refused."""
    column = as_array(values)
    if column.dtype.kind not in "fiu":
        raise refused(f"{name} = {in_words(values)} must be a column of numbers")
    return column.astype(float)


def refused(problem: str) -> ParameterError:
    """The error of a profile, in one line."""
    return ParameterError(PROFILE, f"{PROFILE}: {problem}")
