"""Ball and T-bar pushed down and pulled up over a stroke, time and again: clay is remoulded.

The resistance falls with cycles, and is fitted as practice does.

Einav & Randolph (2005, Int. J. Numer. Meth. Eng. 63:1991-2016): with N_0 the resistance factor of
intact soil, delta the share of it that is left in the end, and n_95 the cycles in which 95 % of
what is lost is lost,

    N(n) = N_0 [delta + (1 - delta) exp(-3 n / n_95)]

n is the number of the cycle: 0.25 where the body passes the middle of the stroke for the first
time, 0.75 on the way back, and so on. If a passage adds a plastic shear strain xi_p to the soil,
the soil has borne 2 n xi_p on the average when the body passes it, and so

    xi_95 = 2 xi_p n_95
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import scipy  # loads its optimisers where they are first used: no other scene waits for them
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials import CRITERIA
from mpm_warp.parameters import parameter
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.results import labelled
from mpm_warp.sampling import follow
from mpm_warp.scenes.catalogue import Progress, compared
from mpm_warp.scenes.cone.soundness import check_energy, energy_error
from mpm_warp.scenes.full_flow.penetrometer import (
    GREATEST_INERTIA,
    T_BAR_STRAIN,
    Ball,
    FullFlowPenetrometer,
    ResistanceSamples,
    TBar,
)
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.further_runs import REASON, reason
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

REFUSED_INERTIA = 10.0
"""rho V^2 over the strength that is left in the last passage above which no case completed."""
NOT_KNOWN = "cyclic: it is known in perfectly plastic clay alone; compare two cells_per_radius"
"""Why the resistance that is left has no uncertainty."""
FITTED = 3
"""Numbers that are fitted."""
MIDDLE = 2.0
"""Length in the middle of the stroke over which the resistance of a passage is a mean, in radii."""
FIRST_CYCLE = 0.25
"""Number of the cycle in the middle of the first passage; each further passage adds a half."""
BEYOND = "not a number where the test ends before n_95, or no falling curve fits"
"""What is said of all that is fitted."""


@dataclass(frozen=True, kw_only=True)
class CyclicPenetration(FullFlowPenetrometer):
    """A round body that goes down and up again in the same soil.

    It starts at rest at the upper end of the stroke, in intact soil: its first passage is that of
    the same body that goes on. Clay that softens resists the less from passage to passage;
    perfectly plastic clay resists each of them alike.
    """

    verifications = compared(
        "cells_per_radius",
        (2, 3),
        {"adhesion_factor": 0.5, "cycle_count": 2, "stroke": 6.0, "speed_ratio": 0.03},
        error=0.01,
    )

    # Remoulded clay is weak: half the speed has a quarter of the inertia.
    relative_speed = 0.15
    cycle_count: int = parameter(
        5, "number of cycles, each a penetration and an extraction", minimum=1, maximum=200
    )
    stroke: float = parameter(8.0, "way from turn to turn over radius", minimum=6, maximum=50)

    def derived(self) -> Mapping[str, float]:
        """See `FullFlowPenetrometer`; slower where little strength is left."""
        by_strength = 0.99 * math.sqrt(GREATEST_INERTIA * self.strength_left)
        relative_speed = min(self.relative_speed, by_strength)
        return {"speed_ratio": relative_speed / math.sqrt(self.rigidity_index)}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inertia > REFUSED_INERTIA:
            beside = f"rigidity_index = {self.rigidity_index:g}"
            self.refuse("speed_ratio", f" with {beside}: {self.thrown_off(REFUSED_INERTIA)}")

    @property
    def last_cycle(self) -> float:
        """See `FullFlowPenetrometer`."""
        return self.cycle_count - FIRST_CYCLE

    @property
    def window(self) -> CyclicWindow:
        """The travel of the grid: the speed is reached in a radius after each turn."""
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
        """Move the body, and take its mean resistance in the middle of each passage.

        Raises:
            InaccurateRun: the transfers took too much of the work of the body.
        """
        loops = ResistanceLoops(simulation, self)
        moments = [self.window.time_to(way) for way in loops.ways]
        recorded = follow(simulation, moments, simulation.advance_to, [loops], progress)
        results = recorded.assign(self._ratio(recorded) | energy_error(simulation, loops.work))
        check_energy(results)
        return results

    def _ratio(self, recorded: xr.Dataset) -> dict[str, xr.Variable]:
        """What is left of the resistance, and what that says of the clay by the fit of practice."""
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
        if self.remoulded_strength_ratio == 1.0 or factor.size <= FITTED:
            return ratio
        fit = fitted_degradation(factor["cycle"].values, factor.values)
        # What lies beyond the end of the test is not a number.
        known = fit.falls and fit.cycles <= self.cycle_count
        cycles, remoulded, intact = (
            values if known else math.nan
            for values in (fit.cycles, fit.remoulded_share, fit.intact)
        )
        misfit = fit.misfit if fit.falls else math.nan
        of_remoulded = "remoulded over intact resistance, fitted"
        before = f"{BEYOND}; the intact one is that before any softening, drawn on to cycle 0"
        of_intact = "resistance factor of intact clay, fitted"
        of_misfit = "root mean square of what it leaves, over the fitted resistance of intact clay"
        fitted = ratio | labelled(
            fitted_cycles=(cycles, "1", "cycles n_95 to 95 % of the loss of resistance", BEYOND),
            fitted_remoulded_ratio=(remoulded, "1", of_remoulded, before),
            fitted_resistance_factor=(intact, "1", of_intact, BEYOND),
            fit_misfit=(misfit, "1", "misfit of the fit", of_misfit),
        )
        if not self.body.planar:
            return fitted
        ductility = 2.0 * T_BAR_STRAIN * cycles
        how = f"by a plastic shear strain of {T_BAR_STRAIN:g} in a passage of a T-bar; {BEYOND}"
        return fitted | labelled(fitted_ductility=(ductility, "1", "ductility xi_95, fitted", how))


@dataclass(frozen=True, kw_only=True)
class CyclicBall(Ball, CyclicPenetration):
    """A ball that goes down and up again in the same soil.

    Its shaft is left out: it would move the ground around the window, which rests between two
    passages. The first passage is that of `ball_penetration` without a shaft.
    """

    summary = "ball without a shaft, pushed down and pulled up in undrained clay"
    version = 4


@dataclass(frozen=True, kw_only=True)
class CyclicTBar(TBar, CyclicPenetration):
    """A T-bar in plane strain that goes down and up again in the same soil.

    Its first passage is that of `t_bar_penetration`.
    """

    summary = "T-bar pushed down and pulled up in undrained clay, plane strain"
    version = 6


class ResistanceLoops(ResistanceSamples):
    """The same at even distances of the way, of about as many radii, down and up again.

    The body starts at the upper end of its stroke. A cycle has two passages.
    """

    def __init__(self, simulation: Simulation, test: CyclicPenetration) -> None:
        super().__init__(simulation, test.body)
        self._stroke = test.stroke
        self._strength = test.undrained_shear_strength
        self._shape = 2 * test.cycle_count, round(test.stroke / SAMPLE_SPACING)

    @property
    def ways(self) -> list[float]:
        """Ways gone, down and up, at which samples are due [m]."""
        passages, per_passage = self._shape
        spacing = self._stroke * self._radius / per_passage
        return [number * spacing for number in range(1, passages * per_passage + 1)]

    @property
    def work(self) -> float:
        """Of the body so far [J], per radian or per unit length of half of it."""
        downward = np.where(np.arange(self._shape[0]) % 2 == 0, 1.0, -1.0)
        forces = self._by_passage(np.array(self.forces))
        spacing = self._stroke * self._radius / self._shape[1]
        return float(np.nansum(forces * downward[:, None])) * spacing

    def dataset(self) -> xr.Dataset:
        """The loops, and the mean over the middle of each passage."""
        passages, per_passage = self._shape
        loops = self._by_passage(self.resistance)
        cycle = FIRST_CYCLE + 0.5 * np.arange(passages)
        place = (np.arange(per_passage) + 0.5) / per_passage * self._stroke
        is_middle = np.abs(place - 0.5 * self._stroke) < 0.5 * MIDDLE
        factor = np.abs(loops[:, is_middle].mean(axis=1)) / self._strength
        numbered = "that of the middle of a passage: 0.25 down, 0.75 up, 1.25 down, ..."
        upward = "upward positive: below 0 on the way up"
        of_loops = (loops, "Pa", "resistance over projected area", upward)
        size = f"size of the mean over the middle {MIDDLE:g} radii of the stroke"
        of_middle = (factor, "1", "resistance over projected area and su", size)
        axis = (place, "1", "penetration over radius of the body")
        return xr.Dataset(
            labelled(dims=("cycle", "penetration"), cyclic_resistance=of_loops)
            | labelled(dims=("cycle",), cyclic_resistance_factor=of_middle),
            coords=labelled(dims=("cycle",), cycle=(cycle, "1", "number of the cycle", numbered))
            | labelled(dims=("penetration",), penetration=axis),
        )

    def _by_passage(self, values: Floats) -> Floats:
        """Values of samples by passage and place from above; not a number where there is none."""
        table = np.full(self._shape, np.nan)
        table.reshape(-1)[: len(values)] = values
        table[1::2] = table[1::2, ::-1]
        return table


@dataclass(frozen=True, kw_only=True)
class Degradation:
    """The fit of a curve of degradation."""

    intact: float  # N_0, dimensionless
    remoulded_share: float  # delta, dimensionless
    cycles: float  # n_95, dimensionless
    misfit: float  # root mean square of what the fit leaves of N over N_0

    @property
    def falls(self) -> bool:
        """Whether the curve falls, from its first passage on to what is left.

        Where the clay hardly softens noise is fitted, by any curve.
        """
        return 0.0 <= self.remoulded_share <= 1.0 and self.cycles > FIRST_CYCLE

    def resistance_factor(self, cycle: Floats) -> Floats:
        """N at numbers of cycles, dimensionless, of their shape."""
        lost = (1.0 - self.remoulded_share) * (1.0 - np.exp(-3.0 * cycle / self.cycles))
        return self.intact * (1.0 - lost)


def fitted_degradation(cycle: Floats, resistance: Floats) -> Degradation:
    """The fit of least squares to N at numbers of cycles, which rise, more than `FITTED`.

    For each n_95 the best N_0 and delta solve a linear problem, so only n_95 is searched: from a
    tenth of a cycle to ten times the cycles that there are.
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
    (remoulded, lost), left = solved(cycles)
    intact = float(remoulded + lost)
    return Degradation(
        intact=intact,
        remoulded_share=float(remoulded) / intact,
        cycles=cycles,
        misfit=float(np.sqrt(np.mean(left**2))) / intact,
    )
