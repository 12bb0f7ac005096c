"""Cyclic tests of ball and T-bar: the body goes down and up many times and remoulds the clay.

The resistance falls from cycle to cycle. Practice fits it by (Einav & Randolph 2005, Int. J. Numer.
Meth. Eng. 63:1991-2016)

    N(n) = N_0 [delta + (1 - delta) exp(-3 n / n_95)]

N_0 is the resistance factor of intact clay, delta N_0 that of remoulded clay, and n_95 the number
of cycles to 95 % of the loss. n is the number of the cycle in the middle of the stroke: 0.25 on the
first way down, 0.75 on the first way up, and so on. If each passage adds a plastic shear strain
xi_p, the soil that the body meets has borne 2 n xi_p on average. So

    xi_95 = 2 xi_p n_95
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy  # loads its optimisers where they are first used: no other scene waits for them
import xarray as xr

from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials import CRITERIA
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.results import Drawn, labelled
from mpm_warp.sampling import follow
from mpm_warp.scenes.catalogue import Progress, compared
from mpm_warp.scenes.cone.soundness import energy_error, energy_limits
from mpm_warp.scenes.full_flow.penetrometer import (
    GREATEST_INERTIA,
    T_BAR_STRAIN,
    Ball,
    FullFlowPenetrometer,
    ResistanceSamples,
    TBar,
)
from mpm_warp.scenes.limits import limited
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.further_runs import REASON, reason
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

REFUSED_INERTIA = 10.0
"""Inertia, rho V^2 over the strength in the last passage, above which no case completed."""
NOT_KNOWN = "cyclic: the error is known only in perfectly plastic clay; try two cells_per_radius"
"""Why the resistance ratio of clay that softens has no uncertainty."""
FIT_SAMPLES = 101
"""Number of samples of the fitted curve."""
FITTED_COUNT = 3
"""Number of fitted parameters: N_0, delta and n_95."""
AVERAGED_LENGTH = 2.0
"""Length in the middle of the stroke over which the resistance is averaged, in radii."""
FIRST_CYCLE = 0.25
"""Number n of the first passage; each further one adds 0.5."""
WHEN_NOT_FITTED = "not a number where the test ends before n_95, or no falling curve fits"


@dataclass(frozen=True, kw_only=True)
class CyclicPenetration(FullFlowPenetrometer):
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

    # Remoulded clay is weak: half the speed has a quarter of the inertia.
    relative_speed = 0.15
    cycle_count: int = parameter(
        5, "number of cycles, each a penetration and an extraction", minimum=1, maximum=200
    )
    stroke: float = parameter(8.0, "length of the stroke over radius", minimum=6, maximum=50)

    def derived(self) -> Mapping[str, float]:
        """The default speed of `FullFlowPenetrometer`, or less where little strength is left."""
        by_strength = 0.99 * math.sqrt(GREATEST_INERTIA * self.strength_left)
        relative_speed = min(self.relative_speed, by_strength)
        return {"speed_ratio": relative_speed / math.sqrt(self.rigidity_index)}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inertia > REFUSED_INERTIA:
            with_index = f" with rigidity_index = {self.rigidity_index:g}"
            self.refuse("speed_ratio", f"{with_index}: {self.thrown_off(REFUSED_INERTIA)}")

    @property
    def last_cycle(self) -> float:
        """See `FullFlowPenetrometer`."""
        return self.cycle_count - FIRST_CYCLE

    @property
    def window(self) -> CyclicWindow:
        """The grid travels with the body, which reaches its speed one radius after each turn."""
        return CyclicWindow(
            speed=self.speed, ramp_travel=self.body.radius, stroke=self.stroke * self.body.radius
        )

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: remoulded soil is thrown off where the body is fast."""
        return "" if self.inertia <= GREATEST_INERTIA else self.thrown_off(GREATEST_INERTIA)

    @property
    def loads_solvers(self) -> bool:
        """See `CatalogueScene`: for the fit of the degradation."""
        return self.remoulded_strength_ratio < 1.0

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
        if self.remoulded_strength_ratio == 1.0 or factor.size <= FITTED_COUNT:
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
        if not self.body.planar:
            return fitted
        ductility = 2.0 * T_BAR_STRAIN * cycles
        how = f"for a plastic shear strain of {T_BAR_STRAIN:g} a passage; {WHEN_NOT_FITTED}"
        return fitted | labelled(fitted_ductility=(ductility, "1", "ductility xi_95, fitted", how))


