"""Undrained shear strength by depth, with the causes of its error.

For each layer the inputs are drawn many times. qnet of each draw is the measured qnet plus a random
multiple of the error of the test, the same at all depths. Then at each depth

    su = qnet / (Nkt(Ir, alpha, Delta, mu, delta, xi_95) e_table)

with Delta by K0 and su, and alpha, if the site file says so, by the sleeve friction and su; both by
iteration. The sleeve friction then has a random error of its own in each draw, the same at all
depths. e_table is the error of the table. This is the strength of simulated clay. Real clay differs
from it by the model factor, by which the strength that is stated is divided. Each draw has one of
the site and one of the depths; the latter is the same at all depths, so that a mean over depths has
the band of a depth. If `use` names sleeve or pore pressure, each draw is weighted by the likelihood
of the layer's mean of fs and u2 - u0, and the draws are resampled by their weights. How fs and u2
of real clay differ from those of simulated clay is not measured.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from harness.interpret.borders import edges_of_runs, near_border, without_borders
from harness.interpret.columns import GAP
from harness.interpret.factors import RANGES, TABLE_RATE, Along, at_table_rate, factors
from harness.interpret.forms import ByDepth
from harness.interpret.measured import NO_INDEX, OTHER_LAYER, REASONS, measured
from harness.interpret.model_factor import (
    DEPTH,
    RATIOS,
    SIMULATED,
    SITE,
    model_causes,
    model_factor,
    over_average,
    with_model_factor,
)
from harness.interpret.result import GROUND, PERCENTILES, without_strength
from harness.interpret.shares import TOGETHER, error_shares
from harness.interpret.site import Layer, Site
from harness.interpret.weights import HALF_WIDTH, Measure, chosen_draws, measures_of
from harness.machine import memory_of_machine
from harness.study.distributions import normal, sampled
from harness.study.tables import StudyError
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled

LEAST_RESISTANCE = 0.01
"""Least qnet of a draw, over the measured qnet."""
REPETITIONS = 30
"""Largest number of iterations of su, Delta and alpha."""
SETTLED = 1e-6
"""Relative change of su at which the iteration ends."""
MOST_OUTSIDE = 0.05
"""Largest share of the draws of a layer outside the table; these are moved to its edge."""
MOST_OF_ANISOTROPY = 0.5
"""Largest share of the draws at a depth with Delta outside the table; these are moved to its edge,
because ground with Delta of 1 or more would have failed before any test."""
SAND = [REASONS.index("not undrained clay"), REASONS.index(NO_INDEX)]
"""Reasons of rows that are, or may be, sand: the clay beside them feels another layer."""
MEASUREMENT, TABLE_ERROR, WEIGHT = "test", "numerical", "unit_weight"
FRICTION = "sleeve_friction"
"""Causes of an error that are not inputs of a layer. That of the sleeve friction counts where the
adhesion follows from it."""
DRAW_BYTES = 160
"""Memory of a draw at a depth while a layer is interpreted [byte]: twenty numbers, as measured."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Draws of one layer."""

    inputs: Mapping[str, Floats]  # causes by name, shape [draws]
    factor: Floats  # Nkt with all errors, for su in the mode of the layer, shape [depths, draws]
    strength: Floats  # su in the mode of the layer [Pa], shape [depths, draws]
    ground: Mapping[str, Floats]  # quantities of `GROUND`, shape [depths, draws]
    outside: Floats  # share of the draws with Delta outside the table, shape [depths]
    log_likelihood: Floats  # of each draw by sleeve and pore pressure, shape [draws]


