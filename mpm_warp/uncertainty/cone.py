"""The error of a cone factor: known from other cases, or measured by further runs of the case.

Known: the correction follows from the laws of mesh, speed and window (`laws`). The half width has
parts for what the laws leave unknown and parts of the single run; they are added as squares.
`studies/held_out.toml` tests it.

Measured: the case and four further runs, each with one choice of the method changed, determine the
unknowns of

    Nc_simulated = Nc + B h + Q h^1.7 + C g^1.5 h^1.3 + S i + W w

with h the width of the cells at the cone over its radius, g their growth, i = rho V^2 / su, and
w = (extent of the window of the case / extent)^2. The terms are those of `laws`, where B, C and S
are known from other cases. Q is taken from there, as it hardly differs between cones and clays.
This serves cases for which the values of `laws` do not hold.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import xarray as xr

from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.results import labelled
from mpm_warp.scene import Scene
from mpm_warp.uncertainty.built import (
    LAWS_OF_CONES,
    Test,
    why_law_not_measured,
    why_not_of_catalogue,
    why_not_tresca,
)
from mpm_warp.uncertainty.further_runs import ALONE, CARRIED_ON, TestRun, those_that_hold
from mpm_warp.uncertainty.laws import (
    APEX_ANGLE,
    EFFECTS,
    LARGEST_CELL,
    LARGEST_MEASURABLE_CELL,
    LARGEST_MEASURED_INERTIA,
    Condition,
    ErrorLaws,
    curvature_error,
    growth_measure,
    window_uncertainty,
)
from mpm_warp.uncertainty.steadiness import REMAINING_CHANGE, SETTLING_MARGIN, last_change

FINER, GROWING, SLOWER, WIDER = 1.6, 2.0, 0.5, 1.4
"""Cells per radius, growth of the cells, speed and extents of the window in the further runs, over
those of the case."""
SETTLING = 0.5
"""Additional penetration of the run with the wider window, at the speed of the approach, over its
extent above the shoulder. Just after the cone has passed all soil there, the resistance still
falls, by 0.03 su at Ir 150. With windows of 1.4 times the extents this makes 0.06 in the cone
factor."""
DIFFERENCES = {
    "mesh": "smaller cells",
    "growth": "more growth",
    "speed": "half the speed",
    "domain": "a wider window",
}
"""Difference of the further run that measures an effect, such as B h, by effect."""
REMEDIES = {
    "mesh": "more cells_per_radius",
    "growth": "a cell_growth of 0.4",
    "speed": "a lower speed_ratio",
    "domain": "larger domain_radius, domain_above and domain_below",
    "bottom": "a larger domain_below",
    "top": "a larger domain_above",
    "bound": "a higher poissons_ratio_bound",
    "steadiness": "more penetration, or a lower steady_tolerance",
    "noise": "more cells_per_radius",
    "limit": "no parameter, it is of the limit of fine cells",
    "points": "no parameter, it is of the number of material points",
    "range": "no parameter, the clay is beyond what was measured",
}
"""What makes each part of U smaller."""
RESIDUAL_SHARES = dict.fromkeys(DIFFERENCES, 0.5) | {"mesh": 0.2}
"""Half width of each error over that in the run where it is smallest: about the difference between
a law and one of the next order. The mesh has such a term already, Q h^1.7. From 5 and 8
rows beside the face its limit is within 0.04 of that from 5 to 14 rows, in other cones and clays
too. That is a sixth of the error on 8 rows."""
FEW_ROWS, INERTIA_WITH_FEW_ROWS = 3, 0.15
"""On fewer than `FEW_ROWS` rows of cells beside the face, further runs need a rho V^2 / su of at
most `INERTIA_WITH_FEW_ROWS`. On two rows beside a cone of 120 degrees the effect of the speed
depends on the mesh, and at 0.38 the error was 1.7 half widths. On three rows and more, cones up to
110 degrees agree at 0.9."""
LARGEST_CORRECTION = 0.08
"""Largest correction over the cone factor for which the laws, which are linear, are trusted. A cone
of 120 degrees on two rows needs 5 %. Friction that sheared soil by more than its strength needed
10 %, and two of its limits were 2 half widths off."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ConeRun(TestRun):
    """What the error of a run of a cone test depends on.

    `recorded` holds `penetration_resistance`, `cone_factor_simulated` and `cone_factor_shear`.
    """

    name = "cone_factor"
    description = "Nc = (qc - sigma_v0) / su, as simulated and corrected for mesh, speed and window"
    differences = DIFFERENCES
    residual_shares = RESIDUAL_SHARES
    remedies = REMEDIES
    largest_correction = LARGEST_CORRECTION
    approach = EFFECTS["approach"].half_width

    laws: ErrorLaws  # of its error at the end of the run
    strength: float  # undrained shear strength su [Pa]
    roughness: float  # mean shear stress on the face over su, that of friction included
    goes_on: bool  # whether the correction goes on where the laws do not hold

    @property
    def factor(self) -> float:
        """The cone factor as simulated."""
        return float(self.recorded.cone_factor_simulated)

    @property
    def usual_correction(self) -> float:
        """By the laws of Tresca clay, at the nearest place where they hold.

        So no effect of clay or contact that they do not know makes a step where it begins. A cone
        with friction is as rough as that makes it under the stress on its face.
        """
        if not self.goes_on:
            return 0.0
        return float(replace(self.laws, adhesion_factor=self.roughness).correction)

    @property
    def usual_correction_is(self) -> str:
        """See `TestRun`."""
        if not self.goes_on:
            return super().usual_correction_is
        return CARRIED_ON

    @property
    def why_not_settled(self) -> list[str]:
        """Why the cone factor has not settled, so that no law holds; empty where it has."""
        return those_that_hold(_not_settled(self.laws))

    def known_parts(self) -> dict[str, float]:
        """Q h^1.7."""
        laws = self.laws
        known = curvature_error(
            rigidity_index=laws.rigidity_index,
            adhesion_factor=laws.adhesion_factor,
            cell_size=laws.cell_size,
        )
        return {"mesh": float(known)}

    def least_parts(self) -> dict[str, float]:
        """That of a window smaller than the default, whose effect is not in proportion to w."""
        return {"domain": window_uncertainty(self.laws.extent_ratio)}

    def own_parts(self, weights: Floats, runs: Sequence[Self]) -> dict[str, float]:
        """Steadiness, limit of fine cells, number of points, and noise of all runs."""
        resistance = self.recorded.penetration_resistance.values / self.strength
        return {
            "steadiness": REMAINING_CHANGE * abs(last_change(resistance)),
            "limit": EFFECTS["limit_of_further_runs"].half_width,
            "points": EFFECTS["points"].half_width * self.factor,
            "noise": EFFECTS["noise_of_further_runs"].half_width * float(np.linalg.norm(weights)),
        }

    def measures(self, case: Self) -> dict[str, float]:
        """h, g^1.5 h^1.3, i and w."""
        laws = self.laws
        return {
            "mesh": laws.cell_size,
            "growth": growth_measure(laws.cell_size, laws.cell_growth),
            "speed": float(laws.inertia),
            "domain": (case.laws.outer / laws.outer) ** 2,
        }

    def why_unsound(self, runs: Mapping[str, Self]) -> list[str]:
        """The runs that have not settled."""
        return [
            f"further runs: {which}: {why}"
            for which, run in runs.items()
            for why in run.why_not_settled
        ]

    def stated(
        self, correction: float, parts: Mapping[str, float], reasons: Sequence[str]
    ) -> dict[str, xr.Variable]:
        """The cone factor, its normal part, and whether it has settled."""
        stated = super().stated(correction, parts, reasons)
        passed = "1 where the cone has passed all soil beside the shaft, else 0"
        is_settled = float(not self.why_not_settled)
        settled = (is_settled, "1", "whether the cone factor has settled", passed)
        normal = float(stated["cone_factor"].values) - float(self.recorded.cone_factor_shear)
        adds = "what the normal traction on the face adds to Nc"
        stated |= labelled(role="settled", cone_factor_settled=settled)
        return stated | labelled(cone_factor_normal=(normal, "1", "cone factor, normal part", adds))


