"""What is known of the error of u1, u2 and the sleeve friction beside a cone, all over su.

Of the excess pore pressures it is known by laws.

h is the width of the cells at the cone over its radius, a the adhesion factor of face and shaft, w
the share with which u2 is read in the wedge beside the shaft, F the factor u1 or u2 over su as
simulated:

    u1    error  A h                                half width  0.7 h, 0.01 F
    u2    error  w S h F - (1 - w) Q h^2, Q = 2 ln(233 / Ir)
          half width  (1 - w) h^2, 0.019 F, w (X h + 0.5 max(0, h - 0.35)) F, 0.8 w (1 - w) v F,
                      0.1 w F ln(Ir / 300);   X = max(0.1, |S| / 2)

Both have the error -P b of a bound of Poisson's ratio beside it, as the cone factor has (`laws`).
The parts of a half width add up as squares. A and S follow the rigidity index Ir and a; S is of
what is read in the wedge. Q is what rows smear that are read outside of it; it is the same from an
Ir of 500 on, and its half width is part of (1 - w) h^2. X leaves half of the correction open; cells
wider than those of 5 rows beside the face do not resolve the wedge. v tells how deep the wedge is:
1 up to an Ir of 100, 0 from 500 on. Where w is neither 0 nor 1 the wedge is thinner than a cell,
and the pressure at the filter may be that within or that outside. The last part counts above an Ir
of 300, where the wedge is thin too. Both half widths grow beyond where they were measured, u1 at an
Ir of 20 to 1000, u2 at 50 to 500. How all of it was measured is in `scenes/cone/README.md`.

Of u3 no error is known: at the end of a run by default, its soil was passed in the fast approach.

The sleeve friction f lies between the adhesion of remoulded clay, delta a, and the simulated value:
the law of softening has no length, strain gathers in the first column of cells, and f falls with
their width. In clay that does not soften both are the same.
"""

import math

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import variable
from mpm_warp.uncertainty.laws import BOUND_ERROR
from mpm_warp.uncertainty.steadiness import last_change

Value = Floats | float
Row = tuple[float, ...]
Table = tuple[Row, ...]

WHOLE_WEDGE = 0.5
"""Adhesion factor of the shaft from which on u2 is read in the wedge alone."""
WEDGE_INDICES, WEDGE_ADHESION = (30.0, 100.0, 300.0, 500.0), (0.5, 0.75, 1.0)
WEDGE_ERROR = ((-0.08, -0.20, -0.26), (0.42, 0.17, 0.22), (0.22, 0.09, 0.17), (0.0, 0.0, 0.0))
"""S at these rigidity indices (rows) and adhesion factors."""
SMEARED_ERROR, NOT_SMEARED, STIFFEST = 2.0, 233.0, 500.0
"""Q over the logarithm; the rigidity index at which it is 0, and above which it stays."""
SHOULDER_INDICES = (50.0, 500.0)
"""Rigidity indices between which the error of u2 was measured."""
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
DEEPEST, NONE_AT = 100.0, 500.0
"""Rigidity indices up to which the wedge is deepest, and from which on there is none."""
SMEARED, SHAFT_LEFT = 1.0, 0.019
"""Half widths of u2: over h^2, and over F."""
WEDGE_LEFT, LEAST_LEFT = 0.5, 0.1
"""Half width of S over S, and its least."""
RESOLVED, WIDE, THIN_WEDGE = 0.35, 0.5, 0.8
"""Width of the cells that the wedge needs; half widths of u2: over w F and what they are wider, and
over w (1 - w) v F."""
STIFF_WEDGE, WEDGE_KNOWN = 0.1, 300.0
"""Half width of u2 over w F ln(Ir), and the rigidity index above which it counts."""
SETTLING = 0.5
"""Half width of what is still to come of u1 and u2, over the last change of their means."""
NOISE = {"face": 0.006, "shoulder": 0.012}
"""Half widths of the noise of these means, over F."""
BOUND = {"face": 1.5, "shoulder": 4.0}
"""Half widths of P, of u1 and u2."""
RANGE = 0.3
"""Half width per ln(Ir) beyond the rigidity indices measured."""


def share_of_wedge(adhesion_factor: Value) -> Value:
    """Share w at adhesion factors of the shaft, shape [...]."""
    return np.minimum(1.0, np.asarray(adhesion_factor) / WHOLE_WEDGE)


def face_error(
    factor: Value, *, cell_size: float, adhesion_factor: Value, rigidity_index: Value
) -> tuple[Value, Value]:
    """Correction of u1 and its half width of 95 %, over su, shape [...]; see `shoulder_error`."""
    slope = _of_table(FACE_ERROR, FACE_INDICES, FACE_ADHESION, rigidity_index, adhesion_factor)
    beyond = _beyond(FACE_INDICES, rigidity_index)
    return -slope * cell_size, _added(FACE * cell_size, FACE_LEFT * factor, beyond)


