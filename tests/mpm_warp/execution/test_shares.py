"""The shares of a launch: together they are the whole launch, whatever the number of threads."""

import pytest

from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.threads import has_dynamic_chunks, share_of
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.plan.launch import OFFSET, WORTH_SHARING
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.elastic.columns import GravityColumn
from mpm_warp.scenes.elastic.thick_cylinder import ThickCylinder

CONE = ConePenetration(cells_per_radius=4, domain_radius=10, domain_above=4, domain_below=4)
FEW_ROWS = ThickCylinder(cell_count=120)


@pytest.mark.parametrize("scene", [CONE, GravityColumn(cell_count=3)])
@pytest.mark.parametrize("count", [1, 3, SHARE_COUNT, 1000])
def test_the_shares_of_a_launch_make_up_the_whole(
    scene: ConePenetration | GravityColumn, count: int
) -> None:
    soil = scene.build()
    assert soil is not None
    for launch in make_plan(soil).step:
        if OFFSET not in launch.arguments:
            continue
        place = next(k for k, item in enumerate(launch.share(0, count).arguments) if item == 0)
        covered = list[int]()
        for number in range(count):
            share = launch.share(number, count)
            first = share.arguments[place]
            covered += range(first, first + share.dim[0])
        assert covered == list(range(launch.dim[0]))


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("threads", [1, 2, 4])
def test_what_threads_do_of_a_launch_makes_up_the_whole(threads: int) -> None:
    for launch in make_plan(CONE.build()).step:
        if OFFSET not in launch.arguments:
            continue
        place = launch.arguments.index(OFFSET)
        shares = [share_of(launch, it, threads, SHARE_COUNT) for it in range(threads)]
        parts = [part for share in shares for part in share.static]
        parts += shares[0].dynamic.values()
        done = [it + part.arguments[place] for part in parts for it in range(part.dim[0])]
        assert sorted(done) == list(range(launch.dim[0]))
        assert len({frozenset(share.dynamic) for share in shares}) == 1
        assert bool(shares[0].dynamic) == (threads > 1 and has_dynamic_chunks(launch))


def test_threads_share_what_takes_longer_than_to_wait_for_each_other() -> None:
    scene = CONE.build()
    small = [
        launch
        for launch in make_plan(scene).step
        if OFFSET in launch.arguments and not launch.is_shared
    ]
    assert any(launch.dim == (len(scene[SurfaceContact].nodes),) for launch in small)
    assert all(launch.item_count < WORTH_SHARING for launch in small)
    # What adds up is always split, else the number of threads would change how sums are rounded.
    few = GravityColumn(cell_count=3).build()
    assert few is not None
    assert all(launch.is_shared == launch.adds_up for launch in make_plan(few).step)


def test_thread_counts_divide_the_shares_so_that_all_have_as_many() -> None:
    assert all(SHARE_COUNT % threads == 0 for threads in THREAD_COUNTS)


def test_no_thread_is_given_an_empty_part_of_a_launch() -> None:
    plan = FEW_ROWS.plan()
    short = [launch for launch in plan.step if launch.is_shared and launch.dim[0] < 4]
    assert short
    for launch in short:
        shares = [share_of(launch, thread, 4, plan.share_count) for thread in range(4)]
        parts = [part for share in shares for part in (*share.static, *share.dynamic.values())]
        assert all(part.item_count > 0 for part in parts)
        done = sum(part.item_count for share in shares for part in share.static)
        assert done == launch.item_count
