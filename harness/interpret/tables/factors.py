"""Factors of a cone without a simulation: polynomials fitted to tables, with their error.

Two tables in `studies` have simulated cone tests with random values of all inputs of the factors,
the second on finer cells. su and mu of the tables hold at the shear strain rate TABLE_RATE. For the
same ground with su and mu at another rate, L log cycles above it,

    su' = su (1 - mu L),   mu' = mu su / su',   Ir' = Ir su / su',   Delta' = Delta su / su'

are the values of the table. A factor of the table is relative to su'; times su' / su it is relative
to su. The factors are polynomials in the inputs, each scaled to -1 to 1 over its range; the
ductility is multiplied by the share of strength that can be lost. The sleeve factor is divided by
the adhesion factor. For u2 = Nkt P + C the polynomial is P, the radial stress on the shaft over
Nkt; C, the rest of the pressure at the filter, has a formula of its own. Each case is left out of
one of PARTS fits, which gives the error of the fit. The error with degree 2 is 3, 1.5 and 1.2 times
that with degree 3, for Nkt, the sleeve and u2. Degree 4 and radial basis functions (scipy) have a
tenth less at most.
"""

import functools
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.study.files import read_text, studies_folder
from mpm_warp.errors import ParameterError
from mpm_warp.fields.plain_numbers import numbers_by_column
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.shoulder import RADIAL_FACTOR, excess_at_filter, shoulder_pressure

TABLE_RATE = 1e-6
"""Shear strain rate of the strength in the tables [1/s]."""
USUAL_SPEED, USUAL_RADIUS = 0.02, 0.01785
"""Real speed [m/s] and radius [m] of the cone in the tables; strain rates go with their ratio."""
RANGES: Mapping[str, tuple[float, float]] = {
    "rigidity_index": (15.0, 1000.0),
    "adhesion_factor": (0.0, 1.0),
    "stress_anisotropy": (-0.6, 0.9),
    "rate_factor": (0.0, 0.25),
    "remoulded_strength_ratio": (0.04, 1.0),
    "ductility": (5.0, 60.0),
}
"""Inputs of the factors, and their ranges in the tables; all dimensionless."""
LOGARITHMIC = ("rigidity_index", "ductility")
MOVING = ("stress_anisotropy", "adhesion_factor")
"""Inputs that vary with depth in a soil: by the strength, and by the sleeve friction."""
QUANTITIES = ("cone_factor", "sleeve_friction_factor", "pore_pressure_factor_shoulder")
SLEEVE, PRESSURE = QUANTITIES[1:]
TABLES: Mapping[str, str] = {
    "cone_factor": "interpretation_table.csv",
    **dict.fromkeys((SLEEVE, PRESSURE), "pore_pressure_table.csv"),
}
"""The table of each quantity. Beside the shaft they need the finer mesh of the second table."""
DEGREE, PARTS = 3, 8
"""Degree of the polynomials; number of fits that each leave out every PARTS-th case."""
SIMULATED_ERROR: Mapping[str, float] = {"cone_factor": 0.03, SLEEVE: 0.2}
"""Half widths of 95 % of the simulated factors, over the factors: mesh, window and speed. For the
cone factor it is 0.015 in clay of constant strength; where the strength changes, twice that is
assumed. For the sleeve it is what ten rows of cells change in 95 % of random cases, as strain in
clay that softens gathers beside the shaft. For u2 it is by the error law of clay of constant
strength."""
PRESSURE_CELL, PRESSURE_SPEED, PRESSURE_POISSON = 3.0**0.5 / 5.0, 0.045, 0.49
"""Of the second table: width of cells at the cone over its radius, speed over that of shear waves,
Poisson's ratio."""


@dataclass(frozen=True, eq=False)
class Factors:
    """The polynomials of all quantities; errors are over the quantity."""

    exponents: np.ndarray  # exponent of each input in each term, shape [terms, inputs]
    weights: Floats  # weight of each term in each quantity, shape [terms, quantities]
    # half widths of 95 %: the errors of fit and simulation, added as squares
    half_widths: Mapping[str, float]
    fit_errors: Mapping[str, Floats]  # of each case by the fit that leaves it out, shape [cases]

    def at(self, inputs: Mapping[str, Floats | float]) -> dict[str, Floats]:
        """The quantities for inputs at the rate of the table, shape [...]; inputs are unchecked."""
        x = np.stack(np.broadcast_arrays(*coordinates(inputs).values()))
        powers = np.stack([x**power for power in range(self.exponents.max() + 1)])
        terms = math.prod(powers[own, place] for place, own in enumerate(self.exponents.T))
        values = dict(zip(QUANTITIES, np.tensordot(self.weights.T, terms, 1), strict=True))
        return _whole(values, **{name: inputs[name] for name in ("rigidity_index", *MOVING)})

    def along(self, fixed: Mapping[str, Floats | float]) -> "Along":
        """The quantities of soils, shape [soils], as functions of the inputs `MOVING`."""
        names, own = list(RANGES), coordinates(fixed)
        places = [names.index(name) for name in own]
        x = np.stack(np.broadcast_arrays(*map(np.atleast_1d, own.values())))
        powers = x[:, None, :] ** self.exponents.T[places][:, :, None]
        terms = np.prod(powers, axis=0)  # [terms, soils]
        moving = self.exponents[:, [names.index(name) for name in MOVING]]
        weights = {
            (a, b): np.einsum("tq,ts->qs", self.weights[rows], terms[rows])
            for a, b in itertools.product(range(self.exponents.max() + 1), repeat=2)
            if (rows := (moving == (a, b)).all(axis=1)).any()
        }
        return Along(weights, np.asarray(fixed["rigidity_index"], dtype=float))