@dataclass(frozen=True, kw_only=True)
class CyclicBall(Ball, CyclicPenetration):
    """A ball without a shaft that goes down and up again in the same soil.

    A shaft would move the ground around the window, which here rests between two passages. The
    first passage is that of `ball_penetration` without a shaft.
    """

    summary = "ball without a shaft, pushed down and pulled up in undrained clay"
    version = 4


@dataclass(frozen=True, kw_only=True)
class CyclicTBar(TBar, CyclicPenetration):
    """A T-bar that goes down and up again; its first passage is that of `t_bar_penetration`."""

    summary = "T-bar pushed down and pulled up in undrained clay, plane strain"
    version = 6


class ResistanceLoops(ResistanceSamples):
    """Samples the resistance at even distances of about `SAMPLE_SPACING` radii, down and up."""

    def __init__(self, simulation: Simulation, test: CyclicPenetration) -> None:
        super().__init__(simulation, test.body)
        self._stroke = test.stroke
        self._strength = test.undrained_shear_strength
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


@dataclass(frozen=True, kw_only=True)
class Degradation:
    """The parameters of a fitted N(n), all dimensionless."""

    intact: float  # N_0
    remoulded_share: float  # delta
    cycles: float  # n_95
    misfit: float  # root mean square of the residuals over N_0

    @property
    def falls(self) -> bool:
        """Whether the curve falls; in clay that hardly softens any curve may fit the noise."""
        return 0.0 <= self.remoulded_share <= 1.0 and self.cycles > FIRST_CYCLE

    def resistance_factor(self, cycle: Floats) -> Floats:
        """N at numbers of cycles, any shape."""
        lost = (1.0 - self.remoulded_share) * (1.0 - np.exp(-3.0 * cycle / self.cycles))
        return self.intact * (1.0 - lost)

    def curve(self, last: float) -> dict[str, xr.Variable]:
        """The fit from cycle 0 to the last one, beside the resistance factors of the passages."""
        cycle, place = np.linspace(0.0, last, FIT_SAMPLES), Drawn(picture="cycles", panel=2)
        return labelled(
            dims=("cycle_of_fit",),
            cycle_of_fit=(cycle, "1", "number of the cycle"),
            resistance_factor_of_fit=(
                self.resistance_factor(cycle),
                "1",
                "resistance factor, fitted",
                place,
            ),
        )


def fitted_degradation(cycle: Floats, resistance: Floats) -> Degradation:
    """The least-squares fit to resistances N at rising cycle numbers, more than `FITTED_COUNT`.

    For each n_95 the best N_0 and delta solve a linear problem. So only n_95 is searched for, from
    0.1 to ten times the last cycle.
    """

    def solved(cycles: float) -> tuple[Floats, Floats]:
        decay = np.exp(-3.0 * cycle / cycles)
        terms = np.stack([np.ones_like(decay), decay], axis=-1)
        factors = np.linalg.lstsq(terms, resistance)[0]
        return factors, terms @ factors - resistance

    def misfit(log_cycles: float) -> float:
        return float(np.sum(solved(np.exp(log_cycles))[1] ** 2))

    ends = np.log([0.1, 10.0 * cycle[-1]])
    cycles = float(np.exp(scipy.optimize.minimize_scalar(misfit, bounds=ends, method="bounded").x))
    (remoulded, lost), residuals = solved(cycles)
    intact = float(remoulded + lost)
    return Degradation(
        intact=intact,
        remoulded_share=float(remoulded) / intact,
        cycles=cycles,
        misfit=float(np.sqrt(np.mean(residuals**2))) / intact,
    )
