"""How the resistance of a ball or T-bar falls from cycle to cycle, and the fit to it.

Practice fits it by (Einav & Randolph 2005, Int. J. Numer.
Meth. Eng. 63:1991-2016)

    N(n) = N_0 [delta + (1 - delta) exp(-3 n / n_95)]

N_0 is the resistance factor of intact clay, delta N_0 that of remoulded clay, and n_95 the number
of cycles to 95 % of the loss. n is the number of the cycle in the middle of the stroke: 0.25 on the
first way down, 0.75 on the first way up, and so on. If each passage adds a plastic shear strain
xi_p, the soil that the body meets has borne 2 n xi_p on average. So

    xi_95 = 2 xi_p n_95
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy  # loads its optimisers where they are first used: no other scene waits for them
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import Drawn, labelled
from mpm_warp.scenes.clay import Clay

T_BAR_STRAIN = 3.7
"""Plastic shear strain xi_p of one passage of a T-bar, for xi_95 = 2 xi_p n_95.

It comes from upper bounds of Einav & Randolph 2005 and is usual since (Zhou & Randolph 2009,
Geotechnique 59(2):79-86). That of a ball is about as large.
"""
FIT_SAMPLES = 101
"""Number of samples of the fitted curve."""
FITTED_COUNT = 3
"""Number of fitted parameters: N_0, delta and n_95."""
FIRST_CYCLE = 0.25
"""Number n of the first passage; each further one adds 0.5."""


def strength_left(clay: Clay, last_cycle: float) -> float:
    """Strength in the last passage over su, by the formula above.

    `last_cycle` is its number n: soil has then borne a plastic strain of 2 n xi_p.
    """
    if clay.ductility is None:
        return 1.0
    decay = math.exp(-6.0 * last_cycle * T_BAR_STRAIN / clay.ductility)
    return clay.remoulded_strength_ratio + (1.0 - clay.remoulded_strength_ratio) * decay


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
