"""The laws of the error of a cone factor: what mesh, speed and window add to it.

Of the mesh, h the width of the cells at the cone over its radius, g their growth:

    E_mesh = B h + Q h^1.7 + C g^1.5 h^1.3

B and Q by rigidity index, tables, and adhesion factor; of the speed, by the inertia
i = rho V^2 / su = Ir (V / c_s)^2, c_s the speed of shear waves:

    E_speed = S i

and of the bottom of the window, H its distance from the tip over the cone's radius:

    E_bottom = -D Ir / H^2

and of a bound of Poisson's ratio, which takes b off that of the clay:

    E_bound = -P b

All are taken from the cone factor; what they leave open is given as half widths. How all of it was
measured is in `scenes/cone/README.md`; `studies/mesh_error.toml` measures B. They are used for a
cone test (`cone`), and for each sample of a sounding (`samples`).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats

Value = Floats | float
Condition = NDArray[np.bool_] | bool
Row = tuple[float, ...]

APEX_ANGLE = 60.0
"""Of the cones that the laws were measured with [degree]."""
RIGIDITY_INDICES = (20.0, 30.0, 50.0, 100.0, 300.0, 1000.0)
"""Where the error of the mesh was measured."""
SLOPES = (
    (-1.71, -1.95, -1.92, -1.89, -1.69, -1.46),
    (-1.04, -1.02, -1.27, -1.34, -1.31, -1.29),
)
CURVATURES = ((1.56, *(1.96,) * 5), (1.01, 1.14, 1.49, 1.55, 1.59, 1.75))
"""B and Q of E_mesh at these rigidity indices, dimensionless, of a smooth cone and of one with
adhesion factor 1; between the two they go with the square of the adhesion factor."""
CURVATURE_POWER = 1.7
"""The power of h that Q goes with."""
GROWTH_ERROR, GROWTH_OF_MESHES = 1.2, 0.4
"""C of E_mesh, dimensionless, and the growth of the meshes by which B and Q were measured."""
LARGEST_CELL, WIDEST_CELL = 0.44, 0.58
"""Width of the cells at the cone over its radius up to which further runs and samples of a sounding
follow these laws, and up to which tests do: 4 and 3 rows of cells beside a face of 60 degrees."""
SPEED_ERROR = 0.07
"""S of E_speed, dimensionless."""
LARGEST_INERTIA, LARGEST_MEASURED_INERTIA = 3.0, 1.0
"""rho V^2 / su up to which the law of the error of the speed holds, and up to which further runs at
half the speed tell it: it is no straight line, and at 2.9 they left twice their half width open."""
LARGEST_INERTIA_OF_APPROACH = 20.0
"""The same of a fast approach: at 17 and 22 Nc was within U, at 35 and 56 not."""
NEAREST_TOP = 0.74
"""Extent of the window above the shoulder over that by default from which on the effect of the top
is known: at 0.5 Nc was off by 1.3 to 2.5 U, at 0.72 by 1.0, at 0.75 random cases were within it."""
LARGEST_GROWTH = 1.0
"""Growth of the cells up to which its effect is known."""
BOTTOM_ERROR = 0.04
"""D of E_bottom, dimensionless: by windows twice as large. Distances of 0.75 to 2.2 times that by
default alone have 0.04 to 0.07 at Ir 50 and 100, -0.03 to 0.01 from 250 on."""
NEAREST_BOTTOM = 0.74
"""Distance of the bottom over sqrt(Ir) from which on its effect is known."""
BOUND_ERROR, BOUND = 4.5, 0.8
"""P of E_bound, and its half width: between Ir 25 and 500, smooth and rough, Delta -0.5 and 0.5 a
Poisson's ratio of 0.45 in place of 0.49 takes off 3.7 to 5.4 times the difference."""
LIMIT = (300.0, 1000.0), (0.015, 0.03)
"""Half width of the limit of fine cells over the rigidity index: all meshes of 5 rows beside the
face and more are, corrected, within it and that of B of the limits that powers of h from 1.5 to 2
have. Up to 300 there are meshes of 28 to 56 rows, at 1000 of 14 to 20."""
MESH, GROWTH, NOISE = 0.09, 0.3, 0.045
"""Half widths: of B; of C; of the noise of a run, over h. Those of B and of the noise hold what the
laws leave of the meshes that they were fitted to: root mean squares of 0.009 on 3 rows, 0.005 on
10, 0.004 on 20 and 28."""
DOMAIN, DOMAIN_FELT, SMALL_DOMAIN = 0.02, 50.0, 0.035
"""Half width of what a default window changes in Nc, and the rigidity index below which it falls in
proportion to it: that window has the same size in softer clay, whose plastic zone is smaller. And
the half width of what a smaller window leaves, see `window_uncertainty`."""
GROWTH_MODEL, GROWTH_SHARE = 0.02, 1.0 / 3.0
"""Half width of what other powers of h and g would change, where cells are not small; and its
largest share of the effect of growth. Both count from the growth of the meshes measured."""
BOTTOM, TOP = 0.03, 0.2
"""Half widths: of D; and of the effect of the top, where the horizontal stress in the ground is the
larger, over (-Delta)^1.5 sqrt(Ir) / A, A the extent above the shoulder over the radius."""
INERTIA = 0.05
"""Half width of S."""
FELT_BEFORE = {True: 3.0, False: 7.0}
"""Distances above a border of layers from which on the resistance feels it, over the radius, by
whether the soil below is the stronger: 5 % of the change is reached, the largest of the study
`two_layers`."""
FELT_BEHIND = {True: 9.0, False: 4.0}
"""Distances below it to where it is felt, likewise: 5 % of the change is lacking."""
WITHIN_HALF_WIDTH = 10.0, 16.0
"""Distances above and below a border, over the radius, beyond which 96 to 100 % of the samples of a
sounding are within the half width of those of uniform ground, by `two_layers` at a quarter and four
times the strength. From 8 to 7 radii above, and from 9 to 12 below, none are."""
WITHIN_OF_GREAT = 16.0, 30.0
"""The same where the strength changes by more than a factor of four: at 0.1 and 0.02 of it all of
520 samples farther away are within the half width."""
TESTED_INDICES = RIGIDITY_INDICES[0], RIGIDITY_INDICES[-1]
TESTED_ANISOTROPY, TESTED_POISSONS_RATIO = 0.5, 0.45
"""Rigidity indices, |Delta| and Poisson's ratios up to which the laws were measured and tested."""
LARGEST_ANISOTROPY, SMALLEST_POISSONS_RATIO = 0.95, 0.4
SMALLEST_INDEX, LARGEST_INDEX = 10.0, 2000.0
"""How far the laws are carried on, in few runs each."""
ANISOTROPY, COMPRESSION, SOFTER, STIFFER = 0.4, 1.0, 0.35, 0.15
"""Half widths of what the laws leave open where they are carried on: per |Delta|, per Poisson's
ratio, and per ln(Ir) below and above the range that they were measured or tested in."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorLaws:
    """The laws, for one cone factor or for an array of them; lengths are over the cone's radius.

    All is as simulated.
    """

    rigidity_index: Value  # G/su, shape [...]
    adhesion_factor: Value  # of the face, shape [...]
    stress_anisotropy: Value  # of the ground, shape [...]
    poissons_ratio: float  # of the clay as simulated
    bounded: float  # what a bound takes off the clay's own
    inertia: Value  # rho V^2 / su, shape [...]
    cell_size: float  # width of the cells at the cone
    cell_growth: float  # growth of their width per distance from the penetrometer
    outer: float  # radius of the window
    above: float  # extent of the window above the shoulder
    below: float  # extent of the window below the tip
    # greatest ratio of an extent of the window that is by default to what it is
    extent_ratio: float
    above_ratio: float  # extent above over that by default
    approach_inertia: float  # rho V^2 / su of a fast approach, 0 without one
    way: Value  # of the cone since its start, shape [...]

    @property
    def correction(self) -> Value:
        """What is to be added to the cone factor, shape [...]."""
        mesh = mesh_error(
            rigidity_index=self.rigidity_index,
            adhesion_factor=self.adhesion_factor,
            cell_size=self.cell_size,
            cell_growth=self.cell_growth,
        )
        rest = BOTTOM_ERROR * self._nearness - SPEED_ERROR * self.inertia - mesh
        return rest + BOUND_ERROR * self.bounded

    def half_widths(self) -> dict[str, Value]:
        """Half widths of 95 % of what the laws leave open of a cone factor, by what they are of."""
        felt = np.minimum(1.0, self.rigidity_index / DOMAIN_FELT)
        return {
            "limit": np.interp(np.log(self.rigidity_index), np.log(LIMIT[0]), LIMIT[1]),
            "noise": NOISE * self.cell_size,
            "mesh": MESH * self.cell_size,
            "growth": growth_uncertainty(self.cell_size, self.cell_growth),
            "domain": DOMAIN * felt * min(1.0, self.extent_ratio) ** 2
            + window_uncertainty(self.extent_ratio),
            "bottom": BOTTOM * self._nearness,
            "top": TOP * self._larger_horizontal_stress * np.sqrt(self.rigidity_index) / self.above,
            "speed": INERTIA * self.inertia,
            "bound": BOUND * self.bounded,
            "range": self._beyond_range,
        }

    def why_none_holds(self, *, largest_cell: float) -> dict[str, Condition]:
        """What keeps the laws from holding, as "word: sentence", and whether it does, shape [...].

        The cells at the cone are allowed to be as wide as `largest_cell`.
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
        """What keeps the laws of mesh and speed from holding, whatever B, C and S are; likewise."""
        return {
            "mesh: the cells are too wide": self.cell_size > LARGEST_CELL,
            "speed: the speed is too high": self.inertia > LARGEST_MEASURED_INERTIA,
        }

    @property
    def _beyond_range(self) -> Value:
        """Half width of what is left open because the laws are carried on, shape [...]."""
        below, above = (np.log(index / self.rigidity_index) for index in TESTED_INDICES)
        anisotropy = np.abs(self.stress_anisotropy) - TESTED_ANISOTROPY
        return (
            ANISOTROPY * np.maximum(0.0, anisotropy)
            + COMPRESSION * max(0.0, TESTED_POISSONS_RATIO - self.poissons_ratio)
            + SOFTER * np.maximum(0.0, below)
            + STIFFER * np.maximum(0.0, -above)
        )

    @property
    def _nearness(self) -> Value:
        """Ir / H^2 of the bottom of the window."""
        return self.rigidity_index / (self.below * self.below)

    @property
    def _larger_horizontal_stress(self) -> Value:
        """(-Delta)^1.5 where the horizontal stress in the ground is the larger, else 0."""
        larger: Value = np.maximum(0.0, -self.stress_anisotropy) ** 1.5
        return larger


