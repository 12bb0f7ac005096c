"""What is known of the error of u1, u2 and the sleeve friction beside a cone, all over su.

Of the excess pore pressures it is known by laws.

h is the width of the cells at the cone over its radius, F the factor u1 or u2 over su as simulated:

    u1    error  A h          half width  0.7 h, 0.01 F, E i, W

u1 has the error -P b of a bound of Poisson's ratio beside it, as the cone factor has (`laws`); that
of u2 is next to none. The parts of a half width add up as squares. A, and S and D below, follow the
rigidity index and the adhesion factor of face and shaft.

u2 is the pressure of the soil within 0.06 radii of the shaft, 1 mm beside a cone of 10 cm2: pore
pressure evens out over such a distance while a cone passes by. With s, the radial deviator over su
of the cells that F is read in, tension positive,

    u2 = (F - s) - S h^1.5 + T + D,    D = w D_l + (1 - w) D_b
    half width  S_h h^1.5, 0.025 S, E_h h (F - s), 0.006 (F - s),
                0.06 (D_b - D_l), 0.08, E_i i, 0.05, W

F - s is the radial pressure, the same in the soil that touches the shaft and in that beside it. S
is known to S_h; powers of h that fit as well as 1.5 have limits that differ by 0.025 S. E_h is what
the place of the rows changes in the reading. D is the deviator within the 0.06 radii. Soil that has
gone round the shoulder forms a layer beside the shaft; D_l is the deviator in it, close to what
yield allows, D_b that of the soil beside it, and w is the share of the 0.06 radii that the layer
takes, known to 0.06; no more of it is left open than there is. A mesh makes it by some half a row
thicker, so w is drawn on from meshes of up to 112 rows beside the face. On fewer than five rows
F - s is read far from the filter: h counts up to 0.45 in its error, and 0.6 (h - 0.35) (F - s) is
one more part of its half width; in very stiff clay three rows tell nothing of u1 and u2. Half
widths grow beyond the rigidity indices where they were measured. No law takes off what the inertia
i = rho V^2 / su does: E i and E_i i are the most that it was found to do. A taller window adds
T = 0.05, with 0.05 left open, below Ir 50 both in proportion to Ir. A window that is smaller than
by default leaves open as much of u1 and u2 as of the cone factor, W. Nor is anything known where
cells grow by more than 0.5. How all of it was measured is in `uncertainty/README.md`.

Of u3 no error is known: at the end of a run by default, its soil was passed in the fast approach.

The sleeve friction f lies between the adhesion of remoulded clay, delta a, and the simulated value:
the law of softening has no length, strain gathers in the first column of cells, and f falls with
their width. In clay that does not soften both are the same.
"""

import math

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled, variable
from mpm_warp.uncertainty.laws import BOUND_ERROR, DOMAIN_FELT, window_uncertainty
from mpm_warp.uncertainty.steadiness import last_change

Value = Floats | float
Row = tuple[float, ...]
Table = tuple[Row, ...]

