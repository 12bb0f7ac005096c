"""A sounding: its ground, its curves over depth, and the stretches that it is cut into."""

import dataclasses
import math

import numpy as np
import pytest
import xarray as xr

from mpm_warp.errors import ParameterError, SimulationDiverged
from mpm_warp.fields.flat import parameters_of
from mpm_warp.planning import make_plan
from mpm_warp.scenes.sounding.curves import (
    PRESSURE_NOISE,
    change_of_resistance,
    layer_values,
    sounding_curves,
)
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.scenes.sounding.sounding_test import TIME_STEP_FRACTION
from mpm_warp.uncertainty.built import why_not_tresca
from mpm_warp.uncertainty.shoulder import shoulder_pressure
from tests.mpm_warp.conftest import refused
from tests.mpm_warp.scenes.sounding.conftest import changed

pytestmark = pytest.mark.slow

HEAD = "depth [m], strength [kPa]"
LAYERS = f"{HEAD}; 0, 10; 13, 10; 13, 30; 20, 30"


@pytest.fixture(scope="module")
def layered() -> xr.Dataset:
    return changed(profile=LAYERS).run()


def test_a_uniform_profile_is_uniform_clay_in_plan_and_result() -> None:
    by_table = changed(profile=f"{HEAD}; 0, 20; 20, 20", to_depth=12.2)
    plain = changed(to_depth=12.2)
    plans = [make_plan(it.build()) for it in (by_table, plain)]
    assert plans[0].arrays.keys() == plans[1].arrays.keys()
    assert [it.kernel for it in plans[0].step] == [it.kernel for it in plans[1].step]
    of_table, of_plain = by_table.run(), plain.run()
    for name in ("net_resistance", "sleeve_friction", "excess_pore_pressure"):
        np.testing.assert_array_equal(of_table[name], of_plain[name])


def test_the_window_is_that_of_the_greatest_rigidity_index() -> None:
    """Which is not that of the strongest and stiffest soil."""
    soils = "0, 10, 400; 2, 10, 400; 2, 50, 100; 5, 50, 100"
    profile = f"depth [m], strength [kPa], rigidity_index [1]; {soils}"
    sounding = Sounding(profile=profile, from_depth=1.5, to_depth=3.0)
    grid = sounding.build().grid
    assert sounding.domain_below == 20.0
    assert -grid.rows[0] / sounding.cone_radius == pytest.approx(20.0, abs=0.2)
    assert grid.outer_radius / sounding.cone_radius == pytest.approx(80.0, rel=0.1)


def test_the_time_step_of_a_sounding_from_the_surface_is_bounded_as_told() -> None:
    assert Sounding(from_depth=0).build().time_step_fraction == TIME_STEP_FRACTION
    told = parameters_of(Sounding)["time_step_fraction"].meaning
    assert f"from the surface {TIME_STEP_FRACTION:g} at most" in told


def test_curves_stand_at_the_middles_of_their_samples_in_metres(layered: xr.Dataset) -> None:
    np.testing.assert_allclose(layered.depth, 12.0 + 0.1 * (np.arange(30) + 0.5))
    assert layered.depth.attrs["units"] == "m"
    np.testing.assert_array_equal(layered.strength, np.where(layered.depth < 13.0, 10e3, 30e3))
    np.testing.assert_allclose(layered.vertical_stress, 17e3 * layered.depth)
    np.testing.assert_allclose(
        layered.total_resistance - layered.net_resistance, layered.vertical_stress
    )
    np.testing.assert_allclose(
        layered.cone_factor_at_tip, layered.net_resistance / layered.strength
    )


def test_u2_has_its_error_away_from_a_border() -> None:
    """In clay that changes at 13 m; none where the shaft has an adhesion of its own."""
    sounding = Sounding(profile=LAYERS, from_depth=12.7, to_depth=13.4, adhesion_factor=0.5)
    _, half_width = u2_of(dataclasses.replace(sounding, shaft_adhesion_factor=0.2))
    assert half_width.isnull().all()
    pressure, half_width = u2_of(sounding)
    factor, of_laws = shoulder_pressure(
        4.0,
        cell_size=sounding.cell_size / sounding.cone_radius,
        adhesion_factor=0.5,
        rigidity_index=sounding.rigidity_index,
        inertia=sounding.dynamic_pressure / 1e4,
        poissons_ratio=sounding.poissons_ratio,
    )
    assert float(pressure[0]) == pytest.approx(1e4 * float(factor))
    assert float(half_width[0]) == pytest.approx(np.hypot(1e4 * of_laws, 5e4 * PRESSURE_NOISE))
    near = half_width.sel(depth=slice(12.95, 13.1))
    assert near.isnull().all()
    assert np.isfinite(half_width[-1])


