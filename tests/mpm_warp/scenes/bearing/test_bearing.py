"""Limit loads at the surface of the ground against exact ones."""

import dataclasses
import math

import numpy as np
import pytest

from mpm_warp import (
    CircularFooting,
    ConeBearing,
    SimulationDiverged,
    StripFooting,
    UnfinishedRun,
)
from mpm_warp.planning import make_plan
from mpm_warp.scenes.bearing.bearing import RADIUS, STRENGTH
from mpm_warp.scenes.bearing.on_ground import Footing
from tests.mpm_warp.scenes.conftest import order_and_errors

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("apex_angle", "adhesion_factor"),
    [(60.0, 0.0), (60.0, 0.5), (60.0, 1.0), (30.0, 0.0), (90.0, 1.0), (120.0, 0.75)],
)
def test_cone_at_the_surface(apex_angle: float, adhesion_factor: float) -> None:
    given = {"apex_angle": apex_angle, "adhesion_factor": adhesion_factor}
    order, _, error = order_and_errors(ConeBearing, "cells_per_radius", 2, **given)
    assert order >= 1
    # Where the rim is, is known to half a cell, and those at the rim are a quarter as wide.
    assert error <= (1 + 1 / 32) ** 2 - 1


def test_a_body_that_leaves_its_cells_is_told_with_what_to_change() -> None:
    """Before it runs, and where it ends: by parameters that the scene has."""
    soft = CircularFooting(rigidity_index=100.0)
    told = "the body moves by 2.4 cells, and soil leaves those beside it; try rigidity_index = 240"
    assert soft.likely_failure.startswith(told)
    for sound in ({"rigidity_index": 240.0}, {"displacement": 12.5}):
        assert dataclasses.replace(soft, **sound).likely_failure == ""
    # Cells at the rim of a cone are a quarter as wide.
    assert ConeBearing(rigidity_index=959.0).likely_failure
    assert ConeBearing(rigidity_index=960.0).likely_failure == ""
    with pytest.raises(SimulationDiverged) as end:
        soft.run()
    parameters = "cells_per_radius or rigidity_index or displacement or speed_ratio"
    assert str(end.value).endswith(f"; try another {parameters}")


def test_a_blunt_face_has_as_many_nodes_as_the_soil_beside_it() -> None:
    """Nodes of the face are no farther from each other, along the radius, than columns there."""
    for apex_angle in (30.0, 60.0, 90.0, 120.0, 150.0):
        grid = ConeBearing(apex_angle=apex_angle).grid()
        at_rim = np.diff(grid.surface_radius)[-1]
        assert at_rim <= np.diff(grid.columns)[0] * (grid.fitted_radius - RADIUS) * (1 + 1e-9)
        assert grid.rows[-1] == ConeBearing(apex_angle=apex_angle).surface_height
        assert 0.0 in grid.rows


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
@pytest.mark.parametrize("footing", [CircularFooting, StripFooting])
def test_footing(footing: type[Footing], adhesion_factor: float) -> None:
    order, _, error = order_and_errors(
        footing, "cells_per_radius", 4, adhesion_factor=adhesion_factor
    )
    assert order == pytest.approx(1, abs=0.25)
    assert error <= (1 + 1 / 16) ** 2 - 1


@pytest.mark.parametrize(
    ("scene", "cells", "at_rim"),
    [(ConeBearing, 4, 16), (CircularFooting, 12, 12), (StripFooting, 12, 12)],
)
def test_strength_that_grows_with_depth(
    scene: type[Footing | ConeBearing], cells: int, at_rim: int
) -> None:
    """The rim is known to half a cell: a body so much wider bears, by its own exact load, more."""
    exact, wider = (
        scene(strength_gradient_ratio=kappa).exact[0] for kappa in (1.0, 1.0 + 0.5 / at_rim)
    )
    result = scene(cells_per_radius=cells, strength_gradient_ratio=1.0).run()
    assert "slip lines" in result.bearing_capacity_exact.attrs["description"]
    assert float(result.error) <= (1 + 0.5 / at_rim) ** 2 * wider / exact - 1
    # Without the gradient the load would be far below.
    assert float(result.bearing_capacity) > exact > 1.15 * scene().exact[0]


def test_adhesion_is_that_of_the_soil_beside_it() -> None:
    """Its integral over the face, exact: su0 (1 + kappa / 3 cot(30 degrees)) pi R^2 / sin(30)."""
    kappa = 2.0
    scene = ConeBearing(cells_per_radius=4, adhesion_factor=0.5, strength_gradient_ratio=kappa)
    adhesion = make_plan(scene.build()).arrays["contact.adhesion"].initial
    mean_strength = STRENGTH * (1.0 + kappa / 3.0 * math.sqrt(3.0))
    assert adhesion.sum() == pytest.approx(0.5 * mean_strength * 0.5 * RADIUS**2 / 0.5)
    assert ConeBearing().soil.variation is None


def test_a_load_that_still_rises_has_no_limit() -> None:
    with pytest.raises(UnfinishedRun, match="displacement = 3; try more displacement") as end:
        ConeBearing(cells_per_radius=4, displacement=3).run()
    assert end.value.status == "unfinished"
    assert np.isnan(end.value.curves["bearing_capacity"])
    assert np.isnan(end.value.curves["error"])


def test_where_soil_is_stuck_below_a_rough_body_no_load_is_known_but_computed() -> None:
    assert CircularFooting(adhesion_factor=1.0, strength_gradient_ratio=1.0).exact is None
    result = ConeBearing(cells_per_radius=1, apex_angle=150.0, adhesion_factor=1.0).run()
    assert float(result.bearing_capacity) > 5.0
    assert result.bearing_capacity.attrs["role"] == "headline"
    assert "error" not in result
    assert "bearing_capacity_exact" not in result


@pytest.mark.parametrize("displacement", [1e-3, 0.1])
def test_a_footing_of_few_steps_has_a_sample_a_step_and_no_plateau(displacement: float) -> None:
    with pytest.raises(UnfinishedRun) as end:
        CircularFooting(cells_per_radius=4, displacement=displacement).run()
    result = end.value.curves
    assert result.sizes["displacement"] == int(result.step_count)
    assert np.isfinite(result.resistance).all()
    assert math.isnan(float(result.bearing_capacity))
