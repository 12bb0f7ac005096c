"""A plan: its arrays by kind, and its launches in their order."""

import numpy as np
import pytest
import warp as wp

from mpm_warp.plan.launch import make_launch
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import PRECISIONS


@wp.kernel(enable_backward=False)
def first(offset: int, values: wp.array(dtype=wp.float64)):
    values[offset + wp.tid()] = wp.float64(1.0)


@wp.kernel(enable_backward=False)
def second(values: wp.array(dtype=wp.float64)):
    values[wp.tid()] = wp.float64(2.0)


@pytest.fixture(params=PRECISIONS)
def plan(request: pytest.FixtureRequest) -> Plan:
    """A plan without anything in it."""
    unbounded = np.full(2, np.inf)
    return Plan(
        precision=PRECISIONS[request.param],
        time_step=0.1,
        longest_time_step=1.0,
        speed_limit=1.0,
        particle_bounds=(-unbounded, unbounded),
    )


@pytest.mark.parametrize(
    ("kind", "components", "scalar"),
    [
        ("real", (), None),
        ("vec2", (2,), None),
        ("vec10", (10,), None),
        ("mat22", (2, 2), None),
        ("int", (), "int32"),
        ("vec2i", (2,), "int32"),
    ],
)
def test_an_array_has_the_type_of_its_kind_and_the_values_that_it_is_given(
    plan: Plan, kind: str, components: tuple[int, ...], scalar: str | None
) -> None:
    values = np.arange(5 * np.prod(components, dtype=int)).reshape(5, *components)
    assert plan.add_array("cell.given", kind, values) == "cell.given"
    assert plan.add_zeros("cell.zeros", kind, 5) == "cell.zeros"
    given, zeros = (plan.arrays[f"cell.{name}"] for name in ("given", "zeros"))
    assert given.shape == zeros.shape == (5,)
    assert given.dtype == zeros.dtype
    on_device = given.allocate("cpu").numpy()
    assert on_device.dtype == (scalar or plan.precision.numpy_name)
    np.testing.assert_array_equal(on_device, values)
    np.testing.assert_array_equal(zeros.allocate("cpu").numpy(), 0 * values)
    assert given.byte_count == on_device.nbytes


def test_what_is_double_stays_so_in_single_precision(plan: Plan) -> None:
    plan.add_zeros("window.motion", "double", 3)
    assert plan.arrays["window.motion"].dtype == wp.float64


def test_only_arrays_that_were_added_are_found(plan: Plan) -> None:
    plan.add_zeros("cell.correction", "vec4", (4, 3))
    assert plan.find("cell.correction") == "cell.correction"
    assert plan.find("cell.dilation_rate") is None
    assert plan.arrays["cell.correction"].shape == (4, 3)


def test_a_launch_is_added_at_the_end_by_the_names_of_its_arguments(plan: Plan) -> None:
    values = plan.add_zeros("cell.values", "real", 5)
    plan.add_launch(second, 5, values=values)
    plan.add_launch(first, 5, values=values)
    assert [launch.name for launch in plan.step] == ["second", "first"]
    assert plan.position_after("second") == 1
    with pytest.raises(TypeError, match=r"unknown: \['value'\]"):
        plan.add_launch(first, 5, value=values)
    assert len(plan.step) == 2


def test_all_launches_are_listed_once(plan: Plan) -> None:
    """Of a step, of what an audited step has besides, and of what the host orders between steps."""
    values = plan.add_zeros("cell.values", "real", 5)
    plan.add_launch(first, 5, values=values)
    audit, between = (make_launch(second, 5, {"values": values}) for _ in range(2))
    plan.audited_step = [audit, *plan.step]
    plan.between_steps["check"] = between
    assert plan.launches == [*plan.step, audit, between]
