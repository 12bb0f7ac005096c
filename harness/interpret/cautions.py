"""Cautions: what a sounding shows of clay that is not like that of the measured sites.

The model factor is that of sites with a certain range of OCR and Bq (`studies/field_sites.csv`).
A layer is judged by the medians of Bq, of Ic, of Nkt and of

    OCR = 0.33 qnet / sigma'_v0     (Mayne 1995; Demers & Leroueil 2002)
    St = 7.5 / Fr [%]               (Rad & Lunne 1986; Fr of 0.5 to 2.2 %)

all as commonly quoted. At the measured sites the first gives 0.9 to 2.0 times the measured OCR.
"""

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from harness.interpret.site import Layer
from harness.interpret.tables.model_factor import RATIOS, SIMULATED, measured_sites

OVERCONSOLIDATION, SENSITIVITY = 0.33, 7.5
"""Constants of the two formulas."""
SILT = 2.95
"""Greatest Ic of mixtures of silt (Robertson 2009, zone 4, as commonly quoted)."""
MOST_SENSITIVE = 15.0
"""Sensitivity at the least Fr of its formula."""
BEYOND = 2.0
"""No clay is taken to have so many times the largest Nkt of the measured sites, nor that part of
the smallest."""
ISOTROPIC = 1.0
"""K0 above which clay is overconsolidated."""


def cautions(layer: Layer, own: xr.Dataset) -> str:
    """What is unlike the measured sites in a layer, in words after a blank, or "".

    Args:
        layer: of the site file.
        own: the result of `interpret` at the depths of the layer that have a strength.
    """
    tip = own.net_resistance / (own.vertical_stress - own.water_pressure)
    shown = {
        "OCR by Qtn": float(OVERCONSOLIDATION * tip.median()),
        "Bq": float(own.pore_pressure_ratio.median()),
        "sensitivity by Fr": SENSITIVITY / float(100.0 * own.friction_ratio.median()),
        "Ic": float(own.soil_index.median()),
        "Nkt": float(own.resistance_factor.sel(percentile=50.0).median()),
    }
    said = ""
    if layer.strength != SIMULATED and (unlike := [*_unlike(*shown.values())]):
        by = ", ".join(f"{name} {value:.2g}" for name, value in shown.items() if np.isfinite(value))
        said = f" Caution: {by}; it may be {'; or '.join(unlike)}."
    assumed = [name for name in RATIOS if name in layer.assumed]
    if assumed and "K0" in layer.inputs and layer.K0.at(0.5) > ISOTROPIC:
        said += f" Caution: K0 is above 1, {' and '.join(assumed)} assumed as in soft clay."
    return said


def _unlike(
    ocr: float, ratio: float, sensitivity: float, index: float, factor: float
) -> Iterator[str]:
    """What a layer may be, by the five values that a sounding shows; NaN where not measured."""
    sites = measured_sites()
    most_ocr = float(np.nanmax([site.OCR for site in sites]))
    least, most = (float(end([site.Bq for site in sites])) for end in (np.min, np.max))
    if ocr > most_ocr:
        yield "overconsolidated beyond the measured sites; fissured or with plates, Nkt is 20 to 35"
    elif ratio < 0.0:
        yield "soft with u2 below u0, so that the filter is not saturated"
    if ratio > most or sensitivity > MOST_SENSITIVE:
        yield "sensitive beyond the measured sites; quick clay is outside of the table"
    if index < SILT and ratio < least:
        yield "silt that drains in part"
    low, high = (math.exp(end(site.measured for site in sites)) for end in (min, max))
    if not low / BEYOND <= factor <= high * BEYOND:
        sites_have = f"Nkt of the sites is {low:.0f} to {high:.0f}"
        yield f"read in wrong units, or beside wrong laboratory tests; {sites_have}"
