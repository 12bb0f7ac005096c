"""What is known of the error of u1, u2 and the sleeve friction beside a cone, all over su.

Of the excess pore pressures it is known by laws.

h is the width of the cells at the cone over its radius, F the factor u1 or u2 over su as simulated:

    u1    error  A h          half width  0.7 h, 0.01 F, E i, W

u1 has the error -P b of a bound of Poisson's ratio beside it, as the cone factor has (`laws`); that
of u2 is next to none. The parts of a half width add up as squares. A, and S and D below, follow the
rigidity index and the adhesion factor of face and shaft.

u2 is the pressure of the soil within 0.06 radii of the shaft, 1 mm beside a cone of 10 cm2: pore
pressure evens out over such a distance while a cone passes by. Beside the filter every mesh smears
what happens at the shoulder. So u2 is stated by F, the radial stress on the shaft from 1.4 to 3.2
radii above it, which meshes of 5 to 56 rows beside the face have alike within some percent, and by
C, what the pressure beside the filter has more, from 14 to 112 rows:

    u2 = F - S h + C + T,    C = B + 0.16 |Delta| - 1.2 (nu - 0.45) + D,    D = w D_l + (1 - w) D_b
    half width  0.045 h F, 0.2 S, B_l, 0.08 |Delta|, 0.8 (nu - 0.45), 0.3 (1 - r), 0.05,
                0.05 (D_b - D_l), E_i i, 0.04, W

S is the error of the mesh, B what the radial stress rises from there down to the filter, known to
B_l, and D the deviator of the radial stress within the 0.06 radii, tension positive. Soil that has
gone round the shoulder forms a layer beside the shaft; D_l is the deviator in it, close to what
yield allows, D_b that of the soil beside it, and w is the share of the 0.06 radii that the layer
takes; no more of it is left open than there is. A mesh makes it by some half a row thicker, so w is
drawn on from meshes of up to 112 rows. The strength of the soil at the shaft is r su; D is in
proportion. On fewer than five rows 0.42 (h - 0.385) F is one more part of the half width; in very
stiff clay three rows tell nothing of u1. Half widths grow beyond the rigidity indices where they
were measured. No law takes off what the inertia i = rho V^2 / su does: E i and E_i i are the most
that it was found to do. A taller window adds T = 0.035 (1 - 2 Delta), nothing from Delta 0.5 on;
below Ir 50 both it and its half width are in proportion to Ir. A window that is smaller than by
default leaves open as much of u1 and u2 as of the cone factor, W. Nor is anything known where cells
grow by more than 0.5. How all of it was measured is in `uncertainty/README.md`.

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

RADIAL_STRESS, RADIAL_FACTOR = "excess_radial_stress_shaft", "radial_stress_factor_shaft"
"""The curve of the radial stress on the shaft, and its mean at the end over su, F."""
SHOULDER_INDICES = (20.0, 50.0, 100.0, 200.0, 300.0, 450.0, 1000.0)
SHOULDER_ADHESION = (0.0, 0.5, 1.0)
SHOULDER_ERROR = (
    (-0.3, -0.4, 0.0),
    (-0.1, -0.1, 0.2),
    (-0.1, -0.1, 0.2),
    (0.5, 0.0, -0.4),
    (0.5, 0.5, -0.6),
    (0.9, 0.6, 0.2),
    (0.9, 0.7, 1.9),
)
"""S at these rigidity indices (rows) and adhesion factors, fitted at once to all clays that were
measured on five rows beside the face and more."""
SHOULDER_MEASURED = SHOULDER_INDICES[0], SHOULDER_INDICES[-1]
"""The least and the greatest rigidity index among them."""
WIDE, OF_THREE_ROWS = 0.385, 0.45
"""h above which cells are wide, and above which they are of three rows or less."""
STIFFEST_OF_WIDE = 500.0
"""Rigidity index up to which cells of three rows tell u1: above, quick tests had 3 to 7 % too
little."""
RISE_ADHESION = (0.0, 0.25, 0.5, 1.0)
RISE = (
    (0.92, 0.88, 0.88, 1.01),
    (1.14, 1.09, 1.06, 1.17),
    (1.28, 1.16, 1.12, 1.11),
    (1.54, 1.46, 1.28, 1.22),
    (1.85, 1.66, 1.58, 1.26),
    (2.22, 2.04, 1.86, 1.55),
    (2.6, 2.5, 2.4, 2.4),
)
"""B at the rigidity indices of S and these adhesion factors, where Delta is 0."""
RISE_BY_ANISOTROPY, RISE_BY_ANISOTROPY_LEFT = 0.16, 0.08
"""What B gains, over |Delta|, and its half width."""
RISE_MEASURED_AT, RISE_BY_POISSON, RISE_BY_POISSON_LEFT = 0.45, 1.2, 0.8
"""Poisson's ratio that B was measured at, what it loses over what nu is greater, its half width."""
LAYER_INDICES, LAYER_ADHESION = (30.0, 100.0, 300.0, 600.0), (0.0, 0.25, 0.5, 1.0)
LAYER_SHARE = (
    (0.78, 0.86, 0.9, 1.0),
    (0.52, 0.72, 0.82, 1.0),
    (0.0, 0.1, 0.46, 0.85),
    (0.0, 0.0, 0.0, 0.9),
)
"""w at these rigidity indices and adhesion factors."""
IN_LAYER = ((0.0, 0.25, 0.5, 0.75, 1.0), (-1.22, -1.21, -1.14, -0.98, -0.56))
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
RISE_LEFT = (50.0, 100.0, 200.0, 450.0, 1000.0), (0.06, 0.04, 0.06, 0.1, 0.2)
"""Half width of B over the rigidity index."""
READ_IN_CELLS, SLOPE_LEFT, NEAR_SHAFT, LAYER_LEFT, SOFTENED = 0.045, 0.2, 0.05, 0.05, 0.3
"""Half widths of u2: over h F; over S, for the power of h; of D; of w; and over 1 - r."""
READ_IN_WIDE_CELLS = 0.42
"""Half width of u2 over F and over what h is above WIDE."""
SETTLING = 0.3
"""Half width of what is still to come of u1 and u2, over the last change of their means."""
NOISE = {"face": 0.006, "shoulder": 0.013}
"""Half widths of the noise of these means, over F."""
BOUND_EFFECT = {"face": BOUND_ERROR, "shoulder": 0.0}
BOUND = {"face": 1.5, "shoulder": 3.0}
"""P of u1 and u2, and their half widths."""
FACE_INERTIA = ((20.0, 100.0, 200.0, 500.0), (0.1, 0.45, 0.45, 0.2))
"""E over the rigidity index: what i = 0.1 to 2.4 changes of u1, over i."""
SHOULDER_INERTIA = (20.0, 50.0, 100.0, 200.0, 300.0, 450.0), (0.4, 0.3, 0.3, 0.6, 0.6, 0.3)
"""The same of u2."""
LARGEST_GROWTH = 0.5
"""Growth of the cells up to which u1 and u2 are known: they were measured with 0.4."""
SHOULDER_WINDOW, SHOULDER_WINDOW_LEFT = 0.035, 0.04
"""T of u2 at Delta 0 and its half width: a window twice as tall adds 0.00 to 0.08 between Ir 50 and
400, most where Delta is least."""
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
    """Correction of u1, its half width of 95 %, over su, shape [...]; see `shoulder_pressure`."""
    slope = _of_table(FACE_ERROR, FACE_INDICES, FACE_ADHESION, rigidity_index, adhesion_factor)
    beyond = FACE_RANGE * _beyond(FACE_INDICES, rigidity_index)
    by_inertia = inertia * _by_index(FACE_INERTIA, rigidity_index)
    of_grid = math.hypot(FACE * cell_size, window_uncertainty(extent_ratio))
    return -slope * cell_size, _added(of_grid, FACE_LEFT * factor, beyond, by_inertia)


