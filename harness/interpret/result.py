"""The result of an interpretation: a dataset, and sentences to be quoted."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from harness.interpret.measured import REASONS
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
"""What a simulation of the ground needs by depth, all at the strain rate of the table; and which
resistance is taken for that of the ground, without the errors of test, table and model that the
draws have. It is the measured one unless sleeve or pore pressure tell of these errors."""
FOUND: Mapping[tuple[str, ...], Mapping[str, tuple[str, str]]] = {
    ("depth", "percentile"): {
        "strength": ("Pa", "undrained shear strength su"),
        "resistance_factor": ("1", "resistance factor Nkt = qnet / su"),
    },
    ("depth", "cause"): {"error_share": ("1", "share of the variance of ln su")},
    ("layer", "cause", "percentile"): {
        "input_before": ("1", "inputs as given"),
        "input_after": ("1", "inputs by what the test tells of them"),
    },
    ("layer",): {"draws": ("1", "draws that count after weighing")},
    ("depth",): GROUND,
}
"""What is found, by its dims: unit and meaning."""
FEWEST_DRAWS = 50
"""Draws that count after weighing below which the measured values contradict the inputs."""


def without_strength(site: Site, test: xr.Dataset, causes: list[str]) -> xr.Dataset:
    """What was measured over depth, and what is to be `FOUND`, not a number yet.

    That is over depth, layers, percentiles, and the `causes` of an error.
    """
    layers = [layer.title for layer in site.layers]
    found = test.assign_coords(percentile=list(PERCENTILES), cause=causes, layer=layers)
    for dims, quantities in FOUND.items():
        shape = [found.sizes[dim] for dim in dims]
        told: dict[str, Any] = {
            name: (np.full(shape, np.nan), *said) for name, said in quantities.items()
        }
        found = found.assign(labelled(dims=dims, **told))
    modes = "; ".join(f"{layer.title}: {layer.strength}" for layer in site.layers)
    return found.assign_attrs(
        title=site.title, site=site.name, strength_mode=modes, use=" ".join(site.use)
    )


def in_words(site: Site, found: xr.Dataset) -> list[str]:
    """What may be quoted, a sentence a layer, with its assumptions."""
    sentences, measures = [], ", ".join(site.use).replace("_", " ")
    for layer, told in zip(site.layers, found["layer"].values, strict=True):
        inside = layer.holds(found.depth)
        here = inside & (found.reason == 0)
        if not bool(here.any()):
            numbers = np.unique(found.reason.values[inside.values]).tolist()
            why = ", ".join(REASONS[number] for number in numbers) or "the test does not reach it"
            sentences.append(f"{told}: no strength; {why}.")
            continue
        own = found.sel(depth=here)
        low, middle, high = own.strength.mean("depth").values / 1e3
        factor = own.resistance_factor.mean("depth").values
        shares = own.error_share.mean("depth").to_series().dropna().sort_values(ascending=False)
        largest = ", ".join(f"{name} {value:.0%}" for name, value in shares.head(4).items())
        assumed = f"; not given and assumed: {', '.join(layer.assumed)}" if layer.assumed else ""
        felt = int(own.near_border.sum())
        near = f"; {felt} of them feel another layer" if felt else ""
        few = float(found.draws.sel(layer=told)) < FEWEST_DRAWS
        warning = " The measured values contradict the inputs as given." if few else ""
        sentences.append(
            f"{told}: su ({layer.strength.replace('_', ' ')}, at {rate_in_words(layer)}) "
            f"{middle:.3g} kPa, {low:.3g} to {high:.3g} with 90 %, by {measures} with Nkt "
            f"{factor[1]:.3g}, {factor[0]:.3g} to {factor[2]:.3g}, on average over "
            f"{int(here.sum())} depths{near}; "
            f"error from {largest}{assumed}.{warning}"
        )
    return sentences


def rate_in_words(layer: Layer) -> str:
    """The strain rate of a layer's strength, in the unit of laboratories."""
    return f"{100.0 * 3600.0 * layer.laboratory_rate:.2g} %/h"
