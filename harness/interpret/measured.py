"""A measured cone test: corrected resistances and ratios.

    qt = qc + (1 - a) u2,   qnet = qt - sigma_v0,   Bq = (u2 - u0) / qnet,   Fr = fs / qnet
    Ic = sqrt((3.47 - lg(qnet / sigma'_v0))^2 + (1.22 + lg(100 Fr))^2)

a is the net area ratio (EN ISO 22476-1; Lunne, Robertson & Powell 1997; Ic: Robertson 2009, with
stress exponent 1, as in clay), all as commonly quoted.
"""

import numpy as np
import scipy  # loads integrators where they are first used: a run waits for none
import xarray as xr

from harness.interpret.columns import read_columns
from harness.interpret.forms import COLUMNS, WATER, ByDepth
from harness.interpret.site import MeasuredTest
from harness.interpret.tables.model_factor import typical
from harness.study.tables import StudyError
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves

CLAY_INDEX = 2.6
"""Least Ic of soil that behaves as clay (Robertson 2009, as commonly quoted)."""
UNDRAINED_BQ = 0.5
"""With this Bq or more, soil is clay whatever its Ic: soil that drains has less (chart of
Senneset, Sandven & Janbu 1989, as commonly quoted). Ic does not depend on u2, and sensitive clay
has little fs, so its Ic may be too low for clay."""
BQ_RANGE = -0.3, 1.4
"""Range of Bq in clay."""
ROUNDING = 1e-6
"""Rounding error of a depth [m]."""
FLAT_LENGTH, FLAT_SHARE = 1.5, 0.3
"""A filter is locked or not saturated if over this length [m] the deviation of its readings is
below this share of that of hydrostatic pressure, while qc has more than hydrostatic pressure;
except in sand above the water table, where it has nothing to read."""
DRY = 500.0
"""u0 [Pa] above the water table is below this."""
LEAST_SHARE_ABOVE = 0.5
"""Least share of rows with qt above sigma_v0; with fewer the unit of qc is probably wrong."""
NO_INDEX, OTHER_LAYER = "no fs and it may be sand", "between border told and found"
REASONS = (
    "used",
    "pre-drilled",
    "value missing",
    "no layer",
    "filter not saturated",
    "not undrained clay",
    "Delta beyond the table",
    "qnet not above 0",
    NO_INDEX,
    OTHER_LAYER,
)
"""Reasons why a depth has no strength, by number; with the first it has one."""


