"""The travel of the window through the soil, layer by layer."""

from __future__ import annotations

import math

import numpy as np

from mpm_warp.grid.fitted import Integers
from mpm_warp.plan.plan import Launch, share_bounds
from mpm_warp.simulation import Simulation
from mpm_warp.watch.health import WindowOverfull

ROUNDING = 1e-6
"""Share of a step that counts as rounding: no step beyond a distance is taken for it."""


class Travel:
    """Advances a simulation whose scene has a window, and lets soil in on the way.

    Args:
        simulation: a simulation that has not travelled yet.
    """

    def __init__(self, simulation: Simulation) -> None:
        scene, plan = simulation.scene, simulation.plan
        assert scene.window is not None, "the scene has no window"
        assert plan.admission is not None
        self._simulation = simulation
        self._admission: Launch = plan.admission
        self._share_bounds = share_bounds(plan.arrays["particle.mass"].shape[0], plan.share_count)
        self._layer_size = plan.arrays["layer.mass"].shape[0]
        self._layers_per_row = scene.particles_per_side
        self._layer_height = float(scene.grid.rows[1] - scene.grid.rows[0]) / self._layers_per_row
        self._window = scene.window
        self._layer_count = 0

    @property
    def distance(self) -> float:
        """How far the window has moved down through the soil [m]."""
        return float(self._simulation.array("window.motion")[2])

    def advance_to(self, distance: float) -> None:
        """Take steps until the window has moved by `distance` [m] since the start.

        Raises:
            SimulationDiverged: the run became unstable.
            WindowOverfull: no place is left for the soil that has to enter.
        """
        now = self.distance
        while now < distance:
            next_layer = (self._layer_count + 0.5) * self._layer_height
            remaining = min(distance, next_layer) - now
            # Where the speed rises or falls this falls short, and the loop goes round again.
            per_step = self._window.highest_speed_from(now) * self._simulation.plan.time_step
            self._simulation.advance(max(1, math.ceil(remaining / per_step - ROUNDING)))
            now = self.distance
            if now >= next_layer:
                self._admit_layer(lift=now - next_layer)

    def _chosen(self, free: Integers) -> Integers:
        """As many of the free places as a layer needs: those of the shares that have most."""
        bounds = self._share_bounds
        end_of_share = np.searchsorted(free, bounds)[np.searchsorted(bounds, free, side="right")]
        left_in_share = end_of_share - np.arange(len(free))
        return free[np.argsort(-left_in_share, kind="stable")[: self._layer_size]]

    def _admit_layer(self, *, lift: float) -> None:
        """Let a layer of soil in, `lift` [m] above the bottom of the grid."""
        simulation = self._simulation
        free = np.flatnonzero(simulation.array("particle.cell")[:, 0] < 0)
        if len(free) < self._layer_size:
            raise WindowOverfull(
                f"after {self.distance:.4g} m of travel more soil has stayed in the window than "
                "it has places for: it piles up on the shaft; try more cells_per_radius or a "
                "shorter penetration"
            )
        simulation.assign("layer.lift", lift)
        simulation.assign("layer.places", self._chosen(free))
        simulation.launch(self._admission)
        self._layer_count += 1
        if simulation.scene.far_field is not None and self._layer_count % self._layers_per_row == 0:
            # The springs at the side belong to the soil there, which has risen by a row.
            springs = simulation.array("far_field.displacement")
            simulation.assign("far_field.displacement", np.concatenate([[0.0], springs[:-1]]))
