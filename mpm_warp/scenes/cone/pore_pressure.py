"""The excess pore pressure beside a penetrometer, where a piezocone measures it.

It is the change of the mean total stress of the soil at the surface: elastic, perfectly plastic,
undrained clay has no other excess pore pressure. Each reading is a weighted sum over cells.

    u1  a line through the first two columns of cells, extrapolated to the face
    u2  a + b ln(z/R + 0.15), z the height above the shoulder, fitted to the pressure of the first
        column from the third row above the shoulder on; its mean over the height of the filter
    u3  the first column, linear between the centres of its cells

At the shoulder the pressure jumps from 9 su on the face to below 6 su (Ir 100). Every mesh smears
this jump over two and a half rows; above them all meshes give the same fall.

So where the law of its error holds, u2 follows not from this reading but from the radial stress on
the shaft some radii above the shoulder (`mpm_warp.uncertainty.pore_pressure`). This stress hardly
depends on the mesh: unlike the pressure, it is the same at the shaft and in the cells beside it.
"""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.parts.window import Window
from mpm_warp.results import Quantity, curves, labelled
from mpm_warp.sampling import PORE_PRESSURE_IS, Samples, excess_pore_pressure, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.cone.interface import Interface
from mpm_warp.scenes.cone.penetration import penetration_axis, without_slowing
from mpm_warp.scenes.cone.penetrometer import (
    SLEEVE_BEGIN,
    SLEEVE_LENGTH,
    Penetrometer,
    PenetrometerContact,
)
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.built import MEASURABLE, MEASURED_LAWS
from mpm_warp.uncertainty.further_runs import CARRIED_ON, REASON
from mpm_warp.uncertainty.laws import ErrorLaws
from mpm_warp.uncertainty.pore_pressure import stated_pressures, stated_sleeve
from mpm_warp.uncertainty.shoulder import LARGEST_GROWTH, RADIAL_FACTOR, RADIAL_STRESS
from mpm_warp.uncertainty.steadiness import steady_mean

FILTER_HEIGHT = 0.5 * SLEEVE_BEGIN
"""Height of a filter over the radius: 5 mm."""
SHOULDER_FILTER, SHAFT_FILTER = FILTER_HEIGHT, SLEEVE_BEGIN + SLEEVE_LENGTH + FILTER_HEIGHT
"""Heights of u2 and u3 above the shoulder, over the radius: the middle of the cylindrical part of
the cone, and 5 mm above the sleeve."""
PLACES: Mapping[str, str] = {
    "face": "u1: in the middle of the cone's face",
    "shoulder": f"u2: on the shaft, {SHOULDER_FILTER:.2g} radii above the shoulder",
    "shaft": f"u3: on the shaft, {SHAFT_FILTER:.3g} radii above the shoulder, over the sleeve",
}
"""Where each pressure is read, by its name in results."""
SMEARED_ROWS, LEAST_ROWS = 2, 3
"""Number of rows above the shoulder left out of the fit for u2, and least number in it."""
RADIAL_FROM, RADIAL_TO = 1.4, 3.2
"""Heights above the shoulder between which the radial stress is averaged, over the radius. The fit
for u2 ends at the upper one."""
LOG_OFFSET = 0.15
"""The 0.15 in ln(z/R + 0.15): with it the pressure on 20 rows beside the face follows the fit down
to the filter."""

ALONG_SHAFT = f"on the shaft, mean from {RADIAL_FROM:g} to {RADIAL_TO:g} radii above the shoulder"

Reading = tuple[Integers, Floats]
"""Indices of cells, and the weights of their pressures."""


def pore_pressure_curves(simulation: Simulation, penetrometer: Penetrometer) -> Samples:
    """Samples excess pore pressures and radial stress beside a penetrometer.

    Intervals are those of `PenetrationCurves`. A sample is the mean of the values at both ends of
    its interval, NaN while the penetrometer slows down. The grid is fitted to the penetrometer.
    """
    scene = soil_scene(simulation)
    grid, window, height = scene.grid, scene[Window], penetrometer.cone_height
    readings = (
        _on_face(grid, 0.5 * height),
        _behind_shoulder(grid, penetrometer),
        _in_first_column(grid, height + SHAFT_FILTER * penetrometer.radius),
    )
    beside_shaft, along_shaft = _along_shaft(grid, penetrometer)

    def take() -> list[float]:
        pressures = excess_pore_pressure(simulation)
        stress = simulation.array("cell.stress")[beside_shaft]
        deviator = stress[:, 0] - stress[:, [0, 1, 3]].mean(axis=1)
        at_places = [float(weights @ pressures[cells]) for cells, weights in readings]
        return [*at_places, float(along_shaft @ (pressures[beside_shaft] - deviator))]

    def over_penetration(*taken: Floats) -> xr.Dataset:
        not_given = (
            "as simulated: not corrected for mesh, speed and window; not a number above the "
            "window, and where the penetrometer slows down"
        )
        means = [
            without_slowing(0.5 * (np.append(0.0, ends[:-1]) + ends), window, penetrometer.radius)
            for ends in taken
        ]
        at_places: dict[str, Quantity] = {
            f"excess_pore_pressure_{name}": (
                mean,
                "Pa",
                f"excess pore pressure, {name}",
                f"{place}; {PORE_PRESSURE_IS}; {not_given}",
            )
            for (name, place), mean in zip(PLACES.items(), means[:-1], strict=True)
        }
        what = f"over the mean stress at rest, {ALONG_SHAFT}; {not_given}"
        radial = means[-1], "Pa", "excess radial stress on the shaft", what
        axis = penetration_axis(len(taken[0]))
        return curves("penetration", axis, **at_places, **{RADIAL_STRESS: radial})

    return Samples(take, over_penetration)


