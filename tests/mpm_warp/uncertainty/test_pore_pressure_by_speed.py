"""What the speed of a cone changes of u1 and u2: readings at several speeds beside the laws."""

import math

import numpy as np
import pytest

from mpm_warp.uncertainty import shoulder as law
from mpm_warp.uncertainty.laws import interpolated
from mpm_warp.uncertainty.pore_pressure import FACE_NOISE, face_error
from tests.mpm_warp.uncertainty.conftest import NOTHING_LEFT, radial_error

EXCESS_BY_SPEED = {
    (20.0, 0.0): [(0.932 - 1.229, 0.951 - 1.211), (0.921 - 1.189, 0.915 - 1.179)],
    (20.0, 0.5): [(0.791 - 1.145, 0.868 - 1.177), (0.881 - 1.157, 0.870 - 1.158)],
    (20.0, 1.0): [(0.925 - 0.614, 0.958 - 0.641), (1.014 - 0.603, 0.997 - 0.603)],
    (50.0, 0.5): [(1.091 - 1.101, 1.172 - 1.166), (1.093 - 1.137, 1.103 - 1.118)],
    (100.0, 0.0): [(1.340 - 1.135, 1.379 - 1.044), (1.317 - 0.783, 1.392 - 0.735)],
    (100.0, 0.25): [(1.298 - 1.182, 1.279 - 1.201)],
    (100.0, 0.5): [(1.214 - 1.082, 1.205 - 1.140), (1.120 - 1.064, 1.160 - 1.026)],
    (100.0, 1.0): [(1.252 - 0.635, 1.197 - 0.623), (1.141 - 0.536, 1.174 - 0.542)],
    (300.0, 0.0): [(1.700 + 0.162, 1.767 + 0.212)],
    (300.0, 0.5): [(1.479 - 0.471, 1.498 - 0.391)],
    (300.0, 1.0): [(1.481 - 0.680, 1.423 - 0.749)],
}
"""C where i is 0.36 and 0.05, by rigidity index and adhesion factor, on 28 rows, 14 at Ir 300, and
on narrow columns of 56 rows."""


def test_what_the_filter_has_more_goes_with_the_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    for (index, adhesion), meshes in EXCESS_BY_SPEED.items():
        at = {"rigidity_index": index, "adhesion_factor": adhesion}
        _, whole = radial_error(4.2, cell_size=0.35, **at)
        with monkeypatch.context() as without:
            without.setattr(law, "SLOW_GAIN_HALF_WIDTH", NOTHING_LEFT)
            _, rest = radial_error(4.2, cell_size=0.35, **at)
        gained = law.interpolated_table(
            law.SLOW_GAIN, law.SLOW_GAIN_INDICES, law.RISE_ADHESION_FACTORS, *at.values()
        )
        left = math.sqrt(whole**2 - rest**2)
        for fast, slow in meshes:
            assert slow - fast == pytest.approx(gained, abs=left)


INERTIA_OF_U1 = (
    (22.0, {0.1: 6.081, 0.3: 6.059, 0.6: 6.075, 1.2: 6.150, 2.4: 6.258}),
    (100.0, {0.1: 9.214, 0.3: 9.337, 0.6: 9.417, 1.2: 9.675, 2.4: 10.156}),
    (140.0, {0.1: 9.925, 0.3: 10.067, 0.6: 10.181, 1.2: 10.424, 2.4: 10.931}),
    (500.0, {0.1: 12.559, 0.3: 12.600, 0.6: 12.603, 1.2: 12.762, 2.4: 12.938}),
    (900.0, {0.1: 13.760, 0.3: 13.757, 0.6: 13.836, 1.2: 13.959, 2.4: 14.210}),
    (50.0, {0.1: 7.262, 0.4: 7.368, 1.0: 7.640, 2.4: 8.003}),
    (100.0, {0.1: 8.918, 0.4: 9.113, 1.0: 9.342, 2.4: 9.982}),
    (200.0, {0.1: 10.470, 0.4: 10.671, 1.0: 10.946, 2.4: 11.600}),
    (500.0, {0.1: 12.347, 0.4: 12.544, 1.0: 12.855, 2.4: 13.551}),
    (500.0, {0.1: 12.380, 0.4: 12.240, 1.0: 12.154, 2.4: 11.948}),
    (1000.0, {0.1: 13.797, 0.4: 13.998, 1.0: 14.281, 2.4: 15.057}),
    (1000.0, {0.1: 13.833, 0.4: 13.714, 1.0: 13.587, 2.4: 13.335}),
)
"""u1 over i: by default but for the speed (adhesion factor 0.8, 0.4, 0.35, 0.5, 0.35), then smooth
cones on 5.2 rows beside the face, at Ir 500 and 1000 on 7 too."""


