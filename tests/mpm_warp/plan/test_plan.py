"""A plan: its arrays by kind, its launches in their order, and their shares."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.errors import Fault, SceneError
from mpm_warp.kernel_types import maybe
from mpm_warp.plan.launch import OFFSET, WORTH_SHARING, Launch, ShareRow, share_bounds
from mpm_warp.plan.plan import Plan, TimeStepControl
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import CHECK_INTERVAL, Simulation


@wp.kernel(enable_backward=False)
def scale(
    offset: int,
    time_step: float,
    factor: float,
    cell_volume: wp.array(dtype=float),
    cell_power: maybe(float),
):
    k = offset + wp.tid()
    cell_volume[k] = time_step * factor * cell_volume[k]


@wp.kernel(enable_backward=False)
def add_up(offset: int, values: wp.array(dtype=wp.float64), total: wp.array(dtype=wp.float64)):
    wp.atomic_add(total, 0, values[offset + wp.tid()])


@wp.kernel(enable_backward=False)
def clear(values: wp.array(dtype=float)):
    values[wp.tid()] = 0.0


@pytest.fixture
def plan() -> Plan:
    """A plan without anything in it."""
    unbounded = np.full(2, np.inf)
    return Plan(
        time_step=0.1,
        longest_time_step=1.0,
        speed_limit=1.0,
        particle_bounds=(-unbounded, unbounded),
    )


@pytest.mark.parametrize(
    ("kind", "components", "scalar"),
    [
        ("real", (), "float64"),
        ("vec2", (2,), "float64"),
        ("vec10", (10,), "float64"),
        ("mat22", (2, 2), "float64"),
        ("int", (), "int32"),
        ("vec2i", (2,), "int32"),
    ],
)
def test_an_array_has_the_type_of_its_kind_and_the_values_that_it_is_given(
    plan: Plan, kind: str, components: tuple[int, ...], scalar: str
) -> None:
    values = np.arange(5 * np.prod(components, dtype=int)).reshape(5, *components)
    assert plan.add_array("cell.given", kind, values) == "cell.given"
    assert plan.add_zeros("cell.zeros", kind, 5) == "cell.zeros"
    given, zeros = (plan.arrays[f"cell.{name}"] for name in ("given", "zeros"))
    assert given.shape == zeros.shape == (5,)
    assert given.dtype == zeros.dtype
    on_device = given.allocate("cpu").numpy()
    assert on_device.dtype == scalar
    np.testing.assert_array_equal(on_device, values)
    np.testing.assert_array_equal(zeros.allocate("cpu").numpy(), 0 * values)
    assert given.byte_count == on_device.nbytes


def test_arguments_of_a_launch_go_by_their_names_in_the_kernel(plan: Plan) -> None:
    """An array by its own name, the length of a step; what is given in any order comes first."""
    plan.add_zeros("cell.volume", "real", 10)
    launch = plan.launch(scale, 10, factor=3.0)
    assert launch.arguments == (OFFSET, plan.time_step, 3.0, "cell.volume", None)
    assert launch.dim == (10,)
    assert launch.item_count == 10
    assert (launch.kernel, launch.name) == (scale, "scale")
    plan.given["factor"] = 4.0
    plan.add_zeros("cell.power", "real", (4, 3))
    launch = plan.launch(scale, 10)
    assert launch.arguments == (OFFSET, plan.time_step, 4.0, "cell.volume", "cell.power")
    assert plan.arrays["cell.power"].shape == (4, 3)
    launch = plan.launch(scale, 10, cell_volume="other.volume", time_step=7.0, factor=3.0)
    assert launch.arguments == (OFFSET, 7.0, 3.0, "other.volume", "cell.power")
    assert plan.launch(clear, (2, 3), values=None).arguments == (None,)
    assert plan.launch(clear, (2, 3), values=None).dim == (2, 3)


@pytest.mark.parametrize(
    ("arguments", "missing", "unknown"),
    [
        ({"volume": "v", "factor": 3.0}, ["cell_volume"], ["volume"]),
        ({}, ["factor", "cell_volume"], []),
    ],
)
def test_what_is_missing_and_what_is_unknown_is_named_beside_what_the_kernel_takes(
    plan: Plan, arguments: dict[str, object], missing: list[str], unknown: list[str]
) -> None:
    with pytest.raises(TypeError, match=scale.key) as refused:
        plan.add_launch(scale, 10, **arguments)
    message = str(refused.value)
    assert f"arguments missing: {missing}, unknown: {unknown};" in message
    assert message.endswith("it takes offset, time_step, factor, cell_volume, cell_power")
    assert plan.step == []


def test_records_stand_in_the_audited_step_where_they_are_asked_for(plan: Plan) -> None:
    values = plan.add_zeros("cell.volume", "real", 5)
    plan.add_launch(clear, 5, values=values)
    plan.add_launch(scale, 5, factor=2.0)
    cleared, scaled = plan.step
    first, before, after, last, check = (plan.launch(clear, 5, values=values) for _ in range(5))
    plan.audit(last)
    plan.audit(before, before="scale")
    plan.audit(after, after="scale")
    plan.audit(first, before="clear")
    assert plan.audited_step == [first, cleared, before, scaled, after, last]
    assert plan.step == [cleared, scaled]
    plan.between_steps["check"] = check
    assert plan.launches == [cleared, scaled, first, before, after, last, check]  # each once


@pytest.mark.parametrize("name", ["cell.volume", "cell_volume"])
def test_an_array_whose_name_is_taken_in_kernels_is_refused(plan: Plan, name: str) -> None:
    plan.add_zeros("cell.volume", "real", 5)
    with pytest.raises(SceneError, match=f"^array '{name}' .*"):
        plan.add_zeros(name, "real", 5)
    with pytest.raises(SceneError, match=f"^array '{name}' .*"):
        plan.add_array(name, "real", np.ones(5))
    assert list(plan.arrays) == ["cell.volume"]


def following(now: float, critical: float, fraction: float = 0.8) -> float:
    control = TimeStepControl(first=0.8, fraction=fraction, critical=lambda array: critical)
    return control.following(now, np.zeros)


@pytest.mark.parametrize(
    ("critical", "fraction", "expected"),
    [
        (1.0, 0.8, 0.8),  # it stays while it is nearly right
        (1.0 / 1.02, 0.8, 0.8),
        (1.0 / 1.06, 0.8, 0.8 / 1.06**2),  # ready for a further fall
        (5.0, 0.8, 0.8),  # up to the first one
        (0.75, 1.0, 0.75**2 / 0.8),  # where the scene asks for the critical one itself
    ],
)
def test_the_time_step_follows_the_critical_one(
    critical: float, fraction: float, expected: float
) -> None:
    assert following(0.8, critical, fraction) == pytest.approx(expected)
    with pytest.raises(Fault, match=r"time step of 0\.8 s is beyond the stable 0\.79 s"):
        following(0.8, critical=0.79)


def test_the_time_step_rises_again_up_to_the_first_one() -> None:
    critical = iter([0.5, 0.5, 0.5 * 1.04, 0.5 * 1.06, 5.0])
    control = TimeStepControl(first=0.8, fraction=0.8, critical=lambda array: next(critical))
    steps = [control.following(0.4, np.zeros) for _ in range(5)]
    np.testing.assert_allclose(steps, [0.2, 0.4, 0.4, 0.4 * 1.06, 0.8])


def test_a_plan_with_another_time_step_is_the_same_but_for_numbers(cavity: Scene) -> None:
    plan = make_plan(cavity)
    assert plan.control is not None
    other = make_plan(cavity, SHARE_COUNT, 0.3 * plan.time_step)
    assert other.time_step == 0.3 * plan.time_step
    assert [launch.kernel for launch in other.step] == [launch.kernel for launch in plan.step]
    assert other.arrays.keys() == plan.arrays.keys()


def test_time_is_the_sum_of_the_steps(cavity: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    factors = iter([0.5, 0.25, 0.5])

    def prescribed(control: TimeStepControl, step: float, array: Any) -> float:
        return control.first * next(factors, 0.5)

    monkeypatch.setattr(TimeStepControl, "following", prescribed)
    simulation = Simulation(cavity)
    first = simulation.plan.time_step
    simulation.advance(3 * CHECK_INTERVAL + 10)
    assert simulation.time == pytest.approx((CHECK_INTERVAL * 1.75 + 10 * 0.5) * first)
    assert simulation.array("wall.motion")[0, 0] == pytest.approx(simulation.time)
    simulation.advance_to(2.5 * CHECK_INTERVAL * first)
    assert simulation.time == pytest.approx(2.5 * CHECK_INTERVAL * first, abs=0.26 * first)


def test_a_share_begins_where_the_one_before_it_ends_and_has_a_row_of_its_own() -> None:
    values, total = np.arange(10.0), np.zeros((4, 1))
    launch = Launch(kernel=add_up, dim=(10,), arguments=(OFFSET, "values", ShareRow("total")))
    assert launch.arrays == ("values", "total")
    assert replace(launch, dim=(10, 3)).share(1, 4).dim == (3, 3)
    arrays = {
        "values": wp.array(values, dtype=wp.float64, device="cpu"),
        "total": wp.array(total, dtype=wp.float64, device="cpu"),
    }
    for number in range(4):
        dim, arguments = launch.share(number, 4).call(arrays)
        wp.launch(add_up, dim, arguments, device="cpu")
    sums = [part.sum() for part in np.split(values, share_bounds(10, 4)[1:-1])]
    np.testing.assert_array_equal(arrays["total"].numpy()[:, 0], sums)


def test_only_launches_worth_it_are_shared_and_all_that_add_up() -> None:
    def scaled(count: int) -> bool:
        return Launch(kernel=scale, dim=(count,), arguments=(OFFSET, 0.1, 1.0, "values")).is_shared

    assert scaled(WORTH_SHARING)
    assert not scaled(WORTH_SHARING - 1)
    assert not Launch(kernel=clear, dim=(10 * WORTH_SHARING,), arguments=("values",)).is_shared
    adding = Launch(kernel=add_up, dim=(10,), arguments=(OFFSET, "values", ShareRow("total")))
    assert adding.is_shared
    assert adding.adds_up
