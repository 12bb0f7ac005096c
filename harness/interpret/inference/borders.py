"""Near a border of two layers the cone feels both: where, and its resistance in one layer alone.

The logarithm of net resistance, q = su Nkt, is a weighted mean over the soil around the cone:

    ln q(z) = sum over the soil of  near weight * ln su + far weight * ln Nkt

With the tip d radii below a border, the soil below the border has the share S of the weight:

    S(d) = (1 + t / sqrt(t^2 + w^2)) / 2,   t = d - m

Strength acts within some 2 radii around the face. Stiffness and in-situ stress act by Nkt, within 7
radii. m and w of both weights are fitted to the studies `two_layers` (strength ratios 0.25 to 4)
and `two_stiffnesses` by least squares; the remaining error is 2.5 %. Because logarithms are
averaged, a strong layer feels a weak one from farther away than the weak one feels it.

`without_borders` finds su and Nkt of the soil from the measured q, by least squares of logarithms,
so that all values are positive. In a layer su has the least curvature and Nkt is constant; both may
jump at a border. The measured q is then multiplied by the soil's own q over the averaged q.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy import sparse
from scipy.sparse.linalg import spsolve

from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.laws import FELT_BEFORE, FELT_BEHIND

Kernel = tuple[float, float]
"""m and w of a share S, over the cone's radius."""
NEAR: Kernel = 0.91, 2.31
FAR: Kernel = 2.6, 6.9
REACH = 60.0
"""Distance over the radius beyond which soil has no weight; this cuts 0.3 % of the far weight."""
CELL = 2.0
"""Largest thickness of the cells of soil whose strength is found, over the radius."""
SMOOTH = 30.0
"""Length over the radius; su does not change over less within a layer. Nkt acts several times less
far, so that its effect is not taken for one of su."""
STIFFNESS = 0.1
"""Weight of squared jumps of ln Nkt, relative to squared errors of ln q times their length in
radii: an error of 0.03 over 5 radii counts like a jump of 0.2 (Ir by a factor of 3)."""
BY_CHANCE = 0.01
"""Probability with which noise alone moves a border."""
LOOK, STEP = 8.0, 0.5
"""A border is searched within so many radii of its given depth, in such steps. If the given depth
is 2 radii off, nothing is gained. Borders of a thin layer are not searched, because its thickness
and its strength cannot both be found."""
LEFT = 0.7
"""Half width of the error of a removed effect, over the effect, in addition to the error of the
factors. It holds 89 % within 15 radii of the borders of `two_layers`, 87 % in thin layers."""
LEAST_ROWS = 3
"""Rows that a border needs above and below it; with fewer it is ignored."""


def near_border(depth: Floats, net: Floats, borders: Sequence[float], radius: float) -> np.ndarray:
    """Whether the resistance feels another layer, shape [n].

    Args:
        depth: depth of the tip [m], increasing, shape [n].
        net: net resistance [Pa], NaN where it is missing, shape [n].
        borders: depths of borders of layers [m].
        radius: radius of the cone [m].
    """
    near = np.zeros(len(depth), dtype=bool)
    there = np.isfinite(net)
    first, last = depth[there][[0, -1]] if there.any() else (0.0, 0.0)
    for border in [border for border in borders if first < border < last]:
        around = border + radius * np.array([-FELT_BEFORE[False], FELT_BEHIND[True]])
        above, below = np.interp(around, depth[there], net[there])
        stronger = bool(below > above)
        distance = (depth - border) / radius
        near |= (distance > -FELT_BEFORE[stronger]) & (distance < FELT_BEHIND[stronger])
    return near


def edges_of_runs(depth: Floats, inside: np.ndarray) -> list[float]:
    """Depths of the first and last rows of each run of more than `LEAST_ROWS` rows inside."""
    turns = np.flatnonzero(np.diff(inside, prepend=False, append=False)).reshape(-1, 2)
    long = turns[np.ptp(turns, axis=1) > LEAST_ROWS]
    edges: list[float] = depth[long - [0, 1]].ravel().tolist()
    return edges


def without_borders(
    test: xr.Dataset, borders: Sequence[float], radius: float
) -> tuple[xr.Dataset, list[float]]:
    """The test with the resistance of its own layer and its error at each depth, and the borders.

    Their depths [m] are by the resistance. Sleeve friction and pore pressure do not change.
    """
    measured = test.net_resistance.values
    net, placed = sharpened(test.depth.values, measured, borders, radius)
    effect = net - measured
    changed = test.assign(
        net_resistance=("depth", net),
        total_resistance=test.total_resistance + effect,
        total_resistance_error=np.hypot(test.total_resistance_error, LEFT * effect),
    )
    return changed, placed


def sharpened(
    depth: Floats, net: Floats, borders: Sequence[float], radius: float
) -> tuple[Floats, list[float]]:
    """Resistance [Pa] of the soil at each depth if it had no border, and the depths of borders [m].

    Both are by the resistance. Values of `net` that are NaN or not positive do not change.
    """
    there = net > 0.0
    tip, logarithm = depth[there] / radius, np.log(net[there])
    ends = tip[LEAST_ROWS - 1 : -LEAST_ROWS]  # a border has rows of both its layers
    known = [
        number
        for number, border in enumerate(borders)
        if ((ends[:1] < border / radius) & (ends[-1:] > border / radius)).any()
    ]
    sharp, placed = net.copy(), list(borders)
    if not known:
        return sharp, placed
    inside = [borders[number] / radius for number in known]
    for place, number in enumerate(known):
        given = inside[place]
        inside[place] = _place(tip, logarithm, inside, given)
        placed[number] += radius * (inside[place] - given)
    sharp[there] *= np.exp(_own_over_mean(tip, logarithm, inside)[0])
    return sharp, placed