def interpret(site: Site, *, sharpen: bool = False) -> xr.Dataset:
    """Strength of the layers of a site by depth.

    Args:
        site: its test and layers.
        sharpen: whether the effect of borders on the resistance is removed.

    Returns:
        By `depth`: measured and corrected values, `near_border`, medians of `GROUND`, and `reason`
        (an index of its flag_meanings), why a depth has no strength. By depth and `percentile`:
        `strength` and `resistance_factor`. By depth and `cause`: `error_share`. By `layer`, cause
        and percentile: `input_before` and `input_after`.

    Raises:
        StudyError: the file of the test is wrong, or an input of a layer leaves the table.
    """
    test = measured(site.test)
    _refuse_without_values(site, test)
    depth, borders, radius = test.depth.values, site.borders, test.attrs["cone_radius"]
    used, placed = without_borders(test, borders, radius) if sharpen else (test, borders)
    names = dict.fromkeys(name for layer in site.layers for name in layer.inputs)
    by_sleeve = [FRICTION] if any(map(_is_by_sleeve, site.layers)) else []
    of_model = [SITE, DEPTH] if any(layer.strength != SIMULATED for layer in site.layers) else []
    causes = [*names, WEIGHT, MEASUREMENT, *by_sleeve, TABLE_ERROR, *of_model, TOGETHER]
    found = without_strength(site, test, causes)
    arrays = {str(name): variable.values for name, variable in found.data_vars.items()}
    reason, strength, share = (arrays[name] for name in ("reason", "strength", "error_share"))
    in_layer = site.layer_at(depth)
    reason[in_layer < 0] = REASONS.index("no layer")
    notes = [found.attrs["notes"]] if found.attrs["notes"] else []
    notes += _moved_borders(borders, placed, depth, reason)
    notes += _beyond_the_test(site.layers, depth)
    for number, layer in enumerate(site.layers):
        if _is_by_sleeve(layer):
            lacking = ~(test.sleeve_friction.values > 0.0) & (reason == 0)
            reason[lacking & (in_layer == number)] = REASONS.index("value missing")
        here = np.flatnonzero((in_layer == number) & (reason == 0))
        if not len(here):
            arrays["draws"][number] = 0.0
            continue
        if DRAW_BYTES * len(here) * site.samples > (most := memory_of_machine()):
            raise StudyError(
                f"{site.name}.toml: samples = {site.samples}: with {len(here)} depths in the layer "
                f"{layer.title} at most {int(most / DRAW_BYTES / len(here))} fit into "
                f"{most / 1e9:.3g} GB of memory"
            )
        notes += _unused(site, layer, measures_of(site.test, used, here))
        drawn = draw(site, number, used, here)
        chosen, arrays["draws"][number] = chosen_draws(drawn.log_likelihood, site.seed)
        distinct, weights = np.unique(chosen, return_counts=True)
        for name, draws in (("strength", drawn.strength), ("resistance_factor", drawn.factor)):
            arrays[name][here] = np.percentile(draws[:, chosen], PERCENTILES, axis=1).T
        for name, draws in drawn.ground.items():
            arrays[name][here] = np.median(draws[:, chosen], axis=1)
        inputs = {name: it[distinct] for name, it in drawn.inputs.items()}
        shares = error_shares(inputs, np.log(drawn.strength[:, distinct]), weights)
        for place, cause in enumerate(causes):
            if cause in shares:
                share[here, place] = shares[cause]
            if cause in drawn.inputs:
                draws = drawn.inputs[cause]
                arrays["input_before"][number, place] = np.percentile(draws, PERCENTILES)
                arrays["input_after"][number, place] = np.percentile(draws[chosen], PERCENTILES)
        left = here[drawn.outside > MOST_OF_ANISOTROPY]
        reason[left] = REASONS.index("Delta beyond the table")
        strength[left] = arrays["resistance_factor"][left] = share[left] = np.nan
    sand = edges_of_runs(depth, np.isin(reason, SAND))
    near = near_border(depth, test.net_resistance.values, [*placed, *sand], radius)
    meaning = "1 where the resistance feels another layer"
    own: dict[str, Any] = {"near_border": (near.astype(np.int8), "1", meaning)}
    if sharpen:
        told = "net resistance without the effect of borders"
        own["sharpened_resistance"] = (used.net_resistance.values, "Pa", told)
    return found.assign(labelled(dims=("depth",), **own)).assign_attrs(notes="; ".join(notes))


