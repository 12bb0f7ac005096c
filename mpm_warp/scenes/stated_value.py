"""A value with its uncertainty, as variables of the results of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping

import xarray as xr

from mpm_warp.results import variable


def stated_value(
    name: str,
    simulated: float,
    *,
    correction: float,
    parts: Mapping[str, float],
    not_known: str,
    description: str,
) -> dict[str, xr.Variable]:
    """A value less what is known of its error, and its uncertainty.

    Args:
        name: of the value, which is dimensionless; "cone_factor", say.
        simulated: the value as simulated.
        correction: what is to be added to it.
        parts: half widths of 95 % by what they are of; their squares add up.
        not_known: why nothing is known of the error, as a phrase; "" where it is known.
        description: how the value is defined.

    Returns:
        The value, its correction; its uncertainty and the parts of it. Where nothing is known of
        the error there is no correction, the uncertainty is not a number, and its attribute
        `not_known` says why.
    """
    if not_known:
        correction, parts = 0.0, dict.fromkeys(parts, math.nan)
    spoken = name.replace("_", " ")
    headline = {
        name: variable(
            simulated + correction,
            unit="1",
            meaning=spoken,
            description=description,
            role="headline",
        )
    }
    uncertainty = variable(
        math.hypot(*parts.values()),
        unit="1",
        meaning=f"uncertainty of the {spoken}",
        description="half width, 95 %",
        role="uncertainty",
    )
    if not_known:
        uncertainty.attrs["not_known"] = not_known
    of_correction = variable(
        correction,
        unit="1",
        meaning=f"correction of the {spoken}",
        description="what is known of the error of mesh, speed and window, taken off; 0 where "
        "nothing is",
    )
    of_parts = {
        f"{name}_uncertainty_{part}": variable(
            half_width, unit="1", meaning=f"uncertainty of the {spoken}, {part}"
        )
        for part, half_width in parts.items()
    }
    return (
        headline
        | {f"{name}_uncertainty": uncertainty, f"{name}_correction": of_correction}
        | of_parts
    )


def further_values(
    name: str, values: Mapping[str, float], differences: Mapping[str, str]
) -> dict[str, xr.Variable]:
    """The value as simulated by each further run, not a number where it failed.

    Args:
        name: of the value.
        values: by choice of the method.
        differences: what the further run has, as "smaller cells", by the same.
    """
    return {
        f"{name}_further_{choice}": variable(
            value,
            unit="1",
            meaning=f"{name.replace('_', ' ')} as simulated with {differences[choice]}",
        )
        for choice, value in values.items()
    }
