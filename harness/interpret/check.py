"""Check of an interpretation: a simulated sounding through its ground, beside the measured one.

The ground has the medians by depth. In each layer strength, rigidity index, adhesion factor and
stress anisotropy are straight lines between a few depths, by least squares. Rate effect and
softening are means over the layers, because a simulated sounding has them constant. In a gap
between layers the ground changes linearly.

The misfit is relative to the resistance of the ground, as the interpretation finds it. Sleeve and
pore pressure may show that the measured resistance has an error: in soft clay a shift within
class 2 is a quarter of it. The difference of the two is stated with the misfit.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from harness.errors import HarnessError
from harness.interpret.inference.draws import rate_of
from harness.interpret.result import GROUND
from harness.interpret.site import Site
from harness.interpret.tables.factors import TABLE_RATE, USUAL_RADIUS, at_table_rate
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.sounding import Sounding

ACCURACY: Mapping[str, Mapping[str, float]] = {
    "quick": {"cells_per_radius": 2.0, "speed_ratio": 0.1},
    "standard": {},
}
"""Mesh and speed of the simulation; `standard` has the defaults of the scene."""
KNOTS = 30.0
"""Least distance of two depths of the ground, over the radius of the cone."""
STEADY = 0.01
"""Weight of second differences of the ground, relative to its misfit. They determine the ground
where no depth has a strength."""


def sounding_of(site: Site, found: xr.Dataset, accuracy: str) -> Sounding:
    """The sounding through the ground that `interpret` found, to be run."""
    radius, depth = found.attrs["cone_radius"], found.depth.values
    rows, soils, thicknesses = [], [], []
    for number, layer in enumerate(site.layers):
        inside = (site.layer_at(depth) == number) & (found.reason.values == 0)
        # Near a border the resistance is also of another layer, unless it is sharpened.
        own = inside & (found.near_border.values == 0)
        if "sharpened_resistance" in found or not own.any():
            own = inside
        if not own.any():
            continue
        count = 1 + max(1, int((layer.bottom - layer.top) / (KNOTS * radius)))
        knots = np.linspace(layer.top, layer.bottom, count)
        columns = [_at_knots(depth[own], found[name].values[own], knots) for name in GROUND]
        rows.append(np.stack([knots, *columns]))
        medians = found.input_after.isel(layer=number).sel(percentile=50.0)
        inputs = {name: medians.sel(cause=name).values for name in layer.inputs}
        inputs["remoulded_strength_ratio"] = 1.0 / inputs["sensitivity"]
        names = ("rate_factor", "remoulded_strength_ratio", "ductility")
        soil, _ = at_table_rate(
            {name: inputs[name] for name in names}, rate_of(site, number, found)
        )
        soils.append([float(value) for value in soil.values()])
        thicknesses.append(layer.bottom - layer.top)
    if not rows:
        raise HarnessError(f"{site.name}: no depth has a strength, so there is nothing to check")
    ground = np.concatenate(rows, axis=1)
    first, last = ground[0, 0], min(ground[0, -1], float(depth[-1]))
    ground = np.concatenate([ground[:, :1], ground], axis=1)
    ground[0, 0] = 0.0  # the cone starts above its first depth
    strength, index, adhesion, anisotropy, _ = ground[1:]
    profile = Profile(
        depth=ground[0],
        strength=strength,
        shear_modulus=index * strength,
        unit_weight=np.full_like(strength, 17e3),  # has no effect on net resistance
        adhesion_factor=adhesion,
        stress_anisotropy=anisotropy,
    )
    rate, remoulded, ductility = np.average(soils, axis=0, weights=thicknesses)
    changes: dict[str, Any] = dict(ACCURACY[accuracy])
    if rate > 0.0:
        changes |= {
            "rate_factor": rate,
            "reference_strain_rate": TABLE_RATE * USUAL_RADIUS / radius,
        }
    if remoulded < 1.0:
        changes |= {"remoulded_strength_ratio": remoulded, "ductility": ductility}
    return Sounding(
        profile=profile.text,
        cone_radius=radius,
        from_depth=max(first, float(depth[0])),
        to_depth=last,
        **changes,
    )


def _at_knots(depth: Floats, values: Floats, knots: Floats) -> Floats:
    """Values at knots: straight lines between them fit those at depths, within their range."""
    lines = np.stack([np.interp(depth, knots, unit) for unit in np.eye(len(knots))], axis=-1)
    bends = STEADY * np.diff(np.eye(len(knots)), n=2, axis=0)
    right = np.concatenate([values, np.zeros(len(bends))])
    at, *_ = np.linalg.lstsq(np.concatenate([lines, bends]), right, rcond=None)
    within: Floats = np.clip(at, values.min(), values.max())
    return within


def checked(found: xr.Dataset, simulated: xr.Dataset) -> xr.Dataset:
    """The result of `interpret`, with the simulated sounding at the depths of the test."""
    depth, at = found.depth.values, simulated.depth.values
    net, friction, excess, ground = (
        np.interp(depth, at, simulated[name].values, left=np.nan, right=np.nan)
        for name in ("net_resistance", "sleeve_friction", "excess_pore_pressure", "strength")
    )
    pressure = excess + found.water_pressure.values
    expected = (found.net_resistance * found.ground_resistance_ratio).values
    misfit = np.where(found.reason == 0, net / expected - 1.0, np.nan)
    return found.assign(
        labelled(
            dims=("depth",),
            simulated_net_resistance=(net, "Pa", "net resistance, simulated"),
            simulated_sleeve_friction=(friction, "Pa", "sleeve friction, simulated"),
            simulated_pore_pressure=(pressure, "Pa", "pore pressure u2, simulated"),
            simulated_strength=(ground, "Pa", "strength of the ground that was simulated"),
            expected_resistance=(expected, "Pa", "net resistance of the interpreted ground"),
            misfit=(misfit, "1", "simulated over expected net resistance, less 1"),
        )
    )


def misfit_in_words(site: Site, found: xr.Dataset) -> list[str]:
    """How far the simulated net resistance is from the expected one, a sentence a layer."""
    sentences = []
    in_layer = site.layer_at(found.depth.values)
    for number in range(len(site.layers)):
        own = found.misfit[(in_layer == number) & found.misfit.notnull().values]
        if not own.size:
            title = found.layer.values[number]
            sentences.append(f"{title}: no depth with a strength is in the simulated sounding")
            continue
        worst = own[int(np.argmax(np.abs(own.values)))]
        error = (found.total_resistance_error / found.net_resistance).sel(depth=own.depth)
        shift = float(found.ground_resistance_ratio.sel(depth=own.depth).mean()) - 1.0
        near = found.near_border.sel(depth=own.depth) != 0
        parts = [f"{float(own.mean()):+.1%} on average"]
        for where, part in (("near borders", own[near]), ("elsewhere", own[~near])):
            if part.size:
                parts.append(f"{float(np.abs(part).mean()):.1%} in absolute value {where}")
        sentences.append(
            f"{found.layer.values[number]}: simulated net resistance differs from the expected one "
            f"by {', '.join(parts)}; the largest difference is {float(worst):+.1%}, at "
            f"{float(worst.depth):.2f} m; the expected one is the measured one {shift:+z.1%}, by "
            f"the measures in `use`; the error of the test is {float(error.mean()):.1%}, half "
            "width of 95 %"
        )
    return sentences