def _refuse_without_values(site: Site, test: xr.Dataset) -> None:
    """Refuse a site that needs fs or u2 of a test that has no value of it."""
    by_sleeve = [layer.title for layer in site.layers if _is_by_sleeve(layer)]
    asked = [("fs", "sleeve_friction", f"adhesion_factor of {title}") for title in by_sleeve]
    if "sleeve" in site.use:
        asked.append(("fs", "sleeve_friction", "use"))
    if "pore_pressure" in site.use:
        asked.append(("u2", "pore_pressure", "use"))
    for name, variable, key in asked:
        if test[variable].isnull().all():
            raise StudyError(f"{site.name}.toml: {key} asks for {name}, which the test has not")


def _moved_borders(
    borders: Sequence[float], placed: Sequence[float], depth: Floats, reason: np.ndarray
) -> list[str]:
    """Notes on borders found at another depth; no strength between, which `reason` is told."""
    notes = []
    for said, lies in zip(borders, placed, strict=True):
        between = (depth >= min(said, lies)) & (depth < max(said, lies))
        if between.any():
            reason[between & (reason == 0)] = REASONS.index(OTHER_LAYER)
            notes.append(f"border told at {said:.2f} m, found at {lies:.2f} m")
    return notes


def _unused(site: Site, layer: Layer, measures: Mapping[str, Measure]) -> list[str]:
    """Notes on what `use` names and a layer cannot use."""
    return [
        f"{layer.title}: the {name.replace('_', ' ')} is not used, its mean is not above 0"
        for name, measure in measures.items()
        if name in site.use and not measure.mean > 0.0
    ]


def _beyond_the_test(layers: Sequence[Layer], depth: Floats) -> list[str]:
    """Notes on layers that reach above or below the depths of the test."""
    first, last = depth[0], depth[-1]
    notes = []
    for layer in layers:
        if layer.top < first - GAP:
            notes.append(f"a layer begins at {layer.top:g} m, the test at {first:g} m")
        if layer.bottom > last + GAP:
            notes.append(f"a layer ends at {layer.bottom:g} m, the test at {last:g} m")
    return notes


def draw(site: Site, number: int, test: xr.Dataset, here: np.ndarray) -> Drawn:
    """Draw the inputs of a layer, and find the strength of each draw at the indices of depths."""
    layer, weight = site.layers[number], site.test.unit_weight
    table, known = factors(), model_factor()
    causes = {
        **layer.inputs,
        MEASUREMENT: normal(1.0 / HALF_WIDTH),
        TABLE_ERROR: normal(table.half_widths["cone_factor"] / HALF_WIDTH),
    }
    if not isinstance(weight, ByDepth):
        causes[WEIGHT] = weight
    if _is_by_sleeve(layer):
        causes[FRICTION] = normal(1.0)
    if layer.strength != SIMULATED:
        causes |= model_causes(known)
    drawn = sampled(causes, site.samples, site.seed + number)
    inputs = with_model_factor(known, layer.strength, drawn)

    at = {str(name): array.values[here, None] for name, array in test.variables.items()}
    stress = at["vertical_stress"]
    if not isinstance(weight, ByDepth):
        stress = stress + at["depth"] * (inputs[WEIGHT] - weight.at(0.5))
    qt_error = at["total_resistance_error"] * inputs[MEASUREMENT]
    net = at["total_resistance"] + qt_error - stress
    net = np.maximum(net, LEAST_RESISTANCE * at["net_resistance"])
    soil, ratio = _in_table(site, number, inputs)
    along, error = table.along(soil), np.exp(inputs[TABLE_ERROR])

    measures = measures_of(site.test, test, here)
    friction, friction_error = at["sleeve_friction"], np.zeros(site.samples)
    if _is_by_sleeve(layer):
        friction_error = measures["sleeve"].deviation[:, None] * inputs[FRICTION]

    # Delta and the adhesion by the sleeve depend on the strength, so all three are iterated.
    strength = net / (10.0 * ratio * error)
    for _ in range(REPETITIONS):
        anisotropy = _anisotropy(inputs, stress - at["water_pressure"], strength) / ratio
        held = np.clip(anisotropy, *RANGES["stress_anisotropy"])
        adhesion = _adhesion(inputs, friction + friction_error, strength * ratio, along, held)
        factor = along(held, adhesion, 1)["cone_factor"] * ratio * error
        before, strength = strength, net / factor
        if np.max(np.abs(strength / before - 1.0)) < SETTLED:
            break
    simulated = along(held, adhesion)
    likelihood = np.zeros(site.samples)
    errors = {"sleeve": friction_error, "pore_pressure": np.zeros(site.samples)}
    for name, measure in measures.items():
        if name in site.use:
            expected = simulated[measure.quantity] * ratio * strength
            likelihood += measure.log_likelihood(expected - errors[name])
    low, high = RANGES["stress_anisotropy"]
    outside = np.mean((anisotropy < low) | (anisotropy > high), axis=1)
    wanted = strength * _over_simulated(layer, inputs)
    own = net / error / at["net_resistance"]
    of_ground = (strength * ratio, soil["rigidity_index"], adhesion, held, own)
    ground = {
        name: np.broadcast_to(draws, strength.shape)
        for name, draws in zip(GROUND, of_ground, strict=True)
    }
    return Drawn(inputs, net / wanted, wanted, ground, outside, likelihood)


