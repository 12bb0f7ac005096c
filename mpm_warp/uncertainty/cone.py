"""The error of a cone factor: known from other cases, or measured by further runs of the case.

Known: the correction is that of the laws of mesh, speed and window (`laws`). What they leave open,
and what differs from run to run, makes up the half width: its parts are added as squares.
`studies/held_out.toml` tests it.

Measured: the case and four runs, which differ from it in one choice of the method each, determine
the unknowns of

    Nc_simulated = Nc + B h + C g^1.5 h^1.3 + S i + W w

with h the width of the cells at the cone over its radius, g their growth, i = rho V^2 / su, and
w = (extent of the window of the case / extent)^2. These are the laws of `laws`, where B, C and S
are known from other cases. This is for cases whose error those do not give.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.results import labelled
from mpm_warp.scene import Scene
from mpm_warp.uncertainty.built import why_not_as_measured, why_not_tresca
from mpm_warp.uncertainty.further_runs import without_errors
from mpm_warp.uncertainty.interval import further_values, stated_value, those_that_hold
from mpm_warp.uncertainty.laws import (
    LARGEST_CELL,
    LARGEST_INERTIA,
    WIDEST_CELL,
    ErrorLaws,
    growth_measure,
)
from mpm_warp.uncertainty.steadiness import ALL_PASSED, left_to_come

BOUND = 0.4
"""Half width of what a bound of Poisson's ratio changes, over Nc and over what it takes off."""
POINTS, NOISE = 0.001, 0.015
"""Half widths: of what more points change, over Nc; of the noise of a run."""
APPROACH = 0.001
"""Half width of what the approach leaves, over Nc."""
APEX_ANGLE = 60.0
"""Of the cones that the laws were measured with [degree]."""

