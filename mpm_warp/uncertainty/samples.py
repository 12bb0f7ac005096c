"""The error of each sample of a sounding: a correction and a half width of 95 %.

The resistance is corrected by the laws of a cone factor (`laws`), with the rigidity index and the
mean strength of the soil around the tip. These laws were measured in uniform, perfectly plastic
clay. They do not hold where the strength depends on strain or strain rate. There, further runs of
cone tests can measure the error, in uniform clay like that of the ground at some depths. No error
is known while the surface of the ground is in the window, nor near a border of layers. Where the
strength changes quickly, the depth of a sample is known to one cell: half the change over one cell
is a part of the half width.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.cone import REMEDIES as REMEDIES_OF_CONE
from mpm_warp.uncertainty.further_runs import CARRIED_ON, NOT_CORRECTED, REASON, largest_part
from mpm_warp.uncertainty.laws import EFFECTS, LARGEST_MEASURABLE_CELL, Condition, ErrorLaws

AVERAGING_DISTANCE = 2.0
"""Distance above and below the tip over which the strength is averaged, in cone radii."""
SURFACE_DEPTH = 28.0
"""Depth in radii beyond which the effect of the surface that has left the window falls in
inverse proportion to depth. The lack of resistance itself falls faster, with its square."""
REMEDIES = REMEDIES_OF_CONE | {
    "noise": "no parameter, it is of one sample; a mean over several has less",
    "borders": "more cells_per_radius",
    "surface": "no parameter, the surface of the ground is near",
    "measured": "more cells_per_radius, which the further runs have too",
}
"""What makes each part of U smaller."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SampleError:
    """The error of the samples of a sounding."""

    # Correction to add to the resistance, over the mean strength around the tip, shape [n]. Near a
    # border it is that of uniform ground, and in clay without a law that of Tresca, so that there
    # is no jump; 0 while the surface is in the window, and in scenes of other packages.
    correction: Floats
    is_corrected: NDArray[np.bool_]  # shape [n]
    half_width: Floats  # of 95 % [Pa], NaN where it is not known; shape [n]
    reason: str  # why it is not known at some depths, as "word: sentence"; "" if known at all
    largest_part: xr.Variable  # the largest part of the half width, over all samples that have one


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredError:
    """The error of cone factors at some depths, measured by further runs; linear between depths."""

    depth: Floats  # increasing [m], shape [m]
    correction: Floats  # to be added to each cone factor, dimensionless, shape [m]
    half_width: Floats  # of 95 %, dimensionless, NaN where it is not known; shape [m]
    reasons: tuple[str, ...] = ()  # why it is not known, each as "word: sentence"

    def at(self, depth: Floats) -> tuple[Floats, Floats]:
        """Correction and half width at depths [m] of shape [n], each of that shape.

        Between two depths the correction may be that of either, so half their difference is a part
        of the half width.
        """
        correction, half_width = (
            np.interp(depth, self.depth, column) for column in (self.correction, self.half_width)
        )
        steps = np.pad(0.5 * np.abs(np.diff(self.correction)), 1)
        between = steps[np.searchsorted(self.depth, depth)]
        return correction, np.hypot(half_width, between)


def measured_by(depths: Sequence[float], tests: Sequence[xr.Dataset | str]) -> MeasuredError:
    """The error at increasing depths [m], from cone tests with a measured error.

    A test is its results, or the reason why it has none.
    """
    reasons = [test if isinstance(test, str) else str(test[REASON].values) for test in tests]
    correction, half_width = (
        np.array([math.nan if isinstance(test, str) else float(test[name]) for test in tests])
        for name in ("cone_factor_correction", "cone_factor_uncertainty")
    )
    return MeasuredError(
        depth=np.array(depths),
        correction=correction,
        half_width=half_width,
        reasons=tuple(dict.fromkeys(filter(None, reasons))),
    )


