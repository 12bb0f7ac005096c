"""The result of an interpretation: a dataset, and sentences to quote."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.conventions import known_digits
from harness.interpret.measured import REASONS
from harness.interpret.model_factor import MEASURED, OF_PRACTICE, SIMULATED
from harness.interpret.site import Layer, Site
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
    ("layer",): {"draws": ("1", "draws that count after weighing")},
    ("depth",): GROUND,
}
"""Results by their dims, each with unit and meaning."""
UNCHECKED = ", of which only the tip is checked on real ground,"
FEWEST_DRAWS = 50
"""With fewer effective draws after weighting, the measured values contradict the inputs."""


def without_strength(site: Site, test: xr.Dataset, causes: list[str]) -> xr.Dataset:
    """The test with all quantities of `FOUND`, which are NaN."""
    layers = [layer.title for layer in site.layers]
    found = test.assign_coords(percentile=list(PERCENTILES), cause=causes, layer=layers)
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
        measures = ", ".join(told_by).replace("_", " ")
        if layer.strength != SIMULATED and len(told_by) > 1:
            measures += UNCHECKED
        low, middle, high = in_digits(*own.strength.mean("depth").values / 1e3)
        factor = in_digits(*own.resistance_factor.mean("depth").values)
        shares = own.error_share.mean("depth").to_series().dropna().sort_values(ascending=False)
        largest = ", ".join(f"{name} {value:.0%}" for name, value in shares.head(4).items())
        assumed = f"; not given and assumed: {', '.join(layer.assumed)}" if layer.assumed else ""
        felt = int(own.near_border.sum())
        removed = ", and its effect is removed at borders of the site file"
        sharp = removed if "sharpened_resistance" in found else ""
        near = f"; another layer is felt at {felt} of them{sharp}" if felt else ""
        few = float(found.draws.sel(layer=told)) < FEWEST_DRAWS
        warning = " The measured values contradict the inputs as given." if few else ""
        sentences.append(
            f"{told}: su ({layer.strength.replace('_', ' ')}, at {rate_in_words(layer)}) "
            f"{middle} kPa, {low} to {high} with 90 %, {of_ground(layer)}, by {measures} with Nkt "
            f"{factor[1]}, {factor[0]} to {factor[2]}, on average over "
            f"{int(here.sum())} depths{near}; "
            f"error from {largest}{assumed}.{warning}"
        )
    return sentences


def of_ground(layer: Layer) -> str:
    """What the band of a layer rests on, in words."""
    if layer.strength == SIMULATED:
        return "for simulated clay, from which real clay departs"
    words = "without a laboratory test of this site"
    if layer.strength == MEASURED:
        return words
    of = "as in practice" if layer.strength == OF_PRACTICE else "not measured in this mode"
    return f"{words}, with a model factor {of}"


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