def mesh_error(
    *, rigidity_index: Value, adhesion_factor: Value, cell_size: float, cell_growth: float
) -> Value:
    """What the mesh adds to the cone factor, shape [...]; arguments as in `ErrorLaws`.

    Beyond the rigidity indices measured the error is that of the nearest.
    """
    of_growth = GROWTH_ERROR * growth_measure(cell_size, cell_growth)
    slope = _by_clay(SLOPES, rigidity_index, adhesion_factor)
    curvature = curvature_error(
        rigidity_index=rigidity_index, adhesion_factor=adhesion_factor, cell_size=cell_size
    )
    return slope * cell_size + curvature + of_growth


def curvature_error(*, rigidity_index: Value, adhesion_factor: Value, cell_size: float) -> Value:
    """What the mesh adds to the cone factor of any cone and clay beside what goes with h."""
    curvature = _by_clay(CURVATURES, rigidity_index, adhesion_factor)
    return curvature * math.pow(cell_size, CURVATURE_POWER)


def _by_clay(table: tuple[Row, Row], rigidity_index: Value, adhesion_factor: Value) -> Value:
    """B or Q: smooth and rough by the logarithm of the rigidity index."""
    smooth, rough = (
        np.interp(np.log(rigidity_index), np.log(RIGIDITY_INDICES), row) for row in table
    )
    return smooth + adhesion_factor**2 * (rough - smooth)