def test_u2_is_less_certain_where_the_strength_changes_quickly() -> None:
    """Within 5 cm, which is no border: the shoulder is below, the soil that is read is not."""
    steep = f"{HEAD}; 0, 20; 13, 20; 13.05, 30; 20, 30"
    sounding = Sounding(profile=steep, from_depth=12.7, to_depth=13.4, adhesion_factor=0.5)
    _, half_width = u2_of(sounding)
    assert float(half_width.sel(depth=13.09, method="nearest")) > 5e4 * (1.0 - 22.5 / 30.0)
    assert float(half_width[-1]) < 2e4


def test_u2_is_less_certain_in_a_small_window() -> None:
    """With a radius of 8 instead of 40, 91 % of the samples were out."""
    small, default = (
        u2_of(Sounding(from_depth=2.0, to_depth=2.1, domain_radius=radius))[1] for radius in (8, 40)
    )
    of_window = 20e3 * 0.035 * (5.0**2 - 1.0)
    np.testing.assert_allclose(small, np.hypot(default, of_window), rtol=1e-6)


def u2_of(sounding: Sounding) -> tuple[xr.DataArray, xr.DataArray]:
    """u2 and its half width where 50 kPa are simulated at all depths."""
    count = sounding.lead_count + len(sounding.samples)
    names = ("penetration_resistance", "sleeve_friction", "contact_share")
    simulated = dict.fromkeys((*names, "excess_pore_pressure_shoulder"), 5e4)
    simulated["excess_radial_stress_shaft"] = 4e4
    recorded = xr.Dataset({it: ("penetration", np.full(count, v)) for it, v in simulated.items()})
    found = sounding_curves(sounding, recorded, [])
    return found.excess_pore_pressure, found.excess_pore_pressure_uncertainty


def test_the_resistance_rises_towards_that_of_the_stronger_layer(layered: xr.Dataset) -> None:
    net = layered.net_resistance
    assert 1.5 < float(net[-5:].mean() / net[:5].mean()) < 3.0


def test_stretches_have_the_samples_of_the_whole_and_an_overlap() -> None:
    whole = changed(to_depth=22.0)
    parts = [
        dataclasses.replace(whole, stretch_count=3, stretch_number=number, overlap=2.0)
        for number in (1, 2, 3)
    ]
    assert [it.samples for it in parts] == [range(33), range(13, 66), range(46, 100)]
    assert parts[1].start_depth == pytest.approx(whole.start_depth + 1.3)


def test_two_stretches_agree_where_they_overlap() -> None:
    """By the mean over the overlap, to the noise that samples have in such coarse cells."""
    first, second = (
        changed(
            profile=LAYERS, to_depth=17.0, stretch_count=2, stretch_number=number, overlap=2.0
        ).run()
        for number in (1, 2)
    )
    net_first, net_second = xr.align(first.net_resistance, second.net_resistance, join="inner")
    assert net_first.sizes["depth"] == 20
    assert float(net_first.mean()) == pytest.approx(float(net_second.mean()), rel=0.02)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"to_depth": 12.0}, "to_depth = 12 is not allowed: must be > from_depth = 12"),
        ({"from_depth": -1.0}, "from_depth = -1"),
        ({"from_depth": 2.0, "profile": f"{HEAD}; 1, 1; 19, 1"}, "must be >= 11.23, or"),
        ({"stretch_number": 2}, "stretch_number = 2 is not allowed: must be <= stretch_count = 1"),
        ({"profile": f"{HEAD}; 0, 1; 14, 1"}, "ends at 14 m, must reach to_"),
        ({"layer_top": 13.0, "layer_thickness": 0.1}, "is 0.1 m thick, must be >= a cell, 0.5774"),
        ({"layer_top": 10001.0}, "must be a number > 0 and <= 10000"),
        ({"layer_thickness": 2.0}, "layer_thickness = 2 needs layer_top, the depth"),
        ({"layer_strength_ratio": 0.5}, "layer_strength_ratio = 0.5 needs layer_top, "),
        (
            {"profile": f"{HEAD}; 0, 1; 9, 1; 9, 2; 9.1, 2; 9.1, 1; 19, 1"},
            "the thinnest layer is 0.1 m thick, must be >= a cell, 0.5774 m",
        ),
        (
            {"profile": f"{HEAD}; 0, 1; 19, 1", "rigidity_index": 50.0},
            "rigidity_index = 50 is not allowed: the profile has it by depth; keep one",
        ),
        (
            {"profile": f"{HEAD}, adhesion_factor [1]; 0, 1, 0; 19, 1, 2"},
            "adhesion_factor in row 2 is 2, must be >= 0 and <= 1",
        ),
        (
            {"profile": f"{HEAD}, adhesion_factor [1]; 0, 1, 0; 19, 1, 1"},
            "adhesion_factor = 0.5 is not allowed: the profile has it by depth; keep one",
        ),
        (
            {"profile": f"{HEAD}, stress_anisotropy [1]; 0, 1, 0; 19, 1, 1"},
            "stress_anisotropy in row 2 is 1, must be > -1 and < 1",
        ),
        ({"stretch_count": 31}, "stretch_count = 31 is not allowed: must be <= 30, the samples"),
        (
            {"strength_gradient": 1e9},
            "in the ground that the cone passes: undrained_shear_strength = ",
        ),
    ],
)
def test_what_is_not_allowed_is_told_in_one_line(changes: dict[str, object], message: str) -> None:
    refused(lambda: changed(**changes), ParameterError, message)


