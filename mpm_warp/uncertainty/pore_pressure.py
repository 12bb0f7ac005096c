"""The errors of the excess pore pressures u1 and u2 and of the sleeve friction, all over su.

The law of u2 is in `shoulder`. That of u1 is here; h is the width of the cells at the cone over its
radius, F = u1 / su as simulated:

    u1    error  A h          half width  0.7 h, 0.01 F, E i, W

The parts of a half width are added as squares. A depends on the rigidity index and on the adhesion
factor of the face. Beyond the rigidity indices measured the half width grows. E i bounds the effect
of the inertia i = rho V^2 / su; W is the half width for a window smaller than the default, the same
as that of the cone factor. In very stiff clay u1 is not known on meshes of three rows, nor anywhere
where cells grow by more than 0.5. `uncertainty/README.md` says how all of it was measured.

Both pressures have two more errors: -P b from the bound of Poisson's ratio, as the cone factor has
(`laws`), and the noise of a mean over two radii. Where the mean of u2 differs from the mean over
the two radii before, it is expected to change by a quarter of that difference again.

No error is known of u3: in a run by default the cone passes the soil there in its fast approach.

The sleeve friction f is between the adhesion of remoulded clay, delta a, and the simulated value.
The law of softening has no internal length: strain localises in the first column of cells, and f
falls with its width. In clay that does not soften both bounds are the same.
"""

import math
from typing import Any

import numpy as np
import xarray as xr

from mpm_warp.results import labelled, variable
from mpm_warp.uncertainty.further_runs import CARRIED_ON
from mpm_warp.uncertainty.laws import (
    BOUND_ERROR,
    ErrorLaws,
    Value,
    interpolated,
    window_uncertainty,
)
from mpm_warp.uncertainty.shoulder import (
    RADIAL_FACTOR,
    RADIAL_STRESS,
    beyond_range,
    interpolated_table,
    root_sum_square,
    shoulder_pressure,
)
from mpm_warp.uncertainty.steadiness import last_change

FACE_RIGIDITY_INDICES, FACE_ADHESION_FACTORS = (20.0, 50.0, 100.0, 300.0, 1000.0), (0.0, 0.5, 1.0)
FACE_MESH_SLOPE = (
    (-1.2, 0.0, -0.8),
    (-1.2, -0.2, -0.8),
    (-1.0, -0.1, -0.8),
    (-0.5, 0.1, -0.7),
    (0.0, 0.4, -0.3),
)
"""A by rigidity index (rows) and adhesion factor (columns), from 4 to 28 rows beside the face."""
FACE_MESH_HALF_WIDTH, FACE_MODEL_HALF_WIDTH = 0.7, 0.01
"""Half widths of u1: of the mesh, over h; of the law, over F."""
FACE_WIDE_CELL, FACE_STIFFEST_WITH_WIDE_CELLS = 0.45, 500.0
"""Where h is above the first, with three rows or fewer beside the face, the law of u1 holds up to
the second, a rigidity index. Above it, quick tests had a u1 3 to 7 % too low."""
REMAINING_CHANGE = {"face": (0.0, 0.3), "shoulder": (0.25, 0.15)}
"""Change of u1 and u2 expected after the end of the run, and its half width, both over the last
change of their means."""
FACE_NOISE = 0.006
SHOULDER_NOISE = (50.0, 90.0, 300.0, 600.0), (0.01, 0.013, 0.013, 0.018)
"""Half widths of the noise of these means, over F; that of u2 by rigidity index."""
BOUND_EFFECT, BOUND_HALF_WIDTH = {"face": BOUND_ERROR, "shoulder": 1.2}, 1.5
"""P of u1 and of u2, and the half width of both."""
FACE_INERTIA_EFFECT = ((20.0, 50.0, 100.0, 500.0), (0.1, 0.35, 0.47, 0.55))
"""E by rigidity index: the largest change of u1 over i on any mesh, at i = 0.1 to 2.4. From Ir 500
on, u1 rises with i on four and five rows beside the face, most on five; on seven rows it falls."""
FACE_RANGE_HALF_WIDTH = 0.3
"""Half width of u1 per ln(Ir) beyond `FACE_RIGIDITY_INDICES`."""