INERTIA_OF_U2: dict[float, tuple[dict[float, float], ...]] = {
    20.0: (
        {0.0225: 3.437, 0.09: 3.427, 0.36: 3.414},
        {0.0225: 3.355, 0.09: 3.352, 0.36: 3.336},
        {0.0225: 2.921, 0.09: 2.985, 0.36: 2.961},
    ),
    50.0: (
        {0.0225: 3.924, 0.09: 3.950, 0.36: 4.013},
        {0.0225: 3.818, 0.09: 3.840, 0.36: 3.845},
        {0.0225: 3.328, 0.09: 3.381, 0.36: 3.408},
    ),
    100.0: (
        {0.0225: 4.304, 0.09: 4.349, 0.18: 4.344, 0.36: 4.314},
        {0.0225: 4.029, 0.09: 4.085, 0.18: 4.090, 0.36: 4.157},
        {0.0225: 3.615, 0.09: 3.682, 0.18: 3.714, 0.36: 3.731},
    ),
    200.0: (
        {0.0225: 4.742, 0.09: 4.724, 0.18: 4.749, 0.36: 4.725},
        {0.0225: 4.588, 0.09: 4.592, 0.18: 4.589, 0.36: 4.503},
        {0.0225: 3.855, 0.09: 3.943, 0.18: 4.015, 0.36: 4.046},
    ),
    300.0: (
        {0.0225: 4.994, 0.09: 4.958, 0.18: 4.983, 0.36: 4.973},
        {0.0225: 4.899, 0.09: 4.881, 0.18: 4.897, 0.36: 4.866},
        {0.0225: 4.345, 0.09: 4.357, 0.18: 4.255, 0.36: 4.153},
    ),
    450.0: (
        {0.0225: 5.382, 0.09: 5.356, 0.36: 5.315},
        {0.0225: 5.217, 0.09: 5.213, 0.36: 5.190},
        {0.0225: 4.914, 0.09: 4.908, 0.36: 4.738},
    ),
}
"""F over i, by rigidity index, for the adhesion factors 0, 0.5 and 1: means over the radii from 6
to 12 or 14 after the approach, on 5 rows beside the face, 6 up to Ir 50."""


def test_what_inertia_changes_of_u1_is_within_its_half_width() -> None:
    """From the slowest run on, beside the noise of both means alone."""
    for index, factors in INERTIA_OF_U1:
        inertia, factor = np.array(list(factors)), np.array(list(factors.values()))
        of_cone = {"adhesion_factor": 0.5, "rigidity_index": index}
        _, known = face_error(0.0, cell_size=0.0, inertia=inertia - inertia[0], **of_cone)
        noise = FACE_NOISE * np.hypot(factor, factor[0])
        assert (np.abs(factor - factor[0]) <= known + noise).all()


