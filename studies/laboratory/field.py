"""Pairs of laboratory strength and cone resistance of measured sites, beside the computed factor.

``field PAIRS`` reads a CSV with a row for each depth: a column "site" and those of COLUMNS; empty
cells are not known. Each depth is interpreted by `harness.interpret` with what a site file has by
default, K0 by the overconsolidation ratio, and the sensitivity where it is known. It prints how
well the strengths of a site are predicted by the other sites: by the simulation alone, with the
model factor, and with three random depths of the site tested; how often the line of su by depth is
in the band of its line; and whether neighbouring depths depart together. ``field PAIRS figures``
prints the rows of `studies/field_sites.csv`.
"""

import csv
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from harness.interpret.inference.calibration import Compared, calibration
from harness.interpret.inference.draws import draw
from harness.interpret.inference.line import strength_line
from harness.interpret.inference.weights import chosen_draws
from harness.interpret.laboratory import LaboratoryTest
from harness.interpret.site import MODES, Layer, MeasuredTest, Site
from harness.interpret.tables.factors import USUAL_RADIUS
from harness.interpret.tables.model_factor import (
    BETWEEN,
    DEPTH,
    MEASURED,
    SIMULATED,
    SITE,
    WITHIN,
    ModelFactor,
    SiteFigures,
    fitted,
    model_causes,
    predicted,
    with_model_factor,
)
from harness.study.distributions import sampled
from mpm_warp.grid.fitted import Floats

COLUMNS = {
    "depth": "depth [m]",
    "effective": "effective_vertical_stress [kPa]",
    "yield": "preconsolidation_stress [kPa]",
    "strength": "su_mobilised [kPa]",
    "net": "net_resistance [kPa]",
    "Bq": "pore_pressure_ratio [1]",
    "Ip": "plasticity_index [%]",
    "sensitivity": "sensitivity [1]",
}
SEED = 1
TEST: Mapping[str, Any] = {
    "name": "pairs",
    "area_ratio": 1.0,
    "water_level": 0.0,
    "unit_weight": {"depth": [0.0], "value": [17.0]},  # without an error; stresses are in the pairs
    "accuracy": {"qc": 0.0, "fs": 0.0, "u2": 0.0},
}
NONE = "total_resistance_error", "water_pressure", "sleeve_friction", "pore_pressure"
TESTED, DRAWS = 3, 100
"""Depths of a site that are tested, and how often they are drawn."""
JUDGED = "share of draws below", "ln median over measured", "ln width of the band"
BINS = np.linspace(0.0, 1.0, 11)
MOST_SENSITIVE = 25.0
FRICTION_ANGLES = 22.0, 32.0  # [degrees]
"""K0 = (1 - sin phi) OCR^(sin phi) (Mayne & Kulhawy 1982, as commonly quoted), from the least to
the greatest of these angles."""
INDEX: Any = {"low": 50.0, "high": 300.0}
"""Range of the rigidity index."""
Pairs = Mapping[str, Floats]
"""Columns of a site, shape [depths]."""


def read_pairs(path: Path) -> dict[str, Pairs]:
    """The columns of each site, by its name; NaN where nothing is known."""
    sites: dict[str, list[list[float]]] = {}
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            cells = [float(row[title]) if row[title] else math.nan for title in COLUMNS.values()]
            sites.setdefault(row["site"], []).append(cells)
    return {name: dict(zip(COLUMNS, np.array(rows).T, strict=True)) for name, rows in sites.items()}


class Computed(NamedTuple):
    """Draws of a site, with the same shares of all distributions at all depths."""

    factors: Floats  # ln Nkt over the average strength, shape [depths, draws]
    pressures: Floats  # Bq, of the same shape


def computed(pairs: Pairs) -> Computed:
    """The draws of a site."""
    factors, pressures = [], []
    with np.errstate(invalid="ignore"):
        ocr = np.maximum(pairs["yield"] / pairs["effective"], 1.0)
    test = xr.Dataset(
        {
            "total_resistance": ("depth", 1e3 * (pairs["net"] + pairs["effective"])),
            "net_resistance": ("depth", 1e3 * pairs["net"]),
            "vertical_stress": ("depth", 1e3 * pairs["effective"]),
            **dict.fromkeys(NONE, ("depth", np.zeros_like(ocr))),
        },
        {"depth": np.arange(len(ocr), dtype=float)},
        {"cone_radius": USUAL_RADIUS, "drawn_share": 0.0},
    )
    told = MeasuredTest(where="", folder=Path(), **TEST)
    for place, (ratio, sensitivity) in enumerate(zip(ocr, pairs["sensitivity"], strict=True)):
        known: dict[str, Any] = {}
        if math.isfinite(ratio):
            sines = np.sin(np.radians(FRICTION_ANGLES))
            known["K0"] = dict(
                zip(("low", "high"), sorted((1.0 - sines) * ratio**sines), strict=True)
            )
        if math.isfinite(sensitivity):
            known["sensitivity"] = min(max(sensitivity, 1.0), MOST_SENSITIVE)
        layer = Layer(top=0.0, bottom=100.0, rigidity_index=INDEX, strength=SIMULATED, **known)
        site = Site(name="pairs", title="pairs", test=told, layers=(layer,))
        drawn = draw(site, 0, test, np.array([place]))
        factors.append(np.log(drawn.resistance / drawn.strength)[0])
        pressures.append(drawn.expected["pore_pressure"] / drawn.resistance[0])
    return Computed(np.stack(factors), np.stack(pressures))


