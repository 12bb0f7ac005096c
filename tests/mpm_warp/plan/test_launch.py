"""A launch, and the shares that it is split into."""

import numpy as np
import pytest
import warp as wp

from mpm_warp.plan.launch import OFFSET, WORTH_SHARING, Launch, ShareRow, share_bounds


@wp.kernel(enable_backward=False)
def scale(offset: int, factor: wp.float64, values: wp.array(dtype=wp.float64)):
    k = offset + wp.tid()
    values[k] = factor * values[k]


@wp.kernel(enable_backward=False)
def add_up(offset: int, values: wp.array(dtype=wp.float64), total: wp.array(dtype=wp.float64)):
    wp.atomic_add(total, 0, values[offset + wp.tid()])


@wp.kernel(enable_backward=False)
def clear(values: wp.array(dtype=wp.float64)):
    values[wp.tid()] = wp.float64(0.0)


def test_a_launch_has_the_name_of_its_kernel_and_knows_its_arrays() -> None:
    launch = Launch(kernel=scale, dim=(10,), arguments=(OFFSET, 3.0, "cell.volume"))
    assert launch.name == "scale"
    assert launch.arrays == ("cell.volume",)
    assert launch.item_count == 10


@pytest.mark.parametrize(("length", "count"), [(10, 4), (3, 4), (0, 4), (1001, 1), (7, 7)])
def test_shares_make_up_the_whole_and_are_as_even_as_can_be(length: int, count: int) -> None:
    bounds = share_bounds(length, count)
    assert bounds[0] == 0
    assert bounds[-1] == length
    assert len(bounds) == count + 1
    assert np.ptp(np.diff(bounds)) <= 1


def test_a_share_begins_where_the_one_before_it_ends_and_has_a_row_of_its_own() -> None:
    launch = Launch(
        kernel=add_up, dim=(10, 3), arguments=(OFFSET, "cell.volume", ShareRow("cell.total"))
    )
    shares = [launch.share(number, 4) for number in range(4)]
    assert [share.arguments[0] for share in shares] == [0, 2, 5, 7]
    assert [share.dim for share in shares] == [(2, 3), (3, 3), (2, 3), (3, 3)]
    assert [share.arguments[2] for share in shares] == [
        ShareRow("cell.total", number) for number in range(4)
    ]
    assert launch.arrays == ("cell.volume", "cell.total")


def test_a_share_is_called_with_its_row_of_an_array() -> None:
    values, total = np.arange(10.0), np.zeros((4, 1))
    launch = Launch(kernel=add_up, dim=(10,), arguments=(OFFSET, "values", ShareRow("total")))
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
        return Launch(kernel=scale, dim=(count,), arguments=(OFFSET, 1.0, "values")).is_shared

    assert scaled(WORTH_SHARING)
    assert not scaled(WORTH_SHARING - 1)
    assert not Launch(kernel=clear, dim=(10 * WORTH_SHARING,), arguments=("values",)).is_shared
    adding = Launch(kernel=add_up, dim=(10,), arguments=(OFFSET, "values", ShareRow("total")))
    assert adding.is_shared
    assert adding.adds_up
