"""Soundings that start with the tip at the surface of the ground."""

import math

import numpy as np
import pytest

from mpm_warp.planning import make_plan
from mpm_warp.sampling import soil_scene
from mpm_warp.scenes.sounding.curves import error_of_samples, layer_values
from mpm_warp.scenes.sounding.sounding import Sounding
from tests.mpm_warp.scenes.sounding.conftest import after_a_step, changed

pytestmark = pytest.mark.slow

PASSED = 3.0 + math.sqrt(3.0) + 1.0
"""Way of the coarse cone, of radius 1, to where a layer of a radius has left the window [m]."""


@pytest.mark.parametrize(
    ("from_depth", "start_depth"), [(0.0, 0.0), (0.3, 0.0), (2.04, -0.06), (10.2, 0.0)]
)
def test_curves_near_the_surface_begin_above_it(from_depth: float, start_depth: float) -> None:
    """By less than a sample; at 3 + 2.5 + 3 + sqrt(3) radii there is room to start in place."""
    sounding = changed(from_depth=from_depth)
    assert sounding.starts_at_surface
    assert sounding.start_depth == pytest.approx(start_depth, abs=1e-9)
    in_place = changed(from_depth=10.24)
    assert not in_place.starts_at_surface
    assert in_place.start_depth == pytest.approx(10.24 - 5.5)


def test_only_the_stretches_near_the_surface_start_there() -> None:
    stretches = [
        changed(from_depth=0.0, to_depth=30.0, stretch_count=3, stretch_number=it, overlap=2.0)
        for it in (1, 2, 3)
    ]
    assert [it.starts_at_surface for it in stretches] == [True, True, False]
    assert [it.lead_count for it in stretches] == [0, 80, 55]


def test_soil_is_below_the_surface_only_and_fills_the_window_in_the_end() -> None:
    near, deep = (make_plan(changed(from_depth=it).build()) for it in (0.0, 12.0))
    cell, height = near.arrays["particle.cell"].initial, near.arrays["particle.position"].initial
    assert height[cell[:, 0] >= 0, 1].max() < 0.0
    # As many slots as the full window has.
    assert len(cell) == deep.arrays["particle.cell"].shape[0]
    for name in ("cell.pic_fraction", "cell.full_mass"):
        assert name in near.arrays
        assert name not in deep.arrays


def test_ground_under_stress_is_at_rest_below_its_surface() -> None:
    """Before the cone touches it. At its surface the side holds as much as there is of a full cell.

    That is told by the mass of the node, within what lumping makes of it: less than a tenth.
    """
    sounding = changed(from_depth=0.04, stress_anisotropy=0.4)
    simulation, speeds, free = after_a_step(sounding.build(), 20e3)
    surface = int(soil_scene(simulation).grid.rows.searchsorted(-1e-9))
    at_side = speeds[surface, -1].copy()
    speeds[surface, -1] = 0.0
    assert speeds.max() < 1e-12 * free
    assert at_side.max() < 0.1 * 0.8 * free


def test_the_load_grows_with_the_square_of_the_depth() -> None:
    """As long as the soil that rises is below the shoulder nothing has a length.

    F / (su d^2) of `cone_self_similar`, smooth, at 12 cells per radius, is 5.1. The surface is
    known to half a cell, 1/12 of a radius, so at the depth d this is known to 2 / 12 / d.
    """
    fine = {"cells_per_radius": 6, "domain_above": 2, "domain_below": 8, "domain_radius": 12}
    result = changed(from_depth=0, to_depth=1.2, adhesion_factor=0, speed_ratio=0.05, **fine).run()
    depth = result.depth.values
    factor = math.pi * result.cone_factor_at_tip.values / depth**2
    for begin, end in ((0.6, 0.9), (0.9, 1.2)):
        mean = factor[(depth > begin) & (depth < end)].mean()
        assert mean == pytest.approx(5.1, rel=2.0 / 12.0 / (0.5 * (begin + end)))


def test_deep_below_the_surface_the_cone_is_that_of_endless_ground() -> None:
    """By means over three radii, to what two stretches of a sounding in such cells differ by."""
    deep = changed(from_depth=20.0, to_depth=23.0).run()
    from_surface = changed(from_depth=0.0, to_depth=23.0).run()
    net = from_surface.net_resistance.values
    assert net[200:].mean() == pytest.approx(float(deep.net_resistance.mean()), rel=0.02)
    # Nearer to the surface the soil heaves, and bears less.
    assert net[:20].mean() < net[30:50].mean() < 0.9 * net[200:].mean()
    assert float(from_surface.contact_share[-30:].min()) > 0.9


def test_near_the_surface_the_error_is_not_known_and_the_reason_is_told() -> None:
    sounding = Sounding(from_depth=0.0)
    radius = sounding.cone_radius
    passed = sounding.surface_passed
    assert passed == pytest.approx((13.0 + math.sqrt(3.0) + 1.0) * radius)
    depth = (np.arange(len(sounding.samples)) + 0.5) * sounding.spacing
    error = error_of_samples(sounding, depth, np.full_like(depth, 350e3))
    before = np.arange(depth.size) * sounding.spacing < passed
    np.testing.assert_array_equal(np.isnan(error.half_width), before)
    np.testing.assert_array_equal(error.correction == 0.0, before)


def test_a_sounding_tells_where_the_surface_leaves() -> None:
    """Through a crust and ground whose strength grows from the surface on."""
    result = changed(
        from_depth=0.0, to_depth=2.0, undrained_shear_strength=5e3, strength_gradient=5e3
    ).run()
    told = str(result.why_no_uncertainty.values)
    surface = f"surface: the surface is in the window to a depth of {PASSED:.4g} m"
    assert told.endswith(f"{surface}: nothing is corrected")
    assert np.isnan(result.last_cone_factor_uncertainty)
    np.testing.assert_allclose(result.strength, 5e3 + 5e3 * result.depth)


def test_a_layer_near_the_surface_has_no_share() -> None:
    """There is no resistance of undisturbed ground to hold it against."""
    near = changed(from_depth=0.0, layer_top=4.0, layer_strength_ratio=2.0)
    assert layer_values(near, near.run(), is_known=True) == {}
