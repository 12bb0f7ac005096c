"""The profile of the ground: properties in rows by depth, linear between the rows."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mpm_warp.fields.checked import complete
from mpm_warp.fields.checks import FINITE, as_array, in_words
from mpm_warp.fields.names import nearest_parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.materials.variation import Variation
from mpm_warp.scenes.sounding.table import (
    EARTH_PRESSURE,
    MEAN_STRESS,
    OWN,
    UNIT_WEIGHT,
    UNITS,
    check_rows,
    columns_of,
    refused,
    text_of,
)
from mpm_warp.uncertainty.laws import CLEAR_OF_BORDER, CLEAR_OF_LARGE_CHANGE

ROUNDING = 1e-9
"""Relative change between two rows below which the change counts as rounding."""
RAMP_LENGTH, RAMP_CHANGE, LARGE_CHANGE = 1.5, 0.3, 0.76
"""A change of more than `RAMP_CHANGE` within `RAMP_LENGTH` radii counts as a border. A
change of strength by more than `LARGE_CHANGE`, just over a factor of four, changes the resistance
from farther away."""
ABSOLUTE_CHANGES = {"adhesion_factor", "stress_anisotropy"}
"""Columns whose change is absolute; that of others is relative to the larger value."""
TINY = 1e-300
"""Divisor that replaces 0."""
FILLED_IN_LATER: Any = None
"""Default of a column that `__post_init__` fills in."""


def _change(name: str, one: Floats, other: Floats) -> Any:
    """Change of a column between two values or arrays; see `ABSOLUTE_CHANGES`."""
    scale = np.maximum(np.maximum(np.abs(one), np.abs(other)), TINY)
    return np.abs(other - one) / (1.0 if name in ABSOLUTE_CHANGES else scale)


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """Ground by depth, in SI units; all arrays of shape [n], n >= 1.

    Attributes:
        depth: below the surface of the ground [m], >= 0, not decreasing, no depth more than twice.
        strength: undrained shear strength su [Pa], > 0.
        shear_modulus: G [Pa], > 0; default: 100 su.
        unit_weight: total unit weight [N/m3], >= 0; default: 17 kN/m3.
        adhesion_factor: of the cone's face beside the soil, dimensionless, 0 to 1; None where the
            profile does not give it.
        stress_anisotropy: Delta = (sigma_v0 - sigma_h0) / (2 su) in situ, dimensionless, > -1 and
            < 1; None where the profile does not give it. Between rows the stress is linear.
        of_law: parameters of the material law that vary with depth, by name, in SI units.

    Raises:
        ParameterError: a column is unknown, or a value is not allowed; the message names column,
            row and value.

    Example:
        >>> ground = Profile(depth=np.array([0.0, 5.0]), strength=np.array([10e3, 30e3]))
        >>> float(ground.strength_at(2.5))  # [Pa]
        20000.0
        >>> ground.shear_modulus
        array([1000000., 3000000.])
        >>> Profile.read(ground.text).strength
        array([10000., 30000.])
    """

    depth: Floats
    strength: Floats
    shear_modulus: Floats = FILLED_IN_LATER
    unit_weight: Floats = FILLED_IN_LATER
    adhesion_factor: Floats | None = None
    stress_anisotropy: Floats | None = None
    of_law: Mapping[str, Floats] = field(default_factory=dict)

    def __new__(cls, **columns: object) -> Self:
        """Refuse an unknown column; the message suggests the nearest one, unlike `__init__`."""
        for name in columns:
            if name not in (*OWN, "of_law"):
                raise refused(f"unknown column {name!r}{nearest_parameter(name, OWN)}")
        return super().__new__(cls)

    def __post_init__(self) -> None:
        given = {name: getattr(self, name) for name in OWN}
        own = {name: _numbers(name, value) for name, value in given.items() if value is not None}
        strength = _numbers("strength", self.strength)
        weight = np.full_like(strength, UNIT_WEIGHT)
        own = {"shear_modulus": 100.0 * strength, "unit_weight": weight} | own
        of_law = {name: _numbers(name, values) for name, values in self.of_law.items()}
        complete(self, **own, of_law=of_law)
        for name, values in self._columns.items():
            if values.ndim != 1 or values.size == 0 or values.shape != self.depth.shape:
                raise refused(f"{name} has shape {values.shape}, must have that of depth, [n]")
            check_rows(name, values, FINITE if name in of_law else None)
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
        """A profile from its text, see `table`; only depth and strength must be given.

        The default rigidity index is 100, the default unit weight 17 kN/m3. Adhesion factor and
        stress anisotropy have no default here: without them those of the scene hold.

        Raises:
            ParameterError: the text has something that is not allowed.
        """
        return cls.of(columns_of(text))

    @classmethod
    def of(cls, columns: Mapping[str, Floats]) -> Self:
        """A profile from the columns of a table; see `read`."""
        if "strength" not in columns:
            raise refused("column strength is missing")
        own = {name: column for name, column in columns.items() if name in OWN}
        if "rigidity_index" in columns:
            own["shear_modulus"] = columns["rigidity_index"] * columns["strength"]
        of_law = {name: column for name, column in columns.items() if name not in UNITS}
        return cls(**own, of_law=of_law)

    @property
    def text(self) -> str:
        """The profile as one line of text in SI units, from which `read` restores it."""
        return text_of(self._columns)

    @property
    def is_uniform(self) -> bool:
        """Whether all properties but the unit weight are constant with depth."""
        return all(np.ptp(values) == 0.0 for values in self._acting.values())

    def between(self, begin: float, end: float) -> Self:
        """The ground from one depth to another [m], `begin` < `end`; constant beyond both."""
        inside = (self.depth > begin) & (self.depth < end)

        def column(values: Floats) -> Floats:
            first, last = np.interp([begin, end], self.depth, values)
            return np.concatenate([[first], values[inside], [last]])

        depth = np.concatenate([[begin], self.depth[inside], [end]])
        columns = {name: column(values) for name, values in self._columns.items()}
        if self.stress_anisotropy is not None:
            columns["stress_anisotropy"][[0, -1]] = self.stress_anisotropy_at(depth[[0, -1]], 0.0)
        if EARTH_PRESSURE in columns:  # the ratio of stresses, each linear between rows
            at_rest = self.of_law[EARTH_PRESSURE]
            vertical = self.of_law.get(MEAN_STRESS, 1.0) / (1.0 + 2.0 * at_rest)
            ends = column(at_rest * vertical) / column(vertical)
            columns[EARTH_PRESSURE][[0, -1]] = ends[[0, -1]]
        return self.of(columns | {"depth": depth})

    def variation(
        self,
        origin_depth: float,
        elsewhere: float = 0.0,
        *,
        strength: float | None = None,
        rows: tuple[Material, ...] | None = None,
    ) -> Variation | None:
        """Variation of strength, stiffness, adhesion and horizontal stress with depth.

        The first three are relative to their largest values. It is None in uniform ground.

        Args:
            origin_depth: depth of z = 0 of the grid [m].
            elsewhere: stress anisotropy where the profile gives none.
            strength: the strength of ratio 1 [Pa]; default: the largest of the profile.
            rows: the material of each row, for a law whose parameters vary.
        """
        if self.is_uniform:
            return None
        anisotropy = elsewhere if self.stress_anisotropy is None else self.stress_anisotropy
        horizontal = 2.0 * anisotropy * self.strength
        rough = self.adhesion_factor
        if rough is not None:
            rough = None if np.ptp(rough) == 0.0 else rough / rough.max()
        return Variation(
            depth=self.depth,
            strength_ratio=self.strength / (strength or self.strength.max()),
            stiffness_ratio=self.shear_modulus / self.shear_modulus.max(),
            adhesion_ratio=rough,
            rows=rows,
            horizontal_stress=horizontal if horizontal.any() else None,
            origin_depth=origin_depth,
        )

    @property
    def _columns(self) -> dict[str, Floats]:
        """The columns that the profile has, by name."""
        own = {name: getattr(self, name) for name in OWN}
        return {name: value for name, value in own.items() if value is not None} | dict(self.of_law)

    @property
    def _acting(self) -> dict[str, Floats]:
        """The columns that the resistance depends on."""
        others = ("depth", "unit_weight")
        return {name: it for name, it in self._columns.items() if name not in others}

    def near_border(self, position: Floats, radius: float) -> NDArray[np.bool_]:
        """Whether a border changes the resistance at positions, depths over `radius` [m], [n].

        A border is a jump between two rows, or a large change within `RAMP_LENGTH` radii.
        """
        near = np.zeros(len(position), dtype=bool)

        def mark(top: float, bottom: float, ratio: float) -> None:
            before, behind = CLEAR_OF_LARGE_CHANGE if ratio > LARGE_CHANGE else CLEAR_OF_BORDER
            near[(position > top / radius - before) & (position < bottom / radius + behind)] = True

        is_jump = np.diff(self.depth) == 0.0
        for row in np.flatnonzero(is_jump):
            change = {name: _change(name, *it[[row, row + 1]]) for name, it in self._acting.items()}
            if max(change.values()) > ROUNDING:
                mark(self.depth[row], self.depth[row], change["strength"])
        jumps = self.depth[1:][is_jump]
        for offset in (-RAMP_LENGTH * radius, RAMP_LENGTH * radius):
            ends = np.sort([self.depth, self.depth + offset], axis=0)
            beyond = {
                name: _change(name, it, np.interp(self.depth + offset, self.depth, it))
                for name, it in self._acting.items()
            }
            changed = np.max(list(beyond.values()), axis=0) > RAMP_CHANGE
            for row in np.flatnonzero(changed):
                top, bottom = ends[:, row]
                if not ((jumps >= top) & (jumps <= bottom)).any():
                    mark(top, bottom, beyond["strength"][row])
        return near

    def strength_at(self, depth: Floats) -> Floats:
        """Strength at depths [Pa]."""
        return np.interp(depth, self.depth, self.strength)

    def adhesion_factor_at(self, depth: Floats, elsewhere: float) -> Floats:
        """Adhesion factor of the face at depths; `elsewhere` if the profile gives none."""
        if self.adhesion_factor is None:
            return np.full_like(depth, elsewhere)
        return np.interp(depth, self.depth, self.adhesion_factor)

    def stress_anisotropy_at(self, depth: Floats, elsewhere: float) -> Floats:
        """Stress anisotropy at depths; `elsewhere` if the profile gives none."""
        if self.stress_anisotropy is None:
            return np.full_like(depth, elsewhere)
        half = np.interp(depth, self.depth, self.stress_anisotropy * self.strength)
        return half / self.strength_at(depth)

    def greatest_adhesion_factor(self, elsewhere: float) -> float:
        """Largest adhesion factor of the face; `elsewhere` if the profile gives none."""
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
        """Integral over depth of a column, linear between rows and constant beyond them."""
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


def _numbers(name: str, values: object) -> Floats:
    """A column as an array; anything but numbers is refused."""
    column = as_array(values)
    if column.dtype.kind not in "fiu":
        raise refused(f"{name} = {in_words(values)} must be a column of numbers")
    return column.astype(float)
