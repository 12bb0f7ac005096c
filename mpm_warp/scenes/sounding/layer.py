"""How far the resistance feels a border, and how much of a thin layer's resistance is reached."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled
from mpm_warp.scenes.cone.error_laws import TOP, top_error
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING
from mpm_warp.scenes.sounding.parameters import SoundingTest

FELT = 0.05
"""Share of the whole change of the resistance from which on a border is felt."""
SMOOTHED = 10
"""Samples of a running mean, one radius: the noise of one sample is a few hundredths."""
NOISE = 0.002
"""Half width of the noise of a mean over a radius, over the resistance."""
UNDISTURBED = 20
"""Samples at the begin of the curves, two radii, whose mean is the resistance without the layer."""


def layer_values(sounding: SoundingTest, recorded: xr.Dataset) -> dict[str, xr.Variable]:
    """Scalars of a sounding through a layer of the scene's parameters; none where there is none.

    There are none of a sounding from the surface either.

    Args:
        sounding: what was run.
        recorded: its curves over depth.
    """
    top, ratio = sounding.layer_top, sounding.layer_strength_ratio
    if top is None or sounding.profile is not None or ratio == 1.0:
        return {}
    if sounding.starts_at_surface:  # no resistance of undisturbed ground to compare it with
        return {}
    depth = recorded.depth.values
    without = sounding.undrained_shear_strength + sounding.strength_gradient * depth
    factor = recorded.net_resistance.values / without
    share = change_of_resistance(factor, ratio)
    distance = (depth - top) / sounding.cone_radius
    if sounding.layer_thickness is None:
        return _ways_felt(distance, share)
    in_layer = (distance > 0.0) & (distance < sounding.layer_thickness / sounding.cone_radius + 5.0)
    reached = float(np.nanmax(share[in_layer], initial=-math.inf))
    return labelled(
        role="headline",
        layer_share=(
            reached,
            "1",
            "share of the layer's resistance that is reached",
            "greatest change, mean over a radius, over that in a layer without end",
        ),
    ) | labelled(
        role="uncertainty",
        layer_share_uncertainty=(
            _half_width(sounding, reached, factor),
            "1",
            "uncertainty of the share of the layer's resistance",
            "half width, 95 %",
        ),
    )


def _half_width(sounding: SoundingTest, reached: float, factor: Floats) -> float:
    """Half width of the share of a layer's resistance; NaN where no law of the error is known.

    Args:
        sounding: what was run; its layer has a thickness.
        reached: the share.
        factor: net resistance over the strength that the soil would have without the layer, [n].
    """
    assert sounding.layer_thickness is not None
    if sounding.strength_changes:
        return math.nan
    ratio = sounding.layer_strength_ratio
    # Errors of mesh and speed are in both resistances; that of the top grows on the way.
    relative = math.hypot(_top(sounding, factor), NOISE)
    of_resistances = abs((1.0 + reached * (ratio - 1.0)) / (ratio - 1.0)) * relative
    return math.hypot(
        of_resistances, _of_borders(reached, sounding.cell_size / sounding.layer_thickness)
    )


def _ways_felt(distance: Floats, share: Floats) -> dict[str, xr.Variable]:
    """From where above a border, and to where below it, the resistance feels it.

    Args:
        distance: of the tip below the border, over the cone's radius, shape [n].
        share: of the change of the resistance that is reached, shape [n].
    """
    return labelled(
        felt_before=(
            _first(-distance, share > FELT),
            "1",
            "way above the border from which on it is felt, over cone radius",
            f"the resistance has changed by {FELT:.0%} of its whole change",
        ),
        felt_behind=(
            _first(distance, share > 1.0 - FELT),
            "1",
            "way below the border up to which it is felt, over cone radius",
            f"the resistance lacks {FELT:.0%} of its whole change",
        ),
    )


def _of_borders(share: float, cell: float) -> float:
    """Half width of the share because the places of the borders are known to a cell.

    A share s = 1 - exp(-t / l) of a layer of thickness t grows with t by -(1 - s) ln(1 - s) / t.

    Args:
        share: s, of the layer's resistance.
        cell: height of a cell over the thickness of the layer.
    """
    lacking = 1.0 - min(max(share, 0.0), 1.0 - NOISE)
    return -lacking * math.log(lacking) * cell


def _top(sounding: SoundingTest, factor: Floats) -> float:
    """Half width of what the top of the window adds on the way, over the resistance.

    Args:
        sounding: what was run.
        factor: net resistance over the strength that the soil would have without the layer, [n].
    """
    error = top_error(
        rigidity_index=sounding.rigidity_index,
        above=sounding.domain_above,
        below=sounding.domain_below,
        way=sounding.travel / sounding.cone_radius,
    )
    return TOP * float(error) / float(np.mean(factor[:UNDISTURBED]))


def change_of_resistance(factor: Floats, ratio: float) -> Floats:
    """Change of the resistance over that from one soil to the other, mean over a radius, [n].

    Args:
        factor: net resistance over the strength that the soil would have without the layer.
        ratio: strength of the layer over that strength.
    """
    undisturbed = float(np.mean(factor[:UNDISTURBED]))
    smooth = np.convolve(factor, np.full(SMOOTHED, 1.0 / SMOOTHED), mode="same")
    half = SMOOTHED // 2
    smooth[:half], smooth[len(smooth) - half :] = np.nan, np.nan
    share: Floats = (smooth / undisturbed - 1.0) / (ratio - 1.0)
    return share


def _first(way: Floats, reached: NDArray[np.bool_]) -> float:
    """The way at the first sample from which on something is reached for a whole radius."""
    window = round(1.0 / SAMPLE_SPACING)
    lasting = np.convolve(reached, np.ones(window), mode="valid") >= window
    return float(way[int(np.argmax(lasting))]) if lasting.any() else math.nan