def pore_pressure_factors(recorded: xr.Dataset, strength: float) -> dict[str, xr.Variable]:
    """Steady means of `pore_pressure_curves` over the strength su [Pa], at each place."""
    factors: dict[str, Quantity] = {}
    for name, place in PLACES.items():
        pressure, over = steady_mean(recorded[f"excess_pore_pressure_{name}"])
        meaning = f"pore pressure factor, {name}"
        what = f"excess pore pressure over su, mean {over}; {place}"
        factors[f"pore_pressure_factor_{name}"] = pressure / strength, "1", meaning, what
    radial, over = steady_mean(recorded[RADIAL_STRESS])
    what = f"excess radial stress over su, mean {over}; {ALONG_SHAFT}"
    factors[RADIAL_FACTOR] = radial / strength, "1", "radial stress factor, shaft", what
    return labelled(dims=(), role=None, **factors)


def stated_beside_shaft(
    results: xr.Dataset,
    built: Scene,
    *,
    laws: ErrorLaws,
    strength: float,
    interface: Interface,
    rough: Interface,
    is_corrected: bool,
) -> dict[str, xr.Variable]:
    """Corrected factors of u1 and u2 with uncertainties, and the uncertainty of sleeve friction.

    Args:
        results: those of a cone test as simulated, with the uncertainty of the cone factor.
        built: the scene that was built. Its law and contact, not the parameters, give the lower
            bound of the sleeve friction.
        laws: of the error at the greatest penetration.
        strength: su [Pa].
        interface: as the parameters give it.
        rough: the same, as adhesive as friction makes it.
        is_corrected: whether the correction of Tresca clay holds or goes on in this clay.
    """
    face, shaft, _ = interface
    material, contact = built.material, built[PenetrometerContact]
    is_as_given = contact.shaft_adhesion == shaft * strength
    slips_at_adhesion = is_as_given and contact.friction == 0.0
    has_lower_bound = slips_at_adhesion and type(material) in MEASURED_LAWS
    remoulded = 1.0
    if isinstance(material, EinavRandolph):
        has_lower_bound &= not material.depends_on_rate
        remoulded = material.remoulded_strength_ratio
    why_none = str(results[REASON].values).replace(MEASURABLE, "")
    if shaft != face:
        other = f"shaft: its adhesion is another than that of the face: {CARRIED_ON}"
        why_none = why_none or other
    if laws.cell_growth > LARGEST_GROWTH:
        grown = f"mesh: cell_growth is above {LARGEST_GROWTH:g}: {CARRIED_ON}"
        why_none = why_none or grown
    sleeve = stated_sleeve(results, remoulded=shaft * remoulded if has_lower_bound else math.nan)
    pressures = stated_pressures(
        results,
        replace(laws, adhesion_factor=rough.face),
        strength=strength,
        shaft_adhesion=rough.shaft,
        why_none=why_none,
        is_corrected=is_corrected,
    )
    return pressures | sleeve


def _middles(edges: Floats) -> Floats:
    middles: Floats = 0.5 * (edges[:-1] + edges[1:])
    return middles


def _in_first_column(grid: Grid, height: float) -> Reading:
    """The first column, linear between the centres of cells; NaN above the highest."""
    middles = _middles(grid.rows)
    row = int(np.clip(np.searchsorted(middles, height), 1, grid.row_count - 1))
    upper = (height - middles[row - 1]) / (middles[row] - middles[row - 1])
    if upper > 1.0:
        upper = math.nan
    return np.array([row - 1, row]) * grid.column_count, np.array([1.0 - upper, upper])


def _on_face(grid: Grid, height: float) -> Reading:
    """The line through the centres of the first two columns, extrapolated to the surface."""
    cells, weights = _in_first_column(grid, height)
    first, second = _middles(grid.columns)[:2]
    outward = first / (second - first)
    extrapolated = np.concatenate([(1.0 + outward) * weights, -outward * weights])
    return np.concatenate([cells, cells + 1]), extrapolated


def _behind_shoulder(grid: Grid, penetrometer: Penetrometer) -> Reading:
    """Mean over the filter of a + b ln(z/R + 0.15), fitted to the first column of cells."""
    heights = (_middles(grid.rows) - penetrometer.cone_height) / penetrometer.radius
    first = int(np.searchsorted(heights, 0.0)) + SMEARED_ROWS
    count = max(LEAST_ROWS, int(np.searchsorted(heights, RADIAL_TO)) - first)
    rows = np.arange(first, min(first + count, grid.row_count))
    if rows.size < LEAST_ROWS:
        return np.zeros(1, dtype=int), np.array([math.nan])
    form = np.stack([np.ones(rows.size), np.log(heights[rows] + LOG_OFFSET)], axis=-1)
    begin, end = SHOULDER_FILTER + LOG_OFFSET + 0.5 * FILTER_HEIGHT * np.array([-1.0, 1.0])
    mean_logarithm = (end * math.log(end) - begin * math.log(begin)) / (end - begin) - 1.0
    return rows * grid.column_count, np.array([1.0, mean_logarithm]) @ np.linalg.pinv(form)


def _along_shaft(grid: Grid, penetrometer: Penetrometer) -> Reading:
    """Mean from RADIAL_FROM to RADIAL_TO in the first column; NaN if the grid ends below."""
    heights = (grid.rows - penetrometer.cone_height) / penetrometer.radius
    if heights[-1] < RADIAL_TO:
        return np.zeros(1, dtype=int), np.array([math.nan])
    shares = np.diff(np.clip(heights, RADIAL_FROM, RADIAL_TO)) / (RADIAL_TO - RADIAL_FROM)
    rows = np.flatnonzero(shares)
    return rows * grid.column_count, shares[rows]