SHOULDER_INDICES = (20.0, 30.0, 50.0, 100.0, 300.0, 450.0, 600.0)
SHOULDER_ADHESION = (0.0, 0.5, 1.0)
SHOULDER_ERROR = (
    (-0.3, -0.4, -0.1),
    (0.5, 0.5, -0.8),
    (1.4, 1.3, 0.7),
    (2.4, 3.5, 3.7),
    (-0.5, 2.5, 4.6),
    (0.6, -1.8, 0.2),
    (0.8, 0.9, -1.4),
)
"""S at these rigidity indices (rows) and adhesion factors, fitted at once to all clays that were
measured on five rows beside the face and more."""
SHOULDER_MEASURED = 20.0, 1000.0
"""The least and the greatest rigidity index among them; from 600 on S stays."""
SHOULDER_POWER, WIDEST, WIDE = 1.5, 0.45, 0.35
"""Power of h in this error; h up to which it grows, and above which cells are wide."""
STIFFEST_OF_WIDE = {"face": 500.0, "shoulder": 300.0}
"""Rigidity indices up to which cells of three rows tell u1 and u2: above, quick tests had 3 to 7 %
too little of u1, and 18 to 24 % of u2."""
LAYER_INDICES, LAYER_ADHESION = (30.0, 100.0, 300.0, 600.0), (0.0, 0.25, 0.5, 1.0)
LAYER_SHARE = (
    (0.78, 0.86, 0.9, 1.0),
    (0.52, 0.72, 0.82, 1.0),
    (0.0, 0.1, 0.46, 0.9),
    (0.0, 0.0, 0.0, 0.9),
)
"""w at these rigidity indices and adhesion factors."""
IN_LAYER = ((0.0, 0.25, 0.5, 0.75, 1.0), (-1.22, -1.21, -1.14, -0.98, -0.52))
"""D_l over the adhesion factor, at any rigidity index."""
BESIDE_LAYER = ((30.0, 100.0, 300.0, 600.0), (-0.6, 0.0, 0.45, 0.62))
"""D_b over the rigidity index, at any adhesion factor."""
FACE_INDICES, FACE_ADHESION = (20.0, 50.0, 100.0, 300.0, 1000.0), (0.0, 0.5, 1.0)
FACE_ERROR = (
    (-1.2, 0.0, -0.8),
    (-1.2, -0.2, -0.8),
    (-1.0, -0.1, -0.8),
    (-0.5, 0.1, -0.7),
    (0.0, 0.4, -0.3),
)
"""A at these rigidity indices (rows) and adhesion factors, of 4 to 28 rows beside the face."""
FACE, FACE_LEFT = 0.7, 0.01
"""Half widths of u1: over h, and over F."""
SLOPE_LEFT = (200.0, 450.0), (0.5, 1.5)
"""Half width of S over the rigidity index."""
READ_IN_CELLS = (30.0, 100.0, 300.0, 1000.0), (0.035, 0.07, 0.08, 0.1)
"""E_h over the rigidity index: half width of what the reading in cells leaves, over h (F - s)."""
POWER_LEFT, SHOULDER_LEFT, NEAR_SHAFT, LAYER_LEFT = 0.025, 0.006, 0.08, 0.06
"""Half widths of u2: over S, for other powers of h fit as well; over F - s, of D, and of w."""
READ_IN_WIDE_CELLS = 0.6
"""Half width of u2 over F - s and over what h is above WIDE."""
SETTLING = 0.3
"""Half width of what is still to come of u1 and u2, over the last change of their means."""
NOISE = {"face": 0.006, "shoulder": 0.01}
"""Half widths of the noise of these means, over F."""
BOUND_EFFECT = {"face": BOUND_ERROR, "shoulder": 0.0}
BOUND = {"face": 1.5, "shoulder": 3.0}
"""P of u1 and u2, and their half widths."""
FACE_INERTIA = ((20.0, 100.0, 200.0, 500.0), (0.1, 0.45, 0.45, 0.2))
"""E over the rigidity index: what i = 0.1 to 2.4 changes of u1, over i."""
SHOULDER_INERTIA, INERTIA_IN_WIDE_CELLS = ((20.0, 50.0), (0.6, 0.45)), 1.2
"""The same of u2, and in cells that are wide, at any rigidity index."""
LARGEST_GROWTH = 0.5
"""Growth of the cells up to which u1 and u2 are known: they were measured with 0.4."""
SHOULDER_WINDOW, SHOULDER_WINDOW_LEFT = 0.05, 0.05
"""T of u2 and its half width: a window twice as tall adds 0.00 to 0.08 between Ir 50 and 400."""
FACE_RANGE, SHOULDER_RANGE = 0.3, 0.8
"""Half widths of u1 and u2 per ln(Ir) beyond the rigidity indices measured."""


def face_error(
    factor: Value,
    *,
    cell_size: float,
    adhesion_factor: Value,
    rigidity_index: Value,
    inertia: Value,
    extent_ratio: float = 1.0,
) -> tuple[Value, Value]:
    """Correction of u1 and its half width of 95 %, over su, shape [...]; see `shoulder_error`."""
    slope = _of_table(FACE_ERROR, FACE_INDICES, FACE_ADHESION, rigidity_index, adhesion_factor)
    beyond = FACE_RANGE * _beyond(FACE_INDICES, rigidity_index)
    by_inertia = inertia * _by_index(FACE_INERTIA, rigidity_index)
    of_grid = math.hypot(FACE * cell_size, window_uncertainty(extent_ratio))
    return -slope * cell_size, _added(of_grid, FACE_LEFT * factor, beyond, by_inertia)


