"""How scenes are compared with their exact solutions."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from mpm_warp.fields.declaration import Value


@dataclass(frozen=True, kw_only=True)
class Verification:
    """How a scene is compared with its exact solution.

    Attributes:
        resolution: name of the parameter that refines the solution.
        resolutions: its values, rising.
        bounds: scalars of the result, and their greatest allowed values at the last resolution.
        least_order: least observed order of the variable `error`; None where no order is claimed.
        settings: parameters that differ from their defaults.
        extreme: whether it is a long or violent run, which is made only on request.

    Example:
        >>> [it.resolutions for it in GravityColumn.verifications]
        [(10, 20, 40)]
    """

    resolution: str
    resolutions: tuple[int, ...]
    bounds: Mapping[str, float]
    least_order: float | None = None
    settings: Mapping[str, Value] = field(default_factory=dict)
    extreme: bool = False


def compared(
    resolution: str,
    resolutions: tuple[int, ...],
    *settings: Mapping[str, Value],
    least_order: float | None = None,
    extreme: bool = False,
    **bounds: float,
) -> tuple[Verification, ...]:
    """A `Verification` for each of the settings, or one for all defaults; bounds by name.

    Example:
        >>> compared("cell_count", (10, 20), least_order=1.9, error=0.01)[0].bounds
        {'error': 0.01}
    """
    by_default = Verification(
        resolution=resolution,
        resolutions=resolutions,
        bounds=bounds,
        least_order=least_order,
        extreme=extreme,
    )
    return tuple(replace(by_default, settings=of_one) for of_one in settings or ({},))
