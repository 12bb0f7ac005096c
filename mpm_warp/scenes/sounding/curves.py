"""The curves of a sounding over the depth of the tip, and scalars that describe a layer.

The scalars are the distances from which and up to which a border changes the resistance, and the
share of its full resistance that a thin layer reaches.
"""

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import Drawn, curves, labelled
from mpm_warp.scenes.cone.pore_pressure import RADIAL_TO
from mpm_warp.scenes.sounding.sounding_test import SoundingTest
from mpm_warp.uncertainty.built import goes_on, is_of_catalogue
from mpm_warp.uncertainty.further_runs import LARGEST_PART, REASON, reason
from mpm_warp.uncertainty.laws import CLEAR_OF_BORDER, Condition
from mpm_warp.uncertainty.samples import (
    AVERAGING_DISTANCE,
    MeasuredError,
    SampleError,
    sample_error,
)
from mpm_warp.uncertainty.shoulder import LARGEST_GROWTH, RADIAL_STRESS, shoulder_pressure
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING, STEADY_SAMPLES

FELT = 0.05
"""A border is felt where the resistance has changed by more than this share of its whole change."""
SMOOTHED = 10
"""Number of samples in a running mean, one radius; the noise of one sample is a few hundredths."""
NOISE = 0.002
"""Half width of the noise of a mean over a radius, over the resistance."""
PRESSURE_NOISE = 0.05
"""Half width of the noise of one sample of u2, over u2: twice the standard deviation of samples in
uniform clay, 0.022 to 0.03 at Ir 40 to 300 and 2.3 and 3 cells per radius."""
BY_DEPTH = partial(Drawn, picture="sounding", downward=True, joined_over="stretch_number")
"""The panels of the picture of a sounding."""
HALF_WIDTH = "half width, 95 %"
"""Description of an uncertainty in results."""
BORDER = "border: the resistance feels another layer, where nothing was tested"
"""Reason why samples near a border of layers have no uncertainty."""
UNDISTURBED = 20
"""Number of samples at the start of the curves, over two radii, whose mean is the resistance of the
ground without the layer."""
PAST_LAYER = 1.5
"""Distance below a thin layer, over the radius, within which the change of the resistance, a mean
over a radius, has its maximum. For layers one radius thick it is up to one radius below them."""


def sounding_curves(
    sounding: SoundingTest,
    recorded: xr.Dataset,
    why_none: Sequence[str],
    measured: MeasuredError | None = None,
) -> xr.Dataset:
    """Curves over the depth of the tip, and the strength and stress of the ground at each depth.

    Args:
        sounding: the sounding.
        recorded: curves over `penetration` from the start of a run, which may have ended early. The
            result omits the part above the first depth.
        why_none: reasons why the laws of the error hold for no sample.
        measured: the error measured by further runs, which replaces the laws; None without them.
    """
    after_lead = recorded.isel(penetration=slice(sounding.lead_count, None))
    samples = np.array(sounding.samples[: after_lead.sizes["penetration"]])
    depth = sounding.path.from_depth + (samples + 0.5) * sounding.spacing
    ground = sounding.ground
    strength = ground.strength_at(depth)
    around = ground.mean_strength_around(depth, AVERAGING_DISTANCE * sounding.cone.cone_radius)
    vertical = ground.vertical_stress_at(depth)
    simulated = after_lead.penetration_resistance.values
    error = error_of_samples(sounding, depth, simulated, why_none, measured)
    net, net_error = simulated + error.correction * around, error.half_width
    u2, u2_error = _pore_pressure(sounding, depth, after_lead, error.is_corrected)
    u2_error[np.isnan(net_error) | (measured is not None)] = np.nan
    at_depth = "when the tip is at the depth"
    corrected = "qt - sigma_v0, as simulated and corrected for mesh, speed and window"
    sleeve = f"mean shear stress on the sleeve of 150 cm2 {at_depth}"
    what = f"{HALF_WIDTH}, of a sample; not a number where the error is not known"
    resistance, pressure = "net cone resistance", "excess pore pressure u2"
    of_resistance, of_pressure = (f"uncertainty of the {it}" for it in (resistance, pressure))
    at_tip = "net resistance over strength at the tip"
    over_mean = "net resistance over mean strength around the tip"
    near = f"from {AVERAGING_DISTANCE:g} radii above the tip to {AVERAGING_DISTANCE:g} below it"
    of_error = BY_DEPTH(panel=4, divided_by="net_resistance")
    own = curves(
        "depth",
        (depth, "m", "depth of the tip"),
        net_resistance=(net, "Pa", resistance, corrected, BY_DEPTH(panel=2)),
        net_resistance_uncertainty=(net_error, "Pa", of_resistance, what, of_error),
        total_resistance=(net + vertical, "Pa", "cone resistance", "net, and sigma_v0"),
        sleeve_friction=(after_lead.sleeve_friction.values, "Pa", "sleeve friction", sleeve),
        excess_pore_pressure=(u2, "Pa", pressure, f"behind the shoulder {at_depth}"),
        excess_pore_pressure_uncertainty=(u2_error, "Pa", of_pressure, what),
        cone_factor_at_tip=(net / strength, "1", at_tip, BY_DEPTH(panel=3)),
        cone_factor_around_tip=(net / around, "1", over_mean, near),
        strength=(strength, "Pa", "undrained shear strength", BY_DEPTH(panel=1)),
        vertical_stress=(vertical, "Pa", "in-situ vertical total stress"),
        contact_share=(after_lead.contact_share.values, "1", "share of cone and shaft in contact"),
    )
    told = {REASON: reason(error.reason), LARGEST_PART: error.largest_part}
    return own.merge(recorded.drop_dims("penetration")).assign(told)


