"""What is known of the error of a cone factor: a correction, and a half width of 95 %.

The correction is that of the laws of mesh, speed and window (`error_laws`). What they leave open,
and what differs from run to run, makes up the half width: its parts are added as squares.
`studies/held_out.toml` tests it.
"""

from __future__ import annotations

import xarray as xr

from mpm_warp.scenes.cone.error_laws import WIDEST_CELL, ErrorLaws
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.stated_error import (
    APPROACH,
    inertia,
    parts_of_a_run,
    stated_error,
    why_not_settled,
)
from mpm_warp.scenes.cone.window import smallness

BOUND = 0.4
"""Half width of what a bound of Poisson's ratio changes, over Nc and over what it takes off."""


def known_error(test: ConeTest, *, cell_size: float, recorded: xr.Dataset) -> xr.Dataset:
    """The cone factor less what is known of its error, and its uncertainty.

    Args:
        test: the cone penetration test.
        cell_size: width of the cells at the cone over its radius, dimensionless.
        recorded: the curve `penetration_resistance`, and the scalars `cone_factor_simulated`,
            `cone_factor_shear` and `penetration_reached`.

    Returns:
        `cone_factor`, its normal part and its correction; `cone_factor_uncertainty` and its parts,
        each a half width of 95 %. Where nothing is known of the error there is no correction, the
        uncertainty is not a number, and its attribute `not_known` says why.
    """
    laws = _laws(test, cell_size, recorded)
    return stated_error(
        test,
        recorded,
        correction=float(laws.correction),
        parts=_parts(test, laws, recorded),
        not_known=_not_known(test, laws, recorded),
    )


def _laws(test: ConeTest, cell_size: float, recorded: xr.Dataset) -> ErrorLaws:
    """The laws at the end of a test."""
    return ErrorLaws(
        rigidity_index=test.rigidity_index,
        adhesion_factor=test.adhesion_factor,
        stress_anisotropy=test.stress_anisotropy,
        poissons_ratio=min(test.poissons_ratio, test.poissons_ratio_bound),
        inertia=inertia(test),
        cell_size=cell_size,
        cell_growth=test.cell_growth,
        above=test.domain_above,
        below=test.domain_below,
        smallness=smallness(test, test.default_extents),
        way=float(recorded.penetration_reached),
    )


def _parts(test: ConeTest, laws: ErrorLaws, recorded: xr.Dataset) -> dict[str, float]:
    """The half widths by what they are of, each 95 %."""
    factor = float(recorded.cone_factor_simulated)
    parts = {name: float(it) for name, it in laws.half_widths(factor).items()}
    parts["speed"] += APPROACH * factor
    parts["bound"] = BOUND * factor * max(0.0, test.poissons_ratio - test.poissons_ratio_bound)
    return parts | parts_of_a_run(test, recorded)


def _not_known(test: ConeTest, laws: ErrorLaws, recorded: xr.Dataset) -> str:
    """Why nothing is known of the error, as a phrase; "" where it is known."""
    phrases = (
        {
            f"material = {test.material} is not tresca": test.material != "tresca",
            f"apex_angle = {test.apex_angle:g} is not 60": test.apex_angle != 60.0,
            "friction_coefficient is not 0": test.friction_coefficient != 0.0,
            "the clay softens": test.remoulded_strength_ratio != 1.0,
            "the clay has a rate effect": test.rate_factor != 0.0,
        }
        | laws.why_none_holds(largest_cell=WIDEST_CELL)
        | why_not_settled(test, recorded)
    )
    return "; ".join(phrase for phrase, holds in phrases.items() if holds)
