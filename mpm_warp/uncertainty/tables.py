"""Tables of what was measured, in the CSV files of the folder `measured`, and their interpolation.

A file begins with comments, which say how it was measured. A table has a row for each rigidity
index and adhesion factor. Between them a value is linear over ln(Ir) and over the adhesion factor,
or over a function of it; beyond its edge a table keeps the value at the edge.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mpm_warp.grid.fitted import Floats

Value = Floats | float

FOLDER = Path(__file__).with_name("measured")
PLACE = ("rigidity_index", "adhesion_factor")


class Effect(NamedTuple):
    """What a choice of the method adds to a result, and how well that is known."""

    size: float  # 0 where nothing is corrected
    half_width: float  # of 95 %


@dataclass(frozen=True, eq=False)
class Table:
    """Values over rigidity index and adhesion factor."""

    rigidity_index: Floats  # increasing, shape [n]
    adhesion_factor: Floats  # increasing, shape [m]
    columns: Mapping[str, Floats]  # by name, shape [n, m]

    @classmethod
    def of(cls, name: str) -> "Table":
        """The table of a file."""
        rows = read(name)
        indices, adhesions = (sorted({float(row[it]) for row in rows}) for it in PLACE)
        shape = len(indices), len(adhesions)
        columns = {
            column: np.array([float(row[column]) for row in rows]).reshape(shape)
            for column in rows[0]
            if column not in PLACE
        }
        return cls(np.array(indices), np.array(adhesions), columns)

    def at(self, column: str, rigidity_index: Value, adhesion_factor: Value = 0.0) -> Value:
        """The values of a column, shape [...], at arguments whose shapes broadcast."""
        values = self.columns[column]
        place = np.interp(adhesion_factor, self.adhesion_factor, np.arange(values.shape[1]))
        index, indices = np.log(rigidity_index), np.log(self.rigidity_index)
        value: Floats = sum(
            np.maximum(0.0, 1.0 - np.abs(place - number)) * np.interp(index, indices, of_adhesion)
            for number, of_adhesion in enumerate(values.T)
        )
        return value

    def beyond(self, rigidity_index: Value) -> Value:
        """Distance in ln(Ir) from the table, 0 inside it, shape [...]."""
        nearest = np.clip(rigidity_index, self.rigidity_index[0], self.rigidity_index[-1])
        return np.abs(np.log(rigidity_index / nearest))

    def left_out(self, column: str) -> Floats:
        """The error of the interpolation at each inner rigidity index, shape [n - 2, m].

        A row that is left out is interpolated between its neighbours. Over their distance, twice
        that of the table, the error of a linear interpolation is four times as large as in the
        table, and so is divided by four.
        """
        values, index = self.columns[column], np.log(self.rigidity_index)
        share = ((index[1:-1] - index[:-2]) / (index[2:] - index[:-2]))[:, None]
        between: Floats = (1.0 - share) * values[:-2] + share * values[2:]
        return 0.25 * (between - values[1:-1])


def read(name: str) -> list[dict[str, str]]:
    """The rows of a file, by the names in its head."""
    with (FOLDER / f"{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def effects(name: str) -> dict[str, Effect]:
    """The effects of a file, by name."""
    return {
        row["effect"]: Effect(float(row["size"] or 0.0), float(row["half_width"]))
        for row in read(name)
    }


def root_sum_square(*parts: Value) -> Value:
    """Root of the sum of squares of half widths, shape [...]."""
    return np.sqrt(sum(np.square(part) for part in parts))
