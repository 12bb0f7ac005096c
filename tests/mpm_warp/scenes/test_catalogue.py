"""The catalogue: which scenes there are, what each gives, and what is left where one diverges."""

import dataclasses
import pickle
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest
import xarray as xr

from mpm_warp.errors import InaccurateRun, SceneError, SimulationDiverged, UnknownSceneError
from mpm_warp.fields.declaration import Value, parameter
from mpm_warp.fields.flat import flat_values, parameters_of
from mpm_warp.results import ROLES, SHARED_NAMES, variable
from mpm_warp.scenes import (
    CatalogueScene,
    Progress,
    catalogue,
    catalogue_scene,
    scene_class,
    scene_names,
)
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.elastic.columns import GravityColumn
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import SMALL_WINDOW

pytestmark = pytest.mark.slow

SMALL: dict[str, dict[str, Value]] = {
    "ball_penetration": {"cells_per_radius": 2, "domain_extent": 4, "penetration": 6.0},
    "cavity_cylinder": {"expansion": 1.1, "cells_per_radius": 1, "rigidity_index": 10.0},
    "cavity_sphere": {"expansion": 1.1, "cells_per_radius": 2, "rigidity_index": 10.0},
    "circular_footing": {"cells_per_radius": 2},
    "cone_bearing": {"cells_per_radius": 4},
    "cone_penetration": {
        "cells_per_radius": 1.0,
        "penetration": 1.0,
        "domain_radius": 8.0,
        "steady_tolerance": 0.0,
    },
    "cone_self_similar": {"cells_per_radius": 4},
    "cyclic_ball": {"cells_per_radius": 2, "domain_extent": 4, "stroke": 6.0, "cycle_count": 1},
    "cyclic_t_bar": {"cells_per_radius": 2, "domain_extent": 4, "stroke": 6.0, "cycle_count": 1},
    "elastic_column_wave": {"cell_count": 4, "period_count": 2},
    "element_test": {"step_count": 10},
    "flying_block": {"step_count": 100, "travel": 1.0},
    "full_flow_cylinder": {"cells_per_radius": 2},
    "full_flow_sphere": {"cells_per_radius": 2},
    "gravity_column": {"cell_count": 2},
    "material_point": {"step_count": 10},
    "sliding_block": {"cells_per_length": 6, "height_ratio": 0.5},
    "sounding": {
        "from_depth": 0.4,
        "to_depth": 0.402,
        "cells_per_radius": 1.0,
        "speed_ratio": 0.1,
        **SMALL_WINDOW,
    },
    "step_cost": {"size": 500, "samples": 1, "sample_time": 1e-3},
    "stretched_bar": {"stretch": 1.1},
    "strip_footing": {"cells_per_radius": 2},
    "struck_bar": {"cell_count": 20},
    "struck_column": {"cell_count": 20},
    "t_bar_penetration": {"cells_per_radius": 2, "domain_extent": 4, "penetration": 6.0},
    "thick_cylinder": {"cell_count": 2},
}
"""Parameters that make a run of each scene as short as can be."""


def test_every_scene_is_in_the_catalogue_and_those_they_are_made_of_are_not() -> None:
    assert scene_names() == tuple(sorted(SMALL))
    for name in scene_names():
        assert scene_class(name).catalogue_name() == name


