"""The result of an interpretation: a dataset, and sentences to be quoted."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from harness.interpret.measured import REASONS, Measured
from harness.interpret.site import Layer, Site
from mpm_warp.results import curves, labelled

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
FEWEST_DRAWS = 50
"""Draws that count after weighing below which the measured values contradict the inputs."""


def without_strength(site: Site, test: Measured, causes: list[str]) -> xr.Dataset:
    """What was measured over depth, and what is to be found, not a number yet.

    That is over depth, layers, percentiles, and the `causes` of an error.
    """
    layers = [layer.title for layer in site.layers]
    places: dict[str, Any] = {
        "depth": test.depth,
        "layer": layers,
        "cause": causes,
        "percentile": PERCENTILES,
    }

    def unknown(*dims: str, **quantities: tuple[str, str]) -> dict[str, xr.Variable]:
        shape = tuple(len(places[dim]) for dim in dims)
        told: dict[str, Any] = {
            k: (np.full(shape, np.nan), *value) for k, value in quantities.items()
        }
        return labelled(dims=dims, **told)

    by_depth = curves(
        "depth",
        (test.depth, "m", "depth of the tip"),
        cone_resistance=(test.qc, "Pa", "cone resistance qc as measured"),
        sleeve_friction=(test.fs, "Pa", "sleeve friction fs as measured"),
        pore_pressure=(test.u2, "Pa", "pore pressure u2 as measured"),
        water_pressure=(test.u0, "Pa", "water pressure u0 before"),
        vertical_stress=(test.vertical_stress, "Pa", "total vertical stress before"),
        total_resistance=(test.qt, "Pa", "corrected cone resistance qt"),
        total_resistance_error=(test.errors["qt"], "Pa", "half width of 95 % of qt"),
        net_resistance=(test.net, "Pa", "net resistance qnet"),
        pore_pressure_ratio=(test.pore_pressure_ratio, "1", "pore pressure ratio Bq"),
        friction_ratio=(test.friction_ratio, "1", "friction ratio Fr = fs / qnet"),
        soil_index=(test.soil_index, "1", "soil behaviour type index Ic"),
    )
    flags = {
        "long_name": "why there is no strength",
        "flag_values": np.arange(len(REASONS), dtype=np.int8),
        "flag_meanings": " ".join(text.replace(" ", "_") for text in REASONS),
    }
    by_depth["reason"] = xr.Variable("depth", test.reason.copy(), flags)
    found = by_depth.assign(
        unknown(
            *("depth", "percentile"),
            strength=("Pa", "undrained shear strength su"),
            resistance_factor=("1", "resistance factor Nkt = qnet / su"),
        )
        | unknown("depth", "cause", error_share=("1", "share of the variance of ln su"))
        | unknown(
            *("layer", "cause", "percentile"),
            input_before=("1", "inputs as given"),
            input_after=("1", "inputs by what the test tells of them"),
        )
        | unknown("layer", draws=("1", "draws that count after weighing"))
        | unknown("depth", **GROUND)
    )
    modes = "; ".join(f"{layer.title}: {layer.strength}" for layer in site.layers)
    return found.assign_coords(
        percentile=list(PERCENTILES), cause=causes, layer=layers
    ).assign_attrs(
        title=site.title,
        site=site.name,
        strength_mode=modes,
        use=" ".join(site.use),
        notes="; ".join(test.notes),
    )


def in_words(site: Site, found: xr.Dataset) -> list[str]:
    """What may be quoted, a sentence a layer, with its assumptions."""
    sentences, measures = [], ", ".join(site.use).replace("_", " ")
    for layer, told in zip(site.layers, found["layer"].values, strict=True):
        here = (found.depth >= layer.top) & (found.depth <= layer.bottom) & (found.reason == 0)
        if not bool(here.any()):
            sentences.append(f"{told}: no strength; {_why_none(found, layer)}.")
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


def _why_none(found: xr.Dataset, layer: Layer) -> str:
    inside = (found.depth >= layer.top) & (found.depth <= layer.bottom)
    numbers = np.unique(found.reason.values[inside.values])
    return ", ".join(REASONS[int(number)] for number in numbers) or "the test does not reach it"
