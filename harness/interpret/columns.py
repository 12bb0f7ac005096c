"""Depth, qc, fs and u2 of a measured test in SI units, whatever file they come from.

Rows in which the tip stands or moves back a little, at a change of rods, are left out with a note.
If the file has the length l of the rods and the inclination of the cone, each step of depth is

    dz = dl / sqrt(1 + tan^2 a + tan^2 b)

with inclinations a and b in two planes, or a alone (EN ISO 22476-1, as commonly quoted). Values
that no cone test can have are refused in a line with file, line, value and what is allowed; single
ones are left out with a note.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy  # loads integrators where they are first used: a run waits for none

from harness.interpret.forms import AXES
from harness.interpret.plausible import check_units, without_lost
from harness.interpret.reading.contents import TestFile, cell_number
from harness.interpret.reading.files import read_file
from harness.interpret.reading.headings import columns_in, is_of_rods
from harness.interpret.site import LARGEST_DEPTH, MeasuredTest
from harness.study.tables import StudyError
from mpm_warp.fields.flat import parameters_of
from mpm_warp.grid.fitted import Floats

REBOUND = 0.05
"""The tip may move back by so much at a change of rods [m]."""
NO_VALUE = -999.0, -9999.0, -99999.0, -999999.0
"""Usual codes for a missing value. A measured pressure of -999 kPa looks the same, so the test file
or the site file has to say which it is."""
GAP = 0.25
"""Larger steps of depth [m] are noted as gaps, if they are also above five times the median."""
NOT_THERE = {"fs": "only Bq and the tip show what is clay", "u2": "there is no Bq"}
"""Columns that a test may lack, and what is lost without them."""
MOST_ROWS = 20_000
USUAL_AREA = 10.0
"""Cross-section of a cone if neither file states it [cm2]."""


@dataclass(frozen=True, eq=False)
class Columns:
    """A measured test; data of the cone are from the site file, or else from the test file."""

    values: dict[str, Floats]  # by name, in SI units, NaN where missing, shape [n]
    area_ratio: float
    pre_drilled: float  # [m]
    cone_radius: float  # [m]
    notes: tuple[str, ...]  # what is unusual in the file, each a line


def read_columns(test: MeasuredTest) -> Columns:
    """The columns of a test file, by increasing depth; fs and u2 are NaN if the file lacks them."""
    path = test.file
    file = read_file(path, test.sounding)
    if len(file.rows) > MOST_ROWS:
        raise StudyError(f"{path}: has {len(file.rows)} rows; a test has at most {MOST_ROWS}")
    area_ratio, pre_drilled, cone_radius, notes = _of_the_cone(test, file)
    for number, cells in file.rows:
        if len(cells) > len(file.headings) and any(cells[len(file.headings) :]):
            raise StudyError(
                f"{path}: {file.row} {number}: has {len(cells)} values, the header names "
                f"{len(file.headings)}; numbers with a decimal comma must be separated by ; or tab"
            )
    found = columns_in(path, file.headings, test.columns, test.units)
    values = {
        name: size * _numbers(path, file, place, test.missing)
        for name, (place, size) in found.items()
    }
    places = np.array([f"{file.row} {number}" for number, _ in file.rows])
    has_depth = _with_depth(path, file.rows, found["depth"][0], values["depth"], places, notes)
    places, values = places[has_depth], {name: value[has_depth] for name, value in values.items()}
    if test.ground_level is not None:
        values["depth"] = np.round(test.ground_level - values["depth"], 9)  # 0.3 and 0.6 are 0.9
    order = np.arange(len(places)) if file.in_order else np.argsort(values["depth"], kind="stable")
    kept = order[_downward(path, values["depth"][order], places[order], notes)]
    places, values = places[kept], {name: value[kept] for name, value in values.items()}
    for name, lost in NOT_THERE.items():
        if name not in values:
            values[name] = np.full_like(values["depth"], np.nan)
            notes.append(f'no column is taken as {name} (columns = {{ {name} = "..." }}): {lost}')
    without_lost(test, places, values, notes)
    units = {it: test.units.get(it, file.headings[place].unit) for it, (place, _) in found.items()}
    angles = [values.pop(name) for name in AXES if name in values]
    of_rods = is_of_rods(file.headings[found["depth"][0]])
    if of_rods and not angles:
        notes.append("depth is the length of the rods, as the file has no inclination")
    elif of_rods or AXES[0] in test.columns:
        length = values["depth"]
        values["depth"] = _corrected(length, angles)
        less = float(length[-1] - values["depth"][-1])
        notes.append(f"depth corrected by inclination, by {less:.2g} m at the end")
    elif angles:
        notes.append("depth is taken as corrected by inclination")
    check_units(test, values, units, notes)
    return Columns(values, area_ratio, pre_drilled, cone_radius, tuple(notes))


def _with_depth(
    path: Path,
    rows: Sequence[tuple[int, list[str]]],
    column: int,
    depth: Floats,
    places: np.ndarray,
    notes: list[str],
) -> np.ndarray:
    """The rows that have a depth; a code for a missing depth is noted, an empty cell is refused."""
    found = ~np.isnan(depth)
    for place, (_, cells), is_there in zip(places, rows, found, strict=True):
        if not is_there and (not cells[column].strip() or not found.any()):
            raise StudyError(f"{path}: {place}: depth is missing")
    if not found.all():
        notes.append(f"rows left out whose depth is a code for no value: {np.sum(~found)}")
    return found


def _of_the_cone(test: MeasuredTest, file: TestFile) -> tuple[float, float, float, list[str]]:
    """Area ratio, pre-drilled depth and radius by the site file or the test file, and notes."""
    values, notes, declared = [], list(file.notes), parameters_of(MeasuredTest)
    for key in ("area_ratio", "pre_drilled", "cone_area"):
        value, stated = getattr(test, key), file.stated.get(key)
        if value is None and stated is not None:
            value = stated
            notes.append(f"{key} = {value:g} by the file")
            if math.isnan(value):
                raise StudyError(
                    f"{test.file}: states {key} by a text that is no number; the site file may "
                    "state it"
                )
            if not declared[key].bounds.holds(value, value):
                raise StudyError(
                    f"{test.file}: {key} = {value:g}: must be {declared[key].bounds.allowed}; "
                    "the site file may state another"
                )
        elif stated is not None and stated != value:
            notes.append(f"{key} = {value:g} by the site file, {stated:g} by the file")
        values.append(value)
    level = file.stated.get("water_level", test.water)
    if level != test.water:
        notes.append(f"the file has a water level of {level:g} m")
    area_ratio, pre_drilled, cone_area = values
    if area_ratio is None:
        raise StudyError(
            f"{test.where} area_ratio: is missing; it stands on the cone's calibration sheet, "
            "0.55 to 0.9; 1 where the file holds corrected resistances"
        )
    cone_radius = math.sqrt(1e-4 * (cone_area or USUAL_AREA) / math.pi)
    return area_ratio, pre_drilled or 0.0, cone_radius, notes


def _numbers(path: Path, file: TestFile, place: int, missing: tuple[float, ...] | None) -> Floats:
    """The numbers of a column, NaN for missing values."""
    heading, values = file.headings[place], np.full(len(file.rows), np.nan)
    for row, (number, cells) in enumerate(file.rows):
        if place >= len(cells):
            raise StudyError(
                f"{path}: {file.row} {number}: has {len(cells)} values; must have one for each of "
                f"the {len(file.headings)} columns"
            )
        cell = cells[place].strip()
        if cell:
            value = cell_number(cell)
            if value is None:
                remedy = (
                    "; a number has a point"
                    if re.fullmatch(r"-?\d+,\d+", cell)
                    else "; it is written as 1.5 or 1.5e-3"
                    if re.search(r"\d", cell)
                    else "; leave the cell empty where there is no value"
                )
                raise StudyError(
                    f"{path}: {file.row} {number}, column {heading.title!r}: {cell[:40]!r} is no "
                    f"number{remedy}"
                )
            values[row] = value
    values[np.isin(values, (*(missing or ()), *heading.missing))] = np.nan
    if missing != () and (codes := np.isin(values, NO_VALUE)).any():
        row = int(np.argmax(codes))
        raise StudyError(
            f"{path}: {file.row} {file.rows[row][0]}, column {heading.title!r}: {values[row]:g} is "
            f"a usual code for no value: missing = [{values[row]:g}] in the site file says so, "
            "missing = [] that all such values were measured"
        )
    return values


def _downward(path: Path, depth: Floats, places: np.ndarray, notes: list[str]) -> np.ndarray:
    """The rows in which the tip is deeper than in all earlier ones; others and gaps are noted."""
    if depth[0] < 0.0:
        raise StudyError(
            f"{path}: {places[0]}: depth {depth[0]:g} m is above the ground; where the file has "
            "levels, or depths that are negative downward, give ground_level, 0 for the latter; "
            "where only the first rows are above the ground, take them out"
        )
    if depth[-1] > LARGEST_DEPTH:
        raise StudyError(
            f"{path}: {places[-1]}: depth {depth[-1]:g} m must be <= {LARGEST_DEPTH:g}; look at "
            "its unit"
        )
    levels = (
        "; where the file has levels, give ground_level; where its first row is the deepest, "
        "reverse the order of rows"
        if depth[-1] < depth[0]
        else ""
    )
    again = "; where another push begins here, part the file, as each push is a test of its own"
    before = np.maximum.accumulate(np.concatenate([[-1.0], depth[:-1]]))
    kept, back = depth > before, before - depth
    if back.max() > REBOUND:
        row = int(np.argmax(back > REBOUND))
        raise StudyError(
            f"{path}: {places[row]}: depth goes back from {before[row]:g} to {depth[row]:g} m; at "
            f"most {REBOUND:g} m are allowed, for a change of rods{levels or again}"
        )
    if not kept.all():
        notes.append(f"rows left out in which the tip stands or goes back: {np.sum(~kept)}")
    step = np.diff(depth[kept])
    wide = step > max(GAP, 5.0 * float(np.median(step)) if len(step) else 0.0)
    for top, length in zip(depth[kept][:-1][wide], step[wide], strict=True):
        notes.append(f"no values from {top:g} to {top + length:g} m")
    return kept


def _corrected(length: Floats, angles: Sequence[Floats]) -> Floats:
    """Depths of lengths of rods, vertical above the first row; missing angles are interpolated."""
    slope = np.zeros_like(length)
    for angle in angles:
        known = np.isfinite(angle)
        if known.any():
            slope += np.tan(np.interp(length, length[known], angle[known])) ** 2
    cosine = 1.0 / np.sqrt(1.0 + slope)
    depth: Floats = length[0] + scipy.integrate.cumulative_trapezoid(cosine, length, initial=0.0)
    return depth
