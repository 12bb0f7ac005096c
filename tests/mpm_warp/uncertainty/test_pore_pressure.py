"""What else than the mesh leaves u1, u2 and sleeve friction open, and what is stated of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.uncertainty import shoulder as law
from mpm_warp.uncertainty.laws import interpolated
from mpm_warp.uncertainty.pore_pressure import (
    BOUND_EFFECT,
    BOUND_HALF_WIDTH,
    FACE_NOISE,
    REMAINING_CHANGE,
    SHOULDER_NOISE,
    face_error,
    stated_pressures,
    stated_sleeve,
)
from mpm_warp.uncertainty.shoulder import deviator_near_shaft, shoulder_pressure
from tests.mpm_warp.uncertainty.conftest import radial_error

LAWS = replace(
    ConePenetration(stress_anisotropy=0.2).laws(penetration=30.0),
    cell_size=0.2,
    adhesion_factor=1.0,
    inertia=0.0,
    poissons_ratio=0.47,
    poissons_ratio_reduction=0.02,
)
RIGIDITY_INDEX = """
13 20 23 26 28 30 35 36 40 44 47 51 54 56 64 68 71 76 82 94 96 106 112 128 132 140 163 164 177 215
225 226 264 285 307 367 389 398 406 510 517 604 723 760 768"""
LAST_CHANGE = """
-0.27 -0.04 0.11 -0.20 -0.33 -0.07 -0.48 -0.41 -0.46 0.16 -0.15 0.39 0.45 0.22 0.27 0.50 1.33 2.21
1.95 4.17 3.35 4.12 3.16 3.40 1.56 3.21 2.89 2.97 3.56 1.31 0.93 2.65 2.16 -0.29 2.34 2.81 1.18 2.59
1.42 -0.19 0.16 0.64 -0.43 0.13 -0.88"""
STILL_CAME = """
0.16 0.29 0.79 -0.25 -0.35 -0.24 -0.60 0.14 -0.97 -0.51 -0.17 -0.83 -0.10 0.04 0.21 0.54 -0.67 0.05
1.15 0.12 1.56 1.08 0.47 1.16 -0.15 1.40 1.00 0.50 0.95 1.61 0.59 0.09 0.37 1.29 1.04 0.31 -0.85
0.61 -0.82 0.01 -0.44 -1.76 -0.32 -1.07 -1.31"""
"""Change of the mean of F at the end of a run by default, and what its mean 5 to 14 radii beyond
differs by [%]: 45 random clays, Delta -0.95 to 0.95."""


def test_the_deviator_near_the_shaft_goes_with_the_strength_there() -> None:
    """What else soil that has lost strength changes is left open."""
    at = {"cell_size": 0.35, "adhesion_factor": 0.5, "rigidity_index": 100.0}
    (whole, of_whole), (half, of_half) = (
        radial_error(4.2, **at, strength_ratio=ratio) for ratio in (1.0, 0.5)
    )
    assert half - whole == pytest.approx(-0.5 * deviator_near_shaft(100.0, 0.5))
    assert of_half > of_whole


IN_SOFTENED = (0.3, 5.394 - 4.042 - 0.384, 5.372 - 4.158 - 1.082)
"""Strength of the soil at the shaft over su, and what the filter has more than F on 28 rows (Ir
100, adhesion factor 0.5): remoulded, and where the strength stays."""


def test_what_softened_soil_changes_of_u2_is_within_its_part_of_the_half_width() -> None:
    ratio, softened, whole = IN_SOFTENED
    by_deviator = (ratio - 1.0) * deviator_near_shaft(100.0, 0.5)
    assert abs(softened - whole - by_deviator) <= law.SOFTENING_HALF_WIDTH * (1.0 - ratio)


BY_ANISOTROPY = {
    14: (1.394, {-0.9: 1.532, -0.5: 1.447, 0.5: 1.510, 0.9: 1.558}),
    28: (1.214, {-0.5: 1.276, 0.5: 1.307}),
}
"""B by rows beside the face, where Delta is 0 and by Delta; Ir 100, adhesion factor 0.5."""


def test_the_rise_to_the_filter_goes_with_the_anisotropy() -> None:
    for without, series in BY_ANISOTROPY.values():
        for anisotropy, rise in series.items():
            gained = law.RISE_BY_ANISOTROPY * abs(anisotropy)
            left = law.RISE_BY_ANISOTROPY_HALF_WIDTH * abs(anisotropy)
            assert rise - without == pytest.approx(gained, abs=left)


BY_POISSON = {
    20.0: ((-0.416, -0.373), (-0.179, -0.172)),
    50.0: ((0.101, 0.071),),
    100.0: ((0.493, 0.423), (0.635, 0.610), (0.290, 0.251), (0.595, 0.546), (0.600, 0.524)),
}
"""C where nu is 0.45 and 0.49, on 10 and 14 rows, by rigidity index."""


def test_what_the_filter_has_more_goes_with_poissons_ratio() -> None:
    for index, pairs in BY_POISSON.items():
        at = {"cell_size": 1e-9, "adhesion_factor": 0.5, "rigidity_index": index}
        (known, of_known), (other, of_other) = (
            radial_error(4.2, **at, poissons_ratio=nu) for nu in (0.45, 0.49)
        )
        left = math.sqrt(of_other**2 - of_known**2)
        for before, after in pairs:
            assert after - before == pytest.approx(other - known, abs=left)


RADIAL_BY_POISSON = {
    20.0: ((3.448, 3.515), (3.369, 3.421), (2.988, 3.040)),
    50.0: ((3.939, 3.978), (3.821, 3.896), (3.404, 3.491)),
    100.0: ((4.311, 4.396), (4.100, 4.185), (3.632, 3.729)),
    250.0: ((4.790, 4.879), (4.677, 4.794)),
}
"""F where nu is 0.45 and 0.49, by rigidity index, for the adhesion factors 0, 0.5 and 1: means over
the radii from 6 to 12 after the approach, on 6 rows, i = 0.18."""


def test_what_a_bound_of_poissons_ratio_takes_off_u2_is_corrected() -> None:
    """F and C change at once."""
    for index, pairs in RADIAL_BY_POISSON.items():
        of_rise = float(interpolated(law.POISSON_SLOPE, index))
        for compressible, other in pairs:
            gained = (other - compressible) / 0.04 - of_rise
            assert gained == pytest.approx(BOUND_EFFECT["shoulder"], abs=BOUND_HALF_WIDTH)


def test_how_thick_the_layer_is_leaves_u2_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is no layer, as at Ir 300 beside a smooth shaft, nothing is open."""
    left, half_widths = law.LAYER_SHARE_HALF_WIDTH, []
    for share in (left, 0.0):
        monkeypatch.setattr(law, "LAYER_SHARE_HALF_WIDTH", share)
        errors = (
            radial_error(5.4, cell_size=0.06, adhesion_factor=0.0, rigidity_index=index)
            for index in (100.0, 300.0)
        )
        half_widths.append([float(half_width) for _, half_width in errors])
    (of_layer, without_layer), (of_rest, the_same) = half_widths
    assert without_layer == the_same
    beside, in_layer = law.DEVIATOR_OUTSIDE_LAYER[1][1], law.DEVIATOR_IN_LAYER[1][0]
    assert of_layer == pytest.approx(math.hypot(of_rest, left * (beside - in_layer)))