@pytest.fixture
def unjudged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs so coarse that some are inaccurate, which matters to none of these tests."""
    monkeypatch.setattr(catalogue_scene, "check_limits", lambda limits, results: None)


@pytest.mark.parametrize("name", sorted(SMALL))
@pytest.mark.usefixtures("unjudged")
def test_a_result_holds_all_that_is_needed_to_read_it(name: str) -> None:
    """Units, names, roles, one headline, and every parameter with its value, derived or given.

    Every error and every balance has a limit, or the scene says why it has none.
    """
    scene = scene_class(name)(**SMALL[name])
    told: list[float] = []
    result = scene.run(told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
    headlines = [it for it, values in result.variables.items() if _role(values) == "headline"]
    assert len(headlines) == 1
    assert result[headlines[0]].ndim == 0
    assert scene.comparable in (None, *headlines)
    for label, values in result.variables.items():
        if values.dtype.kind != "U":
            assert values.attrs["units"], label
            assert values.attrs["long_name"], label
        else:
            assert "units" not in values.attrs, label
        assert _role(values) in {None, *ROLES}
        if _role(values) == "exact":
            assert result[values.attrs["exact_of"]].dims == values.dims
    shared = {key for key in parameters_of(type(scene)) if f"{key}_parameter" in result}
    assert shared == {key for key in parameters_of(type(scene)) if key in SHARED_NAMES}
    for key, (_, given) in flat_values(scene).items():
        stored = result[f"{key}_parameter" if _role(result[key]) != "parameter" else key]
        assert _role(stored.variable) == "parameter"
        assert stored.attrs["description"]
        if given is None:
            assert stored.item() == "" or np.isnan(stored)
        else:
            assert stored.item() == given

    judged = {str(label) for label, values in result.variables.items() if _role(values) == "error"}
    judged |= {"error", "energy_error", "energy_residual"} & set(result)
    judged |= {bound for check in scene.verifications for bound in check.bounds}
    assert judged <= set(scene.limits)
    for label, limit in scene.limits.items():
        if isinstance(limit, str):
            assert limit
        elif label in result:
            assert result[label].attrs["limit"] == limit.size


BEYOND: list[tuple[str, dict[str, Value], str]] = [
    ("thick_cylinder", {"cell_count": 2, "radius_ratio": 100.0}, "stresses and wall displacement"),
    ("cavity_sphere", {"cells_per_radius": 1, "particles_per_cell": 1}, "the cavity pressure"),
    ("circular_footing", {"cells_per_radius": 2}, "the limit load"),
    ("material_point", {"step_count": 10}, "stress"),
]


@pytest.mark.parametrize(("name", "coarse", "what"), BEYOND)
def test_a_run_with_a_large_error_is_inaccurate_and_keeps_its_numbers(
    name: str, coarse: dict[str, Value], what: str
) -> None:
    with pytest.raises(
        InaccurateRun, match=f"the error of {what} is .*, more than 0.15: try"
    ) as end:
        scene_class(name)(**coarse).run()
    assert float(end.value.curves["error"]) > 0.15


@pytest.mark.parametrize(
    ("name", "limited"),
    [(name, it) for name in sorted(SMALL) for it in scene_class(name).limits],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_beyond_each_limit_a_run_is_inaccurate(name: str, limited: str, sign: float) -> None:
    scene = scene_class(name)(**SMALL[name])
    limit = scene.limits[limited]

    def results(value: float) -> xr.Dataset:
        return xr.Dataset({limited: variable(value, meaning="value")})

    if isinstance(limit, str):
        scene.checked(results(1.0))
        return
    assert scene.checked(results(sign * limit.size))[limited].attrs["limit"] == limit.size
    for beyond in (1.01 * sign * limit.size, np.nan):
        with pytest.raises(InaccurateRun, match=f"more than {limit.size:g}: try {limit.remedy}$"):
            scene.checked(results(beyond))


def _role(values: xr.Variable | xr.DataArray) -> str | None:
    return values.attrs.get("role")


@pytest.mark.parametrize("penetration", [6.0, 30.0])
def test_a_bar_ends_at_all_of_it_also_where_the_run_ends_early(
    penetration: float, short_test: ConePenetration, capsys: pytest.CaptureFixture[str]
) -> None:
    test = dataclasses.replace(
        short_test, penetration=penetration, approach=0.0, steady_tolerance=0.1
    )
    result = test.run(progress=True)
    assert float(result.penetration_reached) <= 6.5
    shown = capsys.readouterr().err
    assert shown.rstrip().split("\r")[-1].startswith("cone_penetration 100 %")
    assert "Warp" not in shown


def test_without_a_bar_none_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hidden one too has a semaphore; a worker that is ended leaves it, which Python tells of."""
    monkeypatch.setattr("tqdm.auto.tqdm", None)
    for progress in (None, False):
        assert "error" in GravityColumn(cell_count=2).run(progress=progress)


