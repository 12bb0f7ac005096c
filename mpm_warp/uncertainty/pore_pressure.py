"""What is known of the error of u1, u2 and the sleeve friction beside a cone, all over su.

Of the excess pore pressures it is known by laws: that of u2 is in `shoulder`. h is the width of the
cells at the cone over its radius, F the factor u1 over su as simulated:

    u1    error  A h          half width  0.7 h, 0.01 F, E i, W

The parts of a half width add up as squares. A follows the rigidity index and the adhesion factor of
the face; the half width grows beyond the rigidity indices where it was measured. E i is the most
that the inertia i = rho V^2 / su was found to do, W what a window smaller than by default leaves
open of the cone factor. In very stiff clay three rows tell nothing of u1. Nor is anything known
where cells grow by more than 0.5. How all of it was measured is in `uncertainty/README.md`.

Both have the error -P b of a bound of Poisson's ratio, as the cone factor has (`laws`), and the
noise of a mean over two radii. Where u2 has changed from the two radii before, a quarter of that
change is still to come.

Of u3 no error is known: at the end of a run by default, its soil was passed in the fast approach.

The sleeve friction f lies between the adhesion of remoulded clay, delta a, and the simulated value:
the law of softening has no length, strain gathers in the first column of cells, and f falls with
their width. In clay that does not soften both are the same.
"""

import math
from typing import Any

import numpy as np
import xarray as xr

from mpm_warp.results import labelled, variable
from mpm_warp.uncertainty.laws import BOUND_ERROR, ErrorLaws, Value, window_uncertainty
from mpm_warp.uncertainty.shoulder import (
    RADIAL_FACTOR,
    RADIAL_STRESS,
    added,
    beyond_measured,
    by_index,
    of_table,
    shoulder_pressure,
)
from mpm_warp.uncertainty.steadiness import last_change

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
OF_THREE_ROWS, STIFFEST_OF_WIDE = 0.45, 500.0
"""h above which cells are of three rows or less, and the rigidity index up to which they tell u1:
above, quick tests had 3 to 7 % too little."""
STILL_TO_COME = {"face": (0.0, 0.3), "shoulder": (0.25, 0.15)}
"""What is still to come of u1 and u2, over the last change of their means, and its half width."""
FACE_NOISE = 0.006
SHOULDER_NOISE = (50.0, 90.0, 300.0, 600.0), (0.01, 0.013, 0.013, 0.018)
"""Half widths of the noise of these means, over F; of u2 over the rigidity index."""
BOUND_EFFECT, BOUND_LEFT = {"face": BOUND_ERROR, "shoulder": 1.2}, 1.5
"""P of u1 and u2, and its half width."""
FACE_INERTIA = ((20.0, 50.0, 100.0, 500.0), (0.1, 0.35, 0.47, 0.55))
"""E over the rigidity index: the most that i = 0.1 to 2.4 changes of u1 on any mesh, over i. From
Ir 500 on u1 rises with i on four and five rows beside the face, most on five; on seven it falls."""
FACE_RANGE = 0.3
"""Half width of u1 per ln(Ir) beyond the rigidity indices measured."""


def face_error(
    factor: Value,
    *,
    cell_size: float,
    adhesion_factor: Value,
    rigidity_index: Value,
    inertia: Value,
    extent_ratio: float = 1.0,
) -> tuple[Value, Value]:
    """Correction of u1, its half width of 95 %, over su, shape [...]; see `shoulder`."""
    slope = of_table(FACE_ERROR, FACE_INDICES, FACE_ADHESION, rigidity_index, adhesion_factor)
    beyond = FACE_RANGE * beyond_measured(FACE_INDICES, rigidity_index)
    by_inertia = inertia * by_index(FACE_INERTIA, rigidity_index)
    of_grid = math.hypot(FACE * cell_size, window_uncertainty(extent_ratio))
    return -slope * cell_size, added(of_grid, FACE_LEFT * factor, beyond, by_inertia)


def stated_pressures(
    recorded: xr.Dataset, laws: ErrorLaws, *, strength: float, why_none: str
) -> dict[str, xr.Variable]:
    """The factors of u1 and u2 less what is known of their errors, and their uncertainties.

    What is still to come, by the last change of the curves, is added to u2 and, like the noise of
    their means, to both half widths. Of the laws of the cone factor are taken cone, clay and grid.
    Strength is su [Pa]. Where the laws here do not hold there is no correction, the uncertainties
    are not numbers, and `why_none` says why.
    """
    names = ("cell_size", "adhesion_factor", "rigidity_index", "inertia", "extent_ratio")
    of_cone: dict[str, Any] = {name: getattr(laws, name) for name in names}
    is_too_wide = laws.cell_size > OF_THREE_ROWS and laws.rigidity_index > STIFFEST_OF_WIDE
    too_wide = f"mesh: above Ir {STIFFEST_OF_WIDE:g} cells of three rows are too wide for u1"
    stated = {}
    for place in ("face", "shoulder"):
        name = f"pore_pressure_factor_{place}"
        simulated, spoken = recorded[name].variable, f"pore pressure factor, {place}"
        factor, correction, half_width = float(simulated.values), 0.0, math.nan
        why = why_none or (too_wide if is_too_wide and place == "face" else "")
        if not why:
            if place == "face":
                read, curve = factor, recorded["excess_pore_pressure_face"]
                noise = FACE_NOISE
                off, of_laws = face_error(read, **of_cone)
            else:
                read, curve = float(recorded[RADIAL_FACTOR]), recorded[RADIAL_STRESS]
                noise = float(by_index(SHOULDER_NOISE, laws.rigidity_index))
                pressure, of_laws = shoulder_pressure(
                    read,
                    poissons_ratio=laws.poissons_ratio,
                    stress_anisotropy=laws.stress_anisotropy,
                    **of_cone,
                )
                off = pressure - factor
            comes, comes_left = STILL_TO_COME[place]
            change = last_change(curve.values / strength)
            correction = float(off) + BOUND_EFFECT[place] * laws.bounded + comes * change
            of_mean = math.hypot(comes_left * change, noise * read)
            half_width = math.hypot(float(of_laws), of_mean, BOUND_LEFT * laws.bounded)
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
            description="what is known of the error of mesh and bound, taken off, and of what is "
            "still to come; u2 is that of the soil within 0.06 radii of the shaft then; 0 where "
            "nothing is known",
        )
    return stated


def stated_sleeve(recorded: xr.Dataset, *, remoulded: float) -> dict[str, xr.Variable]:
    """How far the sleeve friction over su may be below what was simulated.

    It is bounded by the adhesion of the shaft in `remoulded` clay, over su; that is not a number
    where the strain rate changes the strength, where there is friction, and in other laws.
    """
    lower = abs(float(recorded.sleeve_friction_factor) - remoulded)
    meaning = "uncertainty of the sleeve friction factor"
    how_far = "how far it may be lower: to the adhesion beside remoulded clay"
    return labelled(sleeve_friction_factor_uncertainty=(lower, "1", meaning, how_far))
