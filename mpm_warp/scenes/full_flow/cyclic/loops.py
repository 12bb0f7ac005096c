"""Resistance of a body that goes down and up again: loops over its depth, and by cycle."""

from __future__ import annotations

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING
from mpm_warp.scenes.full_flow.penetrometer import ResistanceSamples
from mpm_warp.scenes.full_flow.round_body import RoundBody
from mpm_warp.simulation import Simulation

MIDDLE = 2.0
"""Length in the middle of the stroke over which the resistance of a passage is a mean, in radii."""
FIRST_CYCLE = 0.25
"""Number of the cycle in the middle of the first passage; each further passage adds a half."""


class ResistanceLoops:
    """Samples the resistance at even distances of the way, about `SAMPLE_SPACING` radii.

    Args:
        simulation: at its start; the body is at the upper end of its stroke.
        body: that moves.
        stroke: way from turn to turn over its radius.
        cycle_count: cycles, of two passages each.
        strength: undrained shear strength su [Pa].
    """

    def __init__(
        self,
        simulation: Simulation,
        body: RoundBody,
        *,
        stroke: float,
        cycle_count: int,
        strength: float,
    ) -> None:
        self._samples = ResistanceSamples(simulation, body)
        self._radius = body.radius
        self._stroke = stroke
        self._strength = strength
        self._shape = 2 * cycle_count, round(stroke / SAMPLE_SPACING)

    @property
    def ways(self) -> list[float]:
        """Ways gone, down and up, at which samples are due [m]."""
        passages, per_passage = self._shape
        spacing = self._stroke * self._radius / per_passage
        return [number * spacing for number in range(1, passages * per_passage + 1)]

    def sample(self) -> None:
        """Record the mean force since the sample before."""
        self._samples.take()

    @property
    def work(self) -> float:
        """Of the body so far [J], per radian or per unit length of half of it."""
        downward = np.where(np.arange(self._shape[0]) % 2 == 0, 1.0, -1.0)
        forces = self._by_passage(np.array(self._samples.forces))
        spacing = self._stroke * self._radius / self._shape[1]
        return float(np.nansum(forces * downward[:, None])) * spacing

    def dataset(self) -> xr.Dataset:
        """The loops, and the mean over the middle of each passage."""
        passages, per_passage = self._shape
        loops = self._by_passage(self._samples.resistance)
        cycle = FIRST_CYCLE + 0.5 * np.arange(passages)
        place = (np.arange(per_passage) + 0.5) / per_passage * self._stroke
        is_middle = np.abs(place - 0.5 * self._stroke) < 0.5 * MIDDLE
        factor = np.abs(loops[:, is_middle].mean(axis=1)) / self._strength
        numbered = "that of the middle of a passage: 0.25 down, 0.75 up, 1.25 down, ..."
        coordinates = labelled(
            dims=("cycle",), cycle=(cycle, "1", "number of the cycle", numbered)
        ) | labelled(
            dims=("penetration",),
            penetration=(place, "1", "penetration over radius of the body"),
        )
        results = labelled(
            dims=("cycle", "penetration"),
            cyclic_resistance=(
                loops,
                "Pa",
                "resistance over projected area",
                "upward positive: below 0 on the way up",
            ),
        ) | labelled(
            dims=("cycle",),
            cyclic_resistance_factor=(
                factor,
                "1",
                "resistance over projected area and su",
                f"size of the mean over the middle {MIDDLE:g} radii of the stroke",
            ),
        )
        return xr.Dataset(results, coords=coordinates)

    def _by_passage(self, values: Floats) -> Floats:
        """Values of samples by passage and place from above; not a number where there is none."""
        table = np.full(self._shape, np.nan)
        table.reshape(-1)[: len(values)] = values
        table[1::2] = table[1::2, ::-1]
        return table