def shoulder_pressure(
    radial: Value,
    *,
    cell_size: float,
    adhesion_factor: Value,
    rigidity_index: Value,
    inertia: Value,
    poissons_ratio: float,
    stress_anisotropy: Value = 0.0,
    strength_ratio: Value = 1.0,
    extent_ratio: float = 1.0,
) -> tuple[Value, Value]:
    """u2 and its half width of 95 %, over su, shape [...].

    Args:
        radial: F over su as simulated, shape [...].
        cell_size: width of the cells at the cone over its radius.
        adhesion_factor: of face and shaft, shape [...].
        rigidity_index: shape [...].
        inertia: rho V^2 / su, shape [...].
        poissons_ratio: nu as simulated.
        stress_anisotropy: Delta, shape [...].
        strength_ratio: r, strength of the soil at the shaft over su, shape [...].
        extent_ratio: greatest ratio of an extent of the window that is by default to what it is.
    """
    soil = {"rigidity_index": rigidity_index, "adhesion_factor": adhesion_factor}
    slope = _of_table(SHOULDER_ERROR, SHOULDER_INDICES, SHOULDER_ADHESION, **soil)
    share, in_layer, beside = _layer(**soil)
    excess = excess_at_filter(
        **soil, stress_anisotropy=stress_anisotropy, strength_ratio=strength_ratio
    )
    stiffer = poissons_ratio - RISE_MEASURED_AT
    felt = np.minimum(1.0, rigidity_index / DOMAIN_FELT)
    of_window = SHOULDER_WINDOW * np.maximum(0.0, 1.0 - 2.0 * stress_anisotropy) * felt
    half_width = _added(
        (READ_IN_CELLS * cell_size + READ_IN_WIDE_CELLS * max(0.0, cell_size - WIDE)) * radial,
        SLOPE_LEFT * slope,
        _by_index(RISE_LEFT, rigidity_index),
        RISE_BY_ANISOTROPY_LEFT * np.abs(stress_anisotropy),
        RISE_BY_POISSON_LEFT * stiffer,
        SOFTENED * (1.0 - strength_ratio),
        strength_ratio * np.minimum(share, LAYER_LEFT) * (beside - in_layer),
        NEAR_SHAFT,
        SHOULDER_RANGE * _beyond(SHOULDER_MEASURED, rigidity_index),
        _by_index(SHOULDER_INERTIA, rigidity_index) * inertia,
        window_uncertainty(extent_ratio),
        SHOULDER_WINDOW_LEFT * felt,
    )
    pressure = radial - slope * cell_size + excess + of_window
    return pressure - RISE_BY_POISSON * stiffer, half_width


