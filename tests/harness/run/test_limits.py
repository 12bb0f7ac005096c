"""What a case may take of memory and time is looked at before it begins."""

import re
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from harness.run import resources
from harness.run.resources import TooLarge, check_memory, predicted_time
from harness.run.run_study import on_this_machine, run_study
from harness.run.worker import compute
from harness.study.cases import Case
from harness.study.study import Study, load_study
from mpm_warp.errors import SceneError
from mpm_warp.fields.flat import values_of
from mpm_warp.grid.fitted import Grid
from mpm_warp.materials.material import ADHESION_RATIO, PROPERTIES
from mpm_warp.parts.energy import EnergyBalance
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.plan.plan import Plan
from mpm_warp.planning import make_plan
from mpm_warp.scene import Part
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.scenes.bearing.on_ground import CircularFooting
from mpm_warp.scenes.blocks.flying_block import FlyingBlock
from mpm_warp.scenes.blocks.sliding_block import SlidingBlock
from mpm_warp.scenes.catalogue_scene import CatalogueScene
from mpm_warp.scenes.cavity.shapes import CavitySphere
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.elastic.column_wave import ElasticColumnWave
from mpm_warp.scenes.full_flow.limit_load import FullFlowCylinder
from mpm_warp.scenes.run_size import NUMBER_BYTES, law_bytes, shortest_crossing
from mpm_warp.scenes.sounding.sounding import Sounding
from tests.harness.conftest import Command

from .conftest import Record

pytestmark = pytest.mark.slow


def byte_count(plan: Plan) -> int:
    return sum(array.byte_count for array in plan.arrays.values())


@pytest.mark.parametrize(
    ("seconds", "told"),
    [(0.123, "0.12 s"), (17.4, "17 s"), (110.0, "110 s"), (150.0, "2.5 min"), (9e3, "2.5 h")],
)
def test_a_time_is_told_in_a_unit_that_suits_it(seconds: float, told: str) -> None:
    assert resources.spoken_time(seconds) == told


@pytest.mark.parametrize(
    "scene",
    [
        ConePenetration(
            cells_per_radius=100,
            domain_radius=1000,
            domain_above=500,
            domain_below=500,
            cell_growth=0.1,
        ),
        # Of these the arrays take a tenth: what is sampled on the way counts as well.
        SlidingBlock(cells_per_length=400, particles_per_cell=16),
        Sounding(to_depth=9_000.0, profile="depth [m], strength [kPa]; 0, 20; 9500, 20"),
    ],
    ids=lambda scene: scene.catalogue_name(),
)
def test_what_is_too_large_is_refused_before_anything_is_built(scene: CatalogueScene) -> None:
    tracemalloc.start()
    with pytest.raises(TooLarge, match=r"needs about [\d.]+ GB .* but a case may take 2 GB: try"):
        check_memory(scene, 2e9)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50e6
    assert TooLarge.status == "refused"


@pytest.mark.parametrize(
    "scene",
    [
        ConePenetration(),
        ConePenetration(cells_per_radius=6.5, particles_per_cell=9, friction_coefficient=0.3),
        ConePenetration(apex_angle=150, cells_per_radius=3),
        FlyingBlock(cells_per_side=8, travel=20),
        SlidingBlock(cells_per_length=30, particles_per_cell=9),
    ],
    ids=lambda scene: scene.catalogue_name(),
)
def test_arrays_of_a_run_take_less_than_predicted_and_not_far_less(
    scene: CatalogueScene,
) -> None:
    """Set-up takes up to half of it besides."""
    size, plan = scene.run_size(), scene.plan()
    taken = byte_count(plan)
    in_grid = size.byte_count - size.curve_bytes
    assert 0.2 * in_grid < taken < in_grid
    bound = scene.step_count_bound(plan)
    if bound is not None:
        # Both are from the same time step; the bound is a whole number.
        assert size.step_count == pytest.approx(bound, abs=1.0)


@pytest.mark.parametrize("part", [ConservativeInterpolation, EnergyBalance])
def test_a_part_says_what_memory_it_adds(part: type[Part]) -> None:
    scene = ConePenetration(energy_audit="balance", material="von_mises").build()
    grid, plan = scene.grid, make_plan(scene)
    slots = plan.arrays["particle.mass"].shape[0]
    told = part.cell_bytes * grid.cell_count + part.point_bytes * slots
    without = make_plan(scene.without(part))
    # There are more nodes than cells.
    assert told <= byte_count(plan) - byte_count(without) < 1.1 * told


@pytest.mark.parametrize(
    "scene",
    [
        CavitySphere(remoulded_strength_ratio=0.5, ductility=5),
        Sounding(profile="depth [m], strength [kPa]; 0, 20; 10, 40"),
    ],
    ids=["what it remembers", "what varies"],
)
def test_the_law_says_what_memory_a_point_takes(scene: CatalogueScene) -> None:
    built = scene.build()
    arrays = make_plan(built).arrays
    of_law = [name for name in (PROPERTIES, ADHESION_RATIO, "particle.state") if name in arrays]
    slots = arrays["particle.mass"].shape[0]
    taken = sum(arrays[name].byte_count for name in of_law) / slots
    assert 0.0 < taken <= law_bytes(built.material) <= taken + NUMBER_BYTES


@pytest.mark.parametrize("angle", [0.0, 20.0, 90.0, -135.0])
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_the_size_of_a_block_on_a_base_is_that_of_its_grid(angle: float, friction: float) -> None:
    """It slides, or stays where it is. The corners of base and block fill no rectangle."""
    scene = SlidingBlock(cells_per_length=40, grid_angle=angle, friction=friction)
    size, plan, (columns, rows) = scene.run_size(), scene.plan(), scene.build().grid.cell_counts
    assert (columns - 1) * (rows - 1) < size.cell_count < 1.25 * columns * rows
    assert size.particle_count == plan.particle_count
    assert size.step_count == pytest.approx((scene.start + scene.duration) / plan.time_step)