def error_of_samples(
    sounding: SoundingTest,
    depth: Floats,
    resistance: Floats,
    why_none: Sequence[str] = (),
    measured: MeasuredError | None = None,
) -> SampleError:
    """The error of samples of the net `resistance` as simulated [Pa], with the tip at `depth` [m].

    Both have shape [n]; for `why_none` and `measured` see `sounding_curves`.
    """
    ground, cone, cell = sounding.ground, sounding.cone, sounding.cell_size
    radius, elsewhere = cone.cone_radius, sounding.stress.stress_anisotropy

    def strength_around(depth: Floats) -> Floats:
        return ground.mean_strength_around(depth, AVERAGING_DISTANCE * radius)

    around = strength_around(depth)
    laws = sounding.domain.error_laws(
        sounding.clay,
        cone,
        cells_per_radius=sounding.cells_per_radius,
        extents=sounding.default_extents,
        approach_inertia=0.0,
        rigidity_index=ground.shear_modulus_at(depth) / ground.strength_at(depth),
        adhesion_factor=ground.adhesion_factor_at(depth, elsewhere=cone.adhesion_factor),
        stress_anisotropy=ground.stress_anisotropy_at(depth, elsewhere=elsewhere),
        poissons_ratio=sounding.clay.poissons_ratio,
        poissons_ratio_reduction=0.0,
        inertia=sounding.dynamic_pressure / around,
        penetration=SAMPLE_SPACING
        * (sounding.lead_count + np.arange(depth.size, dtype=np.float64)),
    )
    surface: dict[str, Condition] = {}
    borders = {BORDER: ground.near_border(depth / radius, radius)}
    if sounding.starts_at_surface:
        passed = sounding.surface_passed
        left = sounding.start_depth + passed
        why = f"surface: the surface is in the window to a depth of {left:.4g} m"
        surface = {why: laws.penetration < passed / radius}
    return sample_error(
        laws,
        depth=depth,
        around=around,
        resistance=resistance,
        shift=strength_around(depth + cell) - strength_around(depth - cell),
        surface=surface,
        borders=borders,
        why_none=why_none,
        goes_on=goes_on(sounding, sounding.soil)
        or (measured is not None and is_of_catalogue(sounding)),
        measured=measured,
    )