def figures(name: str, pairs: Pairs, drawn: Computed) -> SiteFigures:
    """The figures of a site, given its draws."""
    factors = drawn.factors
    measured, medians = np.log(pairs["net"] / pairs["strength"]), np.median(factors, axis=1)
    with np.errstate(invalid="ignore"):
        ocr = pairs["yield"] / pairs["effective"]
    return SiteFigures(
        float(name),
        len(measured),
        measured.mean(),
        measured.std(ddof=1),
        medians.mean(),
        factors.mean(axis=0).std(),
        (measured - medians).std(ddof=1),
        _median(ocr),
        _median(pairs["Bq"]),
        _median(pairs["Ip"]),
        float(np.median(np.log(over_computed(pairs, drawn)))),
    )


def over_computed(pairs: Pairs, drawn: Computed) -> Floats:
    """Mean excess pore pressure over that of each draw, at depths where it is known."""
    known = np.isfinite(pairs["Bq"])
    net = pairs["net"][known]
    expected = np.mean(drawn.pressures[known] * net[:, None], axis=0)
    over: Floats = np.mean(pairs["Bq"][known] * net) / expected
    return over


def by_pressure(others: Sequence[SiteFigures], pairs: Pairs, drawn: Computed) -> Floats:
    """Log-likelihood of each draw by the mean pore pressure of a site, given other sites."""
    shift, deviation = predicted([site.pressure for site in others])
    distance = np.log(over_computed(pairs, drawn)) - shift
    likelihood: Floats = -0.5 * (distance / deviation) ** 2
    return likelihood


