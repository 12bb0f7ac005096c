"""Blind test: random grounds are simulated, and interpreted from ranges of their parameters alone.

``blind DIR SEED`` simulates soundings into a folder, or uses those in it. It adds
measurement errors of class 2 to each, several times, since an error is constant along a test. It
interprets each from the tip, from tip and sleeve, and with u2 too. It prints for each ground the
share of depths whose strength is in the 90 % band, median error and width of the band; then means.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import xarray as xr

from harness.interpret.forms import ACCURACY
from harness.interpret.site import load_site
from harness.interpret.strength import interpret
from mpm_warp.scenes import scene_class

COUNT, SEED = 24, int(sys.argv[2]) if len(sys.argv) > 2 else 20261124
TOP, BORDER, BOTTOM = 3.0, 4.5, 6.0
"""Depths of the random ground [m]."""
START = 0.4
"""Penetration until the resistance is steady [m], omitted at the top and below a border."""
RADIUS, AREA_RATIO, WATER, WEIGHT, RATE = 0.01785, 0.8, 1.0, 17.0, 1.4e-5
ERRORS_DRAWN = 12
"""Number of random measurement errors for each ground."""
DEPTHS_APART = 10
"""Every tenth depth of a simulated sounding is interpreted."""
USES = ('["tip"]', '["tip", "sleeve"]', '["tip", "sleeve", "pore_pressure"]')


def ground(number: int) -> dict[str, float | str]:
    """Parameters of a sounding through two layers with gradients; every other ground softens."""
    rng = np.random.default_rng([SEED, number])
    rows, top = [], 10.0 ** rng.uniform(1.0, 1.7)
    for begin, end in ((TOP - 1.0, BORDER), (BORDER, BOTTOM + 1.0)):
        index, adhesion = np.exp(rng.uniform(np.log(50), np.log(400))), rng.uniform(0.2, 0.8)
        delta, slope = rng.uniform(-0.3, 0.6), rng.uniform(0.0, 4.0)
        for depth in (begin, end):
            strength = top + slope * (depth - begin)
            soil = f"{index:.4g}, {WEIGHT}, {adhesion:.3g}, {delta:.3g}"
            rows.append(f"{depth}, {strength:.4g}, {soil}")
        top = strength * 10.0 ** rng.uniform(-0.3, 0.3)
    head = (
        "depth [m], strength [kPa], rigidity_index [1], unit_weight [kN/m3], adhesion_factor [1], "
        "stress_anisotropy [1]"
    )
    own: dict[str, float | str] = {
        "profile": "; ".join([head, *rows]),
        "from_depth": TOP,
        "to_depth": BOTTOM,
        "cells_per_radius": 2.0,
        "speed_ratio": 0.1,
    }
    if number % 2:
        own |= {
            "rate_factor": rng.uniform(0.05, 0.15),
            "reference_strain_rate": RATE,
            "remoulded_strength_ratio": 1.0 / rng.uniform(1.5, 6.0),
            "ductility": rng.uniform(10.0, 50.0),
        }
    return own


def simulate(number: int, folder: Path) -> None:
    """Simulate a sounding, unless its file is there."""
    path = folder / f"{number}.nc"
    if not path.exists():
        scene_class("sounding")(**ground(number)).run().to_netcdf(path)


def write_test(number: int, drawn: int, found: xr.Dataset, folder: Path) -> Path:
    """Write a test with the random errors of class 2 number `drawn`, and its site file."""
    rng = np.random.default_rng([SEED, 1 + drawn, number])
    depth = found.depth.values
    water = 9.81e3 * (depth - WATER)
    u2 = found.excess_pore_pressure.values + water
    qc = found.net_resistance.values + 1e3 * WEIGHT * depth - (1.0 - AREA_RATIO) * u2
    measured = {"qc": qc, "fs": found.sleeve_friction.values, "u2": u2}
    for name, values in measured.items():
        least, share = ACCURACY["class 2"][name]
        shift = rng.normal() / 1.96 * np.maximum(least, share * np.abs(values))
        measured[name] = np.maximum(values + shift, 0.0)
    rows = zip(depth, *measured.values(), strict=True)
    lines = [",".join(f"{value:.8g}" for value in row) for row in rows]
    text = "\n".join(["depth [m],qc [Pa],fs [Pa],u2 [Pa]", *lines])
    (folder / f"{number}.csv").write_text(text)
    changes = "rate_factor" in ground(number)
    layer = f"""rigidity_index = {{ low = 50, high = 400 }}
