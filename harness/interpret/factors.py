"""The factors of a cone in a moment: a polynomial through the table that ships, with its error.

The table, `studies/interpretation_table.csv`, holds simulated cone tests drawn over all that the
factors depend on. Its rate factor belongs to the shear strain rate TABLE_RATE. Of the same ground
with su and mu at another rate, L log cycles above it, holds

    su' = su (1 - mu L),   mu' = mu su / su',   Ir' = Ir su / su',   Delta' = Delta su / su'

and what the table gives over su' is 1 / (1 - mu L) of what it is over su. The factors are cubic
polynomials in the inputs, each brought to -1 to 1 over its range; the sleeve's is taken over the
adhesion factor, to which it is nearly in proportion. Errors of 99 cases kept out, 95 %: Nkt 0.9 %,
sleeve 1.7 %, u2 1.6 %. Of degree 2 they are three times as much, of degree 4 no less, and radial
basis functions (scipy) are no better.
"""

from __future__ import annotations

import csv
import functools
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.study.files import studies_folder
from mpm_warp.errors import ParameterError
from mpm_warp.grid.fitted import Floats

TABLE = "interpretation_table.csv"
TABLE_RATE = 1e-6
"""Shear strain rate at which the strength of the table holds [1/s]."""
RANGES: Mapping[str, tuple[float, float]] = {
    "rigidity_index": (15.0, 1000.0),
    "adhesion_factor": (0.0, 1.0),
    "stress_anisotropy": (-0.6, 0.9),
    "rate_factor": (0.0, 0.25),
    "remoulded_strength_ratio": (0.04, 1.0),
    "ductility": (5.0, 60.0),
}
"""What the factors depend on, and from where to where the table goes; all dimensionless."""
LOGARITHMIC = ("rigidity_index", "ductility")
MOVING = ("stress_anisotropy", "adhesion_factor")
"""Inputs that change with depth in the same soil: one over the strength, one by the sleeve."""
DEGREE = 3
HELD_OUT = 8
"""Every so manieth case of the table is kept out of the fit, to measure its error."""
QUANTITIES = ("cone_factor", "sleeve_friction_factor", "pore_pressure_factor_shoulder")
NUMERICAL_ERROR: Mapping[str, float] = {
    "cone_factor": 0.03,
    "sleeve_friction_factor": 0.05,
    "pore_pressure_factor_shoulder": 0.25,
}
"""Half widths of 95 % of the simulated factors themselves, over them: mesh, window and speed. Of
the cone factor it is 0.015 where the strength stays, and is taken as twice that where it changes;
the pore pressure behind the shoulder was read by an older version, see `READ_TOO_HIGH`."""
READ_TOO_HIGH = (0.82, -0.14)
"""What the pore pressure behind the shoulder is, over what the table holds: at adhesion factor 0,
and what its change adds. The table was made where it was read on three rows of cells beside the
face, in the jump of pressure at the shoulder. In nine cases at rigidity indices of 30, 100 and 300
to 400 a reading beyond the jump gave 0.70 to 0.88 times as much smooth, 0.53 to 0.73 at an adhesion
factor of 0.5, 0.66 to 0.72 rough."""


@dataclass(frozen=True, eq=False)
class Factors:
    """The polynomials.

    Attributes:
        exponents: of each input in each term, shape [terms, inputs].
        weights: of each term in each quantity, shape [terms, quantities].
        half_widths: 95 % of each quantity's error over it: of the fit, by the cases kept out, and
            of what was simulated, as squares, shape [quantities].
        fit_errors: errors of the cases kept out over the quantities, shape [cases, quantities].
    """

    exponents: np.ndarray
    weights: Floats
    half_widths: Floats
    fit_errors: Floats

    def at(self, inputs: Mapping[str, Floats | float]) -> dict[str, Floats]:
        """The quantities of inputs of the table, shape [...]; they are not checked."""
        x = np.stack(np.broadcast_arrays(*(scaled(name, inputs[name]) for name in RANGES)))
        powers = np.stack([x**power for power in range(DEGREE + 1)])
        terms = math.prod(powers[own, place] for place, own in enumerate(self.exponents.T))
        values = dict(zip(QUANTITIES, np.tensordot(self.weights.T, terms, 1), strict=True))
        values["sleeve_friction_factor"] = (
            values["sleeve_friction_factor"] * (inputs["adhesion_factor"])
        )
        return values

    def along(self, fixed: Mapping[str, Floats | float]) -> Along:
        """The quantities of soils, shape [soils], as functions of what changes with depth."""
        names = list(RANGES)
        places = [names.index(name) for name in fixed]
        x = np.stack([np.atleast_1d(scaled(name, fixed[name])) for name in fixed])
        powers = x[:, None, :] ** self.exponents.T[places][:, :, None]
        terms = np.prod(powers, axis=0)  # [terms, soils]
        moving = self.exponents[:, [names.index(name) for name in MOVING]]
        weights = {
            (a, b): np.einsum("tq,ts->qs", self.weights[rows], terms[rows])
            for a, b in itertools.product(range(DEGREE + 1), repeat=2)
            if (rows := (moving == (a, b)).all(axis=1)).any()
        }
        return Along(weights)