def test_of_wide_cells_the_half_width_grows_faster() -> None:
    at = {"adhesion_factor": 0.25, "rigidity_index": 100.0}
    narrow, wide, wider = (
        float(radial_error(5.3, cell_size=law.WIDE_CELL + more, **at)[1])
        for more in (-0.1, 0.0, 0.1)
    )
    assert wider**2 - wide**2 > 3.0 * (wide**2 - narrow**2)


def test_beyond_the_range_the_half_width_grows_without_a_jump() -> None:
    for error in (face_error, radial_error):
        indices = np.outer([20.0, 1000.0], [0.25, 0.5, 1.0 - 1e-9, 1.0 + 1e-9, 2.0, 4.0])
        of_cone = {"cell_size": 0.35, "adhesion_factor": 0.0, "inertia": 0.0}
        _, (below, above) = error(6.0, rigidity_index=indices, **of_cone)
        assert below[0] > below[1] > below[2]
        assert above[3] < above[4] < above[5]
        for half_width in (below, above):
            assert half_width[2] == pytest.approx(half_width[3])


IN_SMALL_WINDOWS = (
    (100.0, 0.5, 40.0, (9.163, 4.144), {6.0: (8.683, 4.955), 10.0: (8.960, 3.884)}),
    (100.0, 0.0, 40.0, (8.927, 4.385), {6.0: (8.452, 5.359), 10.0: (8.749, 4.192)}),
    (400.0, 0.3, 80.0, (12.033, 5.211), {6.0: (15.016, 11.264), 10.0: (11.438, 5.391)}),
)
"""u1 and F with the default radius of the window, and with others, by default otherwise."""