@dataclass(frozen=True, eq=False)
class Along:
    """Factors of soils as polynomials in stress anisotropy and adhesion."""

    weights: Mapping[tuple[int, int], Floats]  # by the powers of both, shape [quantities, soils]
    rigidity_index: Floats  # shape [soils]

    def __call__(
        self, stress_anisotropy: Floats, adhesion_factor: Floats, quantities: int = len(QUANTITIES)
    ) -> dict[str, Floats]:
        """The first of QUANTITIES by name, shape [..., soils]."""
        x, y = scaled(MOVING[0], stress_anisotropy), scaled(MOVING[1], adhesion_factor)
        weights, powers = self.weights.values(), [x**a * y**b for a, b in self.weights]
        values = {
            name: sum(it[place] * power for it, power in zip(weights, powers, strict=True))
            for place, name in enumerate(QUANTITIES[:quantities])
        }
        return _whole(
            values,
            rigidity_index=self.rigidity_index,
            stress_anisotropy=stress_anisotropy,
            adhesion_factor=adhesion_factor,
        )


def _whole(values: dict[str, Floats], **soil: Floats | float) -> dict[str, Floats]:
    """The quantities from the values of the polynomials, in place; see `_fitted_values`."""
    if PRESSURE in values:
        excess = excess_at_filter(**soil, strength_ratio=values[SLEEVE])
        values[PRESSURE] = values[PRESSURE] * values["cone_factor"] + excess
    if SLEEVE in values:
        values[SLEEVE] = values[SLEEVE] * soil["adhesion_factor"]
    return values


def coordinates(inputs: Mapping[str, Floats | float]) -> dict[str, Floats]:
    """Variables of the polynomials: of all inputs, or of those that a soil has at all depths."""
    x = {name: scaled(name, inputs[name]) for name in RANGES if name in inputs}
    x["ductility"] = x["ductility"] * (1.0 - np.asarray(inputs["remoulded_strength_ratio"]))
    return x


def scaled(name: str, value: Floats | float) -> Floats:
    """An input scaled to -1 to 1 over its range, by its logarithm if it is one of LOGARITHMIC."""
    low, high = RANGES[name]
    value = np.asarray(value, dtype=float)
    if name in LOGARITHMIC:
        value, low, high = np.log(value), math.log(low), math.log(high)
    scaled: Floats = (2.0 * value - (low + high)) / (high - low)
    return scaled


@functools.cache
def factors() -> Factors:
    """The polynomials fitted to the tables by least squares."""
    powers = itertools.product(range(DEGREE + 1), repeat=len(RANGES))
    exponents = np.array([power for power in powers if sum(power) <= DEGREE])
    weights = np.zeros((len(exponents), len(QUANTITIES)))
    fit_errors, half_widths = {}, {}
    for place, name in enumerate(QUANTITIES):
        table = numbers_by_column(read_text(studies_folder() / TABLES[name], "a table"))
        values, share, simulated_error = _fitted_values(name, table)
        own = coordinates({ranged: table[ranged] for ranged in RANGES})
        terms = np.prod(np.stack(list(own.values()), axis=-1)[:, None, :] ** exponents, axis=-1)
        weights[:, place], errors = _fitted(terms, values)
        fit_errors[name] = share * errors
        half_widths[name] = math.hypot(np.quantile(np.abs(share * errors), 0.95), simulated_error)
    return Factors(exponents, weights, half_widths, fit_errors)


def _fitted_values(name: str, table: Mapping[str, Floats]) -> tuple[Floats, Floats | float, float]:
    """Values that the polynomial of a quantity fits, and their share in it, shape [cases].

    The third result is the half width of 95 % of the simulated quantity, over the quantity.
    """
    if name == PRESSURE:
        soil: dict[str, Any] = {
            **{name: table[name] for name in ("rigidity_index", *MOVING)},
            # The sleeve slips at the adhesion of the soil at the sleeve, which may have softened.
            "strength_ratio": table[SLEEVE] / table["adhesion_factor"],
        }
        pressure, half_width = shoulder_pressure(
            table[RADIAL_FACTOR],
            cell_size=PRESSURE_CELL,
            inertia=table["rigidity_index"] * PRESSURE_SPEED**2,
            poissons_ratio=PRESSURE_POISSON,
            **soil,
        )
        radial = pressure - excess_at_filter(**soil)
        simulated_error = float(np.sqrt(np.mean((half_width / pressure) ** 2)))
        return radial / table["cone_factor"], radial / pressure, simulated_error
    over = table["adhesion_factor"] if name == SLEEVE else 1.0
    return table[name] / over, 1.0, SIMULATED_ERROR[name]