def known_error(run: ConeRun, test: Test, built: Scene) -> dict[str, xr.Variable]:
    """The corrected cone factor and its uncertainty, by the laws.

    Args:
        run: the run.
        test: the cone test.
        built: the scene that was simulated.

    Returns:
        `cone_factor`, its normal part and its correction; `cone_factor_uncertainty` and its parts,
        each a half width of 95 %. Where the laws do not hold, the uncertainty is NaN, and
        `why_no_uncertainty` gives the reason; the correction goes on, see `usual_correction`.
    """
    laws = run.laws
    by_laws = {name: float(value) for name, value in laws.half_widths().items()}
    by_laws["speed"] += EFFECTS["approach"].half_width * run.factor
    of_others = why_not_of_catalogue(test, built)
    of_clay = why_law_not_measured(built.material, LAWS_OF_CONES) or _why_not_of_scene(built)
    reasons = [*(of_others or of_clay), *why_laws_do_not_hold(laws)]
    run = replace(run, goes_on=run.goes_on and not of_others)
    return run.stated(run.usual_correction, run.own_parts(ALONE, [run]) | by_laws, reasons)


def why_laws_do_not_hold(laws: ErrorLaws) -> list[str]:
    """Why the laws do not hold for a cone test, whatever was built; empty where they do."""
    return those_that_hold(laws.why_none_holds(largest_cell=LARGEST_CELL) | _not_settled(laws))


def _not_settled(laws: ErrorLaws) -> dict[str, Condition]:
    return {
        "settling: soil that the cone has not passed is still beside it": (
            laws.penetration < laws.above + SETTLING_MARGIN
        )
    }


def _why_not_of_scene(built: Scene) -> list[str]:
    """Why the laws do not hold for the soil, cone or friction of a scene of the catalogue."""
    grid = built.grid
    tip = np.flatnonzero(grid.surface_radius == 0.0)[-1]
    slope = np.diff(grid.surface_radius)[tip] / np.diff(grid.rows)[tip]
    angle = math.degrees(2.0 * math.atan(slope))
    is_other_cone = not math.isclose(angle, APEX_ANGLE, rel_tol=1e-9)
    return why_not_tresca(built.material) + those_that_hold(
        {
            f"cone: the apex angle is {angle:g} degrees, not {APEX_ANGLE:g}": is_other_cone,
            "contact: the contact has friction": built[SurfaceContact].friction != 0.0,
        }
    )


def check_measurable(laws: ErrorLaws, rows_on_face: int) -> None:
    """Raise `ParameterError` where cells or speed are too large for further runs."""
    too_fast = rows_on_face < FEW_ROWS and laws.inertia > INERTIA_WITH_FEW_ROWS
    most = INERTIA_WITH_FEW_ROWS if rows_on_face < FEW_ROWS else LARGEST_MEASURED_INERTIA
    few = f"speed: rho V^2 is above {INERTIA_WITH_FEW_ROWS:g} su with {rows_on_face} rows of cells"
    for reason in those_that_hold({**laws.why_not_measurable, few: too_fast}):
        raise ParameterError(
            "uncertainty",
            f"uncertainty = measured: {reason}; cells at the cone must be <= "
            f"{LARGEST_MEASURABLE_CELL:g} of its radius, and "
            f"rigidity_index speed_ratio^2 <= {most:g}",
        )
