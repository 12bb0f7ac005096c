"""The result of an interpretation: a dataset, and sentences to be quoted."""

import numpy as np
import xarray as xr

from harness.interpret.measured import REASONS, Measured
from harness.interpret.site import Layer, Site
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, labelled

PERCENTILES = (5.0, 50.0, 95.0)
FEWEST_DRAWS = 50
"""Draws that count after weighing below which the measured values contradict the inputs."""


def as_dataset(
    site: Site,
    test: Measured,
    reason: np.ndarray,
    causes: list[str],
    strength: Floats,
    factor: Floats,
    share: Floats,
    inputs: tuple[Floats, Floats],
    counted: Floats,
) -> xr.Dataset:
    """What was found, over depth, layers, causes and percentiles.

    Args:
        site: it is of.
        test: as measured.
        reason: numbers of `REASONS`, shape [depths].
        causes: names of all causes.
        strength: percentiles of su [Pa], shape [depths, percentiles].
        factor: percentiles of Nkt, likewise.
        share: of each cause in the variance of ln su, shape [depths, causes].
        inputs: percentiles before and after the test tells of them, [layers, causes, percentiles].
        counted: draws of each layer that count.
    """
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
        "flag_meanings": " ".join(it.replace(" ", "_") for it in REASONS),
    }
    by_depth["reason"] = xr.Variable("depth", reason, flags)
    over = ("depth", "percentile")
    by_depth = by_depth.assign(
        labelled(
            dims=over,
            strength=(strength, "Pa", "undrained shear strength su"),
            resistance_factor=(factor, "1", "resistance factor Nkt = qnet / su"),
        )
        | labelled(
            dims=("depth", "cause"), error_share=(share, "1", "share of the variance of ln su")
        )
        | labelled(
            dims=("layer", "cause", "percentile"),
            input_before=(inputs[0], "1", "inputs as given"),
            input_after=(inputs[1], "1", "inputs by what the test tells of them"),
        )
        | labelled(dims=("layer",), draws=(counted, "1", "draws that count after weighing"))
    )
    modes = "; ".join(f"{it.title}: {it.strength}" for it in site.layers)
    return by_depth.assign_coords(
        percentile=list(PERCENTILES), cause=causes, layer=[it.title for it in site.layers]
    ).assign_attrs(
        title=site.title,
        site=site.name,
        strength_mode=modes,
        use=" ".join(site.use),
        notes="; ".join(test.notes),
    )


def in_words(site: Site, found: xr.Dataset) -> list[str]:
    """What may be quoted, a sentence a layer, with its assumptions."""
    sentences = []
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
            f"{told}: su ({layer.strength.replace('_', ' ')}, at {layer.laboratory_rate:.1g} 1/s) "
            f"{middle:.3g} kPa, {low:.3g} to {high:.3g} with 90 %, by Nkt {factor[1]:.3g}, "
            f"{factor[0]:.3g} to {factor[2]:.3g}, on average over {int(here.sum())} depths{near}; "
            f"error from {largest}{assumed}.{warning}"
        )
    return sentences


def _why_none(found: xr.Dataset, layer: Layer) -> str:
    inside = (found.depth >= layer.top) & (found.depth <= layer.bottom)
    numbers = np.unique(found.reason.values[inside.values])
    return ", ".join(REASONS[int(it)] for it in numbers) or "the test does not reach it"
