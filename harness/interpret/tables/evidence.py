"""The measured sites: Nkt as measured, and as computed before and after the model factor.

The factor of a site is that of the other sites, so that no site is judged by itself.
"""

import textwrap
from typing import Any

import numpy as np
import xarray as xr

from harness.compare.columns import Column, table
from harness.interpret.tables.model_factor import (
    BETWEEN,
    DEPTH,
    MEASURED,
    SITE,
    fitted,
    measured_sites,
    model_causes,
    with_model_factor,
)
from harness.references.listing import WIDTH
from harness.study.distributions import normal, sampled
from mpm_warp.results import labelled

PERCENTILES = (5.0, 50.0, 95.0)
AWAY = 1.645 * np.array([-1.0, 0.0, 1.0])
"""The same percentiles of a normal distribution, over its deviation."""
DRAWS, SEED = 65536, 1
"""With so many draws a percentile changes by some 1 % from seed to seed."""
INPUTS = "inputs"
FACTORS = {
    "measured": "Nkt by the measured strengths: by mean and deviation of its logarithm",
    "computed": "computed Nkt, 90 % by the inputs",
    "predicted": "computed Nkt with the model factor by the other sites, 90 % of the depths",
}
SOURCE = (
    "Measured: qnet over the mobilised su, at sites of the database CLAY/10/7490 (Ching & Phoon "
    "2014, Can. Geotech. J. 51:663-685), from a public copy; the papers on the sites were not "
    "read. OCR, Bq and plasticity index Ip [%] are medians. Computed: of simulated clay, over the "
    "average strength. Predicted: times the model factor of the other sites. Brackets hold 90 % "
    "of the depths of a site, where computed of its mean. Figures: studies/field_sites.csv."
)


def evidence() -> xr.Dataset:
    """Each measured site, downward by Nkt: quantities of `FACTORS`, by site and percentile."""
    sites = sorted(measured_sites(), key=lambda it: -it.measured)
    found = np.empty((len(FACTORS), len(sites), len(PERCENTILES)))
    for place, site in enumerate(sites):
        known = fitted([other for other in sites if other is not site])
        drawn = sampled({**model_causes(known), INPUTS: normal(1.0)}, DRAWS, SEED)
        factors = with_model_factor(drawn, *known.of_site(MEASURED, drawn[BETWEEN]))
        mean = np.exp(site.computed + site.computed_deviation * drawn[INPUTS])
        found[:, place] = (
            np.exp(site.measured + AWAY * site.measured_deviation),
            np.exp(site.computed + AWAY * site.computed_deviation),
            np.percentile(mean * factors[SITE] * factors[DEPTH], PERCENTILES),
        )
    values: dict[str, Any] = {
        name: (own, "1", FACTORS[name]) for name, own in zip(FACTORS, found, strict=True)
    }
    known_of = {
        name: ("site", [getattr(site, name) for site in sites])
        for name in ("depths", "OCR", "Bq", "Ip")
    }
    names = [f"{site.site:g}" for site in sites]
    return xr.Dataset(known_of, {"site": names, "percentile": [*PERCENTILES]}).assign(
        labelled(dims=("site", "percentile"), **values)
    )


def inside(found: xr.Dataset, name: str) -> int:
    """Number of the sites whose measured Nkt is in a band."""
    low, _, high = found[name].values.T
    middle = found.measured.sel(percentile=50.0).values
    return int(np.sum((middle >= low) & (middle <= high)))


def evidence_table(found: xr.Dataset) -> str:
    """A row for each site, how many of them are in the bands, and where they come from."""
    columns = [Column("site", [str(site) for site in found.site.values])]
    columns += [
        Column(name, [_text(value, form) for value in found[name].values])
        for name, form in (("depths", ".0f"), ("OCR", ".1f"), ("Bq", ".2f"), ("Ip", ".0f"))
    ]
    for name in FACTORS:
        rows = found[name].values.tolist()
        texts = [f"{middle:.0f} ({low:.0f} to {high:.0f})" for low, middle, high in rows]
        columns.append(Column(f"Nkt_{name}", texts))
    over = (found.measured / found.computed).sel(percentile=50.0).values
    columns.append(Column("over_computed", [f"{value:.1f}" for value in over]))
    logarithm, count = np.log(over), len(over)
    before, after = (inside(found, name) for name in ("computed", "predicted"))
    summary = (
        f"Measured over computed: {np.exp(logarithm.mean()):.1f}, deviation of ln "
        f"{logarithm.std(ddof=1):.1f}. In the band: {before} of {count} sites as computed, {after} "
        "as predicted."
    )
    return table(columns, [*textwrap.wrap(summary, WIDTH), *textwrap.wrap(SOURCE, WIDTH)])


def _text(value: float, form: str) -> str:
    return "-" if np.isnan(value) else f"{value:{form}}"