@dataclass(frozen=True, kw_only=True)
class HalfColumn(CatalogueScene):
    """A column that is not in this package."""

    summary: ClassVar[str] = "column of cells, half of them"
    version: ClassVar[int] = 1

    cell_count: int = parameter(8, unit="1", meaning="cells", minimum=4)

    def build(self) -> object:
        return GravityColumn(cell_count=self.cell_count // 2).build()

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        simulation.advance(3)
        steps = variable(simulation.step_count, unit="1", meaning="steps", role="headline")
        return xr.Dataset({"steps": steps})


@pytest.fixture
def offer(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Entry points, as if packages that offer them were installed."""

    def offered(**values: str) -> None:
        points = [EntryPoint(name, value, catalogue.GROUP) for name, value in values.items()]
        monkeypatch.setattr(catalogue, "entry_points", lambda group: points)
        monkeypatch.setattr(catalogue, "_all_scenes", catalogue._all_scenes.__wrapped__)
        monkeypatch.setattr("mpm_warp.HalfColumn", HalfColumn, raising=False)

    return offered


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_can_be_sent_to_another_process(name: str) -> None:
    scene = scene_class(name)()
    sent = pickle.loads(pickle.dumps(scene))
    assert (sent, type(sent)) == (scene, type(scene))


def test_a_scene_of_another_package_is_found_and_run(offer: Callable[..., None]) -> None:
    offer(half_column="mpm_warp:HalfColumn")
    assert "half_column" in scene_names()
    scene = scene_class("half_column")
    assert scene is HalfColumn
    result = scene(cell_count=6).run()
    assert int(result.steps) == 3
    assert int(result.cell_count) == 6


def test_an_entry_point_may_be_of_another_class(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a worker of Python 3.11 that has imported Dask, and importlib_metadata with it."""
    point = SimpleNamespace(name="half_column", value="a:b", dist=None, load=lambda: HalfColumn)
    everything = {**catalogue._all_scenes(), "half_column": point}
    monkeypatch.setattr(catalogue, "_all_scenes", lambda: everything)
    assert scene_class("half_column") is HalfColumn


def test_a_package_that_ends_the_process_as_it_is_imported_does_not_end_ours(
    offer: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "that_exits.py").write_text("raise SystemExit(7)")
    monkeypatch.syspath_prepend(str(tmp_path))
    offer(lost="that_exits:Scene")
    with pytest.raises(UnknownSceneError, match="cannot be loaded: SystemExit: 7"):
        scene_class("lost")


def test_packages_are_asked_for_scenes_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """That opens a file of each installed package; a command asks for names a thousand times."""
    scene_names()
    monkeypatch.setattr(catalogue, "entry_points", lambda group: pytest.fail("asked again"))
    scene_names()
    assert scene_class("gravity_column") is GravityColumn


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("lost", "no_such_package:Scene", "cannot be loaded: ModuleNotFoundError: No module named"),
        ("lost", "mpm_warp:Nothing", "cannot be loaded: AttributeError"),
        (
            "lost",
            "mpm_warp.fields.declaration:Parameter",
            "is not a CatalogueScene without abstract",
        ),
        ("lost", "mpm_warp.scenes.bearing.bearing:Bearing", "is not a CatalogueScene without"),
    ],
)
def test_a_broken_entry_point_is_named_in_one_line(
    name: str, value: str, said: str, offer: Callable[..., None]
) -> None:
    offer(**{name: value})
    with pytest.raises(UnknownSceneError) as refusal:
        scene_class(name)
    message = str(refusal.value)
    assert message.startswith(f"scene {name!r}: the entry point {value!r} of an unknown package ")
    assert said in message
    assert "\n" not in message
    assert scene_class("gravity_column") is GravityColumn


