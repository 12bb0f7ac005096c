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
    ErrorLaws,
    window_uncertainty,
)
from mpm_warp.uncertainty.shoulder import (
    EFFECTS,
    RADIAL_FACTOR,
    RADIAL_STRESS,
    shoulder_pressure,
)
from mpm_warp.uncertainty.shoulder import TABLE as SHOULDER_TABLE
from mpm_warp.uncertainty.steadiness import last_change
from mpm_warp.uncertainty.tables import Table, Value, root_sum_square

TABLE = Table.of("u1")
FACE_WIDE_CELL, FACE_STIFFEST_WITH_WIDE_CELLS = 0.45, 500.0
"""Where h is above the first, with three rows or fewer beside the face, the law of u1 holds up to
the second, a rigidity index. Above it, quick tests had a u1 3 to 7 % too low."""


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
    left = {name.removeprefix("u1_"): effect.half_width for name, effect in EFFECTS.items()}
    half_width = root_sum_square(
        left["mesh"] * cell_size,
        left["model"] * factor,
        left["range"] * TABLE.beyond(rigidity_index),
        TABLE.at("by_inertia", rigidity_index) * inertia,
        window_uncertainty(extent_ratio),
    )
    return -TABLE.at("slope", rigidity_index, adhesion_factor) * cell_size, half_width


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
        of_place = "u1" if place == "face" else "u2"
        if place == "face":
            read, curve = factor, recorded["excess_pore_pressure_face"]
            noise = EFFECTS["u1_noise"].half_width
            off, of_laws = face_error(read, **of_cone)
        else:
            read, curve = float(recorded[RADIAL_FACTOR]), recorded[RADIAL_STRESS]
            noise = float(SHOULDER_TABLE.at("noise", laws.rigidity_index))
            pressure, of_laws = shoulder_pressure(
                read,
                poissons_ratio=laws.poissons_ratio,
                stress_anisotropy=laws.stress_anisotropy,
                **of_cone | {"adhesion_factor": shaft_adhesion},
            )
            off = pressure - factor
        reduction, bound = laws.poissons_ratio_reduction, EFFECTS[f"{of_place}_bound"]
        to_come = EFFECTS[f"{of_place}_to_come"]
        change = last_change(curve.values / strength)
        found = float(off) + bound.size * reduction + to_come.size * np.nan_to_num(change)
        # In a window that ends below its place the radial stress is not known.
        if is_corrected and math.isfinite(found):
            correction = float(found)
        if not why:
            of_mean = math.hypot(to_come.half_width * change, noise * read)
            half_width = math.hypot(float(of_laws), of_mean, bound.half_width * reduction)
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