def sample_error(
    laws: ErrorLaws,
    *,
    depth: Floats,
    around: Floats,
    resistance: Floats,
    shift: Floats,
    surface: Mapping[str, Condition],
    borders: Mapping[str, Condition],
    why_none: Sequence[str],
    goes_on: bool,
    measured: MeasuredError | None = None,
) -> SampleError:
    """The error of the samples of a sounding.

    Args:
        laws: the laws of the error, with one value for each sample.
        depth: of the tip [m], shape [n].
        around: mean strength around the tip [Pa], shape [n].
        resistance: net resistance as simulated [Pa], shape [n].
        shift: change of `around` where the tip is one cell deeper [Pa], shape [n].
        surface: reasons about the surface of the ground in the window, and where they apply.
        borders: reasons about borders of layers nearby, and where they apply.
        why_none: reasons why the laws hold for no sample.
        goes_on: whether the correction goes on where the laws do not hold.
        measured: the error measured by further runs, which replaces the laws; None without them.
    """
    factor = resistance / around
    correction = laws.correction
    if measured is None:
        parts = laws.half_widths() | {"points": EFFECTS["points"].half_width * factor}
        of_method = laws.why_none_holds(largest_cell=LARGEST_MEASURABLE_CELL)
    else:
        by_runs, half_widths = measured.at(depth)
        correction = np.where(np.isnan(by_runs), correction, by_runs)
        parts = {"measured": half_widths}
        of_method = dict.fromkeys(measured.reasons, np.isnan(half_widths))
    parts |= {"noise": _noise(laws, factor), "borders": 0.25 * factor * np.abs(shift) / around}
    if surface:
        parts["surface"] = (
            EFFECTS["surface"].half_width
            * factor
            * SURFACE_DEPTH
            / np.maximum(SURFACE_DEPTH, laws.penetration)
        )
    of_laws: dict[str, Condition] = {**dict.fromkeys(why_none, True), **of_method}
    is_corrected = goes_on & ~_any_of(surface, depth)
    is_known = ~_any_of({**of_laws, **borders, **surface}, depth)
    squares = {name: np.broadcast_to(part**2, depth.shape) for name, part in parts.items()}
    half_width = around * np.sqrt(sum(squares.values()))
    means = (
        {name: math.sqrt(square[is_known].mean()) for name, square in squares.items()}
        if is_known.any()
        else {}
    )
    left = f"{{}}: {CARRIED_ON if goes_on else NOT_CORRECTED}"
    return SampleError(
        correction=np.where(is_corrected, correction, 0.0),
        is_corrected=is_corrected,
        half_width=np.where(is_known, half_width, np.nan),
        reason="; ".join(
            [
                *map(left.format, _with_depths(of_laws, depth)),
                *_with_depths(borders, depth),
                *(f"{text}: {NOT_CORRECTED}" for text, holds in surface.items() if np.any(holds)),
            ]
        ),
        largest_part=largest_part(means, REMEDIES),
    )


def _noise(laws: ErrorLaws, factor: Floats) -> Floats:
    """Half width of the noise of each sample, over the strength, shape [n]."""
    ratio = laws.poissons_ratio
    over_pressure_waves = np.sqrt(
        laws.inertia / laws.rigidity_index * (1.0 - 2.0 * ratio) / (2.0 * (1.0 - ratio))
    )
    of_sample, of_inflow = (EFFECTS[name].half_width for name in ("sample", "inflow"))
    noise: Floats = np.maximum(of_sample, of_inflow * factor * over_pressure_waves)
    return noise


def _any_of(conditions: Mapping[str, Condition], depth: Floats) -> NDArray[np.bool_]:
    """Whether at least one condition holds, shape [n]."""
    each = [np.broadcast_to(holds, depth.shape) for holds in conditions.values()]
    found: NDArray[np.bool_] = np.logical_or.reduce([np.zeros(depth.shape, dtype=bool), *each])
    return found


def _with_depths(reasons: Mapping[str, Condition], depth: Floats) -> list[str]:
    """The reasons that hold at some depth, with the ranges of depth where they hold."""
    texts = []
    for reason, holds in reasons.items():
        mask = np.broadcast_to(holds, depth.shape)
        edges = np.flatnonzero(np.diff(mask, prepend=False, append=False))
        spans = [f"{depth[a]:.4g} to {depth[b - 1]:.4g}" for a, b in edges.reshape(-1, 2)]
        if mask.all():
            texts.append(reason)
        elif spans:
            texts.append(f"{reason}, from {' and '.join(spans)} m")
    return texts