def _in_table(
    site: Site, number: int, inputs: Mapping[str, Floats]
) -> tuple[dict[str, Floats], Floats]:
    """The soil of each draw at the rate of the table, and su' / su; see `at_table_rate`."""
    layer = site.layers[number]
    given = {
        "rigidity_index": inputs["rigidity_index"],
        "rate_factor": inputs["rate_factor"],
        "remoulded_strength_ratio": 1.0 / inputs["sensitivity"],
        "ductility": inputs["ductility"],
    }
    soil, _ = at_table_rate(given, layer.laboratory_rate)
    for name, values in soil.items():
        low, high = RANGES[name]
        share = np.mean((values < low) | (values > high))
        if share > MOST_OUTSIDE:
            raise StudyError(
                f"{site.name}.toml: [[layer]] {number + 1} ({layer.title}): {share:.0%} of the "
                f"draws leave the table of factors: {name} is {values.min():.3g} to "
                f"{values.max():.3g} at its strain rate, must be {low:g} to {high:g}"
            )
    # With mu' at the edge mu is mu' / (1 + mu' L); a draw beyond may have no strength left there.
    most = RANGES["rate_factor"][1]
    edge = most / (1.0 + most * math.log10(layer.laboratory_rate / TABLE_RATE))
    given["rate_factor"] = np.minimum(given["rate_factor"], edge)
    soil, ratio = at_table_rate(given, layer.laboratory_rate)
    return {name: np.clip(value, *RANGES[name]) for name, value in soil.items()}, ratio


def _anisotropy(inputs: Mapping[str, Floats], effective: Floats, strength: Floats) -> Floats:
    """Delta = (sigma_v0 - sigma_h0) / (2 su), as given or by K0."""
    if "stress_anisotropy" in inputs:
        return np.broadcast_to(inputs["stress_anisotropy"], strength.shape)
    delta: Floats = (1.0 - inputs["K0"]) * np.maximum(effective, 0.0) / (2.0 * strength)
    return delta


def _is_by_sleeve(layer: Layer) -> bool:
    """Whether the adhesion factor follows from the sleeve friction."""
    return "adhesion_factor" not in layer.inputs


def _adhesion(
    inputs: Mapping[str, Floats], friction: Floats, strength: Floats, along: Along, delta: Floats
) -> Floats:
    """The adhesion factor, as given or by the sleeve friction."""
    if "adhesion_factor" in inputs:
        return np.broadcast_to(inputs["adhesion_factor"], strength.shape)
    rough = along(delta, np.ones_like(delta))["sleeve_friction_factor"]
    return np.clip(friction / (strength * rough), 0.0, 1.0)


def _over_simulated(layer: Layer, inputs: Mapping[str, Floats]) -> Floats | float:
    """Strength in the mode of the layer over that of simulated clay, which is the average."""
    if layer.strength == SIMULATED:
        return 1.0
    ratio: Floats | float = 1.0
    if RATIOS.keys() <= inputs.keys():
        ratio = over_average(*(inputs[name] for name in RATIOS))[layer.strength]
    return ratio / (inputs[SITE] * inputs[DEPTH])
