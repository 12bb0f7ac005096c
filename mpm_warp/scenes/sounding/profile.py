"""The ground by depth: its properties in rows, linear between them; and the text of such a table.

The text has a header that names columns and units, and a row for each depth; rows are parted by
new lines or by semicolons, values by commas:

    depth [m], strength [kPa], rigidity_index [1], unit_weight [kN/m3]
    0, 40, 100, 18
    2, 15, 100, 17
    12, 35, 100, 17
    12, 80, 150, 19
    20, 90, 150, 19

Two rows of one depth make the border of two layers. A row that begins with # is a remark.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Self

import numpy as np

from mpm_warp.arguments import NOT_NEGATIVE, POSITIVE, Range, as_array, in_words
from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.materials.variation import Variation
from mpm_warp.parameters import nearest_name

UNITS: Mapping[str, Mapping[str, float]] = {
    "depth": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "strength": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "strength_extension": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "strength_simple_shear": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "strength_horizontal": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "rigidity_index": {"1": 1.0},
    "shear_modulus": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6},
    "unit_weight": {"N/m3": 1.0, "kN/m3": 1e3},
    "adhesion_factor": {"1": 1.0},
    "stress_anisotropy": {"1": 1.0},
}
"""Units of each column, and what they are in SI units."""
OTHER_NAMES = {"strength_compression": "strength"}
"""What a column may be called too."""
BY_DIRECTION = ("strength_extension", "strength_simple_shear", "strength_horizontal")
"""Columns of ground whose strength depends on direction; `strength` is that in compression."""
REQUIRED = ("depth", "strength")
STIFFNESS = ("rigidity_index", "shear_modulus")
PROFILE = "profile"
"""The parameter of a sounding that holds such a text, and the table of a study that gives it."""
ALLOWED = {
    "depth": NOT_NEGATIVE,
    "unit_weight": NOT_NEGATIVE,
    "adhesion_factor": Range(minimum=0.0, maximum=1.0),
    "stress_anisotropy": Range(above=-1.0, below=1.0),
}
"""What the values of a column must be; the others are positive."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Ground by depth, in SI units; all arrays of shape [n], n >= 1.

    Attributes:
        depth: below the surface of the ground [m], >= 0, not falling, no depth more than twice.
        strength: undrained shear strength su [Pa], > 0.
        shear_modulus: G [Pa], > 0.
        unit_weight: total unit weight [N/m3], >= 0.
        adhesion_factor: of the cone's face beside the soil, dimensionless, 0 to 1; none where it is
            not of the ground.
        stress_anisotropy: Delta = (sigma_v0 - sigma_h0) / (2 su), dimensionless, > -1 and < 1, in
            the ground before; none where it is not of the ground. Between rows the stress is
            linear.
        strength_extension, strength_simple_shear, strength_horizontal: of ground whose strength
            depends on direction [Pa], see `Anisotropic`; `strength` is then that in compression.
            The last may be left out; without the others it does not.

    Raises:
        ParameterError: a value is not allowed; the message names column, row and value.
    """

    depth: Floats
    strength: Floats
    shear_modulus: Floats
    unit_weight: Floats
    adhesion_factor: Floats | None = None
    stress_anisotropy: Floats | None = None
    strength_extension: Floats | None = None
    strength_simple_shear: Floats | None = None
    strength_horizontal: Floats | None = None

    def __post_init__(self) -> None:
        columns = {
            it.name: _numbers(it.name, getattr(self, it.name))
            for it in fields(self)
            if getattr(self, it.name) is not None or it.default is MISSING
        }
        for name, values in columns.items():
            object.__setattr__(self, name, values)
            if values.ndim != 1 or values.size == 0 or values.shape != self.depth.shape:
                raise refused(f"{name} has shape {values.shape}, must have that of depth, [n]")
            _check_rows(name, values, ALLOWED.get(name, POSITIVE))
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
        if any(getattr(self, name) is not None for name in BY_DIRECTION):
            if self.strength_extension is None or self.strength_simple_shear is None:
                raise refused("needs strength_extension and strength_simple_shear: give both")
            _ = self.shape  # all rows are possible

    @classmethod
    def read(cls, text: str) -> Self:
        """A profile from its text; columns beside `depth` and `strength` may be left out.

        Without a stiffness the rigidity index is 100, without a unit weight it is 17 kN/m3. Without
        an adhesion factor or a stress anisotropy the ground has none of its own.

        Raises:
            ParameterError: something in it is not allowed.
        """
        columns = columns_of(text)
        if "rigidity_index" in columns:
            columns["shear_modulus"] = columns.pop("rigidity_index") * columns["strength"]
        columns.setdefault("shear_modulus", 100.0 * columns["strength"])
        columns.setdefault("unit_weight", np.full_like(columns["depth"], 17e3))
        return cls(**columns)

    @property
    def text(self) -> str:
        """The profile as a text of one line, in SI units; `read` gives the same profile."""
        return text_of(self._columns)

    @property
    def is_uniform(self) -> bool:
        """Whether all but the unit weight is the same everywhere."""
        others = ("depth", "unit_weight")
        return all(np.ptp(it) == 0.0 for name, it in self._columns.items() if name not in others)

    def between(self, begin: float, end: float) -> Self:
        """The ground from one depth to another [m], `begin` < `end`; beyond it goes on as there."""
        inside = (self.depth > begin) & (self.depth < end)

        def column(values: Floats) -> Floats:
            first, last = np.interp([begin, end], self.depth, values)
            return np.concatenate([[first], values[inside], [last]])

        depth = np.concatenate([[begin], self.depth[inside], [end]])
        others = {name: column(it) for name, it in self._columns.items() if name != "depth"}
        if self.stress_anisotropy is not None:
            others["stress_anisotropy"][[0, -1]] = self.stress_anisotropy_at(depth[[0, -1]], 0.0)
        return type(self)(depth=depth, **others)

    def variation(self, origin_depth: float, elsewhere: float = 0.0) -> Variation | None:
        """Strength, stiffness and adhesion over the greatest of them, and the horizontal stress.

        There is none in uniform ground.

        Args:
            origin_depth: depth of z = 0 in the grid [m].
            elsewhere: stress anisotropy where it is not of the ground.
        """
        if self.is_uniform:
            return None
        anisotropy = elsewhere if self.stress_anisotropy is None else self.stress_anisotropy
        horizontal = 2.0 * anisotropy * self.strength
        return Variation(
            depth=self.depth,
            strength_ratio=self.strength / self.strength.max(),
            stiffness_ratio=self.shear_modulus / self.shear_modulus.max(),
            adhesion_ratio=self._adhesion_ratio,
            shape=self.shape,
            horizontal_stress=horizontal if horizontal.any() else None,
            origin_depth=origin_depth,
        )

    def strengths_in_row(self, row: int) -> dict[str, float]:
        """Strengths by direction, as `Anisotropic` calls them; {} where there are none."""
        if self.strength_extension is None:
            return {}
        columns = {"strength_compression": self.strength}
        columns |= {name: it for name, it in self._columns.items() if name in BY_DIRECTION}
        return {name: float(it[row]) for name, it in columns.items()}

    @property
    def shape(self) -> Floats | None:
        """Shape of the yield surface where the strength depends on direction, [n, shape_count].

        Raises:
            ParameterError: the strengths of a row are not possible together.
        """
        if self.strength_extension is None:
            return None
        shapes = []
        for row, shear_modulus in enumerate(self.shear_modulus.tolist()):
            given = self.strengths_in_row(row) | {"shear_modulus": shear_modulus}
            try:
                shapes.append(Anisotropic(density=1.0, poissons_ratio=0.0, **given).shape)
            except SceneError as refusal:
                raise refused(f"row {row + 1}: {refusal}") from None
        return np.array(shapes)

    @property
    def _columns(self) -> dict[str, Floats]:
        """The columns that there are, by name."""
        return {name: values for name, values in vars(self).items() if values is not None}

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
        anisotropy: Floats = half / self.strength_at(depth)
        return anisotropy

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

        between: Floats = until(end) - until(begin)
        return between


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
        name = OTHER_NAMES.get(name, name)
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


def _numbers(name: str, values: object) -> Floats:
    """A column as an array; anything but numbers is refused."""
    column = as_array(values)
    if column.dtype.kind not in "fiu":
        raise refused(f"{name} = {in_words(values)} must be a column of numbers")
    return column.astype(float)


def refused(problem: str) -> ParameterError:
    """The error of a profile, in one line."""
    return ParameterError(PROFILE, f"{PROFILE}: {problem}")
