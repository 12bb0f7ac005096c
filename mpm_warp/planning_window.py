"""What only a scene with a window has: layers of soil that enter, and its travel."""

from __future__ import annotations

from mpm_warp.parts.window_kernels import make_admit, make_advance_window
from mpm_warp.grid.seeding import PARTICLE_STATE, seed_rows
from mpm_warp.plan.plan import Launch, Plan
from mpm_warp.parts.window import Window


def add_admission(plan: Plan) -> None:
    """The launch by which a layer of soil enters; it is no part of the step."""
    scene = plan.scene
    lowest = seed_rows(scene.grid, 0, 1, scene.particles_per_side)
    count = lowest.particle_count // scene.particles_per_side
    # A layer enters through the bottom of the grid, when it gets there.
    position = lowest.position[:count].copy()
    position[:, 1] = scene.grid.rows[0]
    plan.add_array("layer.position", "vec2", position)
    plan.add_array("layer.mass", "real", scene.material.density * lowest.volume[:count])
    plan.add_array("layer.cell", "vec2i", lowest.cell[:count])
    plan.add_zeros("window.motion", "double", 3)
    plan.add_zeros("layer.lift", "real", 1)
    plan.add_zeros("layer.places", "int", count)
    plan.admission = Launch(
        kernel=make_admit(plan.precision),
        dim=(count,),
        arguments=(
            *("layer.position", "layer.mass", "layer.cell", "layer.lift", "layer.places"),
            *PARTICLE_STATE,
        ),
    )


def add_travel(plan: Plan, window: Window) -> None:
    """The travel of the window, at the end of the step."""
    approach = window.approach
    falling = (0.0, 0.0) if approach is None else (approach.travel, approach.slowing_travel)
    plan.add_launch(
        make_advance_window(approach is not None),
        1,
        *(plan.time_step, window.first_speed, window.ramp_time, window.speed, *falling),
        "window.motion",
    )