def test_two_scenes_of_one_name_are_refused(offer: Callable[..., None]) -> None:
    offer(gravity_column="mpm_warp:HalfColumn")
    with pytest.raises(UnknownSceneError) as refusal:
        scene_names()
    assert str(refusal.value) == (
        "two scenes are called 'gravity_column': mpm_warp.scenes.elastic.columns."
        "GravityColumn and the entry point 'mpm_warp:HalfColumn' of an unknown package; rename one "
        "of them"
    )


@pytest.mark.parametrize(
    ("recorded", "told"),
    [
        ({"time": [0.1, 0.2, 0.2]}, "time = 0.2 was recorded 2 times: take fewer samples"),
        ({"time": [np.nan, np.nan]}, "time = nan was recorded 2 times"),
        ({}, "time: is a dimension without a variable that gives its places"),
    ],
)
def test_a_place_that_is_recorded_twice_is_refused_by_its_name(
    recorded: dict[str, list[float]], told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    curve = xr.Dataset(
        {"settlement": ("time", np.zeros(len(recorded.get("time", [1.0]))))}, recorded
    )
    monkeypatch.setattr(GravityColumn, "compute", lambda *_: curve)
    with pytest.raises(SceneError, match=re.escape(told)):
        GravityColumn().run()


@pytest.mark.parametrize("dims", [(), ("status",)])
def test_a_result_has_no_name_that_a_study_gives(
    dims: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    named = xr.Dataset({"status": (dims, np.zeros(len(dims) * (2,)))})
    monkeypatch.setattr(GravityColumn, "compute", lambda *_: named)
    with pytest.raises(SceneError, match="status: studies have this name already"):
        GravityColumn().run()


def test_a_scene_that_records_nothing_says_so() -> None:
    @dataclasses.dataclass(frozen=True, kw_only=True)
    class Silent(CatalogueScene):
        def build(self) -> object:
            return GravityColumn(cell_count=2).build()

    with pytest.raises(TypeError, match=r"Silent.* abstract method '?record"):
        Silent()  # type: ignore[abstract]


KEPT = 7
"""Samples before the run diverges."""
RECORDING: list[tuple[str, dict[str, Any], str]] = [
    ("cavity_cylinder", {"cells_per_radius": 2, "rigidity_index": 10.0}, "expansion"),
    ("cone_bearing", {"cells_per_radius": 4}, "displacement"),
    (
        "cone_penetration",
        {"cells_per_radius": 1.0, "penetration": 3.0, "steady_tolerance": 0.0},
        "penetration",
    ),
    ("cone_self_similar", {"cells_per_radius": 5}, "depth"),
    ("elastic_column_wave", {"cell_count": 10, "excitation": "standing_wave"}, "phase"),
    ("elastic_column_wave", {"cell_count": 10, "excitation": "sudden_load"}, "phase"),
    ("flying_block", {"step_count": 2000, "travel": 1.0}, "progress"),
    ("sliding_block", {"cells_per_length": 10}, "progress"),
    ("stretched_bar", {"stretch": 1.5}, "progress"),
]


@pytest.mark.parametrize(("name", "parameters", "axis"), RECORDING)
@pytest.mark.usefixtures("unjudged")
def test_curves_up_to_the_failure_are_those_of_the_whole_run(
    name: str, parameters: dict[str, Any], axis: str
) -> None:
    scene = scene_class(name)(**parameters)
    whole = scene.run()
    samples: list[float] = []

    def diverge(fraction: float) -> None:
        if fraction > 0.0:
            samples.append(fraction)
        if len(samples) == KEPT:
            raise SimulationDiverged("on purpose")

    with pytest.raises(SimulationDiverged) as end:
        scene.run(diverge)
    kept_curves = end.value.curves
    assert kept_curves.sizes[axis] == KEPT
    curves = [str(curve) for curve, values in whole.items() if values.dims == (axis,)]
    kept = [curve for curve in curves if curve in kept_curves]
    assert kept
    assert set(kept) == set(kept_curves.data_vars)
    for curve in kept:
        np.testing.assert_array_equal(kept_curves[curve], whole[curve][:KEPT])
        assert kept_curves[curve].attrs == whole[curve].attrs
    xr.testing.assert_identical(kept_curves[axis].variable, whole[axis][:KEPT].variable)