INERTIA_OF_U2_BESIDE_ROUGH_SHAFTS = (
    (150.0, 1.0, 5, {0.0225: 3.719, 0.045: 3.756, 0.09: 3.812, 0.18: 3.852, 0.36: 3.880}),
    (150.0, 1.0, 7, {0.0225: 3.677, 0.09: 3.721, 0.36: 3.812}),
    (200.0, 0.75, 5, {0.0225: 4.229, 0.09: 4.236, 0.36: 4.180}),
    (200.0, 1.0, 5, {0.0225: 3.816, 0.045: 3.856, 0.09: 3.891, 0.18: 3.958, 0.36: 3.984}),
    (200.0, 1.0, 7, {0.0225: 3.850, 0.09: 3.855, 0.36: 3.942}),
    (200.0, 1.0, 10, {0.045: 3.872, 0.36: 3.930}),
    (250.0, 1.0, 5, {0.0225: 4.046, 0.045: 4.043, 0.09: 4.075, 0.18: 4.051, 0.36: 4.036}),
    (250.0, 1.0, 7, {0.0225: 4.005, 0.09: 3.979, 0.36: 4.017}),
    (300.0, 0.75, 5, {0.0225: 4.690, 0.09: 4.702, 0.36: 4.567}),
    (250.0, 0.75, 4, {0.05: 4.597, 0.23: 4.515}),
    (250.0, 0.75, 5, {0.05: 4.517, 0.23: 4.417}),
    (300.0, 0.75, 4, {0.02: 4.813, 0.05: 4.773, 0.23: 4.736, 0.36: 4.688}),
    (300.0, 0.75, 6, {0.05: 4.687, 0.36: 4.525}),
    (300.0, 0.75, 7, {0.05: 4.647, 0.36: 4.478}),
    (350.0, 0.75, 4, {0.05: 4.904, 0.32: 4.877}),
    (350.0, 0.75, 5, {0.05: 4.836, 0.32: 4.785}),
    (350.0, 0.75, 7, {0.05: 4.783, 0.32: 4.681}),
    (450.0, 0.75, 4, {0.05: 5.128, 0.4: 5.059}),
    (600.0, 0.75, 4, {0.1: 5.311, 0.54: 5.230}),
    (600.0, 0.75, 5, {0.1: 5.286, 0.54: 5.230}),
    (300.0, 1.0, 5, {0.0225: 4.289, 0.045: 4.264, 0.09: 4.289, 0.18: 4.189, 0.36: 4.099}),
    (300.0, 1.0, 7, {0.0225: 4.221, 0.09: 4.198, 0.36: 4.067}),
)
"""Rigidity index, adhesion factor, rows beside the face, and F over i: means over the radii from 4
to 20 after the approach."""


def test_what_inertia_changes_of_u2_is_corrected_within_its_parts_of_the_half_width(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At any speed against the slowest: that of the inertia, and that of C in slow clay."""
    left = law.SLOW_GAIN_HALF_WIDTH
    monkeypatch.setattr(law, "SLOW_GAIN_HALF_WIDTH", NOTHING_LEFT)
    series = list(INERTIA_OF_U2_BESIDE_ROUGH_SHAFTS)
    for index, of_adhesions in INERTIA_OF_U2.items():
        rows = 6 if index <= 50.0 else 5
        of_index = zip((0.0, 0.5, 1.0), of_adhesions, strict=True)
        series += [(index, adhesion, rows, readings) for adhesion, readings in of_index]
    for index, adhesion, rows, readings in series:
        size = math.sqrt(3.0) / rows
        at = {"cell_size": size, "adhesion_factor": adhesion, "rigidity_index": index}
        first, slowest = min(readings.items())
        _, at_rest = radial_error(slowest, **at)
        known, _ = radial_error(slowest, inertia=first, **at)
        for inertia, reading in readings.items():
            correction, half_width = radial_error(slowest, inertia=inertia, **at)
            changed = reading - slowest + float(correction - known)
            by_inertia = math.sqrt(half_width**2 - at_rest**2)
            assert abs(changed) <= math.hypot(by_inertia, float(interpolated(left, index)))