def test_a_small_window_is_a_part_of_the_half_widths_of_u1_and_u2() -> None:
    """And a window that is larger than by default is none."""
    for index, adhesion, default, of_default, others in IN_SMALL_WINDOWS:
        of_cone = {
            "cell_size": 0.35,
            "adhesion_factor": adhesion,
            "rigidity_index": index,
            "inertia": 0.09,
        }
        for radius, factors in others.items():
            for error, factor, other in zip(
                (face_error, radial_error), of_default, factors, strict=True
            ):
                _, half_width = error(other, extent_ratio=default / radius, **of_cone)
                assert abs(other - factor) <= half_width
                assert error(other, extent_ratio=0.5, **of_cone) == error(other, **of_cone)


TALLER = {
    50.0: ((0.0, 0.014), (0.0, 0.031), (-0.4, 0.028), (0.4, 0.007)),
    100.0: ((0.0, 0.034), (0.0, 0.037), (-0.4, 0.040), (0.4, 0.023)),
    200.0: ((0.0, 0.017), (0.0, 0.038), (-0.4, 0.050), (0.4, 0.019)),
    400.0: ((0.0, -0.004), (0.0, 0.000), (-0.4, 0.038), (0.4, -0.005)),
}
"""Delta, and what F gains in a window twice as tall, by rigidity index, on 5 rows: means over 12
radii and, but for three, of a second pair of runs; adhesion factor 0.3 and 0.8, and 0.5 where Delta
is not 0."""


def test_what_a_taller_window_adds_to_u2_is_corrected() -> None:
    """A window without a top gains a third more, if what lacks goes with 1 / extent squared."""
    anisotropy, gained = np.concatenate([np.array(them) for them in TALLER.values()]).T
    known = law.TALLER_WINDOW * np.maximum(0.0, 1.0 - 2.0 * anisotropy)
    for whole in (gained, 4.0 / 3.0 * gained):
        assert (np.abs(whole - known) <= law.TALLER_WINDOW_HALF_WIDTH).mean() >= 0.95
    at = {"cell_size": 1e-9, "adhesion_factor": 0.0}
    cases = ((100.0, 0.0, 1.0), (100.0, -0.5, 2.0), (25.0, 0.0, 0.5), (100.0, 0.7, 0.0))
    for index, anisotropy, added in cases:
        soil = {"rigidity_index": index, "stress_anisotropy": anisotropy}
        correction, _ = radial_error(6.0, **at, **soil)
        excess = law.excess_at_filter(adhesion_factor=0.0, **soil)
        assert correction - excess == pytest.approx(added * law.TALLER_WINDOW, abs=1e-6)


def test_in_very_stiff_clay_three_rows_tell_nothing_of_u1() -> None:
    for index, rows, word in ((0.9, 3, ""), (1.1, 3, "mesh"), (1.1, 4, "")):
        stated = stated_of(
            why_none="",
            rigidity_index=index * 500.0,
            cell_size=math.sqrt(3.0) / rows,
        )
        name = "pore_pressure_factor_face"
        assert str(stated[f"{name}_why_no_uncertainty"].values).partition(":")[0] == word
        assert math.isnan(float(stated[f"{name}_uncertainty"].values)) == bool(word)
        assert not str(stated["pore_pressure_factor_shoulder_why_no_uncertainty"].values)


