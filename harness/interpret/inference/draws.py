"""Draws of the inputs of a layer, and the strength of simulated clay in each.

qnet of a draw is the measured qnet plus a random multiple of the error of the test, the same at all
depths. Then at each depth

    su = qnet / (Nkt(Ir, alpha, Delta, mu, delta, xi_95) e_table)

with Delta by K0 and su, and alpha, if the site file says so, by the sleeve friction and su; both by
iteration. The sleeve friction then has a random error of its own in each draw, the same at all
depths. e_table is the error of the table. If `use` names sleeve or pore pressure, each draw is
weighted by the likelihood of the layer's mean of fs and u2 - u0. How fs and u2 of real clay differ
from those of simulated clay is told in `weights`. If u2 is not measured, each draw has its own Bq,
by the table, this difference and its error, and with net area ratio a

    qnet = (qc + (1 - a) u0 - sigma_v0) / (1 - (1 - a) Bq)
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.interpret.forms import ByDepth
from harness.interpret.inference.weights import HALF_WIDTH, measures_of
from harness.interpret.measured import BQ_RANGE
from harness.interpret.result import GROUND
from harness.interpret.site import Layer, Site
from harness.interpret.tables.factors import (
    PRESSURE,
    QUANTITIES,
    RANGES,
    TABLE_RATE,
    USUAL_RADIUS,
    USUAL_SPEED,
    Along,
    at_table_rate,
    factors,
)
from harness.interpret.tables.model_factor import (
    RATIOS,
    SIMULATED,
    SITE,
    model_causes,
    model_factor,
    over_average,
    typical,
)
from harness.study.distributions import Input, normal, sampled
from harness.study.tables import StudyError
from mpm_warp.grid.fitted import Floats

LEAST_RESISTANCE = 0.01
"""Least qnet of a draw, over the measured qnet."""
REPETITIONS = 30
"""Largest number of iterations of su, Delta and alpha."""
SETTLED = 1e-6
"""Relative change of su at which the iteration ends."""
MOST_OUTSIDE = 0.05
"""Largest share of the draws of a layer outside the table; these are moved to its edge."""
MODEL_SEED = 2**32
"""Added to the seed for draws of the model factor."""
MEASUREMENT, TABLE_ERROR, WEIGHT = "test", "numerical", "unit_weight"
FRICTION, UNMEASURED = "sleeve_friction", "pore_pressure"
"""Causes of an error that are not inputs of a layer. That of the sleeve friction counts where the
adhesion follows from it, that of the pore pressure where u2 is not measured."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Draws of one layer; su is that of simulated clay, the average of three modes."""

    inputs: Mapping[str, Floats]  # causes by name, and `model_causes`, shape [draws]
    resistance: Floats  # qnet [Pa], shape [depths, draws]
    strength: Floats  # su [Pa], shape [depths, draws]
    ground: Mapping[str, Floats]  # quantities of `GROUND`, shape [depths, draws]
    outside: Floats  # share of the draws with Delta outside the table, shape [depths]
    log_likelihood: Floats  # of each draw by sleeve and pore pressure, shape [draws]
    expected: Mapping[
        str, Floats
    ]  # mean of fs and of u2 - u0 in simulated clay [Pa], shape [draws]
    beside: Mapping[str, Floats]  # `Measure.beside`, by measure, shape [1 + depths, 3]


def inputs_of(site: Site, layer: Layer) -> Mapping[str, Input]:
    """The inputs of a layer; with ratios of strength if tests of a laboratory need them."""
    asked = RATIOS if site.laboratory and layer.strength != SIMULATED else ()
    return {**layer.inputs, **{name: getattr(layer, name) for name in asked}}


