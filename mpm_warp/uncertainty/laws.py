"""The laws of the error of a cone factor: what mesh, speed and window add to it.

    E_mesh   = B h + Q h^1.7 + C g^1.5 h^1.3
    E_speed  = S i
    E_bottom = -D Ir / H^2
    E_bound  = -P b

h is the width of the cells at the cone over its radius, g their growth. i = rho V^2 / su =
Ir (V / c_s)^2 is the inertia, c_s the speed of shear waves. H is the distance of the bottom of the
window from the tip, over the radius. b is what a bound of Poisson's ratio takes off that of the
clay. A table has B and Q by rigidity index and adhesion factor, another the other effects and all
half widths (`measured`).

All four are subtracted from the cone factor. What remains unknown is given as half widths of 95 %.
`README.md` says how all of it was measured; `studies/mesh_error.toml` measures B. The
laws serve a cone test (`cone`) and each sample of a sounding (`samples`).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpm_warp.uncertainty.built import LARGEST_BRITTLENESS
from mpm_warp.uncertainty.tables import Table, Value, effects, read

Condition = NDArray[np.bool_] | bool

TABLE = Table.of("cone_factor")
"""B, Q and the half width of the limit of fine cells."""
EFFECTS = effects("cone_factor_effects")
BY_APEX = np.array([[float(it) for it in row.values()] for row in read("cone_slopes")]).T
"""Apex angles [degree], and B there over that of `APEX_ANGLE`."""

APEX_ANGLE = 60.0
"""Apex angle of the cones that the laws were measured with [degree]."""
CURVATURE_POWER = 1.7
"""The power of h in the term of Q."""
GROWTH_OF_MESHES = 0.4
"""Growth of the cells of the meshes on which B and Q were measured."""
BY_STRENGTHENING, BY_BRITTLENESS = 0.45, -2.5
"""Change of B over B per relative rise of the strength at the strain rate V / R, and per
(1 - delta) / xi_95; likewise."""
LARGEST_MEASURABLE_CELL, LARGEST_CELL = 0.44, 0.58
"""Largest width of the cells at the cone over its radius for which these laws hold: in further runs
and samples of a sounding, 4 rows of cells beside a face of 60 degrees; in cone tests, 3 rows."""
LARGEST_INERTIA, LARGEST_MEASURED_INERTIA = 3.0, 1.0
"""rho V^2 / su up to which E_speed holds, and up to which further runs at half the speed measure
it. The effect is not linear: at 2.9 the further runs were off by twice their half width."""
LARGEST_INERTIA_OF_APPROACH = 20.0
"""rho V^2 / su up to which a fast approach is allowed: at 17 and 22 Nc was within U, at 35 and 56
it was not."""
NEAREST_TOP = 0.74
"""Smallest extent of the window above the shoulder, over the default one, for which the effect of
the top is known. At 0.5 Nc was off by 1.3 to 2.5 U, at 0.72 by 1.0; at 0.75 random cases were
within U."""
LARGEST_GROWTH = 1.0
"""Growth of the cells up to which its effect is known."""
NEAREST_BOTTOM = 0.74
"""Smallest H / sqrt(Ir) for which the effect of the bottom is known."""
FULL_DOMAIN_INDEX = 50.0
"""Rigidity index below which the half width of the default window is in proportion to Ir: softer
clay has a smaller plastic zone in a window of the same size."""
GROWTH_SHARE = 1.0 / 3.0
"""Largest share of the term of C that its half width for other powers of h and g has."""
FELT_BEFORE = {True: 3.0, False: 7.0}
"""Distance above a border of layers, over the radius, at which 5 % of the change of resistance is
reached; the largest of the study `two_layers`. Key: whether the soil below is the stronger."""
FELT_BEHIND = {True: 9.0, False: 4.0}
"""Distance below a border, over the radius, at which 95 % of the change is reached; likewise."""
CLEAR_OF_BORDER = 10.0, 16.0
"""Distances above and below a border, over the radius, beyond which the border no longer matters:
96 to 100 % of the samples of a sounding there are within the half width of uniform ground. From
`two_layers`, at a quarter and four times the strength. None are from 8 to 7 radii above, and from
9 to 12 below."""
CLEAR_OF_LARGE_CHANGE = 16.0, 30.0
"""The same distances where the strength changes by more than a factor of four. At 0.1 and 0.02
times the strength all of 520 samples beyond them are within the half width."""
TESTED_ANISOTROPY, TESTED_POISSONS_RATIO = 0.5, 0.45
"""Largest |Delta| and smallest Poisson's ratio for which the laws were measured and tested."""
LARGEST_ANISOTROPY, SMALLEST_POISSONS_RATIO = 0.95, 0.4
SMALLEST_INDEX, LARGEST_INDEX = 10.0, 2000.0
"""How far the laws are extrapolated; each was checked in a few runs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorLaws:
    """The laws, for one cone factor or for an array of them.

    All values are those simulated; lengths are over the radius of the cone.
    """

    rigidity_index: Value  # G/su, shape [...]
    adhesion_factor: Value  # of the face, shape [...]
    stress_anisotropy: Value  # Delta of the ground, shape [...]
    poissons_ratio: float  # as simulated
    poissons_ratio_reduction: float  # b, ratio of the clay less ratio as simulated
    inertia: Value  # rho V^2 / su, shape [...]
    cell_size: float  # width of the cells at the cone
    cell_growth: float  # growth of their width per distance from the penetrometer
    outer: float  # radius of the window
    above: float  # extent of the window above the shoulder
    below: float  # extent of the window below the tip
    extent_ratio: float  # default extent over actual extent, greatest of all directions
    above_ratio: float  # extent above over the default one
    approach_inertia: float  # rho V^2 / su of a fast approach, 0 without one
    penetration: Value  # of the cone since its start, shape [...]
    slope_ratio: float = 1.0  # B over that of Tresca clay and a cone of 60 degrees

    @property
    def correction(self) -> Value:
        """The correction to be added to the cone factor, shape [...].

        Where the laws do not hold it is that at the nearest place where they do. So it never ends,
        and a study of any parameter has no step.
        """
        mesh = mesh_error(
            rigidity_index=self.rigidity_index,
            adhesion_factor=self.adhesion_factor,
            cell_size=min(self.cell_size, LARGEST_CELL),
            cell_growth=min(self.cell_growth, LARGEST_GROWTH),
            slope_ratio=self.slope_ratio,
        )
        bottom = EFFECTS["bottom"].size * np.minimum(self._nearness, 1.0 / NEAREST_BOTTOM**2)
        speed = EFFECTS["speed"].size * np.minimum(self.inertia, LARGEST_INERTIA)
        return bottom - speed - mesh + EFFECTS["bound"].size * self.poissons_ratio_reduction

    def half_widths(self) -> dict[str, Value]:
        """Half widths of 95 % that remain in the corrected cone factor, by cause."""
        felt = np.minimum(1.0, self.rigidity_index / FULL_DOMAIN_INDEX)
        left = {name: effect.half_width for name, effect in EFFECTS.items()}
        root = np.sqrt(self.rigidity_index)
        return {
            "limit": TABLE.at(
                "limit_half_width", self.rigidity_index, np.square(self.adhesion_factor)
            ),
            "noise": left["noise"] * self.cell_size,
            "mesh": left["mesh"] * self.cell_size,
            "growth": growth_uncertainty(self.cell_size, self.cell_growth),
            "domain": left["domain"] * felt * min(1.0, self.extent_ratio) ** 2
            + window_uncertainty(self.extent_ratio),
            "bottom": left["bottom"] * self._nearness,
            "top": left["top"] * self._larger_horizontal_stress * root / self.above,
            "speed": left["speed"] * self.inertia,
            "bound": left["bound"] * self.poissons_ratio_reduction,
            "range": self._beyond_range,
        }

    def why_none_holds(self, *, largest_cell: float) -> dict[str, Condition]:
        """Reasons why the laws may not hold, as "word: sentence", and where each applies.

        Each value is a bool or has shape [...]. `largest_cell` is the allowed width of the cells at
        the cone, over its radius.
        """
        return {
            f"rigidity index: the rigidity index is not {SMALLEST_INDEX:g} to {LARGEST_INDEX:g}": (
                (self.rigidity_index < SMALLEST_INDEX) | (self.rigidity_index > LARGEST_INDEX)
            ),
            f"Delta: the stress anisotropy is beyond {LARGEST_ANISOTROPY:g}": (
                np.abs(self.stress_anisotropy) > LARGEST_ANISOTROPY
            ),
            f"Poisson's ratio: Poisson's ratio is below {SMALLEST_POISSONS_RATIO:g}": (
                self.poissons_ratio < SMALLEST_POISSONS_RATIO
            ),
            "window: the bottom of the window is too near": self._nearness * NEAREST_BOTTOM**2
            > 1.0,
            "window: the top of the window is too near": self.above_ratio < NEAREST_TOP,
            "mesh: the cells are too wide": self.cell_size > largest_cell,
            f"mesh: cell_growth is above {LARGEST_GROWTH:g}": self.cell_growth > LARGEST_GROWTH,
            "speed: the speed is too high": self.inertia > LARGEST_INERTIA,
            "approach: the approach is too fast": self.approach_inertia
            > LARGEST_INERTIA_OF_APPROACH,
        }

    @property
    def why_not_measurable(self) -> dict[str, Condition]:
        """Reasons why the forms of E_mesh and E_speed may not hold, whatever B, C and S are."""
        return {
            "mesh: the cells are too wide": self.cell_size > LARGEST_MEASURABLE_CELL,
            "speed: the speed is too high": self.inertia > LARGEST_MEASURED_INERTIA,
        }

    @property
    def _beyond_range(self) -> Value:
        """Half width of the extrapolation beyond the range tested, shape [...]."""
        softest, stiffest = TABLE.rigidity_index[[0, -1]]
        beyond = {
            "anisotropy": np.abs(self.stress_anisotropy) - TESTED_ANISOTROPY,
            "compressible": TESTED_POISSONS_RATIO - self.poissons_ratio,
            "softer": np.log(softest / self.rigidity_index),
            "stiffer": -np.log(stiffest / self.rigidity_index),
        }
        parts = [EFFECTS[it].half_width * np.maximum(0.0, by) for it, by in beyond.items()]
        whole: Value = sum(parts)
        return whole

    @property
    def _nearness(self) -> Value:
        """Ir / H^2: how near the bottom of the window is, shape [...]."""
        return self.rigidity_index / (self.below * self.below)

    @property
    def _larger_horizontal_stress(self) -> Value:
        """(-Delta)^1.5 where the horizontal stress in the ground is larger, else 0; shape [...]."""
        larger: Value = np.maximum(0.0, -self.stress_anisotropy) ** 1.5
        return larger


def mesh_error(
    *,
    rigidity_index: Value,
    adhesion_factor: Value,
    cell_size: float,
    cell_growth: float,
    slope_ratio: float = 1.0,
) -> Value:
    """E_mesh, shape [...]; arguments as in `ErrorLaws`.

    Beyond the rigidity indices measured it is that of the nearest one.
    """
    of_growth = EFFECTS["growth"].size * growth_measure(cell_size, cell_growth)
    slope = TABLE.at("slope", rigidity_index, np.square(adhesion_factor)) * slope_ratio
    curvature = curvature_error(
        rigidity_index=rigidity_index, adhesion_factor=adhesion_factor, cell_size=cell_size
    )
    return slope * cell_size + curvature + of_growth


def slope_ratio(apex_angle: float, strengthening: float, brittleness: float) -> float:
    """B of other cones and of clay whose strength changes, over that of Tresca clay.

    Args:
        apex_angle: of the cone [degree].
        strengthening: mu log10(V / R / gd_ref), at least 0.
        brittleness: (1 - delta) / xi_95, no more counts than `LARGEST_BRITTLENESS`.
    """
    of_brittleness = BY_BRITTLENESS * min(brittleness, LARGEST_BRITTLENESS)
    of_cone = float(np.interp(apex_angle, *BY_APEX))
    return of_cone * (1.0 + BY_STRENGTHENING * strengthening) * (1.0 + of_brittleness)


def curvature_error(*, rigidity_index: Value, adhesion_factor: Value, cell_size: float) -> Value:
    """Q h^1.7, the part of E_mesh that hardly differs between cones and clays, shape [...]."""
    curvature = TABLE.at("curvature", rigidity_index, np.square(adhesion_factor))
    return curvature * math.pow(cell_size, CURVATURE_POWER)


def growth_measure(cell_size: float, cell_growth: float) -> float:
    """g^1.5 h^1.3; the effect of the growth of the cells on Nc is in proportion to it."""
    return math.pow(cell_growth, 1.5) * math.pow(cell_size, 1.3)


def growth_uncertainty(cell_size: float, cell_growth: float) -> float:
    """Half width for a growth of the cells other than `GROWTH_OF_MESHES`; see `mesh_error`."""
    measured = growth_measure(cell_size, GROWTH_OF_MESHES)
    differs = abs(growth_measure(cell_size, cell_growth) - measured)
    size, half_width = EFFECTS["growth"]
    of_law = min(EFFECTS["growth_law"].half_width, GROWTH_SHARE * size * differs)
    return half_width * differs + of_law


def window_uncertainty(extent_ratio: float) -> float:
    """Half width of the effect of a window smaller than the default, for which there is no law.

    It is measured on the cone factor and comes on top of that of the default window. u1 and u2 use
    it too: at Ir 100, with a radius of 10 and 6 instead of 40, u1 is 0.1 to 0.5 lower and u2 0.2 to
    0.7; at Ir 400, with 10 and 6 instead of 80, u2 is 1.3 lower and 4.2 higher. Further runs have
    windows 1.4 times as large; their Nc is up to 0.8 too low with a radius of 5 to 10, and 0.2 too
    low with 12 and 5 above and below.

    Args:
        extent_ratio: as in `ErrorLaws`.
    """
    return EFFECTS["small_window"].half_width * max(0.0, extent_ratio**2 - 1.0)