def face_error(
    factor: Value,
    *,
    cell_size: float,
    adhesion_factor: Value,
    rigidity_index: Value,
    inertia: Value,
    extent_ratio: float = 1.0,
) -> tuple[Value, Value]:
    """Correction to be added to u1, and its half width of 95 %, both over su, shape [...].

    The factor is u1 over su as simulated; the other arguments are as in
    `shoulder.shoulder_pressure`.
    """
    clay = rigidity_index, adhesion_factor
    slope = interpolated_table(FACE_MESH_SLOPE, FACE_RIGIDITY_INDICES, FACE_ADHESION_FACTORS, *clay)
    beyond = FACE_RANGE_HALF_WIDTH * beyond_range(FACE_RIGIDITY_INDICES, rigidity_index)
    by_inertia = inertia * interpolated(FACE_INERTIA_EFFECT, rigidity_index)
    of_grid = math.hypot(FACE_MESH_HALF_WIDTH * cell_size, window_uncertainty(extent_ratio))
    of_law = FACE_MODEL_HALF_WIDTH * factor
    half_width = root_sum_square(of_grid, of_law, beyond, by_inertia)
    return -slope * cell_size, half_width


def stated_pressures(
    recorded: xr.Dataset,
    laws: ErrorLaws,
    *,
    strength: float,
    shaft_adhesion: float,
    why_none: str,
    is_corrected: bool,
) -> dict[str, xr.Variable]:
    """The corrected factors of u1 and u2, with corrections, uncertainties and reasons.

    The change expected after the end of the run, estimated from the last change of the curves, is
    added to u2. Its half width and the noise of the means are part of both uncertainties.

    Args:
        recorded: results of the run: the factors as simulated and the curves [Pa].
        laws: the laws of the cone factor; cone, clay and grid are taken from them.
        strength: su [Pa].
        shaft_adhesion: adhesion factor of the shaft.
        why_none: why the laws here do not hold; "" where they do. With a reason the uncertainties
            are NaN; the corrections go on, as that of the cone factor does.
        is_corrected: whether there are corrections at all.
    """
    names = ("cell_size", "adhesion_factor", "rigidity_index", "inertia", "extent_ratio")
    of_cone: dict[str, Any] = {name: getattr(laws, name) for name in names}
    stiffest = FACE_STIFFEST_WITH_WIDE_CELLS
    is_too_wide = laws.cell_size > FACE_WIDE_CELL and laws.rigidity_index > stiffest
    wide = f"mesh: above Ir {stiffest:g} cells of three rows are too wide for u1"
    too_wide = f"{wide}: {CARRIED_ON}"
    stated = {}
    for place in ("face", "shoulder"):
        name = f"pore_pressure_factor_{place}"
        simulated, spoken = recorded[name].variable, f"pore pressure factor, {place}"
        factor, correction, half_width = float(simulated.values), 0.0, math.nan
        why = why_none or (too_wide if is_too_wide and place == "face" else "")
        if place == "face":
            read, curve = factor, recorded["excess_pore_pressure_face"]
            noise = FACE_NOISE
            off, of_laws = face_error(read, **of_cone)
        else:
            read, curve = float(recorded[RADIAL_FACTOR]), recorded[RADIAL_STRESS]
            noise = float(interpolated(SHOULDER_NOISE, laws.rigidity_index))
            pressure, of_laws = shoulder_pressure(
                read,
                poissons_ratio=laws.poissons_ratio,
                stress_anisotropy=laws.stress_anisotropy,
                **of_cone | {"adhesion_factor": shaft_adhesion},
            )
            off = pressure - factor
        reduction = laws.poissons_ratio_reduction
        remaining, remaining_spread = REMAINING_CHANGE[place]
        change = last_change(curve.values / strength)
        found = float(off) + BOUND_EFFECT[place] * reduction + remaining * np.nan_to_num(change)
        # In a window that ends below its place the radial stress is not known.
        if is_corrected and math.isfinite(found):
            correction = float(found)
        if not why:
            of_mean = math.hypot(remaining_spread * change, noise * read)
            half_width = math.hypot(float(of_laws), of_mean, BOUND_HALF_WIDTH * reduction)
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
    """The uncertainty of the sleeve friction over su: how far it may be below the simulated value.

    Its lower bound is `remoulded`, the adhesion of the shaft in remoulded clay over su. This is NaN
    where the strength depends on strain rate, where there is friction, and in other laws.
    """
    lower = abs(float(recorded.sleeve_friction_factor) - remoulded)
    meaning = "uncertainty of the sleeve friction factor"
    how_far = "how far it may be lower: to the adhesion beside remoulded clay"
    return labelled(sleeve_friction_factor_uncertainty=(lower, "1", meaning, how_far))