def _pore_pressure(
    sounding: SoundingTest, depth: Floats, recorded: xr.Dataset, is_corrected: NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Corrected u2 and its half width [Pa], each of shape [n].

    The half width is NaN where the shaft is not as rough as the face, or the cells grow too much.

    The radial stress is read above the filter, where the strength may be another. The effect of
    this difference of strength on u2 is a part of the half width.
    """
    ground, cone, radius = sounding.ground, sounding.cone, sounding.cone.cone_radius
    elsewhere = sounding.stress.stress_anisotropy
    simulated = recorded.excess_pore_pressure_shoulder.values
    at_shoulder = np.maximum(0.0, depth - cone.penetrometer.cone_height)
    strength = ground.strength_at(at_shoulder)
    of_face = ground.adhesion_factor_at(depth, elsewhere=cone.adhesion_factor)
    as_rough = ground.greatest_adhesion_factor(cone.adhesion_factor)
    of_shaft = cone.shaft_adhesion_factor
    factor, half_width = shoulder_pressure(
        recorded[RADIAL_STRESS].values / strength,
        cell_size=sounding.cell_size / radius,
        adhesion_factor=of_face * (of_shaft / as_rough) if as_rough > 0.0 else of_shaft,
        rigidity_index=ground.shear_modulus_at(at_shoulder) / strength,
        inertia=sounding.dynamic_pressure / strength,
        poissons_ratio=sounding.clay.poissons_ratio,
        stress_anisotropy=ground.stress_anisotropy_at(depth, elsewhere=elsewhere),
        extent_ratio=sounding.domain.extent_ratio(sounding.default_extents),
    )
    above = np.maximum(0.0, at_shoulder - RADIAL_TO * radius)
    change = simulated * (1.0 - ground.strength_at(above) / strength)
    is_as_measured = of_shaft == as_rough and sounding.domain.cell_growth <= LARGEST_GROWTH
    of_sample = np.hypot(np.hypot(half_width * strength, PRESSURE_NOISE * simulated), change)
    return (
        np.where(is_corrected & np.isfinite(factor), factor * strength, simulated),
        np.where(is_corrected & is_as_measured, of_sample, np.nan),
    )


def last_factor(recorded: xr.Dataset) -> dict[str, xr.Variable]:
    """The cone factor at the end of `sounding_curves`: a mean over two radii, to reduce noise."""
    count = min(STEADY_SAMPLES, recorded.sizes["depth"])
    last = recorded.isel(depth=slice(-count, None))
    half_width = last.net_resistance_uncertainty / last.strength
    greatest = float(half_width.max(skipna=False))  # NaN if unknown for a sample
    factor = float(last.cone_factor_at_tip.mean())
    meaning = "cone factor over strength at the tip, at the end"
    over = f"mean over the last {count * SAMPLE_SPACING:g} radii"
    of_samples = f"{HALF_WIDTH}: the greatest of its samples"
    uncertainty = (greatest, "1", "uncertainty of the cone factor at the end", of_samples)
    return labelled(role="headline", last_cone_factor=(factor, "1", meaning, over)) | labelled(
        role="uncertainty", last_cone_factor_uncertainty=uncertainty
    )


def layer_values(
    sounding: SoundingTest, recorded: xr.Dataset, *, is_known: bool
) -> dict[str, xr.Variable]:
    """Scalars of a sounding through the layer that its parameters define.

    There are none without a layer, in a sounding from the surface, and where the curves begin too
    near the layer for a resistance of undisturbed ground, or end before the largest change.
    `is_known` says whether the laws of the error hold.
    """
    layers, clay = sounding.layers, sounding.clay
    top, ratio = layers.layer_top, layers.layer_strength_ratio
    if top is None or layers.profile is not None or ratio == 1.0 or sounding.starts_at_surface:
        return {}
    depth = recorded.depth.values
    distance = (depth - top) / sounding.cone.cone_radius
    thickness = (layers.layer_thickness or math.inf) / sounding.cone.cone_radius
    is_passed = math.isinf(thickness) or distance[-1] > thickness + PAST_LAYER
    if distance[:UNDISTURBED][-1] > -CLEAR_OF_BORDER[0] or not is_passed:
        return {}
    without = clay.undrained_shear_strength + layers.strength_gradient * depth
    factor = recorded.net_resistance.values / without
    share = change_of_resistance(factor, ratio)
    if math.isinf(thickness):
        before, behind = _first(-distance, share > FELT), _first(distance, share > 1.0 - FELT)
        changed = f"the resistance has changed by {FELT:.0%} of its whole change"
        lacks = f"the resistance lacks {FELT:.0%} of its whole change"
        above = "way above the border from which on it is felt, over cone radius"
        below = "way below the border up to which it is felt, over cone radius"
        return labelled(
            felt_before=(before, "1", above, changed), felt_behind=(behind, "1", below, lacks)
        )
    in_layer = (distance > 0.0) & (distance < thickness + 5.0)
    reached = float(np.nanmax(share[in_layer]))
    half_width = _half_width(sounding, reached) if is_known else math.nan
    meaning = "share of the layer's resistance that is reached"
    what = "greatest change, mean over a radius, over that in a layer without end"
    of_share = "uncertainty of the share of the layer's resistance"
    return labelled(role="headline", layer_share=(reached, "1", meaning, what)) | labelled(
        role="uncertainty", layer_share_uncertainty=(half_width, "1", of_share, HALF_WIDTH)
    )


def _half_width(sounding: SoundingTest, reached: float) -> float:
    """Half width of `reached`, the share s of a layer's full resistance."""
    layers = sounding.layers
    assert layers.layer_thickness is not None
    ratio = layers.layer_strength_ratio
    # Errors of mesh and speed are in both resistances and cancel in their ratio.
    of_resistances = abs((1.0 + reached * (ratio - 1.0)) / (ratio - 1.0)) * NOISE
    # The places of the borders are known to a cell. In a layer of thickness t the share
    # s = 1 - exp(-t / l) grows with t by -(1 - s) ln(1 - s) / t.
    lacking = 1.0 - min(max(reached, 0.0), 1.0 - NOISE)
    cell = sounding.cell_size / layers.layer_thickness
    return math.hypot(of_resistances, -lacking * math.log(lacking) * cell)


def change_of_resistance(factor: Floats, ratio: float) -> Floats:
    """Change of the resistance over its whole change from one soil to the other, shape [n].

    It is a running mean over a radius. `factor` is the net resistance over the strength of the
    ground without the layer, `ratio` the strength of the layer over that strength.
    """
    undisturbed = float(np.mean(factor[:UNDISTURBED]))
    smooth = np.convolve(factor, np.full(SMOOTHED, 1.0 / SMOOTHED), mode="same")
    half = SMOOTHED // 2
    smooth[:half], smooth[len(smooth) - half :] = np.nan, np.nan
    return (smooth / undisturbed - 1.0) / (ratio - 1.0)


def _first(position: Floats, reached: NDArray[np.bool_]) -> float:
    """Position of the first sample of the first radius over which `reached` holds throughout."""
    window = round(1.0 / SAMPLE_SPACING)
    lasting = np.convolve(reached, np.ones(window), mode="valid") >= window
    return float(position[int(np.argmax(lasting))]) if lasting.any() else math.nan