def draw(site: Site, number: int, test: xr.Dataset, here: np.ndarray) -> Drawn:
    """Draw the inputs of a layer, and find the strength of each draw at the indices of depths."""
    layer, weight = site.layers[number], site.test.unit_weight
    table, drawn_share = factors(), test.attrs["drawn_share"]
    inputs = _drawn_inputs(site, number, is_u2_drawn=drawn_share > 0.0)
    at = {str(name): array.values[here, None] for name, array in test.variables.items()}
    stress = at["vertical_stress"]
    if not isinstance(weight, ByDepth):
        stress = stress + at["depth"] * (inputs[WEIGHT] - weight.at(0.5))
    qt_error = at["total_resistance_error"] * inputs[MEASUREMENT]
    net, least = at["total_resistance"] + qt_error - stress, LEAST_RESISTANCE * at["net_resistance"]
    soil, ratio = _in_table(site, number, rate_of(site, number, test), inputs)
    along, error = table.along(soil), np.exp(inputs[TABLE_ERROR])

    measures = measures_of(site.test, test, here, layer.strength)
    friction, friction_error = at["sleeve_friction"], np.zeros(site.samples)
    if is_by_sleeve(layer):
        friction_error = measures["sleeve"].deviation[:, None] * inputs[FRICTION]

    pressure = measures["pore_pressure"]
    # qnet if Bq were 0, where u2 is not measured
    plain = net - drawn_share * typical("Bq") * at["net_resistance"]
    net = np.maximum(net, least)
    of_pressure = np.exp(pressure.shift + pressure.width * inputs.get(UNMEASURED, 0.0)) / error

    # Delta, the adhesion by the sleeve and an unmeasured u2 depend on the strength: all iterated.
    strength = net / (10.0 * ratio * error)
    for _ in range(REPETITIONS):
        anisotropy = _anisotropy(inputs, stress - at["water_pressure"], strength) / ratio
        held = np.clip(anisotropy, *RANGES["stress_anisotropy"])
        adhesion = _adhesion(inputs, friction + friction_error, strength * ratio, along, held)
        own = along(held, adhesion, len(QUANTITIES) if drawn_share else 1)
        if drawn_share:
            share = np.minimum(own[PRESSURE] / own["cone_factor"] * of_pressure, BQ_RANGE[1])
            net = np.maximum(plain / (1.0 - drawn_share * share), least)
        before, strength = strength, net / (own["cone_factor"] * ratio * error)
        if np.max(np.abs(strength / before - 1.0)) < SETTLED:
            break
    simulated = along(held, adhesion)
    likelihood = np.zeros(site.samples)
    errors = {"sleeve": friction_error, "pore_pressure": np.zeros(site.samples)}
    beside, means = {}, {}
    for name, measure in measures.items():
        expected = simulated[measure.quantity] * ratio * strength - errors[name]
        beside[name] = measure.beside(expected, site.seed)
        means[name] = expected.mean(axis=0)
        if name in site.use:
            likelihood += measure.log_likelihood(expected)
    low, high = RANGES["stress_anisotropy"]
    outside = np.mean((anisotropy < low) | (anisotropy > high), axis=1)
    relative = net / error / at["net_resistance"]
    of_ground = (strength * ratio, soil["rigidity_index"], adhesion, held, relative)
    ground = {
        name: np.broadcast_to(draws, strength.shape)
        for name, draws in zip(GROUND, of_ground, strict=True)
    }
    return Drawn(inputs, net, strength, ground, outside, likelihood, means, beside)


def _drawn_inputs(site: Site, number: int, *, is_u2_drawn: bool) -> Mapping[str, Floats]:
    """All that is drawn for a layer, by cause, shape [draws]."""
    layer, weight = site.layers[number], site.test.unit_weight
    causes = {
        **inputs_of(site, layer),
        MEASUREMENT: normal(1.0 / HALF_WIDTH),
        TABLE_ERROR: normal(factors().half_widths["cone_factor"] / HALF_WIDTH),
        SITE: normal(1.0),  # for simulated clay too, so that all modes have the same draws
    }
    if not isinstance(weight, ByDepth):
        causes[WEIGHT] = weight
    if is_by_sleeve(layer):
        causes[FRICTION] = normal(1.0)
    if is_u2_drawn:
        causes[UNMEASURED] = normal(1.0)
    inputs = sampled(causes, site.samples, site.seed + number)
    if layer.strength == SIMULATED:
        del inputs[SITE]
        return inputs
    of_model = model_causes(model_factor())
    return sampled(of_model, site.samples, MODEL_SEED + site.seed + number) | inputs


def rate_of(site: Site, number: int, test: xr.Dataset) -> float:
    """Shear strain rate of the su of a layer [1/s], for a cone with the strain rates of the table.

    Strain rates scale with speed over radius, and only the ratio of both rates counts.
    """
    radius = float(test.attrs["cone_radius"])
    over_usual = 1e-3 * site.test.speed / USUAL_SPEED * USUAL_RADIUS / radius
    return site.layers[number].laboratory_rate / over_usual


def _in_table(
    site: Site, number: int, rate: float, inputs: Mapping[str, Floats]
) -> tuple[dict[str, Floats], Floats]:
    """The soil of each draw at the rate of the table, and su' / su; see `at_table_rate`."""
    layer = site.layers[number]
    given = {
        "rigidity_index": inputs["rigidity_index"] * of_mode(layer.rigidity_strength, inputs),
        "rate_factor": inputs["rate_factor"],
        "remoulded_strength_ratio": 1.0 / inputs["sensitivity"],
        "ductility": inputs["ductility"],
    }
    soil, _ = at_table_rate(given, rate)
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
    edge = most / (1.0 + most * math.log10(rate / TABLE_RATE))
    given["rate_factor"] = np.minimum(given["rate_factor"], edge)
    soil, ratio = at_table_rate(given, rate)
    return {name: np.clip(value, *RANGES[name]) for name, value in soil.items()}, ratio


def of_mode(mode: str, inputs: Mapping[str, Floats]) -> Floats | float:
    """Strength in a mode over that of simulated clay, without the model factor."""
    ratios = [inputs[name] for name in RATIOS if name in inputs]
    return over_average(*ratios).get(mode, 1.0) if ratios else 1.0


def _anisotropy(inputs: Mapping[str, Floats], effective: Floats, strength: Floats) -> Floats:
    """Delta = (sigma_v0 - sigma_h0) / (2 su), as given or by K0."""
    if "stress_anisotropy" in inputs:
        return np.broadcast_to(inputs["stress_anisotropy"], strength.shape)
    delta: Floats = (1.0 - inputs["K0"]) * np.maximum(effective, 0.0) / (2.0 * strength)
    return delta


def is_by_sleeve(layer: Layer) -> bool:
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
