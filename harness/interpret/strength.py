"""Undrained shear strength by depth, with the causes of its error.

For each layer the inputs are drawn many times, which gives the strength of simulated clay. Real
clay differs from it by the model factor, by which this strength is divided. Each draw has one of
the site and one of the depths; the latter is the same at all depths, so that a mean over depths has
the band of a depth. The draws are resampled by their weights, which sleeve and pore pressure give,
if `use` names them, and tests of a laboratory.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from harness.interpret.columns import GAP
from harness.interpret.forms import MEASURES
from harness.interpret.inference.borders import edges_of_runs, near_border, without_borders
from harness.interpret.inference.calibration import Compared
from harness.interpret.inference.draws import (
    FRICTION,
    MEASUREMENT,
    TABLE_ERROR,
    UNMEASURED,
    WEIGHT,
    Drawn,
    draw,
    inputs_of,
    is_by_sleeve,
)
from harness.interpret.inference.line import line_figures
from harness.interpret.inference.real_clay import Stated, calibrated, compared, judged, stated
from harness.interpret.inference.shares import TOGETHER, error_shares
from harness.interpret.inference.weights import Measure, chosen_draws, measures_of
from harness.interpret.measured import NO_INDEX, OTHER_LAYER, REASONS, measured
from harness.interpret.result import PERCENTILES, with_laboratory, without_strength
from harness.interpret.site import Layer, Site
from harness.interpret.tables.model_factor import DEPTH, SIMULATED, SITE
from harness.machine import memory_of_machine
from harness.study.tables import StudyError
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled

MOST_OF_ANISOTROPY = 0.5
"""Largest share of the draws at a depth with Delta outside the table; these are moved to its edge,
because ground with Delta of 1 or more would have failed before any test."""
SAND = [REASONS.index("not undrained clay"), REASONS.index(NO_INDEX)]
"""Reasons of rows that are, or may be, sand: the clay beside them feels another layer."""
DRAW_BYTES = 160
"""Memory of a draw at a depth while a layer is interpreted [byte]: twenty numbers, as measured."""


@dataclass(frozen=True, eq=False)
class Readings:
    """A measured test, and which of its depths have a strength."""

    site: Site
    sharpen: bool  # whether the effect of borders on the resistance is removed
    test: xr.Dataset  # as measured
    used: xr.Dataset  # without the effect of borders, if that is asked
    placed: Sequence[float]  # depths of the borders as they are found [m]
    in_layer: np.ndarray  # index of the layer of each depth, -1 if none
    reason: np.ndarray  # why a depth has no strength, an index of `REASONS`
    notes: list[str]

    @classmethod
    def of(cls, site: Site, sharpen: bool) -> "Readings":
        """The test of a site."""
        test = measured(site.test)
        _refuse_without_values(site, test)
        depth, borders, radius = test.depth.values, site.borders, test.attrs["cone_radius"]
        used, placed = without_borders(test, borders, radius) if sharpen else (test, borders)
        in_layer, reason = site.layer_at(depth), test.reason.values.copy()
        reason[in_layer < 0] = REASONS.index("no layer")
        notes = [test.attrs["notes"]] if test.attrs["notes"] else []
        notes += _moved_borders(borders, placed, depth, reason)
        notes += _beyond_the_test(site.layers, depth)
        for number, layer in enumerate(site.layers):
            if is_by_sleeve(layer):
                lacking = ~(test.sleeve_friction.values > 0.0) & (reason == 0)
                reason[lacking & (in_layer == number)] = REASONS.index("value missing")
        return cls(site, sharpen, test, used, placed, in_layer, reason, notes)

    def here(self, number: int) -> np.ndarray:
        """Indices of the depths of a layer that have a strength."""
        return np.flatnonzero((self.in_layer == number) & (self.reason == 0))

    def laboratory(self) -> list[Compared]:
        """The tests of a laboratory beside the cone, by layer."""
        layers = range(len(self.site.layers))
        return [compared(self.site, number, self.used, self.here(number)) for number in layers]


def laboratory_beside(site: Site, *, sharpen: bool = False) -> list[Compared]:
    """The tests of a laboratory of a site beside its cone, by layer."""
    return Readings.of(site, sharpen).laboratory()


def interpret(site: Site, *, sharpen: bool = False, beside: Sequence[Compared] = ()) -> xr.Dataset:
    """Strength of the layers of a site by depth.

    Args:
        site: its test and layers.
        sharpen: whether the effect of borders on the resistance is removed.
        beside: tests of a laboratory beside other soundings of the site.

    Returns:
        By `depth`: measured and corrected values, `near_border`, medians of `GROUND`, and `reason`
        (an index of its flag_meanings), why a depth has no strength. By depth and `percentile`:
        `strength` and `resistance_factor`. By depth and `cause`: `error_share`. By `layer`: the
        line su = a + b z; and by layer, cause and percentile: `input_before` and `input_after`. By
        `laboratory_test`, if there are any: what was measured, and what the others let expect.

    Raises:
        StudyError: the file of the test is wrong, or an input of a layer leaves the table.
    """
    readings = Readings.of(site, sharpen)
    found = without_strength(site, readings.test, _causes(site, readings.test))
    tests, work = readings.laboratory(), _Work.of(readings, found)
    beside_others = []
    for number in range(len(site.layers)):
        others = [*tests[:number], *tests[number + 1 :], *beside]
        if (judgement := work.interpret(number, tests[number], others)) is not None:
            beside_others.append(judgement)
    meaning = "1 where the resistance feels another layer"
    own: dict[str, Any] = {"near_border": (work.near.astype(np.int8), "1", meaning)}
    if sharpen:
        told = "net resistance without the effect of borders"
        own["sharpened_resistance"] = (readings.used.net_resistance.values, "Pa", told)
    kept = [test for group in tests for test in group.tests]
    if kept:
        found = with_laboratory(found, kept, *map(np.concatenate, zip(*beside_others, strict=True)))
    notes = work.notes + [
        f"the laboratory test at {test.depth:g} m is not used: no strength of real clay beside it"
        for test in site.laboratory
        if test not in kept
    ]
    return found.assign(labelled(dims=("depth",), **own)).assign_attrs(notes="; ".join(notes))


def _causes(site: Site, test: xr.Dataset) -> list[str]:
    """Causes of the error of the strength: inputs, errors of the test, the table and the model."""
    names = dict.fromkeys(name for layer in site.layers for name in inputs_of(site, layer))
    of_test = [WEIGHT, MEASUREMENT, *([UNMEASURED] if test.attrs["drawn_share"] else [])]
    by_sleeve = [FRICTION] if any(map(is_by_sleeve, site.layers)) else []
    of_model = [SITE, DEPTH] if any(layer.strength != SIMULATED for layer in site.layers) else []
    return [*names, *of_test, *by_sleeve, TABLE_ERROR, *of_model, TOGETHER]


@dataclass(frozen=True, eq=False)
class _Work:
    """A site whose layers are interpreted one after the other, into the arrays of its result."""

    readings: Readings
    causes: Sequence[str]
    arrays: Mapping[str, np.ndarray]  # of the result, by name; a layer writes its part of each
    near: np.ndarray  # whether a depth feels another layer
    notes: list[str]

    @classmethod
    def of(cls, readings: Readings, found: xr.Dataset) -> "_Work":
        """With a result in which nothing is interpreted yet."""
        arrays = {str(name): variable.values for name, variable in found.data_vars.items()}
        arrays["reason"][:] = readings.reason
        test = readings.test
        sand = edges_of_runs(test.depth.values, np.isin(readings.reason, SAND))
        near = near_border(
            test.depth.values,
            test.net_resistance.values,
            [*readings.placed, *sand],
            test.attrs["cone_radius"],
        )
        causes = [str(name) for name in found.cause.values]
        return cls(readings, causes, arrays, near, [*readings.notes])

    def interpret(
        self, number: int, tests: Compared, others: Sequence[Compared]
    ) -> tuple[Floats, Floats, Floats] | None:
        """Interpret a layer.

        Args:
            number: of the layer.
            tests: those of a laboratory in the layer.
            others: those in the other layers, and beside other soundings of the site.

        Returns:
            Net resistance beside each test of the layer, and what `judged` says of it; None where
            no test of a laboratory counts.
        """
        site, arrays, used = self.readings.site, self.arrays, self.readings.used
        layer, here = site.layers[number], self.readings.here(number)
        if not len(here):
            arrays["draws"][number] = 0.0
            return None
        _refuse_too_large(site, layer, len(here))
        self.notes.extend(_unused(site, layer, measures_of(site.test, used, here, layer.strength)))
        drawn = draw(site, number, used, here)
        mean, *depths = np.stack([drawn.beside[name] for name in MEASURES[1:]], axis=1)
        arrays["measure_mean"][number], arrays["measure_at_depth"][here] = mean, depths
        counting = calibrated(layer, drawn, tests, others)
        clay = stated(layer, drawn, counting)
        chosen, arrays["draws"][number] = chosen_draws(clay.log_likelihood, site.seed)
        _fill(arrays, self.causes, number, here, drawn, clay, chosen)
        outside = drawn.outside > MOST_OF_ANISOTROPY
        depth = used.depth.values[here]
        own_only = ~self.near[here] | self.readings.sharpen
        line = line_figures(depth, ~outside, own_only, drawn, clay, chosen, site.seed)
        for name, values in line.items():
            arrays[name][number] = values
        left = here[outside]
        arrays["reason"][left] = REASONS.index("Delta beyond the table")
        for name in ("strength", "resistance_factor", "error_share"):
            arrays[name][left] = np.nan
        if counting is None:
            return None
        arrays["laboratory_tests"][number] = len(counting.measurements)
        net = tests.at_tests(depth, used.net_resistance.values[here])
        return net, *judged(layer, counting, tests, drawn, site.seed)


def _fill(
    arrays: Mapping[str, np.ndarray],
    causes: Sequence[str],
    number: int,
    here: np.ndarray,
    drawn: Drawn,
    clay: Stated,
    chosen: np.ndarray,
) -> None:
    """Write percentiles and shares of a layer into the arrays, by the chosen draws."""
    distinct, weights = np.unique(chosen, return_counts=True)
    factor = drawn.resistance / clay.strength
    for name, draws in (("strength", clay.strength), ("resistance_factor", factor)):
        arrays[name][here] = np.percentile(draws[:, chosen], PERCENTILES, axis=1).T
    for name, draws in drawn.ground.items():
        arrays[name][here] = np.median(draws[:, chosen], axis=1)
    inputs = {name: draws[distinct] for name, draws in clay.inputs.items()}
    shares = error_shares(inputs, np.log(clay.strength[:, distinct]), weights)
    for place, cause in enumerate(causes):
        if cause in shares:
            arrays["error_share"][here, place] = shares[cause]
        if cause in clay.inputs:
            draws = clay.inputs[cause]
            before = clay.before.get(cause, draws)
            arrays["input_before"][number, place] = np.percentile(before, PERCENTILES)
            arrays["input_after"][number, place] = np.percentile(draws[chosen], PERCENTILES)


def _refuse_too_large(site: Site, layer: Layer, depths: int) -> None:
    """Refuse draws of a layer that do not fit into the memory."""
    if DRAW_BYTES * depths * site.samples > (most := memory_of_machine()):
        raise StudyError(
            f"{site.name}.toml: samples = {site.samples}: with {depths} depths in the layer "
            f"{layer.title} at most {int(most / DRAW_BYTES / depths)} fit into "
            f"{most / 1e9:.3g} GB of memory"
        )


def _refuse_without_values(site: Site, test: xr.Dataset) -> None:
    """Refuse a site that needs fs or u2 of a test that has no value of it."""
    by_sleeve = [layer.title for layer in site.layers if is_by_sleeve(layer)]
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
