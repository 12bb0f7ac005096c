"""A measured cone test: the resistances that follow from what was measured.

    qt = qc + (1 - a) u2,   qnet = qt - sigma_v0,   Bq = (u2 - u0) / qnet,   Fr = fs / qnet
    Ic = sqrt((3.47 - lg(qnet / sigma'_v0))^2 + (1.22 + lg(100 Fr))^2)

a is the net area ratio (EN ISO 22476-1; Lunne, Robertson & Powell 1997; Ic: Robertson 2009, with
stress exponent 1, as in clay), all as commonly quoted.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from harness.interpret.columns import read_columns
from harness.interpret.keys import COLUMNS
from harness.interpret.site import ByDepth, MeasuredTest
from harness.study.tables import StudyError
from mpm_warp.grid.fitted import Floats

WATER = 9.81e3
"""Unit weight of water [N/m3]."""
CLAY_INDEX = 2.6
"""Ic from which soil behaves as clay (Robertson 2009, as commonly quoted)."""
BQ_RANGE = -0.3, 1.4
"""Pore pressure ratios between which a test in clay lies."""
FLAT_LENGTH, FLAT_RANGE = 1.0, 500.0
"""A filter that reads the same within so much [Pa] over such a length [m] is not saturated."""
USED = "used"
REASONS = (
    USED,
    "pre-drilled",
    "value missing",
    "no layer",
    "filter not saturated",
    "not undrained clay",
    "Delta beyond the table",
    "qnet not above 0",
)
"""Why a depth has no strength, by number; the first has one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """A test by depth, in SI units; arrays of shape [n], not a number where a value is missing.

    Attributes:
        depth: of the tip [m], rising.
        qc, fs, u2: as measured [Pa].
        u0: water pressure before [Pa].
        vertical_stress: total [Pa], with the median of the unit weight.
        qt, net: corrected and net resistance [Pa].
        pore_pressure_ratio, friction_ratio, soil_index: Bq, Fr, Ic.
        errors: half widths of 95 % of qc, fs, u2 and qt [Pa], each the same share of its error
            along the whole test.
        reason: numbers of `REASONS`; the layers' are not among them yet.
        notes: what a reader must know of the file.
    """

    depth: Floats
    qc: Floats
    fs: Floats
    u2: Floats
    u0: Floats
    vertical_stress: Floats
    qt: Floats
    net: Floats
    pore_pressure_ratio: Floats
    friction_ratio: Floats
    soil_index: Floats
    errors: Mapping[str, Floats]
    reason: np.ndarray
    notes: tuple[str, ...]


def measured(test: MeasuredTest) -> Measured:
    """The test of a site, corrected."""
    read = read_columns(test)
    columns, area_ratio = read.values, read.area_ratio
    depth, qc, fs, u2 = (columns[name] for name in COLUMNS)
    if isinstance(test.water, ByDepth):
        u0 = np.interp(depth, test.water.depth, test.water.value)
    else:
        u0 = WATER * np.maximum(0.0, depth - test.water)
    stress = vertical_stress(test, depth)
    errors = {
        name: np.maximum(least, share * np.abs(columns[name]))
        for name, (least, share) in test.accuracy.items()
    }
    qt = qc + (1.0 - area_ratio) * u2 if area_ratio < 1.0 else qc
    errors["qt"] = np.hypot(errors["qc"], (1.0 - area_ratio) * np.nan_to_num(errors["u2"]))
    net = qt - stress
    if not (net > 0.0).any():
        raise StudyError(
            f"{test.file}: qt is nowhere above sigma_v0, {np.nanmax(stress):.3g} Pa at most; look "
            "at the unit of qc"
        )
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio, friction = (u2 - u0) / net, fs / net
        effective = np.maximum(stress - u0, 1.0)
        index = np.hypot(3.47 - np.log10(net / effective), 1.22 + np.log10(100.0 * friction))
    reason = np.zeros(len(depth), dtype=np.int8)
    low, high = BQ_RANGE
    drained = (index < CLAY_INDEX) | (ratio < low) | (ratio > high)
    reason[drained] = REASONS.index("not undrained clay")
    reason[_flat(depth, u2, qc)] = REASONS.index("filter not saturated")
    reason[net <= 0.0] = REASONS.index("qnet not above 0")
    reason[~np.isfinite(net)] = REASONS.index("value missing")
    reason[depth < read.pre_drilled] = REASONS.index("pre-drilled")
    return Measured(
        depth=depth,
        qc=qc,
        fs=fs,
        u2=u2,
        u0=u0,
        vertical_stress=stress,
        qt=qt,
        net=net,
        pore_pressure_ratio=ratio,
        friction_ratio=friction,
        soil_index=index,
        errors=errors,
        reason=reason,
        notes=read.notes,
    )


def vertical_stress(test: MeasuredTest, depth: Floats) -> Floats:
    """Total vertical stress [Pa], with the median unit weight where that is not known exactly."""
    weight = test.unit_weight
    if not isinstance(weight, ByDepth):
        return float(weight.quantiles(np.array(0.5))) * depth
    # Linear between the depths given: fine steps integrate it to rounding of what is known.
    fine = np.linspace(0.0, depth[-1], 4001)
    values = np.interp(fine, weight.depth, weight.value)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(fine))])
    stress: Floats = np.interp(depth, fine, total)
    return stress


def _flat(depth: Floats, u2: Floats, qc: Floats) -> np.ndarray:
    """Where the pore pressure stays the same over a length in which the resistance does not."""
    flat = np.zeros(len(depth), dtype=bool)
    ends = np.searchsorted(depth, depth + FLAT_LENGTH)
    for begin, end in enumerate(ends):
        piece = slice(begin, end)
        if end < len(depth) and end - begin > 5:
            still = np.ptp(u2[piece]) < FLAT_RANGE and np.ptp(qc[piece]) > 10.0 * FLAT_RANGE
            flat[piece] |= still
    return flat