def growth_measure(cell_size: float, cell_growth: float) -> float:
    """g^1.5 h^1.3: what the growth of the cells adds to the cone factor is in proportion to it."""
    return math.pow(cell_growth, 1.5) * math.pow(cell_size, 1.3)


def growth_uncertainty(cell_size: float, cell_growth: float) -> float:
    """Half width of what another growth than that of the meshes measured changes; `mesh_error`."""
    measured = growth_measure(cell_size, GROWTH_OF_MESHES)
    differs = abs(growth_measure(cell_size, cell_growth) - measured)
    return GROWTH * differs + min(GROWTH_MODEL, GROWTH_SHARE * GROWTH_ERROR * differs)


def window_uncertainty(extent_ratio: float) -> float:
    """Half width of what a window smaller than by default changes, where no law takes it off.

    It is that of a cone factor less what the default window leaves. At Ir 100 u1 is 0.1 to 0.5
    lower and u2 0.2 to 0.7 with a radius of 10 and 6 instead of 40; at Ir 400 u2 is 1.3 lower and
    4.2 higher with 10 and 6 instead of 80. Nc by further runs, whose windows are 1.4 times as
    large, is up to 0.8 too low with a radius of 5 to 10, and 0.2 with 12 and 5 above and below.

    Args:
        extent_ratio: as in `ErrorLaws`.
    """
    return SMALL_DOMAIN * max(0.0, extent_ratio**2 - 1.0)
