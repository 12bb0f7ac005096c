"""Near a border of two layers the resistance is of both: where, and what it would be of one alone.

The logarithm of net resistance, su Nkt, is a weighted mean of that of the soil around the cone:

    ln q(z) = sum over the soil of  near share of it * ln su + far share of it * ln Nkt
    share of what lies below a border, the tip d radii below it:
    S(d) = (1 + t / sqrt(t^2 + w^2)) / 2,   t = d - m

Strength acts within some 2 radii around the face, stiffness and in-situ stress, by Nkt, within 7.
m and w of both are least squares of the studies `two_layers` (strength ratios 0.25 to 4) and
`two_stiffnesses`, where they leave 2.5 %. As logarithms are averaged, a strong layer feels a weak
one from farther away than the weak one feels it.

`without_borders` asks for what gives the measured q: least squares of logarithms, so that all is
positive. In a layer su has the least curvature and Nkt is one number; over a border both may jump.
What is measured is then multiplied by the ratio of the soil's own q to the q so averaged.
"""

import itertools
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
"""Distance beyond which soil has no weight, over the radius; 0.3 % of the far share would be."""
CELL = 2.0
"""Thickness of the cells of soil that are asked for, at most, over the radius."""
SMOOTH = 30.0
"""Length over the radius: changes of su in a layer over less are not asked for; several times as
far as Nkt acts, so that what Nkt does is not taken for su."""
STIFFNESS = 0.1
"""Weight of the squared jumps of ln Nkt beside the squared errors of ln q, times their way in
radii: 0.03 for the error over 5 radii, beside 0.2 for a jump (Ir by a factor of 3)."""
LOOK, STEP = 8.0, 0.5
"""A border is looked for within so many radii of where it is told, in such steps: 2 radii off,
nothing is gained. Of a thin layer, thickness and strength cannot both be told; its borders stay."""
LEFT = 0.7
"""Half width of what is left of an effect, over the effect, beside the error of the factors: it
holds 89 % within 15 radii of the borders of `two_layers`, 87 % in thin layers."""
LEAST_ROWS = 3
"""Rows above and below a border without which nothing is told of it."""