@dataclass(frozen=True, eq=False)
class Along:
    """Factors of soils over stress anisotropy and adhesion; weights are by the powers of both."""

    weights: Mapping[tuple[int, int], Floats]

    def __call__(
        self, stress_anisotropy: Floats, adhesion_factor: Floats, quantities: int = len(QUANTITIES)
    ) -> dict[str, Floats]:
        """The first quantities by name, shape [..., soils]."""
        x, y = scaled(MOVING[0], stress_anisotropy), scaled(MOVING[1], adhesion_factor)
        values = {
            name: sum(weight[place] * x**a * y**b for (a, b), weight in self.weights.items())
            for place, name in enumerate(QUANTITIES[:quantities])
        }
        if quantities > 1:
            values["sleeve_friction_factor"] = values["sleeve_friction_factor"] * adhesion_factor
        return values


def scaled(name: str, value: Floats | float) -> Floats:
    """An input between -1 and 1 over its range, the logarithm of those that are so drawn."""
    low, high = RANGES[name]
    value = np.asarray(value, dtype=float)
    if name in LOGARITHMIC:
        value, low, high = np.log(value), math.log(low), math.log(high)
    scaled: Floats = (2.0 * value - (low + high)) / (high - low)
    return scaled


def read_table(path: Path) -> dict[str, Floats]:
    """The columns of the table by name, shape [cases]."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@functools.cache
def factors() -> Factors:
    """The polynomials through the table that ships, by least squares."""
    table = read_table(studies_folder() / TABLE)
    count = len(table["cone_factor"])
    kept_out = np.arange(count) % HELD_OUT == HELD_OUT - 1
    inputs = np.stack([scaled(name, table[name]) for name in RANGES], axis=-1)
    exponents = np.array(
        [it for it in itertools.product(range(DEGREE + 1), repeat=len(RANGES)) if sum(it) <= DEGREE]
    )
    terms = np.prod(inputs[:, None, :] ** exponents, axis=-1)
    over = {"sleeve_friction_factor": table["adhesion_factor"]}
    at_smooth, change = READ_TOO_HIGH
    table["pore_pressure_factor_shoulder"] *= at_smooth + change * table["adhesion_factor"]
    values = np.stack([table[name] / over.get(name, 1.0) for name in QUANTITIES], axis=-1)
    weights, *_ = np.linalg.lstsq(terms[~kept_out], values[~kept_out], rcond=None)
    errors = terms[kept_out] @ weights / values[kept_out] - 1.0
    numerical = np.array([NUMERICAL_ERROR[name] for name in QUANTITIES])
    half_widths = np.hypot(np.quantile(np.abs(errors), 0.95, axis=0), numerical)
    return Factors(exponents, weights, half_widths, errors)


def at_table_rate(inputs: Mapping[str, Floats], rate: float) -> tuple[dict[str, Floats], Floats]:
    """Inputs whose strength holds at a shear strain rate [1/s], as those of the table.

    Returns:
        The inputs, and su' / su, by which a factor of the table is one over su.
    """
    ratio = 1.0 - inputs["rate_factor"] * math.log10(rate / TABLE_RATE)
    changed = ("rate_factor", "rigidity_index", "stress_anisotropy")
    own = {name: it / ratio if name in changed else it for name, it in inputs.items()}
    return own, np.asarray(ratio)


def cone_factor(
    *,
    rigidity_index: float | Floats,
    adhesion_factor: float | Floats = 0.0,
    stress_anisotropy: float | Floats = 0.0,
    rate_factor: float | Floats = 0.0,
    reference_strain_rate: float = TABLE_RATE,
    remoulded_strength_ratio: float | Floats = 1.0,
    ductility: float | Floats = 20.0,
) -> tuple[Floats, Floats]:
    """The factor Nkt = qnet / su of a 60 degree cone in Tresca clay, at once, with its error.

    All but the rate may be arrays that go together, shape [...].

    Args:
        rigidity_index: G / su, 15 to 1000.
        adhesion_factor: of face and shaft, 0 to 1.
        stress_anisotropy: Delta = (sigma_v0 - sigma_h0) / (2 su), -0.6 to 0.9.
        rate_factor: mu, what a log cycle of strain rate adds to su, over it; 0 to 0.25.
        reference_strain_rate: shear strain rate at which su holds [1/s], 1e-6 to 1e-2.
        remoulded_strength_ratio: remoulded over intact strength, 0.04 to 1.
        ductility: plastic shear strain xi_95 at which 95 % of that loss is done, 5 to 60.

    Returns:
        Nkt, and the half width of 95 % of its numerical error; of numbers alone, numbers.

    Raises:
        ParameterError: a value is outside the table.
    """
    if not TABLE_RATE <= reference_strain_rate <= 1e-2:
        raise ParameterError(
            "reference_strain_rate",
            f"reference_strain_rate = {reference_strain_rate:g} must be >= {TABLE_RATE:g} and "
            "<= 0.01 s-1",
        )
    given = {
        "rigidity_index": rigidity_index,
        "adhesion_factor": adhesion_factor,
        "stress_anisotropy": stress_anisotropy,
        "rate_factor": rate_factor,
        "remoulded_strength_ratio": remoulded_strength_ratio,
        "ductility": ductility,
    }
    own, ratio = at_table_rate({k: np.asarray(v) for k, v in given.items()}, reference_strain_rate)
    for name, value in own.items():
        low, high = RANGES[name]
        outside = np.atleast_1d(~((value >= low) & (value <= high)))
        if outside.any():
            asked, at_table = (
                np.broadcast_to(it, outside.shape)[outside][0] for it in (given[name], value)
            )
            at_rate = "" if asked == at_table else f", {at_table:g} at the rate of the table,"
            raise ParameterError(name, f"{name} = {asked:g}{at_rate} must be {low:g} to {high:g}")
    table = factors()
    factor: Floats = (table.at(own)["cone_factor"] * ratio)[()]
    return factor, factor * table.half_widths[0]
