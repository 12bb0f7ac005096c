"""Waves of shear in a column of soil that travels through a grid, in one dimension.

The column is elastic, periodic and without boundaries: what grows in it grows by the method alone,
the transfers between points and nodes, with or without the mass-matrix correction of
`mpm_warp.step.momentum`. Lengths are over a cell, speeds over that of shear waves, and the density
is 1. Poisson's ratio counts by the time step that the wave of pressure allows.

``travelling_column`` prints by how much the largest wave grows, in percent from one
cell to the next, over the speed of the column (`studies/stability.md`).
"""

import math
from dataclasses import dataclass

import numpy as np

CELLS, STEPS = 64, 6000
SPEEDS = (0.06, 0.08, 0.1, 0.134, 0.17, 0.25)


@dataclass(frozen=True, kw_only=True)
class Column:
    """How a column is simulated."""

    points: int = 2  # per cell
    correction: float = 1.0  # over that of the method
    step: float = 0.85  # over the critical one
    poissons_ratio: float = 0.45

    def growth(self, speed: float) -> float:
        """By how much the largest wave grows on the way of a cell at a speed, over its size."""
        ratio = self.poissons_ratio
        pressure_waves = math.sqrt(2.0 * (1.0 - ratio) / (1.0 - 2.0 * ratio))
        dt = self.step / (pressure_waves + speed)
        weight = self.correction * (1.0 - self.points**-2.0) / 6.0
        count = CELLS * self.points
        mass = 1.0 / self.points
        place = (np.arange(count) + 0.5) / self.points
        of_points, stress = np.random.default_rng(0).normal(size=count), np.zeros(count)
        of_points -= of_points.mean()
        after = np.zeros(CELLS)
        energy = []
        for _ in range(STEPS):
            cell = place.astype(int) % CELLS
            upper, xi = (cell + 1) % CELLS, place - np.floor(place)
            nodes = np.concatenate([cell, upper])
            shares = mass * np.concatenate([1.0 - xi, xi])
            at_node = np.bincount(nodes, shares, CELLS)
            across = np.roll(after, -1) - after
            before = np.bincount(nodes, shares * np.tile(of_points, 2), CELLS) / at_node
            before += weight * (np.roll(across, 1) - across) / np.maximum(at_node, 1.0)
            in_cells = np.bincount(cell, stress, CELLS) / np.bincount(cell, minlength=CELLS)
            force = in_cells - np.roll(in_cells, 1)
            after = before + dt * force / np.maximum(at_node, 0.5)
            change = after - before
            of_points += (1.0 - xi) * change[cell] + xi * change[upper]
            stress += dt * (after[upper] - after[cell])
            place = (place + dt * speed) % CELLS
            energy.append(np.mean(of_points**2) + np.mean(stress**2))
        half = STEPS // 2
        return 0.5 * math.log(energy[-1] / energy[half]) / ((STEPS - 1 - half) * dt * speed)


SHOWN = {
    "as it is": Column(),
    "0.4 of the critical step": Column(step=0.4),
    "Poisson's ratio 0.49": Column(poissons_ratio=0.49),
    "3 points along a side": Column(points=3),
    "4 points along a side": Column(points=4),
    "no correction": Column(correction=0.0),
}

if __name__ == "__main__":
    print(f"{'speed':>26}", *(f"{it:7g}" for it in SPEEDS))
    for name, column in SHOWN.items():
        print(f"{name:>26}", *(f"{100.0 * column.growth(it):7.1f}" for it in SPEEDS), flush=True)