def excess_at_filter(
    *,
    rigidity_index: Value,
    adhesion_factor: Value,
    stress_anisotropy: Value = 0.0,
    strength_ratio: Value = 1.0,
) -> Value:
    """C over su where nu is 0.45, shape [...]; arguments as in `shoulder_pressure`."""
    rise = _of_table(RISE, SHOULDER_INDICES, RISE_ADHESION, rigidity_index, adhesion_factor)
    by_anisotropy = RISE_BY_ANISOTROPY * np.abs(stress_anisotropy)
    return (
        rise + by_anisotropy + deviator_near_shaft(rigidity_index, adhesion_factor, strength_ratio)
    )


def deviator_near_shaft(
    rigidity_index: Value, adhesion_factor: Value, strength_ratio: Value = 1.0
) -> Value:
    """D over su, shape [...]; arguments as in `shoulder_pressure`."""
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
    poissons_ratio: float,
    stress_anisotropy: float,
    **of_cone: float,
) -> dict[str, xr.Variable]:
    """The factors of u1 and u2 less what is known of their errors, and their uncertainties.

    What is still to come, by the last change of the curves, and the noise of their means are added
    to the half widths. Strength is su [Pa], `bounded` what a bound takes off Poisson's ratio nu;
    `of_cone` are the arguments of `face_error`. Where these laws do not hold there is no
    correction, the uncertainties are not numbers, and `why_none` says why.
    """
    stated = {}
    for place in ("face", "shoulder"):
        name = f"pore_pressure_factor_{place}"
        simulated, spoken = recorded[name].variable, f"pore pressure factor, {place}"
        factor, correction, half_width = float(simulated.values), 0.0, math.nan
        why = why_none or (_why_too_wide(**of_cone) if place == "face" else "")
        if not why:
            if place == "face":
                read, curve = factor, recorded["excess_pore_pressure_face"]
                off, of_laws = face_error(read, **of_cone)
            else:
                read = float(recorded[RADIAL_FACTOR])
                curve = recorded[RADIAL_STRESS]
                pressure, of_laws = shoulder_pressure(
                    read,
                    poissons_ratio=poissons_ratio - bounded,
                    stress_anisotropy=stress_anisotropy,
                    **of_cone,
                )
                off = pressure - factor
            correction = float(off) + BOUND_EFFECT[place] * bounded
            to_come = SETTLING * last_change(curve.values / strength)
            of_mean = math.hypot(to_come, NOISE[place] * read)
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


def _why_too_wide(*, cell_size: float, rigidity_index: float, **_: float) -> str:
    if cell_size > OF_THREE_ROWS and rigidity_index > STIFFEST_OF_WIDE:
        return f"mesh: above Ir {STIFFEST_OF_WIDE:g} cells of three rows are too wide for u1"
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
