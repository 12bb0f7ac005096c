"""Cyclic tests of ball and T-bar: the body goes down and up many times and remoulds the clay."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.fields.checked import refuse
from mpm_warp.fields.declaration import group, own_parameters_of, parameter, redefined
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.results import Drawn, labelled
from mpm_warp.sampling import follow
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.clay_scene import ClayScene
from mpm_warp.scenes.cone.groups import Cone
from mpm_warp.scenes.cone.soundness import energy_error, energy_limits
from mpm_warp.scenes.full_flow import failure
from mpm_warp.scenes.full_flow.degradation import (
    FIRST_CYCLE,
    FITTED_COUNT,
    T_BAR_STRAIN,
    fitted_degradation,
    strength_left,
)
from mpm_warp.scenes.full_flow.groups import Ball, Body, ClayAroundBody, Flow, TBar
from mpm_warp.scenes.full_flow.round_body import ResistanceSamples
from mpm_warp.scenes.limits import limited
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.further_runs import REASON, reason
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

RELATIVE_SPEED = 0.15
"""Speed by default over sqrt(su / rho). Remoulded clay is weak: half the speed of a push has a
quarter of its inertia."""
REFUSED_INERTIA = 10.0
"""Inertia, rho V^2 over the strength in the last passage, above which no case completed."""
NOT_KNOWN = "cyclic: the error is known only in perfectly plastic clay; try two cells_per_radius"
"""Why the resistance ratio of clay that softens has no uncertainty."""
AVERAGED_LENGTH = 2.0
"""Length in the middle of the stroke over which the resistance is averaged, in radii."""
WHEN_NOT_FITTED = "not a number where the test ends before n_95, or no falling curve fits"


@dataclass(frozen=True, kw_only=True, init=False)
class CyclicPenetration(ClayScene):
    """A round body that goes down and up again in the same soil.

    It starts at rest at the upper end of the stroke, in intact soil. Clay that softens resists each
    passage less than the one before; perfectly plastic clay resists all alike.
    """

    verifications = compared(
        "cells_per_radius",
        (2, 3),
        {"adhesion_factor": 0.5, "cycle_count": 2, "stroke": 6.0, "speed_ratio": 0.03},
        error=0.01,
    )
    limits = energy_limits() | limited(error="a lower speed_ratio, or more cells_per_radius")
    method = tuple(own_parameters_of(Flow))

    clay: ClayAroundBody = group()
    adhesion_factor: float = redefined(
        Cone, "adhesion_factor", meaning="adhesion factor of the body"
    )
    flow: Flow = group()
    cycle_count: int = parameter(
        5, "number of cycles, each a penetration and an extraction", minimum=1, maximum=200
    )
    stroke: float = parameter(8.0, "length of the stroke over radius", minimum=6, maximum=50)

    body: Body = group()

    def derived(self) -> Mapping[str, float]:
        """The speed over that of shear waves, or less where little strength is left."""
        left = strength_left(self.clay, self.last_cycle)
        by_strength = 0.99 * math.sqrt(failure.GREATEST_INERTIA * left)
        relative_speed = min(RELATIVE_SPEED, by_strength)
        speed_ratio = relative_speed / math.sqrt(self.clay.rigidity_index)
        return {**super().derived(), "speed_ratio": speed_ratio}

    def __post_init__(self) -> None:
        super().__post_init__()
        if refusal := self._thrown_off(REFUSED_INERTIA):
            with_index = f" with rigidity_index = {self.clay.rigidity_index:g}"
            refuse(self, "speed_ratio", f"{with_index}: {refusal}")

    @property
    def last_cycle(self) -> float:
        """Number n of the last passage."""
        return self.cycle_count - FIRST_CYCLE

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: remoulded soil is thrown off where the body is fast."""
        return self._thrown_off(failure.GREATEST_INERTIA)

    def _thrown_off(self, limit: float) -> str:
        """Message where rho V^2 over the strength that is left is above a limit; else ""."""
        test = self.clay, self.flow.speed_ratio, self.last_cycle
        return failure.thrown_off(*test, limit) if failure.inertia(*test) > limit else ""

    @property
    def soil(self) -> Material:
        """The clay as it is simulated, with strain rates as at the real speed."""
        return self.clay.at_speed(self.flow.speed_ratio, self.stress_at_rest)

    @property
    def window(self) -> CyclicWindow:
        """The grid travels with the body, which reaches its speed one radius after each turn."""
        radius = self.body.shape.radius
        speed = self.flow.speed(self.clay, self.soil)
        return CyclicWindow(speed=speed, ramp_travel=radius, stroke=self.stroke * radius)

    def build(self) -> Scene:
        """The soil around the body, in a grid that travels with it."""
        strength = self.clay.undrained_shear_strength
        adhesion = self.adhesion_factor * strength
        return self.flow.around(
            self.body.shape, self.soil, self.window, strength=strength, adhesion=adhesion
        )

    @property
    def loads_solvers(self) -> bool:
        """See `CatalogueScene`: for the fit of the degradation."""
        return self.clay.remoulded_strength_ratio < 1.0

    @property
    def end_time(self) -> float:
        """Time to the end of the last cycle [s]."""
        return 2.0 * self.cycle_count * self.window.passage_time

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Move the body, and record its mean resistance in the middle of each passage."""
        loops = ResistanceLoops(simulation, self)
        moments = [self.window.time_to(travel) for travel in loops.sampled_travels]
        recorded = follow(simulation, moments, simulation.advance_to, [loops], progress)
        return recorded.assign(self._degradation(recorded) | energy_error(simulation, loops.work))

    def _degradation(self, recorded: xr.Dataset) -> dict[str, xr.Variable]:
        """The resistance ratio and, where the clay softens, the parameters of the fit."""
        factor = recorded.cyclic_resistance_factor
        first, last = float(factor[0]), float(factor[-2:].mean())
        mean = "mean of penetration and extraction, over that of the first passage"
        left = (last / first, "1", "resistance left in the last cycle", mean)
        ratio = labelled(role="headline", resistance_ratio=left)
        if str(recorded.built_law.values) in CRITERIA:
            what = "of perfectly plastic clay, which does not degrade"
            error = (abs(last / first - 1.0), "1", "error of the resistance ratio", what)
            exact = labelled(resistance_ratio_exact=(1.0, "1", "resistance ratio", what))
            return ratio | exact | labelled(role="error", error=error)
        ratio[REASON] = reason(NOT_KNOWN)
        if self.clay.remoulded_strength_ratio == 1.0 or factor.size <= FITTED_COUNT:
            return ratio
        fit = fitted_degradation(factor["cycle"].values, factor.values)
        known = fit.falls and fit.cycles <= self.cycle_count
        cycles, remoulded, intact = (
            values if known else math.nan
            for values in (fit.cycles, fit.remoulded_share, fit.intact)
        )
        misfit = fit.misfit if fit.falls else math.nan
        of_remoulded = "remoulded over intact resistance, fitted"
        over = f"{WHEN_NOT_FITTED}; the intact resistance is the fit at cycle 0, before softening"
        of_intact = "resistance factor of intact clay, fitted"
        of_misfit = "root mean square of the residuals, over the fitted resistance of intact clay"
        of_cycles = "cycles n_95 to 95 % of the loss of resistance"
        fitted = ratio | labelled(
            fitted_cycles=(cycles, "1", of_cycles, WHEN_NOT_FITTED),
            fitted_remoulded_ratio=(remoulded, "1", of_remoulded, over),
            fitted_resistance_factor=(intact, "1", of_intact, WHEN_NOT_FITTED),
            fit_misfit=(misfit, "1", "misfit of the fit", of_misfit),
        )
        if known:
            fitted |= fit.curve(float(factor["cycle"][-1]))
        if not self.body.shape.planar:
            return fitted
        ductility = 2.0 * T_BAR_STRAIN * cycles
        how = f"for a plastic shear strain of {T_BAR_STRAIN:g} a passage; {WHEN_NOT_FITTED}"
        return fitted | labelled(fitted_ductility=(ductility, "1", "ductility xi_95, fitted", how))


@dataclass(frozen=True, kw_only=True, init=False)
class CyclicBall(CyclicPenetration):
    """A ball without a shaft that goes down and up again in the same soil.

    A shaft would move the ground around the window, which here rests between two passages. The
    first passage is that of `ball_penetration` without a shaft.

    Example:
        >>> CyclicBall(cycle_count=3).last_cycle
        2.75
    """

    summary = "ball without a shaft, pushed down and pulled up in undrained clay"
    version = 4

    body: Ball = group()


@dataclass(frozen=True, kw_only=True, init=False)
class CyclicTBar(CyclicPenetration):
    """A T-bar that goes down and up again; its first passage is that of `t_bar_penetration`.

    Example:
        >>> CyclicTBar(cycle_count=3).last_cycle
        2.75
    """

    summary = "T-bar pushed down and pulled up in undrained clay, plane strain"
    version = 6

    body: TBar = group()


class ResistanceLoops(ResistanceSamples):
    """Samples the resistance at even distances of about `SAMPLE_SPACING` radii, down and up."""

    def __init__(self, simulation: Simulation, test: CyclicPenetration) -> None:
        super().__init__(simulation, test.body.shape)
        self._stroke = test.stroke
        self._strength = test.clay.undrained_shear_strength
        self._shape = 2 * test.cycle_count, round(test.stroke / SAMPLE_SPACING)

    @property
    def sampled_travels(self) -> list[float]:
        """Distances travelled, down and up together, at which samples are due [m]."""
        passages, per_passage = self._shape
        spacing = self._stroke * self._radius / per_passage
        return [number * spacing for number in range(1, passages * per_passage + 1)]

    @property
    def work(self) -> float:
        """See `ResistanceSamples`."""
        downward = np.where(np.arange(self._shape[0]) % 2 == 0, 1.0, -1.0)
        forces = self._by_passage(np.array(self.forces))
        spacing = self._stroke * self._radius / self._shape[1]
        return float(np.nansum(forces * downward[:, None])) * spacing

    def dataset(self) -> xr.Dataset:
        """Curves over penetration by cycle, and the mean over the middle of each passage."""
        passages, per_passage = self._shape
        loops = self._by_passage(self.resistance)
        cycle = FIRST_CYCLE + 0.5 * np.arange(passages)
        place = (np.arange(per_passage) + 0.5) / per_passage * self._stroke
        is_middle = np.abs(place - 0.5 * self._stroke) < 0.5 * AVERAGED_LENGTH
        factor = np.abs(loops[:, is_middle].mean(axis=1)) / self._strength
        numbered = "in the middle of a passage: 0.25 down, 0.75 up, 1.25 down, ..."
        upward = "upward positive: below 0 on the way up"
        by_depth = Drawn(picture="cycles", divided_by="undrained_shear_strength", downward=True)
        of_loops = (loops, "Pa", "resistance over projected area", upward, by_depth)
        size = f"size of the mean over the middle {AVERAGED_LENGTH:g} radii of the stroke"
        marks = Drawn(picture="cycles", panel=2, as_marks=True)
        of_middle = (factor, "1", "resistance over projected area and su", size, marks)
        axis = (place, "1", "penetration over radius of the body")
        return xr.Dataset(
            labelled(dims=("cycle", "penetration"), cyclic_resistance=of_loops)
            | labelled(dims=("cycle",), cyclic_resistance_factor=of_middle),
            coords=labelled(dims=("cycle",), cycle=(cycle, "1", "number of the cycle", numbered))
            | labelled(dims=("penetration",), penetration=axis),
        )

    def _by_passage(self, values: Floats) -> Floats:
        """Samples by passage and depth, from above; not a number where none was taken."""
        table = np.full(self._shape, np.nan)
        table.reshape(-1)[: len(values)] = values
        table[1::2] = table[1::2, ::-1]
        return table