adhesion_factor = {{ low = 0.2, high = 0.8 }}
stress_anisotropy = {{ low = -0.3, high = 0.6 }}
rate_factor = {"{ low = 0.05, high = 0.15 }" if changes else 0}
sensitivity = {"{ low = 1.5, high = 6.0 }" if changes else 1}
ductility = {{ low = 10, high = 50 }}
laboratory_rate = {RATE}
strength = "isotropic"
"""
    path = folder / f"site{number}.toml"
    path.write_text(
        f"""title = "Ground {number}"
use = USE
[test]
file = "{number}.csv"
area_ratio = {AREA_RATIO}
water_level = {WATER}
unit_weight = {WEIGHT}
[[layer]]
from = {TOP}
to = {BORDER}
{layer}
[[layer]]
from = {BORDER}
to = {BOTTOM}
{layer}"""
    )
    return path


def judge(number: int, folder: Path) -> np.ndarray:
    """Whether the strength is in the band, error of the median, width of the band.

    Shape [3, uses, errors drawn, depths]; NaN near borders of layers, where nothing is interpreted.
    """
    truth = xr.open_dataset(folder / f"{number}.nc").isel(depth=slice(None, None, DEPTHS_APART))
    depth, judged_rows = truth.depth.values, []
    near = (depth < TOP + START) | ((depth > BORDER - 15 * RADIUS) & (depth < BORDER + START))
    for drawn in range(ERRORS_DRAWN):
        path = write_test(number, drawn, truth, folder)
        text = path.read_text()
        for use in USES:
            path.write_text(text.replace("USE", use, 1))
            found = interpret(load_site(path))
            low, middle, high = found.strength.values.T / truth.strength.values
            inside = np.where((low <= 1.0) & (high >= 1.0), 1.0, 0.0)
            row = np.array([inside, middle - 1.0, high - low])
            row[:, near | np.isnan(middle)] = np.nan
            judged_rows.append(row)
    shape = (ERRORS_DRAWN, len(USES), 3, len(depth))
    return np.reshape(judged_rows, shape).transpose(2, 1, 0, 3)


def main(folder: Path) -> None:
    """Simulate and interpret; print a row for each ground, and the means."""
    folder.mkdir(exist_ok=True)
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(simulate, range(COUNT), [folder] * COUNT))
        grounds = list(pool.map(judge, range(COUNT), [folder] * COUNT))
    for number, judged in enumerate(grounds):
        cells = [
            f"{np.nanmean(inside):4.0%} {np.nanmedian(error):+6.1%} {np.nanmean(width):5.0%}"
            for inside, error, width in zip(*judged, strict=True)
        ]
        print(f"{number:3}  " + "   ".join(cells))
    for place, use in enumerate(USES):
        inside, error, width = (
            [np.ravel(it[which, place]) for it in grounds] for which in range(3)
        )
        by_draw = [
            np.nanmean(np.concatenate([np.ravel(it[0, place, drawn]) for it in grounds]))
            for drawn in range(ERRORS_DRAWN)
        ]
        print(
            f"{use}: inside {np.nanmean(np.concatenate(inside)):.1%} "
            f"({min(by_draw):.0%} to {max(by_draw):.0%} of one draw of the errors), "
            f"|error| {np.nanmedian(np.abs(np.concatenate(error))):.1%}, "
            f"width {np.nanmean(np.concatenate(width)):.0%}"
        )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "blind"))
