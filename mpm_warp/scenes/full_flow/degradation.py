"""How the resistance of a ball or a T-bar falls with cycles, fitted as practice does.

Einav & Randolph (2005, Int. J. Numer. Meth. Eng. 63:1991-2016): with N_0 the resistance factor of
intact soil, delta the share of it that is left in the end, and n_95 the cycles in which 95 % of
what is lost is lost,

    N(n) = N_0 [delta + (1 - delta) exp(-3 n / n_95)]

n is the number of the cycle: 0.25 where the body passes the middle of the stroke for the first
time, 0.75 on the way back, and so on. If a passage adds a plastic shear strain xi_p to the soil,
the soil has borne 2 n xi_p on the average when the body passes it, and so

    xi_95 = 2 xi_p n_95
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy  # loads its optimisers where they are first used: no other scene waits for them

from mpm_warp.grid.fitted import Floats

T_BAR_STRAIN = 3.7
"""Plastic shear strain xi_p of a passage of a T-bar, by which practice turns n_95 into xi_95.

From upper bounds of Einav & Randolph 2005, and usual since (Zhou & Randolph 2009, Geotechnique
59(2):79-86).
"""
FITTED = 3
"""Numbers that are fitted."""


@dataclass(frozen=True, kw_only=True)
class Degradation:
    """The fit of a curve of degradation.

    Attributes:
        intact: N_0, dimensionless.
        remoulded_share: delta, dimensionless.
        cycles: n_95, dimensionless.
        misfit: root mean square of what the fit leaves of N over N_0.
    """

    intact: float
    remoulded_share: float
    cycles: float
    misfit: float

    def resistance_factor(self, cycle: Floats) -> Floats:
        """N at numbers of cycles, dimensionless, of their shape."""
        lost = (1.0 - self.remoulded_share) * (1.0 - np.exp(-3.0 * cycle / self.cycles))
        factor: Floats = self.intact * (1.0 - lost)
        return factor


def fitted_degradation(cycle: Floats, resistance: Floats) -> Degradation:
    """The fit of least squares.

    For each n_95 the best N_0 and delta solve a linear problem, so only n_95 is searched: from a
    tenth of a cycle to ten times the cycles that there are.

    Args:
        cycle: numbers of the cycles, rising, shape [passage_count], more than `FITTED`.
        resistance: N there, positive, of that shape.
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
