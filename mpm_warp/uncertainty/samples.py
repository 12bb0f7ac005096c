"""What is known of the error of the samples of a sounding: a correction, a half width of 95 %.

The resistance is corrected by the laws of a cone factor (`laws`), with rigidity index and mean
strength of the soil around the tip. These laws were measured in uniform, perfectly plastic clay;
where strain or its rate changes the strength nothing is known, nor while the surface of the ground
is in the window. Near a border they are taken as they are. The place of the border is known to a
cell: half of what a shift by one cell changes is a part of the half width.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.scene import Scene
from mpm_warp.uncertainty.built import why_not_as_measured, why_not_tresca
from mpm_warp.uncertainty.cone import POINTS
from mpm_warp.uncertainty.laws import LARGEST_CELL, Condition, ErrorLaws

AROUND = 2.0
"""Way above and below the tip over which strength is averaged, in cone radii."""
SAMPLE_NOISE = 0.07
"""Half width of the noise of one sample of a tenth of a radius, over strength: twice the standard
deviation that samples have in uniform clay, 0.032 at 3 cells per radius."""
LEFT_BY_SURFACE, FALLING = 0.026, 28.0
"""Half width of what the surface leaves when it is out of the window, over the resistance: twice
what a window of twice the extents changes, 0.6 % smooth and 1.3 % rough, at 20 to 28 radii. From
there on it falls with the depth at least: the lack of resistance falls with its square."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SampleError:
    """The error of samples.

    Attributes:
        correction: what is to be added to the resistance, over the mean strength around the tip,
            dimensionless, 0 where nothing is known; shape [n].
        half_width: of 95 % [Pa], NaN where nothing is known; shape [n].
        reason: why nothing is known of some samples, as "word: sentence", with their depths; "".
    """

    correction: Floats
    half_width: Floats
    reason: str


def why_not_known(built: Scene, expected: Scene | None) -> list[str]:
    """Why the error of no sample of a sounding is known, whatever its ground; see `built`."""
    return why_not_as_measured(built, expected) or why_not_tresca(built.material)


def sample_error(
    laws: ErrorLaws,
    *,
    depth: Floats,
    around: Floats,
    resistance: Floats,
    shift: Floats,
    surface: Mapping[str, Condition],
    why_none: Sequence[str],
) -> SampleError:
    """What is known of the error of the samples of a resistance.

    Args:
        laws: at the samples.
        depth: of the tip [m], shape [n].
        around: mean strength around the tip [Pa], shape [n].
        resistance: net, as simulated [Pa], shape [n].
        shift: what a cell further down changes of that strength [Pa], shape [n].
        surface: where the surface of the ground is in the window, by what is said of it; nothing
            for a cone that starts in place.
        why_none: why the error of no sample is known; see `why_not_known`.
    """
    factor = resistance / around
    parts = laws.half_widths(factor) | {
        "points": POINTS * factor,
        "noise": SAMPLE_NOISE,
        "borders": 0.25 * factor * np.abs(shift) / around,
    }
    if surface:
        parts["surface"] = LEFT_BY_SURFACE * factor * FALLING / np.maximum(FALLING, laws.way)
    of_laws = laws.why_none_holds(largest_cell=LARGEST_CELL)
    reasons: dict[str, Condition] = {**dict.fromkeys(why_none, True), **of_laws, **surface}
    not_known = np.zeros(depth.shape, dtype=bool)
    for holds in reasons.values():
        not_known |= holds
    half_width = around * np.sqrt(sum(np.square(it) for it in parts.values()))
    return SampleError(
        correction=np.where(not_known, 0.0, laws.correction),
        half_width=np.where(not_known, np.nan, half_width),
        reason="; ".join(
            [
                *_with_depths({it: reasons[it] for it in reasons if it not in surface}, depth),
                *(text for text, holds in surface.items() if np.any(holds)),
            ]
        ),
    )


def _with_depths(reasons: Mapping[str, Condition], depth: Floats) -> list[str]:
    """The reasons that hold somewhere, and from where to where."""
    told = []
    for reason, holds in reasons.items():
        where = depth[np.broadcast_to(holds, depth.shape)]
        if where.size == depth.size:
            told.append(reason)
        elif where.size:
            told.append(f"{reason}, from {where[0]:.4g} to {where[-1]:.4g} m")
    return told