def _median(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else math.nan


def table(sites: Sequence[SiteFigures]) -> Iterator[str]:
    """The lines of `studies/field_sites.csv` after its comments."""
    yield ",".join(SiteFigures._fields)
    for site in sites:
        yield ",".join("" if math.isnan(number) else f"{number:.4g}" for number in site)


def print_model_factor(known: ModelFactor) -> None:
    """Both deviations, and mean and deviation of b of each mode, at three shares."""
    for share in np.array([0.05, 0.5, 0.95]):
        between = known.between_at(share)
        print(f"{share:4.0%}: between {between:.3f}, within {known.within_at(share):.3f}")
        for mode in MODES[:-1]:
            mean, variance = known.of_mode(mode, between)
            print(f"      {mode}: b {mean:.3f} +- {math.sqrt(variance):.3f}")


def judgement(
    known: ModelFactor,
    drawn: Computed,
    pairs: Pairs,
    *,
    mode: str = MEASURED,
    tested: Sequence[int] = (),
    told: Floats | float = 0.0,
) -> Floats:
    """Rows of JUDGED for the depths of a site that are not tested, shape [3, depths].

    Args:
        known: the model factor by other sites.
        drawn: draws of the site.
        pairs: what is measured there.
        mode: MEASURED, or SIMULATED for no model factor.
        tested: depths whose strength is known.
        told: log-likelihood of each draw by the pore pressure.
    """
    factors = drawn.factors
    inputs: Mapping[str, Any] = {SITE: 1.0, DEPTH: 1.0}
    chosen = np.arange(factors.shape[1])
    if mode != SIMULATED:
        shares = sampled(model_causes(known), factors.shape[1], SEED)
        deviations = shares[BETWEEN], shares[WITHIN]
        tests = tuple(
            LaboratoryTest(depth=0.1 * row, strength=pairs["strength"][row], test=MEASURED)
            for row in tested
        )
        rows = list(tested)
        own = np.log(pairs["net"] / pairs["strength"])[rows, None] - factors[rows]
        belief = calibration(known, mode, deviations, Compared(tests, own), ()).belief()
        inputs = with_model_factor(shares, belief.mean[:, 0], belief.covariance[:, 0, 0])
        chosen, _ = chosen_draws(belief.log_likelihood + told, SEED)
    rest = np.setdiff1d(np.arange(len(factors)), tested)
    measured = pairs["strength"][rest]
    strength = pairs["net"][rest, None] * np.exp(-factors[rest]) / (inputs[SITE] * inputs[DEPTH])
    strength = strength[:, chosen]
    low, middle, high = np.quantile(strength, [0.05, 0.5, 0.95], axis=1)
    share = np.mean(strength < measured[:, None], axis=1)
    return np.stack([share, np.log(middle / measured), np.log(high / low)])


def line_inside(known: ModelFactor, drawn: Computed, pairs: Pairs) -> tuple[int, int, int]:
    """Whether the line through the measured strengths is in the band.

    Returns:
        Number of its two ends inside; 1 if the line has a slope, or 0; 1 if that is inside.
    """
    order = np.argsort(pairs["depth"])
    depth, count = pairs["depth"][order], drawn.factors.shape[1]
    shares = sampled(model_causes(known), count, SEED)
    site = with_model_factor(shares, *known.of_site(MEASURED, shares[BETWEEN]))[SITE]
    strength = (pairs["net"][:, None] * np.exp(-drawn.factors))[order] / site
    intercept, slope = strength_line(depth, strength, shares[WITHIN], np.arange(count), SEED)
    gradient, at_zero = np.polyfit(depth, pairs["strength"][order], 1).tolist()

    def holds(draws: Floats, value: float) -> int:
        low, high = np.quantile(draws, [0.05, 0.95])
        return int(low <= value <= high)

    ends = depth[[0, -1]].tolist()
    held = sum(holds(intercept + at * slope, at_zero + gradient * at) for at in ends)
    return held, int(slope.any()), int(slope.any()) and holds(slope, gradient)


def neighbours(pairs: Pairs, drawn: Computed) -> Floats:
    """Distances of neighbouring depths [m], and products of their departures over the variance."""
    order = np.argsort(pairs["depth"])
    departure = np.log(pairs["net"] / pairs["strength"]) - np.median(drawn.factors, axis=1)
    scaled = ((departure - departure.mean()) / departure.std(ddof=1))[order]
    return np.stack([np.diff(pairs["depth"][order]), scaled[1:] * scaled[:-1]])


def with_tests(known: ModelFactor, drawn: Computed, pairs: Pairs) -> Floats:
    """Rows of JUDGED with TESTED random depths of the site tested, DRAWS times over."""
    rng = np.random.default_rng(SEED)
    depths = len(drawn.factors)
    chosen = (rng.choice(depths, TESTED, replace=False) for _ in range(DRAWS))
    judged = [judgement(known, drawn, pairs, tested=rows.tolist()) for rows in chosen]
    return np.concatenate(judged, axis=1)


def summary(judged: Sequence[Floats]) -> str:
    """Coverage, bias, width, and the histogram of the shares; each site counts once."""
    inside = np.mean([np.mean((own[0] >= 0.05) & (own[0] <= 0.95)) for own in judged])
    below = np.mean([np.mean(own[0] < 0.05) for own in judged])
    bias = math.expm1(np.mean([own[1].mean() for own in judged]))
    width = math.exp(0.5 * np.mean([own[2].mean() for own in judged]))
    counts = np.mean([np.histogram(own[0], BINS)[0] / own.shape[1] for own in judged], axis=0)
    return (
        f"inside the band of 90 % {inside:.1%}, below it {below:.1%}; median {bias:+.1%}; "
        f"band a factor of {width:.2f} each way; shares of depths in tenths "
        + " ".join(f"{count:.2f}" for count in counts)
    )


def main(path: Path, *, is_of_figures: bool) -> None:
    """Print the figures of the sites, or how well each is predicted by the others."""
    sites = read_pairs(path)
    drawn = {name: computed(pairs) for name, pairs in sites.items()}
    known = [figures(name, pairs, drawn[name]) for name, pairs in sites.items()]
    if is_of_figures:
        print("\n".join(table(known)))
        return
    print_model_factor(fitted(known))
    shift, deviation = predicted([site.pressure for site in known])
    print(f"Bq over computed Bq: ln {shift:.3f} +- {deviation:.3f}")
    apart, products = np.concatenate([neighbours(sites[it], drawn[it]) for it in sites], axis=1)
    error = products.std() / math.sqrt(len(products))
    print(
        f"{len(apart)} neighbouring depths, {np.median(apart):.1f} m apart in the median: "
        f"correlation of departures {products.mean():.2f} +- {error:.2f}"
    )
    cases: dict[str, list[Floats]] = {}
    lines = []
    for place, (name, pairs) in enumerate(sites.items()):
        others = [*known[:place], *known[place + 1 :]]
        model, own = fitted(others), drawn[name]
        told = by_pressure(others, pairs, own)
        lines.append(line_inside(model, own, pairs))
        for words, judged in (
            ("by the simulation alone", judgement(model, own, pairs, mode=SIMULATED)),
            ("with the model factor", judgement(model, own, pairs)),
            ("and the pore pressure", judgement(model, own, pairs, told=told)),
            (f"with the model factor and {TESTED} tests", with_tests(model, own, pairs)),
        ):
            cases.setdefault(words, []).append(judged)
    for words, of_sites in cases.items():
        for name, judged in zip(sites, of_sites, strict=True):
            print(f"{name:>6}: {summary([judged])}")
        print(f"each site by the others, {words}: {summary(of_sites)}")
    ends, sloped, held = np.sum(lines, axis=0)
    print(
        f"lines of the sites inside the band: {ends} of {2 * len(lines)} ends; {sloped} have a "
        f"slope, {held} of these inside"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), is_of_figures="figures" in sys.argv[2:])
