"""The result of an interpretation: a dataset, and sentences to quote."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.conventions import known_digits, spoken
from harness.interpret.cautions import cautions
from harness.interpret.forms import MEASURES
from harness.interpret.laboratory import LaboratoryTest
from harness.interpret.measured import REASONS
from harness.interpret.site import Layer, Site
from harness.interpret.tables.model_factor import DEPTH, MEASURED, OF_PRACTICE, SIMULATED, SITE
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled

PERCENTILES = (5.0, 50.0, 95.0)
GROUND: Mapping[str, tuple[str, str]] = {
    "ground_strength": ("Pa", "strength su, the same in all modes"),
    "ground_rigidity_index": ("1", "rigidity index"),
    "ground_adhesion_factor": ("1", "adhesion factor"),
    "ground_stress_anisotropy": ("1", "stress anisotropy Delta"),
    "ground_resistance_ratio": ("1", "net resistance of this ground over the measured one"),
}
"""Inputs by depth of a simulation of the ground, at the strain rate of the table; and the ratio of
its resistance, without the errors of test, table and model in the draws, to the measured one. The
ratio is 1 unless sleeve or pore pressure show such an error."""
FOUND: Mapping[tuple[str, ...], Mapping[str, tuple[str | None, str]]] = {
    ("depth", "percentile"): {
        "strength": ("Pa", "undrained shear strength su"),
        "resistance_factor": ("1", "resistance factor Nkt = qnet / su"),
    },
    ("depth", "cause"): {"error_share": ("1", "share of the variance of ln su")},
    ("layer", "cause", "percentile"): {
        "input_before": (None, "inputs as given, in SI units"),
        "input_after": (None, "inputs by what the test tells of them, in SI units"),
    },
    ("layer",): {
        "draws": ("1", "draws that count after weighing"),
        "laboratory_tests": ("1", "tests of a laboratory that count for the layer"),
    },
    ("layer", "percentile"): {
        "line_intercept": ("Pa", "su at depth 0 on the line of the layer, a of su = a + b z"),
        "line_slope": ("Pa m-1", "slope b of the line, 0 where it is not significant"),
    },
    ("layer", "end"): {"line_depth": ("m", "depth of the ends of the line")},
    ("layer", "end", "percentile"): {"line_strength": ("Pa", "su on the line at its ends")},
    ("layer", "measure", "bound"): {
        "measure_mean": ("Pa", "mean of fs and of u2 - u0, and what the inputs allow"),
    },
    ("depth", "measure", "bound"): {
        "measure_at_depth": ("Pa", "fs and u2 - u0, and what the inputs allow"),
    },
    ("depth",): GROUND,
}
"""Results by their dims, each with unit and meaning."""
NO_TEST = "without a laboratory test of this site"
LABORATORY = "laboratory_strength"
UNCHECKED = " The sleeve is not checked on real ground."
REAL_CLAY = "; site and depth factor are how far real clay departs from simulated clay"
FEWEST_DRAWS = 50
"""With fewer effective draws after weighting, the measured values contradict the inputs."""
CONTRADICTED = (
    " The measured values contradict the inputs as given: too few draws meet them for the band to "
    "hold 90 %."
)


def without_strength(site: Site, test: xr.Dataset, causes: list[str]) -> xr.Dataset:
    """The test with all quantities of `FOUND`, which are NaN."""
    layers = [layer.title for layer in site.layers]
    found = test.assign_coords(percentile=list(PERCENTILES), cause=causes, layer=layers)
    found = found.assign_coords(
        measure=[*MEASURES[1:]], bound=["measured", "least", "largest"], end=["top", "bottom"]
    )
    for dims, quantities in FOUND.items():
        shape = [found.sizes[dim] for dim in dims]
        empty: dict[str, Any] = {
            name: (np.full(shape, np.nan), *texts) for name, texts in quantities.items()
        }
        found = found.assign(labelled(dims=dims, **empty))
    modes = "; ".join(f"{layer.title}: {layer.strength}" for layer in site.layers)
    return found.assign_attrs(
        title=site.title, site=site.name, strength_mode=modes, use=" ".join(site.use)
    )


def with_laboratory(
    found: xr.Dataset,
    tests: Sequence[LaboratoryTest],
    net: Floats,
    expected: Floats,
    in_mode: Floats,
) -> xr.Dataset:
    """A result with the tests of a laboratory.

    Args:
        found: the result.
        tests: those that are beside a depth with a strength.
        net: net resistance of the clay of their layer at their depths [Pa], shape [tests].
        expected: percentiles of su by the other tests [Pa], shape [tests, percentiles].
        in_mode: su brought to the mode of the layer [Pa], shape [tests].
    """
    depth = np.array([test.depth for test in tests])
    strength = 1e3 * np.array([test.strength for test in tests])
    told: dict[str, Any] = {
        "laboratory_depth": (depth, "m", "depth of the sample"),
        "laboratory_strength": (strength, "Pa", "strength su of the test"),
        "laboratory_in_mode": (in_mode, "Pa", "strength brought to the mode of the layer"),
        "laboratory_factor": (net / strength, "1", "net resistance over the strength of the test"),
    }
    by_others: dict[str, Any] = {
        "laboratory_expected": (expected, "Pa", "strength of the test by the others")
    }
    kinds = [test.test for test in tests]
    return (
        found.assign_coords(laboratory_test=kinds)
        .assign(labelled(dims=("laboratory_test",), **told))
        .assign(labelled(dims=("laboratory_test", "percentile"), **by_others))
    )


def laboratory_points(found: xr.Dataset) -> list[tuple[float, float]]:
    """Depths [m] and strengths in the mode of the layer [Pa] of tests of a laboratory."""
    if LABORATORY not in found:
        return []
    pairs = zip(found.laboratory_depth.values, found.laboratory_in_mode.values, strict=True)
    return [(float(depth), float(strength)) for depth, strength in pairs]


def laboratory_rows(found: xr.Dataset) -> list[tuple[str, ...]]:
    """A row for each test of a laboratory, beside what the others let expect; the heading first."""
    rows: list[tuple[str, ...]] = [
        (
            "test",
            "depth [m]",
            "su [kPa]",
            "qnet / su",
            "su by the other tests [kPa]",
            "it is",
            "su in the mode of the layer [kPa]",
        )
    ]
    for place, kind in enumerate(found.laboratory_test.values if LABORATORY in found else ()):
        own = found.isel(laboratory_test=place)
        strength, expected = float(own.laboratory_strength), own.laboratory_expected.values
        low, middle, high = in_digits(*expected / 1e3)
        is_inside = expected[0] <= strength <= expected[-1]
        rows.append(
            (
                str(kind),
                f"{float(own.laboratory_depth):g}",
                f"{strength / 1e3:g}",
                f"{float(own.laboratory_factor):.1f}",
                f"{middle}, {low} to {high} with 90 %",
                "inside" if is_inside else "outside",
                f"{float(own.laboratory_in_mode) / 1e3:.3g}",
            )
        )
    return rows


def laboratory_in_words(site: Site, found: xr.Dataset) -> list[str]:
    """What tests of a laboratory tell: Nkt of the site, and the model factor."""
    lines = []
    for kind in dict.fromkeys(found.laboratory_test.values if LABORATORY in found else ()):
        own = found.laboratory_factor.values[found.laboratory_test.values == kind]
        deviation = f", standard deviation {own.std(ddof=1):.1f}" if len(own) > 1 else ""
        mean = f"mean {own.mean():.1f}{deviation}"
        lines.append(f"Nkt of the site by {kind}: {mean}, {counted(len(own))}.")
    for layer in site.layers:
        count = int(np.nan_to_num(found.laboratory_tests.sel(layer=layer.title)))
        if count:
            both = (
                in_digits(*found[f"input_{time}"].sel(layer=layer.title, cause=SITE).values)
                for time in ("before", "after")
            )
            before, after = (f"{middle}, {low} to {high} with 90 %" for low, middle, high in both)
            lines.append(
                f"{layer.title}: the model factor of the site, real over computed, is {after}, by "
                f"{counted(count)}; without them {before}."
            )
    return lines


def tests_in_words(found: xr.Dataset) -> list[str]:
    """A line for each test of a laboratory, beside what the others let expect."""
    return [
        f"{kind} at {depth} m: su is {strength} kPa, by the other tests {expected}: {is_it}."
        for kind, depth, strength, _, expected, is_it, _ in laboratory_rows(found)[1:]
    ]


def counted(tests: int) -> str:
    """A number of tests of a laboratory in words."""
    return f"{tests} laboratory test{'s' if tests > 1 else ''}"


def in_words(site: Site, found: xr.Dataset) -> list[str]:
    """A sentence to quote for each layer, with its assumptions."""
    sentences = []
    in_layer = site.layer_at(found.depth.values)
    for place, layer in enumerate(site.layers):
        told, inside = layer.title, in_layer == place
        here = inside & (found.reason.values == 0)
        if not here.any():
            numbers = np.unique(found.reason.values[inside]).tolist()
            why = ", ".join(REASONS[number] for number in numbers) or "the test has no row in it"
            sentences.append(f"{told}: no strength; {why}.")
            continue
        own = found.isel(depth=here)
        told_by = telling(site, own)
        tests = int(np.nan_to_num(found.laboratory_tests.sel(layer=told)))
        by_sleeve = [] if "adhesion_factor" in layer.inputs else ["adhesion by the sleeve"]
        measures = ", ".join([*told_by, *by_sleeve]).replace("_", " ")
        is_unchecked = layer.strength != SIMULATED and "sleeve" in measures
        low, middle, high = in_digits(*own.strength.mean("depth").values / 1e3)
        factor = in_digits(*own.resistance_factor.mean("depth").values)
        shares = own.error_share.mean("depth").to_series().dropna().sort_values(ascending=False)
        causes = [f"{spoken(name)} {value:.0%}" for name, value in shares.head(4).items()]
        real = REAL_CLAY if {SITE, DEPTH} & {*shares.head(4).index} else ""
        names = (*site.test.assumed, *layer.assumed)
        assumed = f" Not given and assumed: {', '.join(names)}." if names else ""
        felt = int(own.near_border.sum())
        removed = ", and its effect is removed at borders of the site file"
        sharp = removed if "sharpened_resistance" in found else ""
        near = f"; another layer is felt at {felt} of them{sharp}" if felt else ""
        few = float(found.draws.sel(layer=told)) < FEWEST_DRAWS
        warning = CONTRADICTED if few else ""
        sentences.append(
            f"{told}: su ({layer.strength.replace('_', ' ')}, at {rate_in_words(layer)}) is "
            f"{middle} kPa, {low} to {high} with 90 %, {of_ground(layer, tests)}. "
            f"It is found by {measures} with Nkt {factor[1]}, {factor[0]} to {factor[2]}, "
            f"on average over {int(here.sum())} depths{near}.{UNCHECKED if is_unchecked else ''} "
            f"Largest causes of the error: {', '.join(causes)}{real}.{assumed}"
            f"{misfits(found.isel(depth=inside), told)}{warning}{cautions(layer, own)}"
        )
    return sentences


def of_ground(layer: Layer, tests: int) -> str:
    """What the band of a layer rests on, in words, given the number of laboratory tests."""
    if layer.strength == SIMULATED:
        return "for simulated clay, from which real clay departs"
    words = f"by {counted(tests)} of this site" if tests else NO_TEST
    if layer.strength == MEASURED:
        return words
    of = "as in practice" if layer.strength == OF_PRACTICE else "not measured in this mode"
    return f"{words}, with a model factor {of}"


def misfits(own: xr.Dataset, title: str) -> str:
    """What fs and Bq are in a layer beside what its inputs allow, in words after a blank, or "".

    Bq is the mean of u2 - u0 over that of qnet at the same depths.
    """
    has_pressure = own.measure_at_depth.sel(measure="pore_pressure", bound="measured").notnull()
    net, words = float(own.net_resistance.where(has_pressure).mean()), []
    for measure, name, size, unit in (
        ("sleeve", "fs", 1e3, " kPa"),
        ("pore_pressure", "Bq", net, ""),
    ):
        mean, least, largest = own.measure_mean.sel(layer=title, measure=measure).values / size
        if np.isfinite(mean):
            side = "below" if mean < least else "above" if mean > largest else "within"
            low, middle, high = in_digits(least, mean, largest)
            words.append(
                f" The mean {name} is {middle}{unit}, {side} what the inputs allow, "
                f"{low} to {high}{unit}."
            )
    return "".join(words)


def in_digits(low: float, middle: float, high: float) -> list[str]:
    """Three percentiles, with as many digits as a tenth of their band justifies; all if it is 0."""
    tenth = 0.1 * (high - low)
    return [known_digits(it, tenth) if tenth > 0.0 else f"{it:g}" for it in (low, middle, high)]


def telling(site: Site, own: xr.Dataset) -> list[str]:
    """Measurements of `use` that have values above 0 at the depths of `own`."""
    above = {
        "tip": own.net_resistance,
        "sleeve": own.sleeve_friction,
        "pore_pressure": own.pore_pressure - own.water_pressure,
    }
    return [measure for measure in site.use if bool((above[measure] > 0.0).any())]


def rate_in_words(layer: Layer) -> str:
    """The strain rate of the strength of a layer, in %/h as in laboratories."""
    return f"{100.0 * 3600.0 * layer.laboratory_rate:.6g} %/h"
