"""The shares of a launch: together they are the whole launch, whatever the number of threads."""

import pytest

from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.threads import share_of
from mpm_warp.plan.launch import OFFSET
from mpm_warp.planning import SHARE_COUNT
from mpm_warp.scenes import CatalogueScene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.elastic.thick_cylinder import ThickCylinder

CONE = ConePenetration(cells_per_radius=4, domain_radius=10, domain_above=4, domain_below=4)
FEW_ROWS = ThickCylinder(cell_count=120)


@pytest.mark.usefixtures("all_take_part")
@pytest.mark.parametrize("scene", [CONE, FEW_ROWS], ids=["cone", "few_rows"])
@pytest.mark.parametrize("threads", THREAD_COUNTS)
def test_what_threads_do_of_a_launch_makes_up_the_whole(
    threads: int, scene: CatalogueScene
) -> None:
    assert SHARE_COUNT % threads == 0
    for launch in scene.plan().step:
        if OFFSET not in launch.arguments:
            continue
        place = launch.arguments.index(OFFSET)
        shares = [share_of(launch, it, threads, SHARE_COUNT) for it in range(threads)]
        parts = [part for share in shares for part in share]
        done = [it + part.arguments[place] for part in parts for it in range(part.dim[0])]
        assert sorted(done) == list(range(launch.dim[0]))
        assert all(part.item_count > 0 for part in parts)
