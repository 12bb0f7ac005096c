"""A value with its uncertainty, or with the reason why it has none, as variables of a result."""

import math
from collections.abc import Mapping, Sequence

import xarray as xr

from mpm_warp.results import variable

REASON = "why_no_uncertainty"
"""Name of the text that says why a result has no uncertainty; "" where it has one."""


def stated_value(
    name: str,
    simulated: float,
    *,
    correction: float,
    parts: Mapping[str, float],
    reasons: Sequence[str],
    description: str,
) -> dict[str, xr.Variable]:
    """A value less what is known of its error, and its uncertainty.

    Args:
        name: of the value, which is dimensionless; "cone_factor", say.
        simulated: the value as simulated.
        correction: what is to be added to it.
        parts: half widths of 95 % by what they are of; their squares add up.
        reasons: why nothing is known of the error, each as "word: sentence"; none where it is.
        description: how the value is defined.

    Returns:
        The value, its correction; its uncertainty, the parts of it, and the reason for none. Where
        nothing is known of the error there is no correction, and the uncertainty is not a number.
    """
    if reasons:
        correction, parts = 0.0, dict.fromkeys(parts, math.nan)
    spoken = name.replace("_", " ")
    return {
        name: variable(
            simulated + correction, meaning=spoken, description=description, role="headline"
        ),
        f"{name}_uncertainty": variable(
            math.nan if reasons else math.hypot(*parts.values()),
            meaning=f"uncertainty of the {spoken}",
            description="half width, 95 %",
            role="uncertainty",
        ),
        f"{name}_correction": variable(
            correction,
            meaning=f"correction of the {spoken}",
            description="what is known of the error of mesh, speed and window, taken off; 0 where "
            "nothing is",
        ),
        REASON: reason("; ".join(reasons)),
    } | {
        f"{name}_uncertainty_{part}": variable(
            half_width, meaning=f"uncertainty of the {spoken}, {part}"
        )
        for part, half_width in parts.items()
    }


def reason(text: str) -> xr.Variable:
    """The variable `REASON`: "word: sentence", parted by semicolons; "" where there is none."""
    return variable(text, unit=None, meaning="why there is no uncertainty", role="reason")


def those_that_hold(conditions: Mapping[str, object]) -> list[str]:
    """The reasons that hold, of some with what says whether they do."""
    return [text for text, holds in conditions.items() if holds]
