"""The penetrometer's surface: areas, normals and the forces read from them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from mpm_warp.penetrometer import PenetrometerSurface

from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.contact import SurfaceContact

ROUNDING = 1e-12
HALF_ANGLE = np.radians(30.0)


def test_areas_of_face_and_shaft_are_exact(surface: PenetrometerSurface) -> None:
    face, shaft = surface.areas
    slant = 1.0 / np.sin(HALF_ANGLE)
    assert face.sum() == pytest.approx(0.5 * slant, rel=ROUNDING)  # pi R l over 2 pi
    shaft_length = surface.grid.rows[-1] - surface.penetrometer.cone_height
    assert shaft.sum() == pytest.approx(shaft_length, rel=ROUNDING)
    assert surface.shaft_area == pytest.approx(shaft_length, rel=ROUNDING)


def test_nothing_flows_through_the_surface_on_the_whole(surface: PenetrometerSurface) -> None:
    """Uniform flow along z through the closed tip: the z areas sum to the base, less none."""
    contact = surface.contact
    vectors = contact.normals * contact.normal_areas[:, None]
    assert vectors[:, 1].sum() == pytest.approx(0.5, rel=ROUNDING)  # R^2 / 2, the base
    np.testing.assert_allclose(np.linalg.norm(contact.normals, axis=1), 1.0, rtol=ROUNDING)


def test_the_shoulder_has_the_mean_normal_and_the_tip_the_vertical_one(
    surface: PenetrometerSurface,
) -> None:
    normals = surface.contact.normals
    face, shaft = surface.areas
    shoulder = int(np.flatnonzero((face > 0.0) & (shaft > 0.0))[0])
    expected = face[shoulder] * np.array([-np.cos(HALF_ANGLE), np.sin(HALF_ANGLE)])
    expected += shaft[shoulder] * np.array([-1.0, 0.0])
    np.testing.assert_allclose(
        normals[shoulder], expected / np.linalg.norm(expected), rtol=ROUNDING
    )
    np.testing.assert_allclose(normals[0], [0.0, 1.0], atol=ROUNDING)


def _uniform_traction(surface: PenetrometerSurface, pressure: float) -> Floats:
    """Nodal forces of a uniform normal traction and of full adhesion, but none at the fixed tip."""
    contact = surface.contact
    shear = contact.adhesion_forces.copy()
    shear[0] = 0.0
    return np.stack([pressure * contact.normal_areas, shear], axis=-1)


def test_a_uniform_pressure_gives_its_value_times_the_base(surface: PenetrometerSurface) -> None:
    forces = surface.forces(_uniform_traction(surface, 7.0))
    assert forces.face_normal == pytest.approx(7.0 * 0.5, rel=ROUNDING)


def test_full_adhesion_gives_the_exact_shear_less_the_share_of_the_tip(
    surface: PenetrometerSurface,
) -> None:
    """2 F / R^2 = a / tan(half angle); the tip's share is 1 / (3 n^2) with n rows on the face."""
    face, _ = surface.areas
    rows_on_face = np.count_nonzero(face) - 1
    forces = surface.forces(_uniform_traction(surface, 7.0))
    exact = 3.0 / np.tan(HALF_ANGLE) * (1.0 - 1.0 / (3.0 * rows_on_face**2))
    assert 2.0 * forces.face_shear == pytest.approx(exact, rel=ROUNDING)
    assert forces.shaft_shear == pytest.approx(1.0 * surface.shaft_area, rel=ROUNDING)


def test_friction_shares_the_shoulder_by_the_total_normal_traction(
    surface: PenetrometerSurface,
) -> None:
    rubbing = dataclasses.replace(surface, friction=0.5, face_adhesion=0.0, shaft_adhesion=0.0)
    face, shaft = rubbing.areas
    nodal = np.zeros((len(face), 2))
    shoulder = int(np.flatnonzero((face > 0.0) & (shaft > 0.0))[0])
    nodal[shoulder, 1] = 1.0
    forces = rubbing.forces(nodal)
    share = face[shoulder] / (face[shoulder] + shaft[shoulder])
    assert forces.face_shear == pytest.approx(share * np.cos(HALF_ANGLE), rel=ROUNDING)
    assert forces.shaft_shear == pytest.approx(1.0 - share, rel=ROUNDING)


@pytest.mark.parametrize("in_situ_stress", [0.0, 10.0])
def test_the_share_in_touch_is_of_the_area_that_something_presses(in_situ_stress: float) -> None:
    """Of areas 1, 2, 4 and 8: pressed, just still pressed, parted, and parted but for rounding."""
    areas = np.array([1.0, 2.0, 4.0, 8.0])
    contact = SurfaceContact(
        nodes=np.arange(4, dtype=np.int32),
        normals=np.tile([-1.0, 0.0], (4, 1)),
        normal_areas=areas,
        adhesion_forces=np.zeros(4),
        friction=0.0,
        in_situ_stress=in_situ_stress,
    )
    parted = -in_situ_stress * areas
    still = np.array([5.0, 0.01, 0.0, 0.0]) * areas * max(1.0, in_situ_stress)
    rounding = ROUNDING * parted * [0.0, 0.0, 1.0, -1.0]
    assert contact.share_in_touch(parted + still + rounding) == 3.0 / 15.0
    assert contact.share_in_touch(parted) == 0.0
    assert contact.share_in_touch(np.ones(4)) == 1.0