def _fitted(terms: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Weights of terms, and the error of each value by the fit that leaves it out, over it."""
    errors, part = np.empty_like(values), np.arange(len(values)) % PARTS
    for out in (part == number for number in range(PARTS)):
        weights, *_ = np.linalg.lstsq(terms[~out], values[~out], rcond=None)
        errors[out] = terms[out] @ weights / values[out] - 1.0
    weights, *_ = np.linalg.lstsq(terms, values, rcond=None)
    return np.asarray(weights, dtype=float), errors


def at_table_rate(inputs: Mapping[str, Floats], rate: float) -> tuple[dict[str, Floats], Floats]:
    """Inputs at the rate of the table, from those at a shear strain rate [1/s], and su' / su."""
    ratio = 1.0 - inputs["rate_factor"] * math.log10(rate / TABLE_RATE)
    changed = ("rate_factor", "rigidity_index", "stress_anisotropy")
    with np.errstate(divide="ignore"):  # su' may be 0
        own = {
            name: numbers / ratio if name in changed else numbers
            for name, numbers in inputs.items()
        }
    return own, np.asarray(ratio)


def cone_factor(
    *,
    rigidity_index: float | Floats,
    adhesion_factor: float | Floats = 0.0,
    stress_anisotropy: float | Floats = 0.0,
    rate_factor: float | Floats = 0.0,
    reference_strain_rate: float | None = None,
    remoulded_strength_ratio: float | Floats = 1.0,
    ductility: float | Floats = 20.0,
) -> tuple[Floats, Floats]:
    """The factor Nkt = qnet / su of a 60 degree cone in Tresca clay, and its error, by the table.

    All inputs but the rate may be arrays whose shapes broadcast.

    Args:
        rigidity_index: Ir = G / su, 15 to 1000.
        adhesion_factor: adhesion of face and shaft over su, 0 to 1.
        stress_anisotropy: Delta = (sigma_v0 - sigma_h0) / (2 su), -0.6 to 0.9.
        rate_factor: mu, increase of su per log cycle of strain rate, over su, 0 to 0.25.
        reference_strain_rate: shear strain rate of su [1/s], 1e-6 to 1e-2; 1 % an hour is
            2.8e-6. Required if mu is not 0.
        remoulded_strength_ratio: remoulded over intact strength, 0.04 to 1.
        ductility: plastic shear strain xi_95 at which 95 % of this loss is reached, 5 to 60.

    Returns:
        Nkt, and the half width of 95 % of its numerical error; numbers if all inputs are numbers.

    Raises:
        ParameterError: a value is outside the table.

    Example:
        >>> factor, half_width = cone_factor(rigidity_index=100, adhesion_factor=0.5)
        >>> f"{factor:.1f} +- {half_width:.1f}"
        '11.5 +- 0.4'
    """
    if reference_strain_rate is None and np.any(np.asarray(rate_factor) != 0.0):
        raise ParameterError("rate_factor", "rate_factor needs a reference_strain_rate [1/s]")
    rate = TABLE_RATE if reference_strain_rate is None else reference_strain_rate
    if not TABLE_RATE <= rate <= 1e-2:
        raise ParameterError(
            "reference_strain_rate",
            f"reference_strain_rate = {rate:g} must be >= {TABLE_RATE:g} and <= 0.01 s-1",
        )
    given = {
        "rigidity_index": rigidity_index,
        "adhesion_factor": adhesion_factor,
        "stress_anisotropy": stress_anisotropy,
        "rate_factor": rate_factor,
        "remoulded_strength_ratio": remoulded_strength_ratio,
        "ductility": ductility,
    }
    own, ratio = at_table_rate({k: np.asarray(v) for k, v in given.items()}, rate)
    for name, value in own.items():
        low, high = RANGES[name]
        outside = np.atleast_1d(~((value >= low) & (value <= high)))
        if outside.any():
            own_value, at_table = (
                np.broadcast_to(number, outside.shape)[outside][0]
                for number in (given[name], value)
            )
            at_rate = "" if own_value == at_table else f", {at_table:g} at the rate of the table,"
            message = f"{name} = {own_value:g}{at_rate} must be {low:g} to {high:g}"
            raise ParameterError(name, message)
    table = factors()
    factor: Floats = (table.at(own)["cone_factor"] * ratio)[()]
    return factor, factor * table.half_widths["cone_factor"]