def measured(test: MeasuredTest) -> xr.Dataset:
    """The corrected test of a site by depth; missing values are NaN.

    `reason` has indices of `REASONS`, without those that depend on layers. Attributes: `notes` on
    the test file, `cone_radius` [m], and `drawn_share`, the share of u2 in qt if u2 is not measured
    and each draw has its own, or else 0.
    """
    read = read_columns(test)
    depth, qc, fs, u2 = (read.values[name] for name in COLUMNS)
    u0 = water_pressure(test, depth)
    stress = vertical_stress(test, depth)
    by_u2, notes = 1.0 - read.area_ratio, [*read.notes]
    if not u2.any():
        u2 = np.full_like(u2, np.nan)
        notes.append("u2 is 0 in all rows, and taken as not measured")
    drawn = 0.0
    if by_u2 > 0.0 and np.isnan(u2).all():
        drawn, usual = by_u2, typical("Bq")
        net = (qc + by_u2 * u0 - stress) / (1.0 - by_u2 * usual)
        notes.append(
            f"u2 is not measured: each draw has its own for the correction by area_ratio = "
            f"{read.area_ratio:g}; qt and qnet as given here are with Bq = {usual:.2g}"
        )
    else:
        net = qc + (by_u2 * u2 if by_u2 > 0.0 else 0.0) - stress
    qt = net + stress
    qt_error = np.hypot(error_of(test, "qc", qc), by_u2 * np.nan_to_num(error_of(test, "u2", u2)))
    there = np.isfinite(net) & (depth >= read.pre_drilled)
    share_above = float(np.mean(net[there] > 0.0)) if there.any() else 1.0
    if share_above < LEAST_SHARE_ABOVE:
        raise StudyError(
            f"{test.file}: only in {share_above:.0%} of the rows is qt above sigma_v0, which is at "
            f"most {np.nanmax(stress):.3g} Pa; look at the unit of qc"
        )
    effective = np.where(depth > 0.0, stress - u0, 1.0)
    if (effective <= 0.0).any():
        first = depth[effective <= 0.0][0]
        raise StudyError(
            f"{test.where} unit_weight: sigma_v0 is not above u0 from {first:g} m on; it is the "
            "weight of soil with its water, 14 to 22 kN/m3"
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio, friction = (u2 - u0) / net, np.where(fs > 0.0, fs / net, np.nan)
        by_tip = 3.47 - np.log10(net / effective)
        index = np.hypot(by_tip, 1.22 + np.log10(100.0 * friction))
    low, high = BQ_RANGE
    may_drain = ~(ratio >= UNDRAINED_BQ)
    is_sand = may_drain & (index < CLAY_INDEX)
    may_be_sand = may_drain & np.isnan(friction) & (by_tip < CLAY_INDEX)
    dry = (is_sand | may_be_sand) & (u0 < DRY)
    reasons = {
        "pre-drilled": depth < read.pre_drilled,
        "value missing": ~np.isfinite(net),
        "qnet not above 0": net <= 0.0,
        "filter not saturated": _flat(depth, u2, qc) & ~dry,
        "not undrained clay": is_sand | (ratio < low) | (ratio > high),
        NO_INDEX: may_be_sand,
    }  # the first that holds is taken
    reason = np.select(list(reasons.values()), [REASONS.index(it) for it in reasons])
    found = curves(
        "depth",
        (depth, "m", "depth of the tip"),
        cone_resistance=(qc, "Pa", "cone resistance qc as measured"),
        sleeve_friction=(fs, "Pa", "sleeve friction fs as measured"),
        pore_pressure=(u2, "Pa", "pore pressure u2 as measured"),
        water_pressure=(u0, "Pa", "water pressure u0 before"),
        vertical_stress=(stress, "Pa", "total vertical stress before"),
        total_resistance=(qt, "Pa", "corrected cone resistance qt"),
        total_resistance_error=(qt_error, "Pa", "half width of 95 % of qt"),
        net_resistance=(net, "Pa", "net resistance qnet"),
        pore_pressure_ratio=(ratio, "1", "pore pressure ratio Bq"),
        friction_ratio=(friction, "1", "friction ratio Fr = fs / qnet"),
        soil_index=(index, "1", "soil behaviour type index Ic"),
    )
    flags = {
        "long_name": "why there is no strength",
        "flag_values": np.arange(len(REASONS), dtype=np.int8),
        "flag_meanings": " ".join(text.replace(" ", "_") for text in REASONS),
    }
    found["reason"] = xr.Variable("depth", reason.astype(np.int8), flags)
    return found.assign_attrs(
        notes="; ".join(notes), cone_radius=read.cone_radius, drawn_share=drawn
    )


def error_of(test: MeasuredTest, name: str, values: Floats) -> Floats:
    """Half width of 95 % of qc, fs or u2 [Pa]."""
    least, share = test.accuracy[name]
    return np.maximum(least, share * np.abs(values))


def water_pressure(test: MeasuredTest, depth: Floats) -> Floats:
    """Pressure of the water before the test [Pa]."""
    if not isinstance(test.water, ByDepth):
        return WATER * np.maximum(0.0, depth - test.water)
    first, last = test.water.depth[0], test.water.depth[-1]
    if first > depth[0] or last < depth[-1]:
        raise StudyError(
            f"{test.where} u0: is given from {first:g} to {last:g} m, the test goes from "
            f"{depth[0]:g} to {depth[-1]:g} m; must be given for all of it"
        )
    return np.interp(depth, test.water.depth, test.water.value)


def vertical_stress(test: MeasuredTest, depth: Floats) -> Floats:
    """Total vertical stress [Pa] by the median unit weight, with water that is on the ground."""
    weight, water = test.unit_weight, test.water
    if not isinstance(water, ByDepth):
        at_surface = -WATER * water
    else:
        at_surface = float(np.interp(0.0, water.depth, water.value, left=0.0))
    above = max(0.0, at_surface)  # suction weighs nothing
    if not isinstance(weight, ByDepth):
        return above + weight.at(0.5) * depth
    # The weight is linear between the given depths, so fine steps integrate it well enough.
    fine = np.linspace(0.0, depth[-1], 4001)
    values = np.interp(fine, weight.depth, weight.value)
    total = scipy.integrate.cumulative_trapezoid(values, fine, initial=0.0)
    stress: Floats = above + np.interp(depth, fine, total)
    return stress


def _flat(depth: Floats, u2: Floats, qc: Floats) -> np.ndarray:
    """Where the pore pressure hardly changes over a length in which the resistance does."""
    flat = np.zeros(len(depth), dtype=bool)
    after = depth + FLAT_LENGTH - ROUNDING
    begins = np.flatnonzero(after <= depth[-1])
    ends = np.searchsorted(depth, after[begins] + 2.0 * ROUNDING, side="right")
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        piece = slice(begin, end)
        if end - begin > 5:
            hydrostatic = WATER * depth[piece].std()
            still = u2[piece].std() < FLAT_SHARE * hydrostatic
            flat[piece] |= still and qc[piece].std() > hydrostatic
    return flat