def shoulder_error(
    factor: Value,
    deviator: Value,
    *,
    cell_size: float,
    adhesion_factor: Value,
    rigidity_index: Value,
    inertia: Value,
    strength_ratio: Value = 1.0,
    extent_ratio: float = 1.0,
) -> tuple[Value, Value]:
    """Correction of u2 and its half width of 95 %, over su, shape [...].

    Args:
        factor: u2 over su as simulated, shape [...].
        deviator: radial deviator of the cells it was read in, over su, shape [...].
        cell_size: width of the cells at the cone over its radius.
        adhesion_factor: of face and shaft, shape [...].
        rigidity_index: shape [...].
        inertia: rho V^2 / su, shape [...].
        strength_ratio: strength of the soil at the shaft over su, shape [...]; D is in proportion.
        extent_ratio: greatest ratio of an extent of the window that is by default to what it is.
    """
    slope = _of_table(
        SHOULDER_ERROR, SHOULDER_INDICES, SHOULDER_ADHESION, rigidity_index, adhesion_factor
    )
    share, in_layer, beside = _layer(rigidity_index, adhesion_factor)
    near_shaft = deviator_near_shaft(rigidity_index, adhesion_factor, strength_ratio)
    of_size = math.pow(min(cell_size, WIDEST), SHOULDER_POWER)
    error = slope * of_size
    of_narrow = _by_index(SHOULDER_INERTIA, rigidity_index)
    by_inertia = INERTIA_IN_WIDE_CELLS if cell_size > WIDE else of_narrow
    radial = factor - deviator
    felt = np.minimum(1.0, rigidity_index / DOMAIN_FELT)
    half_width = _added(
        _by_index(SLOPE_LEFT, rigidity_index) * of_size,
        POWER_LEFT * slope,
        _by_index(READ_IN_CELLS, rigidity_index) * cell_size * radial,
        READ_IN_WIDE_CELLS * max(0.0, cell_size - WIDE) * radial,
        SHOULDER_LEFT * radial,
        strength_ratio * np.minimum(share, LAYER_LEFT) * (beside - in_layer),
        NEAR_SHAFT,
        SHOULDER_RANGE * _beyond(SHOULDER_MEASURED, rigidity_index),
        by_inertia * inertia,
        window_uncertainty(extent_ratio),
        SHOULDER_WINDOW_LEFT * felt,
    )
    return near_shaft - deviator - error + SHOULDER_WINDOW * felt, half_width


def deviator_near_shaft(
    rigidity_index: Value, adhesion_factor: Value, strength_ratio: Value = 1.0
) -> Value:
    """D over su, shape [...]; arguments as in `shoulder_error`."""
    share, in_layer, beside = _layer(rigidity_index, adhesion_factor)
    return strength_ratio * (share * in_layer + (1.0 - share) * beside)


def _layer(rigidity_index: Value, adhesion_factor: Value) -> tuple[Value, Value, Value]:
    """w, D_l and D_b in clay whose strength stays."""
    share = _of_table(LAYER_SHARE, LAYER_INDICES, LAYER_ADHESION, rigidity_index, adhesion_factor)
    in_layer = np.interp(adhesion_factor, *IN_LAYER)
    beside = _by_index(BESIDE_LAYER, rigidity_index)
    return share, in_layer, beside


