"""What is known of the error of u1, u2 and the sleeve friction beside a cone, all over su.

Of the excess pore pressures it is known by laws.

h is the width of the cells at the cone over its radius, F the factor u1 or u2 over su as simulated:

    u1    error  A h          half width  0.7 h, 0.01 F
    u2    error  S h^1.5      half width  (0.15 + w) S h^1.5, 0.035 F, 0.4 a (1 - a) v F,
                                          0.1 (1 - a / 0.1) F where a is below 0.1

Both have the error -P b of a bound of Poisson's ratio beside it, as the cone factor has (`laws`).
The parts of a half width add up as squares. A and S follow the rigidity index and the adhesion
factor a of face and shaft. The error of u2 is that of cells wider than the layer of lower pressure
beside the shaft, in which it is read. Wide cells read the soil outside of it alone: h counts up to
0.45, and w is what it is above 0.35. Beside a half rough shaft in stiff clay the layer is thinner
than the cells of 20 rows beside the face; v goes from 0 at a rigidity index of 100 to 1 at 300.
Beside an all but smooth shaft the layer is two cells thick on every mesh, so its pressure is less
certain. Both half widths grow beyond the rigidity indices where they were measured. How all of it
was measured is in `uncertainty/README.md`.

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

SHOULDER_INDICES = (20.0, 30.0, 100.0, 300.0, 600.0)
SHOULDER_ADHESION = (0.0, 0.25, 0.5, 1.0)
SHOULDER_ERROR = (
    (1.3, 0.2, -0.6, -2.8),
    (2.2, 0.8, -0.3, -2.9),
    (5.7, 4.2, 2.8, 0.9),
    (-1.2, 0.4, 4.4, 1.1),
    (0.1, -0.5, 0.2, 1.0),
)
"""S at these rigidity indices (rows) and adhesion factors, of 5 to 40 rows beside the face."""
SHOULDER_POWER, WIDEST, WIDE = 1.5, 0.45, 0.35
"""Power of h in the error of u2; h up to which it grows, and above which w counts."""
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
SHOULDER, SHOULDER_LEFT, THIN_LAYER = 0.15, 0.035, 0.4
"""Half widths of u2: over its error, over F, and over a (1 - a) v F."""
ALL_BUT_SMOOTH, SMOOTH = 0.1, 0.1
"""Adhesion factor below which u2 is less certain, and half width over F of that of a smooth one."""
ALL_THICK, ALL_THIN = 100.0, 300.0
"""Rigidity indices up to which v is 0, and from which on it is 1."""
SETTLING = 0.5
"""Half width of what is still to come of u1 and u2, over the last change of their means."""
NOISE = {"face": 0.006, "shoulder": 0.012}
"""Half widths of the noise of these means, over F."""
BOUND_EFFECT = {"face": BOUND_ERROR, "shoulder": 1.0}
BOUND = {"face": 1.5, "shoulder": 3.0}
"""P of u1 and u2, and their half widths."""
FACE_RANGE, SHOULDER_RANGE = 0.3, 0.8
"""Half widths of u1 and u2 per ln(Ir) beyond the rigidity indices measured."""


def face_error(
    factor: Value, *, cell_size: float, adhesion_factor: Value, rigidity_index: Value
) -> tuple[Value, Value]:
    """Correction of u1 and its half width of 95 %, over su, shape [...]; see `shoulder_error`."""
    slope = _of_table(FACE_ERROR, FACE_INDICES, FACE_ADHESION, rigidity_index, adhesion_factor)
    beyond = FACE_RANGE * _beyond(FACE_INDICES, rigidity_index)
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
    slope = _of_table(
        SHOULDER_ERROR, SHOULDER_INDICES, SHOULDER_ADHESION, rigidity_index, adhesion_factor
    )
    error = slope * math.pow(min(cell_size, WIDEST), SHOULDER_POWER)
    thin = np.interp(np.log(rigidity_index), np.log([ALL_THICK, ALL_THIN]), [0.0, THIN_LAYER])
    rough = np.asarray(adhesion_factor)
    return -error, _added(
        (SHOULDER + max(0.0, cell_size - WIDE)) * error,
        SHOULDER_LEFT * factor,
        thin * rough * (1.0 - rough) * factor,
        SMOOTH * np.maximum(0.0, 1.0 - rough / ALL_BUT_SMOOTH) * factor,
        SHOULDER_RANGE * _beyond(SHOULDER_INDICES, rigidity_index),
    )


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
            correction = float(off) + BOUND_EFFECT[place] * bounded
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
    """How far a rigidity index is beyond those measured, by its logarithm."""
    nearest = np.clip(rigidity_index, indices[0], indices[-1])
    return np.abs(np.log(rigidity_index / nearest))


def _added(*parts: Value) -> Value:
    return np.sqrt(sum(np.square(part) for part in parts))