def test_the_change_of_the_resistance_is_a_share_of_the_whole_change() -> None:
    """Of a factor of 10 that becomes 40 at fourfold strength; the ends have no mean."""
    factor = np.concatenate([np.full(50, 10.0), np.full(50, 40.0)])
    share = change_of_resistance(factor, 4.0)
    np.testing.assert_allclose(share[[10, 40, 60, 90]], [0.0, 0.0, 1.0, 1.0], atol=1e-12)
    assert np.isnan(share[[0, -1]]).all()


def test_a_border_is_felt_before_and_behind_it() -> None:
    result = changed(from_depth=20.0, to_depth=46.0, layer_top=32.0, layer_strength_ratio=2.0).run()
    assert 0.0 < float(result.felt_before) < 6.0
    assert 0.0 < float(result.felt_behind) < 14.0


def test_a_thin_layer_is_run_for_the_share_that_is_reached() -> None:
    """Thinner than what the cone feels: a part of its resistance, with a half width."""
    result = changed(
        from_depth=16, to_depth=32, layer_top=28, layer_thickness=1, layer_strength_ratio=3
    ).run()
    share = result.layer_share
    assert 0.05 < float(share) < 0.7
    assert share.attrs["role"] == "headline"
    # 0.2 % of noise of the whole resistance, which is 1 + 2 share times that of the soil around.
    whole = 0.002 * (1.0 + 2.0 * float(share)) / 2.0
    # The layer of one radius is known to a cell; its share grows as 1 - exp(-thickness / length).
    lacking = 1.0 - float(share)
    expected = math.hypot(whole, -lacking * math.log(lacking) * changed().cell_size)
    assert float(result.layer_share_uncertainty) == pytest.approx(expected, rel=0.01)
    assert "last_cone_factor" not in result


@pytest.mark.parametrize(("ratio", "speed_ratio"), [(100.0, 0.02), (0.01, 0.2)])
def test_far_within_a_layer_of_another_strength_the_factor_is_that_of_uniform_ground(
    ratio: float, speed_ratio: float
) -> None:
    """At the same inertia. 17 radii from the border 1 % of the factor is lacking, 1 % is noise."""
    result = changed(to_depth=32.0, layer_top=14.0, layer_strength_ratio=ratio).run()
    uniform = changed(to_depth=16.0, speed_ratio=speed_ratio).run()
    within, alone = (float(it.cone_factor_at_tip[-10:].mean()) for it in (result, uniform))
    assert within == pytest.approx(alone, rel=0.02)
    assert abs(float(result.energy_error)) < 0.01


def test_what_ends_before_its_curves_begin_has_none_and_says_why() -> None:
    with pytest.raises(SimulationDiverged, match="velocity of particle") as ended:
        changed(adhesion_factor=0.0, speed_ratio=0.05, time_step_fraction=1.2).run()
    assert ended.value.curves is None


def through_layer(
    begin: float, end: float, *, without_end: bool = False
) -> tuple[Sounding, xr.Dataset]:
    """A sounding through a layer of twice the strength from 30 to 32 m, and curves of it."""
    depth = np.arange(begin, end, 0.1)
    recorded = xr.Dataset(coords={"depth": depth}).assign(
        net_resistance=("depth", np.where(abs(depth - 31.0) < 1.0, 300e3, 200e3))
    )
    thickness = None if without_end else 2.0
    through = changed(
        from_depth=begin,
        to_depth=end,
        layer_top=30.0,
        layer_thickness=thickness,
        layer_strength_ratio=2.0,
    )
    return through, recorded


def test_the_share_of_a_layer_that_softens_has_no_half_width() -> None:
    through, recorded = through_layer(16.0, 34.0)
    soft = dataclasses.replace(through, remoulded_strength_ratio=0.2, ductility=10.0)
    known, unknown = (
        layer_values(it, recorded, is_known=not why_not_tresca(it.build().material))
        for it in (through, soft)
    )
    assert np.isfinite(known["layer_share_uncertainty"])
    assert np.isnan(unknown["layer_share_uncertainty"])
    assert unknown["layer_share"] == known["layer_share"]


@pytest.mark.parametrize(
    ("begin", "end", "without_end"),
    [(19.0, 34.0, False), (36.0, 40.0, False), (16.0, 33.0, False), (19.0, 40.0, True)],
    ids=["felt at the begin", "above the begin", "not passed", "border felt at the begin"],
)
def test_nothing_is_said_of_a_layer_that_the_curves_do_not_tell(
    begin: float, end: float, without_end: bool
) -> None:
    """One without end that is felt at the begin had 0.3 of its change, one above it minus infinity.

    Their resistance without the layer is not that of undisturbed ground.
    """
    assert layer_values(*through_layer(begin, end, without_end=without_end), is_known=True) == {}
