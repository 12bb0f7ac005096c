"""Rate effect of measured soundings at several speeds, beside that of the computed factor.

``rate_of_soundings FOLDER`` reads SGF files (.cpt) from a folder for each of SITES. In each depth
window a sounding has its median net resistance over that of all. Means of ln are fitted by

    ln(qnet / qnet at 20 mm/s) = constant + slope log10(speed / 20 mm/s)

by least squares over the soundings, with their own scatter. The computed slope is that of a layer
with the defaults of a site file. It prints the rows of `studies/rate_of_soundings.csv`.
"""

import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.interpret.forms import WATER
from harness.interpret.site import Layer
from harness.interpret.tables.factors import USUAL_SPEED, at_table_rate, factors
from harness.study.distributions import sampled
from mpm_warp.grid.fitted import Floats

WINDOW, FEWEST, STEADY = 0.5, 5, 0.9
"""Length of a depth window [m], rows that it needs, and share of the windows a sounding needs."""
ROW = r"^D=([\d.]+),QC=(-?[\d.]+),FS=-?[\d.]+,U=(-?[\d.]+),.*?\bB=(\d+)"
"""A row of a file: depth [m], qc [MPa], u2 [kPa], speed [mm/s]."""


class Ground(NamedTuple):
    """A site: the folder of its soundings, and what net resistance needs."""

    folder: str
    soil: str
    unit_weight: float  # [kN/m3]
    water_level: float  # [m]
    top: float  # [m]
    bottom: float


SITES = (
    Ground("0_tiller_flotten", "quick clay", 17.5, 1.5, 7.5, 19.5),
    Ground("2_stjordal", "silt", 20.5, 1.5, 8.5, 15.0),
    Ground("1_oysand", "silty sand", 18.9, 2.0, 9.0, 16.0),
)


class Slope(NamedTuple):
    """What the soundings of a site say; speeds in mm/s, slope and scatter of ln qnet."""

    soundings: int
    least_speed: float
    largest_speed: float
    Bq: float  # median, with hydrostatic u0
    slope: float
    slope_error: float  # standard deviation
    scatter: float  # of the soundings


def sounding(path: Path, ground: Ground) -> tuple[float, Floats, Floats]:
    """Median speed [mm/s], and medians of qnet [kPa] and Bq by window; NaN where not known."""
    text = path.read_text(encoding="latin-1")
    depth, qc, u2, speed = np.array(re.findall(ROW, text, re.MULTILINE), dtype=float).T
    by_u2 = 1.0 - (float(re.findall(r",MA=([\d.]+)", text)[0]) or math.nan)
    net = 1e3 * qc + by_u2 * u2 - ground.unit_weight * depth
    ratio = (u2 - 1e-3 * WATER * (depth - ground.water_level)) / net
    tops = np.arange(ground.top, ground.bottom, WINDOW)
    inside = [(depth >= top) & (depth < top + WINDOW) for top in tops]
    net, ratio = (
        np.array([np.median(it[here]) if here.sum() >= FEWEST else math.nan for here in inside])
        for it in (net, ratio)
    )
    return float(np.median(speed)), net, ratio


def slope_of(ground: Ground, folder: Path) -> Slope:
    """The rate effect at a site."""
    files = sorted((folder / ground.folder).glob("*.cpt"))
    speed, net, ratio = map(np.array, zip(*(sounding(it, ground) for it in files), strict=True))
    kept = np.mean(np.isfinite(net), axis=1) >= STEADY
    logarithm = np.log(net[kept])
    over_median = np.nanmean(logarithm - np.nanmedian(logarithm, axis=0), axis=1)
    speed, cycles = speed[kept], np.log10(speed[kept] / (1e3 * USUAL_SPEED))
    line, covariance = np.polyfit(cycles, over_median, 1, cov=True)
    told = float(np.nanmedian(ratio)), line[0], math.sqrt(covariance[0, 0])
    scatter = np.std(over_median - np.polyval(line, cycles), ddof=2)
    return Slope(len(speed), speed.min(), speed.max(), *told, float(scatter))


def computed(least: float, largest: float) -> tuple[float, float]:
    """Mean and deviation of the slope of the computed factor between two speeds [mm/s]."""
    layer = Layer(top=0.0, bottom=1.0, rigidity_index={"low": 50.0, "high": 300.0})  # type: ignore[arg-type]
    inputs = sampled({**layer.inputs}, 2048, 1)
    soil = {name: inputs[name] for name in ("rigidity_index", "rate_factor", "ductility")}
    soil |= {"remoulded_strength_ratio": 1.0 / inputs["sensitivity"]}
    soil |= {"stress_anisotropy": np.zeros(2048)}  # it hardly changes the slope
    ends = []
    for speed in (least, largest):
        own, ratio = at_table_rate(soil, layer.laboratory_rate * 1e3 * USUAL_SPEED / speed)
        own["adhesion_factor"] = inputs["adhesion_factor"]
        ends.append(np.log(factors().at(own)["cone_factor"] * ratio))
    slopes = (ends[1] - ends[0]) / math.log10(largest / least)
    return float(slopes.mean()), float(slopes.std())


def rows(folder: Path) -> Iterator[str]:
    """The lines of the CSV after its comments."""
    yield ",".join(("site", "soil", *Slope._fields, "computed_slope", "computed_deviation"))
    for ground in SITES:
        found = slope_of(ground, folder)
        numbers = *found, *computed(found.least_speed, found.largest_speed)
        yield ",".join((ground.folder[2:], ground.soil, *(f"{it:.3g}" for it in numbers)))


if __name__ == "__main__":
    print("\n".join(rows(Path(sys.argv[1]))))