def shoulder_error(
    factor: Value, *, cell_size: float, adhesion_factor: Value, rigidity_index: Value
) -> tuple[Value, Value]:
    """Correction of u2 and its half width of 95 %, over su, shape [...].

    Args:
        factor: u2 over su as simulated, shape [...].
        cell_size: width of the cells at the cone over its radius.
        adhesion_factor: of face and shaft, shape [...].
        rigidity_index: shape [...].
    """
    share = share_of_wedge(adhesion_factor)
    depth = np.interp(np.log(rigidity_index), np.log([DEEPEST, NONE_AT]), [1.0, 0.0])
    slope = _of_table(WEDGE_ERROR, WEDGE_INDICES, WEDGE_ADHESION, rigidity_index, adhesion_factor)
    in_wedge = share * slope * cell_size * factor
    left_in_wedge = np.maximum(LEAST_LEFT, WEDGE_LEFT * np.abs(slope)) * cell_size
    smeared = SMEARED_ERROR * np.log(NOT_SMEARED / np.minimum(rigidity_index, STIFFEST))
    beyond = np.maximum(0.0, np.log(rigidity_index / WEDGE_KNOWN))
    half_width = _added(
        SMEARED * (1.0 - share) * cell_size**2,
        SHAFT_LEFT * factor,
        share * (left_in_wedge + WIDE * max(0.0, cell_size - RESOLVED)) * factor,
        THIN_WEDGE * share * (1.0 - share) * depth * factor,
        STIFF_WEDGE * share * factor * beyond,
        _beyond(SHOULDER_INDICES, rigidity_index),
    )
    return (1.0 - share) * smeared * cell_size**2 - in_wedge, half_width


def stated_pressures(
    recorded: xr.Dataset,
    *,
    strength: float,
    bounded: float,
    is_known: bool,
    **of_cone: float,
) -> dict[str, xr.Variable]:
    """The factors of u1 and u2 less what is known of their errors, and their uncertainties.

    What is still to come, by the last change of the curves, and the noise of their means are added
    to the half widths. Strength is su [Pa], `bounded` what a bound takes off Poisson's ratio;
    `of_cone` are the other arguments of `shoulder_error`. Where these laws do not hold (`is_known`)
    there is no correction, and the uncertainties are not numbers.
    """
    stated = {}
    for place in ("face", "shoulder"):
        name = f"pore_pressure_factor_{place}"
        simulated, spoken = recorded[name].variable, f"pore pressure factor, {place}"
        factor, correction, half_width = float(simulated.values), 0.0, math.nan
        if is_known:
            error = face_error if place == "face" else shoulder_error
            off, of_laws = error(factor, **of_cone)
            curve = recorded[f"excess_pore_pressure_{place}"].values / strength
            correction = float(off) + BOUND_ERROR * bounded
            to_come = SETTLING * last_change(curve)
            of_mean = math.hypot(to_come, NOISE[place] * factor)
            half_width = math.hypot(float(of_laws), of_mean, BOUND[place] * bounded)
        stated[name] = simulated.copy(data=np.asarray(factor + correction))
        stated[f"{name}_uncertainty"] = variable(
            half_width,
            meaning=f"uncertainty of the {spoken}",
            description="half width, 95 %; not a number where it is not known of the cone factor, "
            "and where the shaft has another adhesion than the face",
        )
        stated[f"{name}_correction"] = variable(
            correction,
            meaning=f"correction of the {spoken}",
            description="what is known of the error of mesh and bound, taken off; 0 where "
            "nothing is",
        )
    return stated


def stated_sleeve(recorded: xr.Dataset, *, remoulded: float) -> dict[str, xr.Variable]:
    """How far the sleeve friction over su may be below what was simulated.

    It is bounded by the adhesion of the shaft in `remoulded` clay, over su; that is not a number
    where the strain rate changes the strength, where there is friction, and in other laws.
    """
    name = "sleeve_friction_factor"
    return {
        f"{name}_uncertainty": variable(
            abs(float(recorded[name]) - remoulded),
            meaning="uncertainty of the sleeve friction factor",
            description="how far it may be lower: to the adhesion beside remoulded clay",
        )
    }


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


def _beyond(indices: Row, rigidity_index: Value) -> Value:
    """Half width of what is left open beyond the rigidity indices measured."""
    nearest = np.clip(rigidity_index, indices[0], indices[-1])
    return RANGE * np.abs(np.log(rigidity_index / nearest))


def _added(*parts: Value) -> Value:
    return np.sqrt(sum(np.square(part) for part in parts))