def _place(tip: Floats, logarithm: Floats, borders: Sequence[float], border: float) -> float:
    """Depth of a border by the resistance.

    It is the given depth if another border is within `SMOOTH`, and if the resistance shows none:
    the misfit then is least at an end of the search, or lower elsewhere by no more than noise
    explains. Its variance times chi-square with two degrees of freedom, the two jumps of a border,
    is exceeded with the probability `BY_CHANCE` at any of the places.
    """
    near = np.abs(tip - border) < LOOK + REACH
    ends = tip[near][[0, -1]]
    others = [other for other in borders if other != border and ends[0] < other < ends[1]]
    if min(np.abs([*ends, *others] - np.array(border))) < SMOOTH:
        return border
    places = border + np.arange(-LOOK, LOOK + STEP, STEP)
    misfits = np.array(
        [
            _own_over_mean(tip[near], logarithm[near], sorted([*others, place]))[1]
            for place in places
        ]
    )
    best, given = int(np.argmin(misfits)), len(places) // 2
    noise = misfits[best] / np.count_nonzero(near)
    most = -2.0 * math.log(BY_CHANCE / len(places)) * noise
    is_shown = misfits[given] - misfits[best] > most
    return float(places[best]) if is_shown and 0 < best < len(places) - 1 else border


def _own_over_mean(tip: Floats, logarithm: Floats, inside: Sequence[float]) -> tuple[Floats, float]:
    """Logarithm of the soil's own resistance over the averaged one, shape [n], and the misfit.

    Depths of the tip and of the borders between them are over the radius.
    """
    edges, curvature = _cells([tip[0], *inside, tip[-1]])
    jumps = sparse.csr_array(edges[:-1, None] >= np.array(inside), dtype=float)
    mean = sparse.hstack([averaging(tip, edges, NEAR), averaging(tip, edges, FAR) @ jumps])
    least = sparse.block_diag(
        [curvature.T @ curvature, STIFFNESS * sparse.eye_array(len(inside))], format="csc"
    )
    weight = np.gradient(tip)  # the length for which each depth stands
    centred = logarithm - logarithm.mean()
    weighed = mean.T * weight
    found = spsolve((weighed @ mean + least).tocsc(), weighed @ centred)
    strength, factor = np.split(found, [len(edges) - 1])
    cells = np.clip(np.searchsorted(edges, tip, side="right") - 1, 0, len(strength) - 1)
    averaged = mean @ found
    misfit = float(weight @ (centred - averaged) ** 2 + found @ (least @ found))
    return (strength + jumps @ factor)[cells] - averaged, misfit


def share_below(distance: Floats, kernel: Kernel) -> Floats:
    """Share S of the weight below a border, with the tip `distance` radii below the border."""
    middle, width = kernel
    t = distance - middle
    most = REACH / np.hypot(REACH, width)
    share: Floats = np.clip(0.5 * (1.0 + t / np.hypot(t, width) / most), 0.0, 1.0)
    return share


def averaging(tip: Floats, edges: Floats, kernel: Kernel) -> sparse.csr_array:
    """Weight of each cell of soil in the mean at each depth of the tip, shape [n, cells].

    Depths of the tip and of the edges of cells are over the radius. The outer cells go on without
    end.
    """
    beyond = 2.0 * (REACH + kernel[0])
    edges = np.concatenate([[tip[0] - beyond], edges[1:-1], [tip[-1] + beyond]])
    first = np.searchsorted(edges, tip - beyond / 2.0) - 1
    count = int(np.max(np.searchsorted(edges, tip + beyond / 2.0) - first))
    columns = np.minimum(first[:, None] + np.arange(count + 1), len(edges) - 1)
    shares = -np.diff(share_below(tip[:, None] - edges[columns], kernel), axis=1)
    columns = np.minimum(columns[:, :-1], len(edges) - 2)
    rows = count * np.arange(len(tip) + 1)
    shape = len(tip), len(edges) - 1
    return sparse.csr_array((shares.ravel(), columns.ravel(), rows), shape=shape)


def _cells(borders: Sequence[float]) -> tuple[Floats, sparse.csr_array]:
    """Edges of cells between borders, and the matrix of their curvature times `SMOOTH` squared."""
    edges, blocks = [np.array(borders[:1])], []
    for top, bottom in itertools.pairwise(borders):
        count = int(np.ceil((bottom - top) / CELL))
        edges.append(np.linspace(top, bottom, count + 1)[1:])
        cell = sparse.eye_array(count, format="csr")
        second = cell[:-2] - 2.0 * cell[1:-1] + cell[2:]
        blocks.append(SMOOTH**2 * ((bottom - top) / count) ** -1.5 * second)
    return np.concatenate(edges), sparse.csr_array(sparse.block_diag(blocks))