def near_border(depth: Floats, net: Floats, borders: Sequence[float], radius: float) -> np.ndarray:
    """Whether the resistance feels another layer, shape [n].

    Args:
        depth: of the tip [m], rising, shape [n].
        net: net resistance [Pa], shape [n]; not a number where there is none.
        borders: depths of borders of layers [m].
        radius: of the cone [m].
    """
    near = np.zeros(len(depth), dtype=bool)
    there = np.isfinite(net)
    first, last = depth[there][[0, -1]] if there.any() else (0.0, 0.0)
    for border in [it for it in borders if first < it < last]:
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
    """A test in which each depth has the resistance of its own layer, with the error of that.

    Beside it where each border lies. Sleeve friction and pore pressure stay; the others are as for
    `near_border`.
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
    """Resistance that the soil at each depth would have if it went on without end [Pa], [n].

    Beside it where each border lies by the resistance [m]. Arguments as for `near_border`. Where
    `net` is not a number or not positive it stays.
    """
    there = net > 0.0
    way, logarithm = depth[there] / radius, np.log(net[there])
    ends = way[LEAST_ROWS - 1 : -LEAST_ROWS]  # a border has rows of both its layers
    known = [
        number
        for number, it in enumerate(borders)
        if ((ends[:1] < it / radius) & (ends[-1:] > it / radius)).any()
    ]
    sharp, placed = net.copy(), list(borders)
    if not known:
        return sharp, placed
    inside = [borders[number] / radius for number in known]
    for place, number in enumerate(known):
        told = inside[place]
        inside[place] = _place(way, logarithm, inside, told)
        placed[number] += radius * (inside[place] - told)
    sharp[there] *= np.exp(_own_over_mean(way, logarithm, inside)[0])
    return sharp, placed


def _place(way: Floats, logarithm: Floats, borders: Sequence[float], border: float) -> float:
    """Where a border lies by the resistance; as told where another is within `SMOOTH`."""
    near = np.abs(way - border) < LOOK + REACH
    ends = way[near][[0, -1]]
    others = [it for it in borders if it != border and ends[0] < it < ends[1]]
    if min(np.abs([*ends, *others] - np.array(border))) < SMOOTH:
        return border
    places = border + np.arange(-LOOK, LOOK + STEP, STEP)
    misfits = [
        _own_over_mean(way[near], logarithm[near], sorted([*others, place]))[1] for place in places
    ]
    return float(places[int(np.argmin(misfits))])


def _own_over_mean(way: Floats, logarithm: Floats, inside: Sequence[float]) -> tuple[Floats, float]:
    """Logarithm of the soil's own resistance over the one so averaged, [n], and the misfit.

    The way of the tip and the borders inside it are over the radius; the logarithm is of net
    resistance.
    """
    edges, curvature = _cells([way[0], *inside, way[-1]])
    jumps = sparse.csr_array(edges[:-1, None] >= np.array(inside), dtype=float)
    mean = sparse.hstack([averaging(way, edges, NEAR), averaging(way, edges, FAR) @ jumps])
    least = sparse.block_diag(
        [curvature.T @ curvature, STIFFNESS * sparse.eye_array(len(inside))], format="csc"
    )
    weight = np.gradient(way)  # each depth counts by the way that it stands for
    centred = logarithm - logarithm.mean()
    weighed = mean.T * weight
    found = spsolve((weighed @ mean + least).tocsc(), weighed @ centred)
    strength, factor = np.split(found, [len(edges) - 1])
    cells = np.clip(np.searchsorted(edges, way, side="right") - 1, 0, len(strength) - 1)
    averaged = mean @ found
    misfit = float(weight @ (centred - averaged) ** 2 + found @ (least @ found))
    return (strength + jumps @ factor)[cells] - averaged, misfit


def share_below(distance: Floats, kernel: Kernel) -> Floats:
    """Share S of the weight below a border, the tip `distance` radii below it; 0 or 1 far away."""
    middle, width = kernel
    t = distance - middle
    most = REACH / np.hypot(REACH, width)
    share: Floats = np.clip(0.5 * (1.0 + t / np.hypot(t, width) / most), 0.0, 1.0)
    return share


def averaging(way: Floats, edges: Floats, kernel: Kernel) -> sparse.csr_array:
    """Share of each cell of soil in what a cone takes the mean of, shape [n, cells].

    Args:
        way: depths of the tip, over the radius, shape [n].
        edges: depths of the cells' edges, over the radius, shape [cells + 1]; soil goes on beyond
            the outer ones as it is there.
        kernel: of the share.
    """
    beyond = 2.0 * (REACH + kernel[0])
    edges = np.concatenate([[way[0] - beyond], edges[1:-1], [way[-1] + beyond]])
    first = np.searchsorted(edges, way - beyond / 2.0) - 1
    count = int(np.max(np.searchsorted(edges, way + beyond / 2.0) - first))
    columns = np.minimum(first[:, None] + np.arange(count + 1), len(edges) - 1)
    shares = -np.diff(share_below(way[:, None] - edges[columns], kernel), axis=1)
    columns = np.minimum(columns[:, :-1], len(edges) - 2)
    rows = count * np.arange(len(way) + 1)
    shape = len(way), len(edges) - 1
    return sparse.csr_array((shares.ravel(), columns.ravel(), rows), shape=shape)


def _cells(borders: Sequence[float]) -> tuple[Floats, sparse.csr_array]:
    """Edges of cells between borders, and what gives their curvature times `SMOOTH` squared."""
    edges, blocks = [np.array(borders[:1])], []
    for top, bottom in itertools.pairwise(borders):
        count = int(np.ceil((bottom - top) / CELL))
        edges.append(np.linspace(top, bottom, count + 1)[1:])
        cell = sparse.eye_array(count, format="csr")
        second = cell[:-2] - 2.0 * cell[1:-1] + cell[2:]
        blocks.append(SMOOTH**2 * ((bottom - top) / count) ** -1.5 * second)
    return np.concatenate(edges), sparse.csr_array(sparse.block_diag(blocks))
