"""Soil that moves along the rays of its grid alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def test_of_the_velocity_of_a_node_what_is_along_its_ray_is_left(cavity: Scene) -> None:
    """A velocity that is the same everywhere keeps its part along each ray, to rounding."""
    rows = np.linspace(0.0, 0.5 * np.pi, 6)
    grid = PolarGrid(
        columns=cavity.grid.columns,
        rows=rows,
        surface_radius=np.ones(6),
        fitted_radius=cavity.grid.outer_radius,
    )
    # So short a step that no stress acts.
    simulation = Simulation(
        dataclasses.replace(
            cavity.without(Fixed, FarField, MovingWall),
            grid=grid,
            time_step_fraction=1e-6,
        ).with_parts(RadialMotion(), cavity[MovingWall])
    )
    simulation.array("particle.velocity")[:] = [3.0, 7.0]
    simulation.advance(1)
    velocity = simulation.array("node.velocities")[:, :2].reshape(6, -1, 2)
    outward = np.stack([np.sin(rows), np.cos(rows)], axis=-1)
    expected = (outward @ [3.0, 7.0])[:, None] * outward
    beyond_the_wall = velocity[:, 1:]
    np.testing.assert_allclose(
        beyond_the_wall, np.broadcast_to(expected[:, None], beyond_the_wall.shape), atol=1e-9
    )


def test_a_grid_without_rays_is_refused(cavity: Scene) -> None:
    with pytest.raises(SceneError, match="radial motion: the grid is a Grid, must be a PolarGrid"):
        cavity.with_parts(RadialMotion())
