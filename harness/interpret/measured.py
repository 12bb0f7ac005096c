"""A measured cone test: its file, and the resistances that follow from what was measured.

    qt = qc + (1 - a) u2,   qnet = qt - sigma_v0,   Bq = (u2 - u0) / qnet,   Fr = fs / qnet
    Ic = sqrt((3.47 - lg(qnet / sigma'_v0))^2 + (1.22 + lg(100 Fr))^2)

a is the net area ratio (EN ISO 22476-1; Lunne, Robertson & Powell 1997; Ic: Robertson 2009, with
stress exponent 1, as in clay), all as commonly quoted.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.interpret.site import ByDepth, MeasuredTest
from harness.study.tables import StudyError
from mpm_warp.grid.fitted import Floats
from mpm_warp.parameters import nearest_name

NAMES: Mapping[str, tuple[str, ...]] = {
    "depth": ("depth", "z", "penetration", "sondeerlengte", "penetrationlength"),
    "qc": ("qc", "cone_resistance", "coneresistance", "tip"),
    "fs": ("fs", "sleeve_friction", "localfriction", "friction"),
    "u2": ("u2", "u", "pore_pressure", "porepressureu2"),
}
"""What each column may be called, without regard to capitals."""
UNITS: Mapping[str, Mapping[str, float]] = {
    "depth": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "qc": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5},
}
"""Units of depths and of pressures, and what they are in SI units."""
WATER = 9.81e3
"""Unit weight of water [N/m3]."""
LARGEST_FILE = 50_000_000
LARGEST_PRESSURE = 200e6
"""What no cone bears [Pa]."""
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


def measured(test: MeasuredTest) -> Measured:
    """The test of a site, corrected.

    Raises:
        StudyError: the file cannot be read, or what it holds cannot be.
    """
    columns = _checked(test, read_columns(test))
    depth, qc, fs, u2 = (columns[name] for name in NAMES)
    if isinstance(test.water, ByDepth):
        u0 = np.interp(depth, test.water.depth, test.water.value)
    else:
        u0 = WATER * np.maximum(0.0, depth - test.water)
    stress = vertical_stress(test, depth)
    errors = {
        name: np.maximum(least, share * np.abs(columns[name]))
        for name, (least, share) in test.accuracy.items()
    }
    qt = qc + (1.0 - test.area_ratio) * u2 if test.area_ratio < 1.0 else qc
    errors["qt"] = np.hypot(errors["qc"], (1.0 - test.area_ratio) * np.nan_to_num(errors["u2"]))
    net = qt - stress
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio, friction = (u2 - u0) / net, fs / net
        effective = np.maximum(stress - u0, 1.0)
        index = np.hypot(3.47 - np.log10(net / effective), 1.22 + np.log10(100.0 * friction))
    reason = np.zeros(len(depth), dtype=np.int8)
    low, high = BQ_RANGE
    drained = (index < CLAY_INDEX) | (ratio < low) | (ratio > high)
    reason[drained] = REASONS.index("not undrained clay")
    reason[_flat(depth, u2, qc)] = REASONS.index("filter not saturated")
    reason[~np.isfinite(net) | ~(net > 0.0)] = REASONS.index("value missing")
    reason[depth < test.pre_drilled] = REASONS.index("pre-drilled")
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


def read_columns(test: MeasuredTest) -> dict[str, Floats]:
    """Depth, qc, fs and u2 of the file in SI units; u2 is all missing where it has none.

    Raises:
        StudyError: the file is missing or too large, or lacks a column.
    """
    path = test.file
    if not path.is_file():
        raise StudyError(f"{path}: no such file")
    if path.stat().st_size > LARGEST_FILE:
        raise StudyError(
            f"{path}: has {path.stat().st_size} bytes; a test has at most {LARGEST_FILE}"
        )
    header, rows = _rows(path)
    found = _found(path, header, test.columns)
    columns = {}
    for name, (place, told_unit) in found.items():
        known = UNITS["depth" if name == "depth" else "qc"]
        unit = test.units.get(name, told_unit)
        if unit not in known:
            told = f"has unit {unit!r}" if unit else "has no unit"
            raise StudyError(
                f"{path}: column {header[place]!r} {told}; allowed: {', '.join(known)}, in the "
                f'header as "{name} [{next(iter(known))}]", or under units of the site file'
            )
        columns[name] = known[unit] * _numbers(path, header[place], rows, place, test.missing)
    return columns


def _rows(path: Path) -> tuple[list[str], list[list[str]]]:
    """The header and the rows of a CSV file, whatever parts its values."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise StudyError(f"{path}: not UTF-8 at byte {error.start}") from None
    lines = [it for it in text.splitlines() if it.strip() and not it.lstrip().startswith("#")]
    if len(lines) < 2:
        raise StudyError(f"{path}: has no rows below its header")
    parting = next((it for it in ("\t", ";", ",") if it in lines[0]), None)
    header, *rows = csv.reader(lines, delimiter=parting or ",")
    return [it.strip() for it in header], rows