FINER, GROWING, SLOWER, WIDER = 1.6, 2.0, 0.5, 1.4
"""Cells per radius, growth of the cells, speed and extents of the window in the further runs, over
those of the case."""
DIFFERENCES = {
    "mesh": "smaller cells",
    "growth": "more growth",
    "speed": "half the speed",
    "domain": "a wider window",
}
"""The effects of B h and of the other terms, and what the run that measures each has."""
LEFT_OPEN = 0.5
"""Half width of an error over what the best run still has of it: about what lies between a law and
one of the next order."""
LARGEST_CORRECTION = 0.12
"""Error that the laws, which are linear, may take off, over the cone factor. Friction of 0.2 needs
10 % and follows them to 12 cells per radius; a rough cone of 120 degrees would need 16 % and does
not."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ConeRun:
    """A run of a cone test, as far as its error goes.

    Attributes:
        laws: of its error, at its end.
        strength: undrained shear strength su [Pa].
        bounded: what a bound of Poisson's ratio takes off it.
        recorded: the curve `penetration_resistance`, and the scalars `cone_factor_simulated` and
            `cone_factor_shear`.
    """

    laws: ErrorLaws
    strength: float
    bounded: float
    recorded: xr.Dataset

    @property
    def factor(self) -> float:
        """The cone factor as simulated."""
        return float(self.recorded.cone_factor_simulated)

    @property
    def has_settled(self) -> bool:
        """Whether the cone has passed all soil beside the shaft."""
        return bool(self.laws.way >= self.laws.above + ALL_PASSED)

    @property
    def why_not_settled(self) -> list[str]:
        """Why the error of the run is not known whatever its laws; nothing where it has settled."""
        reason = "settling: soil that the cone has not passed is still beside it"
        return [] if self.has_settled else [reason]

    @property
    def own_parts(self) -> dict[str, float]:
        """Half widths of what a run leaves open whatever its mesh, speed and window."""
        resistance = self.recorded.penetration_resistance.values / self.strength
        return {
            "steadiness": left_to_come(resistance),
            "points": POINTS * self.factor,
            "noise": NOISE,
        }


def known_error(run: ConeRun, built: Scene, expected: Scene | None) -> xr.Dataset:
    """The cone factor less what is known of its error, and its uncertainty.

    Args:
        run: the run.
        built: the scene that was simulated.
        expected: what the catalogue builds of the same parameters; see `built`.

    Returns:
        `cone_factor`, its normal part and its correction; `cone_factor_uncertainty` and its parts,
        each a half width of 95 %. Where nothing is known of the error there is no correction, the
        uncertainty is not a number, and `why_no_uncertainty` says why.
    """
    laws = run.laws
    parts = {name: float(it) for name, it in laws.half_widths(run.factor).items()}
    parts["speed"] += APPROACH * run.factor
    parts["bound"] = BOUND * run.factor * run.bounded
    reasons = [
        *(why_not_as_measured(built, expected) or _why_laws_do_not_hold(built)),
        *those_that_hold(laws.why_none_holds(largest_cell=WIDEST_CELL)),
        *run.why_not_settled,
    ]
    return _stated(run, float(laws.correction), parts | run.own_parts, reasons)


def _why_laws_do_not_hold(built: Scene) -> list[str]:
    """Why the laws do not hold for a scene that is one of a cone test."""
    grid = built.grid
    tip = np.flatnonzero(grid.surface_radius == 0.0)[-1]
    slope = np.diff(grid.surface_radius)[tip] / np.diff(grid.rows)[tip]
    angle = math.degrees(2.0 * math.atan(slope))
    is_other_cone = not math.isclose(angle, APEX_ANGLE, rel_tol=1e-9)
    return why_not_tresca(built.material) + those_that_hold(
        {
            f"cone: its apex angle is {angle:g} degrees, not {APEX_ANGLE:g}": is_other_cone,
            "contact: it has friction": built[SurfaceContact].friction != 0.0,
        }
    )


def check_measurable(laws: ErrorLaws) -> None:
    """Refuse a test whose error no further runs can measure.

    Raises:
        ParameterError: no law of the error holds.
    """
    for reason in those_that_hold(laws.why_not_linear()):
        raise ParameterError(
            "uncertainty",
            f"uncertainty = measured: {reason}; cells at the cone must be <= {LARGEST_CELL:g} of "
            f"its radius, and rigidity_index speed_ratio^2 <= {LARGEST_INERTIA:g}",
        )


def measured_error(case: ConeRun, further: Mapping[str, ConeRun | str]) -> xr.Dataset:
    """The cone factor less its error, and its uncertainty, as measured by five runs.

    Args:
        case: the run whose error is measured.
        further: the further runs, or why there is none, by effect.

    Returns:
        What `known_error` gives, and what each further run gave. Nothing is known of the error
        where one of the runs failed, or has not settled, or where the laws would have to take off
        more than `LARGEST_CORRECTION`.
    """
    runs = {"the case": case} | {
        f"the run with {DIFFERENCES[effect]}": run for effect, run in further.items()
    }
    reasons = [
        f"further runs: {name}: {fault}"
        for name, run in runs.items()
        for fault in ([run] if isinstance(run, str) else run.why_not_settled)
    ]
    parts = dict.fromkeys(DIFFERENCES, 0.0) | case.own_parts
    correction = 0.0
    if not reasons:
        whole = [run for run in runs.values() if isinstance(run, ConeRun)]
        found = without_errors([run.factor for run in whole], [_measures(it, case) for it in whole])
        correction = found.value - case.factor
        if abs(correction) > LARGEST_CORRECTION * found.value:
            off = f"their laws would take off {abs(correction) / found.value:.0%}"
            reasons = [f"further runs: {off}, and hold up to {LARGEST_CORRECTION:.0%}"]
        parts |= {choice: LEFT_OPEN * error for choice, error in found.left.items()}
        parts["speed"] += APPROACH * case.factor
        parts["noise"] = NOISE * float(np.linalg.norm(found.weights))
    factors = {
        effect: math.nan if isinstance(run, str) else run.factor for effect, run in further.items()
    }
    return _stated(case, correction, parts, reasons).assign(
        further_values("cone_factor", factors, DIFFERENCES)
    )


def _measures(run: ConeRun, case: ConeRun) -> dict[str, float]:
    """What the errors are in proportion to, by effect: h, g^1.5 h^1.3, i and w."""
    laws = run.laws
    return {
        "mesh": laws.cell_size,
        "growth": growth_measure(laws.cell_size, laws.cell_growth),
        "speed": float(laws.inertia),
        "domain": (case.laws.outer / laws.outer) ** 2,
    }


def _stated(
    run: ConeRun, correction: float, parts: Mapping[str, float], reasons: Sequence[str]
) -> xr.Dataset:
    """What is said of a cone factor, whichever way its error is known."""
    stated = stated_value(
        "cone_factor",
        run.factor,
        correction=correction,
        parts=parts,
        reasons=reasons,
        description="Nc = (qc - sigma_v0) / su, as simulated and corrected for mesh, speed and "
        "window",
    )
    settled = labelled(
        role="settled",
        cone_factor_settled=(
            float(run.has_settled),
            "1",
            "whether the cone factor has settled",
            "1 where the cone has passed all soil beside the shaft, else 0",
        ),
    )
    normal = labelled(
        cone_factor_normal=(
            float(stated["cone_factor"].values) - float(run.recorded.cone_factor_shear),
            "1",
            "cone factor, normal part",
            "what the normal traction on the face adds to Nc",
        ),
    )
    return xr.Dataset(stated | settled | normal)
