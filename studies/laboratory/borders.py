"""Simulated soundings near a border of two layers: su as measured, sharpened, and by ngl_tools.

``borders DIR SEED`` takes the soundings that `blind` simulated.
su is net resistance over the factor that each layer has away from its border, so that its error is
the border's. Where the package ngl_tools is installed (``pip install ngl_tools scikit-learn``), its
filter (Boulanger & DeJong 2018, Cone Penetration Testing 2018, Delft) is printed beside.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

from harness.interpret.inference.borders import near_border, sharpened
from mpm_warp.grid.fitted import Floats
from studies.laboratory.blind import BORDER, COUNT, RADIUS, START, TOP

EVERY = 10
"""Samples of the simulation between two of a test: 18 mm, as in practice."""
AWAY = 15.0
"""Radii on either side of the border within which errors count."""
DISPLACED = 5.0
"""Radii that the border may be wrong by."""


def by_ngl_tools(depth: Floats, net: Floats) -> Floats:
    """The filter of Boulanger & DeJong with its own constants; it knows no borders."""
    try:
        from ngl_tools.smt import cpt_inverse_filter
    except ImportError:
        return np.full_like(net, np.nan)
    found: Floats = 1e3 * cpt_inverse_filter(net / 1e3, depth, dc=2.0 * RADIUS)
    return found


METHODS: dict[str, Callable[[Floats, Floats], Floats]] = {
    "as measured": lambda depth, net: net,
    "sharpened": lambda depth, net: sharpened(depth, net, [BORDER], RADIUS)[0],
    "border told 5 R too high": lambda depth, net: sharpened(
        depth, net, [BORDER - DISPLACED * RADIUS], RADIUS
    )[0],
    "border told 5 R too low": lambda depth, net: sharpened(
        depth, net, [BORDER + DISPLACED * RADIUS], RADIUS
    )[0],
    "ngl_tools": by_ngl_tools,
}


def errors(path: Path) -> tuple[list[Floats], list[float]]:
    """Errors of su within `AWAY` radii by method, over su; share of the large ones marked."""
    ground = xr.open_dataset(path).isel(depth=slice(None, None, EVERY))
    depth, net, strength = (ground[name].values for name in ("depth", "net_resistance", "strength"))
    above, factor = depth < BORDER, net / strength
    away = (depth > TOP + START) & ((depth < BORDER - AWAY * RADIUS) | (depth > BORDER + START))
    own = np.where(above, np.median(factor[away & above]), np.median(factor[away & ~above]))
    near = np.abs(depth - BORDER) < AWAY * RADIUS
    found = [(it(depth, net.copy()) / own / strength - 1.0)[near] for it in METHODS.values()]
    marked = near_border(depth, net, [BORDER], RADIUS)[near]
    felt = np.abs(found[0]) > 0.05
    return found, [marked[felt].mean() if felt.any() else np.nan, marked.mean()]


def main(folder: Path) -> None:
    """Print a row a ground, and the means."""
    print("mean |error| of su within 15 radii, %: " + ", ".join(METHODS))
    rows, marks = [], []
    for number in range(COUNT):
        found, marked = errors(folder / f"{number}.nc")
        rows.append([100.0 * np.mean(np.abs(it)) for it in found])
        marks.append(marked)
        print(f"{number:3}  " + " ".join(f"{it:6.1f}" for it in rows[-1]))
    print("all  " + " ".join(f"{it:6.1f}" for it in np.mean(rows, axis=0)))
    felt, of_all = np.nanmean(marks, axis=0)
    print(f"marked: {felt:.0%} of the depths whose error is above 5 %, {of_all:.0%} of all these")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