def stated_pressures(
    recorded: xr.Dataset,
    *,
    strength: float,
    bounded: float,
    why_none: str,
    **of_cone: float,
) -> dict[str, xr.Variable]:
    """The factors of u1 and u2 less what is known of their errors, and their uncertainties.

    What is still to come, by the last change of the curves, and the noise of their means are added
    to the half widths. Strength is su [Pa], `bounded` what a bound takes off Poisson's ratio;
    `of_cone` are the arguments of `face_error`. Where these laws do not hold there is no
    correction, the uncertainties are not numbers, and `why_none` says why.
    """
    stated = {}
    for place in ("face", "shoulder"):
        name = f"pore_pressure_factor_{place}"
        simulated, spoken = recorded[name].variable, f"pore pressure factor, {place}"
        factor, correction, half_width = float(simulated.values), 0.0, math.nan
        why = why_none or _why_too_wide(place, **of_cone)
        if not why:
            curve = recorded[f"excess_pore_pressure_{place}"].values / strength
            if place == "face":
                off, of_laws = face_error(factor, **of_cone)
            else:
                deviator = float(recorded["radial_deviator_factor_shoulder"])
                off, of_laws = shoulder_error(factor, deviator, **of_cone)
                curve = curve - recorded["radial_deviator_shoulder"].values / strength
            correction = float(off) + BOUND_EFFECT[place] * bounded
            to_come = SETTLING * last_change(curve)
            of_mean = math.hypot(to_come, NOISE[place] * factor)
            half_width = math.hypot(float(of_laws), of_mean, BOUND[place] * bounded)
        stated[name] = simulated.copy(data=np.asarray(factor + correction))
        stated[f"{name}_uncertainty"] = variable(
            half_width,
            meaning=f"uncertainty of the {spoken}",
            description="half width, 95 %; not a number where it is not known",
        )
        stated[f"{name}_why_no_uncertainty"] = variable(
            why, unit=None, meaning=f"why there is no uncertainty of the {spoken}"
        )
        stated[f"{name}_correction"] = variable(
            correction,
            meaning=f"correction of the {spoken}",
            description="what is known of the error of mesh and bound, taken off; u2 is that of "
            "the soil within 0.06 radii of the shaft then; 0 where nothing is known",
        )
    return stated


def _why_too_wide(place: str, *, cell_size: float, rigidity_index: float, **_: float) -> str:
    if cell_size > WIDEST and rigidity_index > STIFFEST_OF_WIDE[place]:
        spoken = {"face": "u1", "shoulder": "u2"}[place]
        above = f"above Ir {STIFFEST_OF_WIDE[place]:g}"
        return f"mesh: {above} cells of three rows are too wide for {spoken}"
    return ""


def stated_sleeve(recorded: xr.Dataset, *, remoulded: float) -> dict[str, xr.Variable]:
    """How far the sleeve friction over su may be below what was simulated.

    It is bounded by the adhesion of the shaft in `remoulded` clay, over su; that is not a number
    where the strain rate changes the strength, where there is friction, and in other laws.
    """
    lower = abs(float(recorded.sleeve_friction_factor) - remoulded)
    meaning = "uncertainty of the sleeve friction factor"
    how_far = "how far it may be lower: to the adhesion beside remoulded clay"
    return labelled(sleeve_friction_factor_uncertainty=(lower, "1", meaning, how_far))


def _of_table(
    table: Table, indices: Row, adhesions: Row, rigidity_index: Value, adhesion_factor: Value
) -> Value:
    """Linear between the values of a table, over the logarithm of the rigidity index."""
    places = np.arange(len(indices), dtype=float)
    place = np.interp(np.log(rigidity_index), np.log(indices), places)
    error: Floats = sum(
        np.maximum(0.0, 1.0 - np.abs(place - row)) * np.interp(adhesion_factor, adhesions, at)
        for row, at in enumerate(table)
    )
    return error


def _by_index(table: tuple[Row, Row], rigidity_index: Value) -> Value:
    """A table at a rigidity index, straight over its logarithm, shape [...]."""
    return np.interp(np.log(rigidity_index), np.log(table[0]), table[1])


def _beyond(indices: Row, rigidity_index: Value) -> Value:
    """How far a rigidity index is beyond those measured, by its logarithm."""
    nearest = np.clip(rigidity_index, indices[0], indices[-1])
    return np.abs(np.log(rigidity_index / nearest))


def _added(*parts: Value) -> Value:
    return np.sqrt(sum(np.square(part) for part in parts))