def _found(path: Path, header: list[str], given: Mapping[str, str]) -> dict[str, tuple[int, str]]:
    """Place and unit of each column that the file has."""
    split = [re.fullmatch(r"(.*?)\s*(?:[\[(]([^\])]*)[\])])?", it) for it in header]
    names = [(it[1] if it else "").strip().lower() for it in split]
    found = {}
    for name, usual in NAMES.items():
        wanted = given.get(name)
        places = [
            place
            for place, own in enumerate(names)
            if (own in usual if wanted is None else wanted in (header[place], split[place][1]))  # type: ignore[index]
        ]
        if len(places) > 1:
            raise StudyError(f"{path}: column {name} is there {len(places)} times; name one")
        if places:
            found[name] = places[0], (split[places[0]] or [""] * 3)[2] or ""
        elif name != "u2" or wanted is not None:
            near = nearest_name(wanted or name, names)
            raise StudyError(
                f"{path}: has no column {wanted or name!r}{near}; name it under columns of the "
                f'site file, as columns = {{ {name} = "..." }}'
            )
    return found


def _numbers(
    path: Path, title: str, rows: list[list[str]], place: int, missing: tuple[float, ...]
) -> Floats:
    values = np.full(len(rows), np.nan)
    for row, cells in enumerate(rows):
        cell = cells[place].strip() if place < len(cells) else ""
        if cell:
            try:
                values[row] = float(cell)
            except ValueError:
                comma = "; a number has a point" if re.fullmatch(r"-?\d+,\d+", cell) else ""
                raise StudyError(
                    f"{path}: row {row + 2}, column {title!r}: {cell[:40]!r} is no number{comma}"
                ) from None
    values[np.isin(values, missing)] = np.nan
    return values


def _checked(test: MeasuredTest, columns: dict[str, Floats]) -> dict[str, Floats]:
    """The columns, where they can be a cone test; each with what is missing as not a number."""
    path, depth = test.file, columns["depth"]
    if np.isnan(depth).any():
        raise StudyError(f"{path}: depth is missing in row {int(np.isnan(depth).argmax()) + 2}")
    falls = np.flatnonzero(np.diff(depth) <= 0.0)
    if len(falls):
        row = int(falls[0]) + 1
        raise StudyError(
            f"{path}: row {row + 2}: depth goes back from {depth[row - 1]:g} to {depth[row]:g} m"
        )
    if depth[0] < 0.0:
        raise StudyError(
            f"{path}: depth {depth[0]:g} m is above the ground; it is positive downward"
        )
    if "u2" not in columns:
        if test.area_ratio < 1.0:
            raise StudyError(
                f"{path}: has no u2, which the correction by area_ratio = {test.area_ratio:g} "
                "needs; area_ratio = 1 takes qc as corrected"
            )
        columns["u2"] = np.full_like(depth, np.nan)
    for name in ("qc", "fs", "u2"):
        values = columns[name]
        wrong = np.flatnonzero(np.abs(values) > LARGEST_PRESSURE)
        if len(wrong):
            raise StudyError(
                f"{path}: row {wrong[0] + 2}: {name} = {values[wrong[0]]:g} Pa is more than any "
                "cone bears; look at its unit, or at `missing`"
            )
    below = np.flatnonzero(columns["qc"] < 0.0)
    if len(below):
        raise StudyError(
            f"{path}: row {below[0] + 2}: qc = {columns['qc'][below[0]]:g} Pa must be >= 0; a code "
            "for no value belongs under `missing`"
        )
    return columns


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
