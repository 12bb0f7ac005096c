"""Limits of errors and balances: beyond one a run is inaccurate, whatever its headline says."""

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

from mpm_warp.errors import InaccurateRun

LARGEST_ERROR = 0.15
"""Largest error against an exact solution; the coarsest checked mesh has 0.12, the finest 0.02."""
LARGEST_LACK = 0.05
"""Largest share of energy, momentum or spin that the method itself may create or dissipate."""


@dataclass(frozen=True)
class Limit:
    """The greatest allowed size of a scalar result.

    Attributes:
        size: > 0; a value without a number is beyond it too.
        remedy: what to try, as in "more cell_count".
        meaning: of the value in a message; default: its long name.

    Example:
        >>> Limit(0.05, "a lower speed_ratio").remedy
        'a lower speed_ratio'
    """

    size: float
    remedy: str
    meaning: str = ""


Limits = Mapping[str, Limit | str]
"""By the names of results: the limit, or why there is none."""


def limited(**remedies: str) -> dict[str, Limit]:
    """Errors against exact solutions by name, each with what to try beyond `LARGEST_ERROR`.

    Example:
        >>> limited(error="more cell_count")["error"].size
        0.15
    """
    return {name: Limit(LARGEST_ERROR, remedy) for name, remedy in remedies.items()}


def with_limits(limits: Limits, results: xr.Dataset) -> xr.Dataset:
    """Results whose limited values have the attribute ``limit``."""
    return results.assign(
        {
            name: results[name].assign_attrs(limit=limit.size)
            for name, limit in limits.items()
            if isinstance(limit, Limit) and name in results
        }
    )


def check_limits(limits: Limits, results: xr.Dataset) -> None:
    """Raise `InaccurateRun`, with the remedy, where a result is beyond its limit."""
    for name, limit in limits.items():
        if isinstance(limit, str) or name not in results:
            continue
        size = abs(float(results[name]))
        if not size <= limit.size:
            meaning = limit.meaning or results[name].attrs["long_name"]
            raise InaccurateRun(
                f"the {meaning} is {size:.3g}, more than {limit.size:g}: try {limit.remedy}",
                results,
            )
