"""Strength of real clay by draws of simulated clay, the model factor, and tests of a laboratory."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.interpret.inference.calibration import Calibration, Compared, calibration
from harness.interpret.inference.draws import Drawn, draw, of_mode
from harness.interpret.inference.weights import chosen_draws
from harness.interpret.site import Layer, Site
from harness.interpret.tables.model_factor import (
    BETWEEN,
    DEPTH,
    SIMULATED,
    SITE,
    WITHIN,
    model_factor,
    with_model_factor,
)
from mpm_warp.grid.fitted import Floats

APART = 0.5
"""A test of the laboratory is compared with the cone if a depth with a strength is so near [m]."""
USUAL_RATE = 0.01 / 3600.0
"""Shear strain rate of tests in a laboratory [1/s]: 1 % an hour."""
NO_TESTS = Compared((), np.zeros((0, 1)))
PERCENTILES = (5.0, 50.0, 95.0)


@dataclass(frozen=True, eq=False)
class Stated:
    """Draws of the strength of a layer in the mode that is asked."""

    inputs: Mapping[str, Floats]  # causes by name, shape [draws]
    before: Mapping[str, Floats]  # those that tests of a laboratory change, without them
    strength: Floats  # [Pa], shape [depths, draws]
    log_likelihood: Floats  # of each draw, by sleeve, pore pressure and laboratory, shape [draws]


def stated(layer: Layer, drawn: Drawn, tests: Calibration | None) -> Stated:
    """The strength of a layer, by draws of simulated clay and tests of a laboratory, if any."""
    if layer.strength == SIMULATED:
        return Stated(drawn.inputs, {}, drawn.strength, drawn.log_likelihood)
    prior = model_factor().of_site(layer.strength, drawn.inputs[BETWEEN])
    inputs, likelihood = with_model_factor(drawn.inputs, *prior), drawn.log_likelihood
    before = {SITE: inputs[SITE]}
    if tests is not None:
        belief = tests.belief()
        asked = belief.mean[:, 0], belief.covariance[:, 0, 0]
        inputs = with_model_factor(drawn.inputs, *asked)
        likelihood = likelihood + belief.log_likelihood
    ratio = of_mode(layer.strength, drawn.inputs) / (inputs[SITE] * inputs[DEPTH])
    return Stated(inputs, before, drawn.strength * ratio, likelihood)


def compared(site: Site, number: int, test: xr.Dataset, here: np.ndarray) -> Compared:
    """The tests of a laboratory in a layer, beside the cone at the indices of depths."""
    layer, depth = site.layers[number], test.depth.values[here]
    tests = tuple(
        one
        for one in site.laboratory
        if site.layer_at(np.array([one.depth]))[0] == number
        and len(depth)
        and np.min(np.abs(depth - one.depth)) <= APART
    )
    if not tests or layer.strength == SIMULATED:
        return NO_TESTS
    own = np.array([one.depth for one in tests])
    below = np.clip(np.searchsorted(depth, own), min(1, len(depth) - 1), len(depth) - 1)
    above = np.maximum(below - 1, 0)
    rows, places = np.unique([above, below], return_inverse=True)
    drawn = draw(site, number, test, here[rows])
    first, second = np.log(drawn.strength)[places.reshape(2, -1)]
    step = np.maximum(depth[below] - depth[above], 1e-9)
    share = np.clip((own - depth[above]) / step, 0.0, 1.0)[:, None]
    slower = np.log10(layer.laboratory_rate / USUAL_RATE)
    at_usual_rate = np.log(np.maximum(1.0 - drawn.inputs["rate_factor"] * slower, 0.1))
    modes = np.stack(
        [np.log(of_mode(one.kind.mode, drawn.inputs)) + at_usual_rate for one in tests]
    )
    measured = np.log(1e3 * np.array([one.strength for one in tests]))[:, None]
    return Compared(tests, first + share * (second - first) + modes - measured)


def calibrated(
    layer: Layer, drawn: Drawn, own: Compared, others: Sequence[Compared]
) -> Calibration | None:
    """The tests of a site as they count for a layer; None if there are none."""
    others = [group for group in others if group.tests]
    if layer.strength == SIMULATED or not (own.tests or others):
        return None
    deviations = drawn.inputs[BETWEEN], drawn.inputs[WITHIN]
    return calibration(model_factor(), layer.strength, deviations, own, others)


def judged(
    layer: Layer, tests: Calibration, own: Compared, drawn: Drawn, seed: int
) -> tuple[Floats, Floats]:
    """What each test of a layer is beside all the others [Pa].

    Returns:
        Percentiles of the strength that the others let expect of the test, shape [tests,
        percentiles]; and the strength of the test, brought to the mode of the layer, shape [tests].
    """
    belief, expected, converted = tests.belief(), [], []
    known, _ = chosen_draws(drawn.log_likelihood + belief.log_likelihood, seed)
    for number, test in enumerate(own.tests):
        place, factor, _ = tests.measurements[number]
        by_others, likelihood = tests.expected(number, drawn.inputs[SITE], drawn.inputs[DEPTH])
        chosen, _ = chosen_draws(drawn.log_likelihood + likelihood, seed)
        over = np.exp(factor - by_others)[chosen]
        expected.append(1e3 * test.strength * np.percentile(over, PERCENTILES))
        ratio = of_mode(layer.strength, drawn.inputs) / of_mode(test.kind.mode, drawn.inputs)
        ratio = ratio * np.exp(belief.mean[:, place] - belief.mean[:, 0])
        ratio = np.broadcast_to(ratio / np.exp(test.kind.mean), drawn.log_likelihood.shape)
        converted.append(1e3 * test.strength * np.median(ratio[known]))
    return np.reshape(expected, (len(expected), len(PERCENTILES))), np.array(converted)
