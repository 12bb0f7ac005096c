"""From a scene to its plan: the order of the stages, and nothing that the scene does not need."""

import dataclasses

import pytest

from mpm_warp import Damping, Gravity, Part, Scene, SceneError, Window, scene_class, scene_names
from mpm_warp.materials.material import PROPERTIES
from mpm_warp.plan.plan import Plan
from mpm_warp.planning import SHARE_COUNT, make_plan

STAGES = ["particles_to_grid", "cell_stress", "momentum", "cell_rates", "grid_to_particles"]


def kernels(plan: Plan) -> list[str]:
    return [launch.name for launch in plan.step]


def test_soil_alone_has_no_part_that_it_does_not_need(floating: Scene) -> None:
    plan = make_plan(dataclasses.replace(floating, particles_per_side=1))
    assert kernels(plan) == STAGES
    assert {name.split(".")[0] for name in plan.arrays} == {"particle", "grid", "cell", "node"}
    unneeded = {"cell.viscosity", "cell.dilation_rate", "cell.correction", PROPERTIES}
    assert not unneeded & set(plan.arrays)
    assert plan.audited_step == []
    assert plan.between_steps == {}
    assert plan.control is None


def test_the_stages_of_a_step_stand_in_their_order_and_parts_between_them(cone: Scene) -> None:
    """On nodes forces, boundaries, contact; those at one place in the order of the tuple."""
    nodes = ["damping", "gravity", "fixed", "far_field", "surface_contact"]
    forces = (Damping(1.0), Gravity(9.81))
    for parts, turned in (
        ((*forces, *cone.parts), ()),
        ((*cone.parts, *forces), ()),
        ((*forces, *cone.parts[::-1]), (2, 3)),
        ((*cone.parts, *forces[::-1]), (0, 1)),
    ):
        in_order = list(nodes)
        for k in turned[:1]:
            in_order[k : k + 2] = nodes[k + 1], nodes[k]
        plan = make_plan(dataclasses.replace(cone, parts=parts))
        assert kernels(plan) == [*STAGES[:3], *in_order, *STAGES[3:], "advance_window"]


def test_a_wall_pushes_last_and_moves_after_the_particles(cavity: Scene) -> None:
    assert kernels(make_plan(cavity)) == [
        *STAGES[:3],
        *("fixed", "far_field", "push"),
        *STAGES[3:],
        *("move_wall", "refit_cells"),
    ]


@pytest.mark.parametrize("name", scene_names())
def test_every_array_is_used(name: str) -> None:
    plan = scene_class(name)().plan()
    used = {array for launch in plan.launches for array in launch.arrays}
    assert set(plan.arrays) == used


def test_the_time_step_is_the_fraction_of_what_a_wave_takes_to_cross_a_cell(
    floating: Scene, cone: Scene
) -> None:
    """Soil that streams past the grid carries its waves along."""
    plan = make_plan(floating)
    speed = floating.material.pressure_wave_speed
    assert plan.time_step == pytest.approx(0.5 * floating.grid.cell_lengths.min() / speed)
    assert plan.longest_time_step == pytest.approx(2.0 * plan.time_step)
    in_window = cone.grid.cell_lengths.min() / (
        cone.material.pressure_wave_speed + cone[Window].first_speed
    )
    assert make_plan(cone).time_step == pytest.approx(0.85 * in_window)
    assert make_plan(cone, time_step=1e-4).time_step == 1e-4


def test_sums_have_a_row_for_each_share(floating: Scene) -> None:
    for count in (1, SHARE_COUNT):
        plan = make_plan(floating, share_count=count)
        for name in ("cell.stress_sum", "cell.mass", "node.momentum"):
            assert plan.arrays[name].shape[0] == count


class Warmth(Part):
    """Points that carry a temperature, but empty slots do not."""

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        plan.add_zeros("particle.temperature", "real", plan.particle_count)


def test_what_points_carry_has_a_place_for_each_slot(floating: Scene, cone: Scene) -> None:
    assert make_plan(floating.with_parts(Warmth())).particle_count  # no slot is empty
    with pytest.raises(SceneError, match=r"'particle.temperature' has shape .* must have"):
        make_plan(cone.with_parts(Warmth()))


def test_a_grid_without_a_point_is_refused(floating: Scene) -> None:
    level = 0.01 * float(floating.grid.rows[1])
    for border in ("ground_level", "soil_radius"):
        empty = dataclasses.replace(floating.grid, **{border: level})
        with pytest.raises(SceneError, match="no material point is in the grid"):
            make_plan(dataclasses.replace(floating, grid=empty))


def test_what_nobody_can_plan_is_a_type_error() -> None:
    with pytest.raises(TypeError, match=r"^a str cannot be planned$"):
        make_plan("cone_penetration")
