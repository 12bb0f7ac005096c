"""A scene: what it refuses, and parts that meet what they were not made for."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import warp as wp
from mpm_warp.parts.boundary_kernels import make_far_field
from mpm_warp.parts.load_kernels import make_nodal_load
from mpm_warp.scenes.cavity_cylinder import CavityCylinder
from mpm_warp.scenes.cavity_sphere import CavitySphere
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.scenes.strip_footing import StripFooting

from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.precision import FLOAT64
from mpm_warp.scene import Scene, SceneError
from mpm_warp.simulation import Simulation

CONE = ConePenetration(cells_per_radius=1, penetration=1, domain_radius=5, domain_above=2)
WALL = MovingWall(speed=1.0, ramp_travel=1.0)
ON_RAYS = CavitySphere(cells_per_radius=1).simulated_scene()
PLANE = StripFooting(cells_per_radius=2).simulated_scene()


@pytest.mark.parametrize(
    ("scene", "changes", "message"),
    [
        (PLANE, {"particles_per_side": 0}, "particles_per_side = 0 must be > 0"),
        (PLANE, {"time_step_fraction": float("nan")}, "time_step_fraction = nan must be > 0"),
        (PLANE, {"gravity": -9.81}, "gravity = -9.81 must be > 0, or none"),
        (PLANE, {"precision": "float16"}, "precision = 'float16' must be one of float64, float32"),
        (PLANE, {"moving_wall": WALL}, "moving_wall: not together with a grid that leans"),
        (CONE.build()[0], {"moving_wall": WALL}, "moving_wall: not together with a grid that"),
        (
            CavityCylinder(cells_per_radius=1).simulated_scene(),
            {"window": CONE.build()[0].window},
            "moving_wall: not together with a window",
        ),
        (ON_RAYS, {"even_flow": True}, "even_flow: not together with a grid of rays"),
        (PLANE, {"even_flow": True}, "even_flow: not together with a grid of rays or that is pla"),
        (ON_RAYS, {"consistent_mass": True}, "consistent_mass: not together with a grid of rays"),
        (CONE.build()[0], {"consistent_mass": True}, "consistent_mass: not together with a window"),
    ],
)
def test_what_does_not_go_together_is_refused_in_one_line(
    scene: Scene, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(SceneError, match=f"^{message}"):
        dataclasses.replace(scene, **changes)  # type: ignore[arg-type]


def test_a_node_without_soil_is_left_alone() -> None:
    """Not a number there would stay in the far field after soil has come back."""
    motion = wp.zeros(1, dtype=FLOAT64.vec4, device="cpu")
    nodes, mass = (wp.zeros(1, dtype=kind, device="cpu") for kind in (int, wp.float64))
    spring, displacement = (wp.ones(1, dtype=wp.float64, device="cpu") for _ in range(2))
    vectors = wp.ones(1, dtype=FLOAT64.vec2, device="cpu")
    wp.launch(
        make_far_field(FLOAT64),
        1,
        [0, nodes, spring, vectors, mass, 1.0, displacement, motion],
        device="cpu",
    )
    wp.launch(make_nodal_load(FLOAT64), 1, [nodes, vectors, mass, 1.0, motion], device="cpu")
    assert displacement.numpy().tolist() == [1.0]
    np.testing.assert_array_equal(motion.numpy(), 0.0)


def test_the_travel_is_as_exact_in_single_precision() -> None:
    """A step of some 1e-8 of the travel would be rounded to another in single precision."""
    travels = []
    for precision in ("float64", "float32"):
        simulation = Simulation(dataclasses.replace(CONE, precision=precision).build()[0])
        simulation.advance(500)
        travels.append(simulation.array("window.motion"))
    np.testing.assert_array_equal(*travels)