@pytest.mark.parametrize("name", scene_names())
def test_the_size_of_every_scene_is_predicted(name: str) -> None:
    scene = scene_class(name)()
    size, plan = scene.run_size(), scene.plan()
    assert size.particle_count >= plan.particle_count
    # Small runs have little but the numbers that a run has whatever its size.
    few = 50e3
    assert byte_count(plan) < size.byte_count + few


@pytest.mark.parametrize(
    "make",
    [
        lambda: ConePenetration(apex_angle=150, cells_per_radius=3).build().grid,
        lambda: ConePenetration(apex_angle=30, cells_per_radius=2, cell_growth=1.6).build().grid,
        lambda: CavitySphere().grid(),
        lambda: CircularFooting().grid(),
        lambda: FullFlowCylinder(cells_per_radius=5).grid(),
    ],
    ids=["flat cone", "sharp cone", "sphere", "disc", "rays"],
)
def test_the_shortest_crossing_is_that_of_cells_at_the_surface(make: Callable[[], Grid]) -> None:
    grid = make()
    assert shortest_crossing(grid) == pytest.approx(grid.cell_lengths.min(), rel=1e-12)


@pytest.mark.usefixtures("in_this_process")
def test_only_a_case_beyond_the_limit_is_refused(
    stub: Study, tmp_path: Path, command: Command
) -> None:
    settings = ["--set", "number=1", "--set", "points=[1, 3000000]"]
    options = ["--out", tmp_path / "results", "--workers", 2, "--memory-limit", "0.8GB"]
    told = command("run", stub.source, *options, *settings, code=1).err
    assert "points=3000000: refused: needs about " in told
    assert "but a case may take 0.4 GB" in told
    assert "points=1: completed" in told


def test_a_run_refuses_by_the_memory_planned(
    small_file: Path, tmp_path: Path, command: Command
) -> None:
    settings = ["adhesion_factor=0", "adhesion_factor=[0, 1]"]
    told = "".join(command("plan", small_file, "--set", setting).out for setting in settings)
    (taken,) = {float(megabytes) for megabytes in re.findall(r"([\d.]+) MB", told)}
    (case,) = load_study(str(small_file), settings[:1]).cases
    scene = case.built()
    check_memory(scene, (taken + 0.1) * 1e6)
    with pytest.raises(TooLarge):
        check_memory(scene, (taken - 0.1) * 1e6)


@pytest.mark.parametrize(
    "scene",
    [
        SlidingBlock(time_step_fraction=1e-12),
        CircularFooting(speed_ratio=1e-12),
        FullFlowCylinder(speed_ratio=1e-300),
    ],
    ids=lambda scene: type(scene).__name__,
)
def test_more_steps_than_can_be_counted_are_refused_before_the_run(
    scene: CatalogueScene,
) -> None:
    with pytest.raises(SceneError, match=r"^needs .* time steps, where at most 1e\+12 can be"):
        scene.run()
    name, parameters = scene.catalogue_name(), values_of(scene)
    case = Case(scene=name, scene_version=scene.version, parameters=parameters, label=name)
    assert predicted_time(case) == 0.0
    assert compute(case).outcome.status == "refused"


def test_a_long_standing_wave_takes_no_more_than_a_short_one() -> None:
    long = ElasticColumnWave(cell_count=1000, period_count=1_000_000).run_size()
    check_memory(ElasticColumnWave(cell_count=1000, period_count=1_000_000), 0.4e9)
    assert long.curve_bytes == pytest.approx(
        ElasticColumnWave(cell_count=1000, period_count=10).run_size().curve_bytes
    )


def test_a_case_of_days_is_told(
    stub: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = load_study(str(stub.source), ["number=1", "points=1000", "seconds=[1, 1e11, 2e11]"])
    run_study(study, tmp_path, lambda cases, folder, watcher: None, fresh=False)
    (line,) = [it for it in capsys.readouterr().err.splitlines() if "24 hours" in it]
    assert "2 of 3 cases may take longer than 24 hours; seconds=200000000000.0: " in line
    assert "about 116 days on one thread; --case-timeout ends such cases" in line


@pytest.fixture
def mixed(stub: Study) -> Study:
    """Four cases; of those of one length both take as long."""
    return load_study(str(stub.source), ["seconds=[1, 3]", "number=[0, 1]"])


def test_the_costliest_case_is_first_and_one_of_unknown_time_last(
    mixed: Study,
) -> None:
    one, long, two, as_long = mixed.cases
    refused = replace(one, parameters={**one.parameters, "seconds": -1.0})
    ordered = resources.costliest_first([refused, *mixed.cases])
    assert ordered == [long, as_long, one, two, refused]
    # That of one point times its steps, at the speed that is told of everywhere.
    seconds = [predicted_time(case) * resources.UPDATE_RATE for case in (refused, one, long)]
    assert seconds == pytest.approx([0.0, 2.0, 4.0])


@pytest.mark.parametrize(("workers", "first"), [(1, 1), (2, 3)])
def test_several_workers_begin_with_the_costliest_and_one_goes_by_the_study(
    workers: int, first: int, mixed: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[Case] = []

    def note(cases: list[Case], *_: object, **__: object) -> None:
        given.extend(cases)

    monkeypatch.setattr("harness.run.run_study.run_cases", note)
    on_this_machine(mixed, workers)(mixed.cases, tmp_path, Record())
    assert given[0].parameters["seconds"] == first
    assert len(given) == len(mixed.cases)
    assert (given == list(mixed.cases)) == (workers == 1)