@pytest.mark.parametrize(
    ("is_known", "is_corrected"), [(True, True), (False, True), (False, False)]
)
def test_stated_pressures(is_known: bool, is_corrected: bool) -> None:
    """What is still to come goes with the last change; without U the correction goes on.

    What a bound of Poisson's ratio takes off is another of u1 and u2.
    """
    at = {"cell_size": 0.2, "adhesion_factor": 1.0, "rigidity_index": 100.0, "inertia": 0.1}
    why_none = "" if is_known else "law: of one's own"
    stated = stated_of(why_none=why_none, is_corrected=is_corrected, **at)
    of_soil = {"poissons_ratio": 0.47, "stress_anisotropy": 0.2}
    pressure, of_pressure = shoulder_pressure(4.0, **at, **of_soil)
    errors = face_error(5.0, **at), (pressure - 5.0, of_pressure)
    noise = {"face": FACE_NOISE, "shoulder": 0.013}
    for place, (of_mesh, of_laws) in zip(("face", "shoulder"), errors, strict=True):
        remaining, remaining_spread = REMAINING_CHANGE[place]
        off = of_mesh + 0.02 * BOUND_EFFECT[place] - 0.2 * remaining
        name = f"pore_pressure_factor_{place}"
        value, correction, half_width = (
            float(stated[it].values) for it in (name, f"{name}_correction", f"{name}_uncertainty")
        )
        assert value == pytest.approx(5.0 + (off if is_corrected else 0.0))
        assert correction == pytest.approx(off if is_corrected else 0.0)
        read = {"face": 5.0, "shoulder": 4.0}[place]
        of_mean = math.hypot(remaining_spread * 0.2, read * noise[place])
        expected = math.hypot(of_laws, of_mean, 0.02 * BOUND_HALF_WIDTH) if is_known else math.nan
        assert half_width == pytest.approx(expected, nan_ok=True)
        why = str(stated[f"{name}_why_no_uncertainty"].values)
        assert why == why_none


def stated_of(
    *, why_none: str, is_corrected: bool = True, **of_cone: float
) -> dict[str, xr.Variable]:
    """What is stated of a run whose pressures have fallen from 5.2 to 5 su."""
    curve = ("penetration", np.append(np.full(20, 5.2e4), np.full(20, 5.0e4)))
    recorded = xr.Dataset(
        {f"excess_pore_pressure_{it}": curve for it in ("face", "shoulder")}
        | {f"pore_pressure_factor_{it}": 5.0 for it in ("face", "shoulder")}
        | {law.RADIAL_STRESS: curve, law.RADIAL_FACTOR: 4.0}
    )
    laws = replace(LAWS, **of_cone)
    return stated_pressures(
        recorded,
        laws,
        strength=1e4,
        shaft_adhesion=float(laws.adhesion_factor),
        why_none=why_none,
        is_corrected=is_corrected,
    )


def test_what_still_comes_of_u2_is_known_within_its_half_width() -> None:
    """With 95 %."""
    index, change, came = (
        np.array(them.split(), dtype=float) for them in (RIGIDITY_INDEX, LAST_CHANGE, STILL_CAME)
    )
    known, left = REMAINING_CHANGE["shoulder"]
    noise = 100.0 * interpolated(SHOULDER_NOISE, index)
    assert (np.abs(came - known * change) <= np.hypot(left * change, noise)).mean() >= 0.95


def test_the_sleeve_friction_may_be_as_low_as_beside_remoulded_clay() -> None:
    recorded = xr.Dataset({"sleeve_friction_factor": 0.3})
    stated = stated_sleeve(recorded, remoulded=0.2 * 0.5)
    assert float(stated["sleeve_friction_factor_uncertainty"].values) == pytest.approx(0.2)
