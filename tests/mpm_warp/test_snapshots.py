"""Snapshots of the soil: when they are taken, what they hold, and that they change nothing."""

import numpy as np
import pytest
import xarray as xr

from mpm_warp import ConePenetration, GravityColumn, SceneError, Simulation, Snapshots, soil_fields
from mpm_warp.scenes.cone.penetration import PenetrationCurves

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def run(short_test: ConePenetration) -> tuple[xr.Dataset, xr.Dataset]:
    """The result of a short penetration, and its snapshots."""
    snapshots = Snapshots([1, 0.55, 5, 7])
    result = short_test.run(snapshots=snapshots)
    return result, snapshots.dataset()


def test_snapshots_change_no_bit_of_a_result(
    run: tuple[xr.Dataset, xr.Dataset], short_test: ConePenetration
) -> None:
    bare = short_test.run()
    for name, variable in bare.variables.items():
        if variable.attrs.get("role") != "measured":
            np.testing.assert_array_equal(run[0][name], variable, err_msg=str(name))


def test_snapshots_are_taken_at_the_first_sample_and_once_at_the_end(
    run: tuple[xr.Dataset, xr.Dataset],
) -> None:
    result, fields = run
    assert fields.penetration.values.tolist() == [0.6, 1.0, 2.0]
    samples = result.penetration_resistance.sel(
        penetration=fields.penetration - 0.05, method="nearest"
    )
    np.testing.assert_array_equal(fields.resistance, samples)


def test_the_traction_integrates_to_the_resistance(
    run: tuple[xr.Dataset, xr.Dataset], short_test: ConePenetration
) -> None:
    """Linear between the nodes of the surface, weighted by the radius: exact but for rounding."""
    fields = run[1].where(run[1].surface_part == "face", drop=True)
    r, z = fields.surface_r.values, fields.surface_z.values
    length, sine = np.hypot(np.diff(r), np.diff(z)), np.sin(np.radians(30))

    def integral(values: np.ndarray) -> np.ndarray:
        weights = np.stack([2 * r[:-1] + r[1:], r[:-1] + 2 * r[1:]]) * length / 6.0
        return values[:, :-1] @ weights[0] + values[:, 1:] @ weights[1]

    normal, shear = (fields[f"{it}_traction"].values for it in ("normal", "shear"))
    force = sine * integral(normal) + np.cos(np.radians(30)) * integral(shear)
    resistance = force / (0.5 * short_test.cone_radius**2)
    np.testing.assert_allclose(resistance, run[1].resistance, rtol=1e-12)
    # What the soil bears at most by shear.
    assert np.abs(shear).max() == pytest.approx(0.5 * short_test.undrained_shear_strength)


def test_points_are_those_of_the_run(
    run: tuple[xr.Dataset, xr.Dataset], short_test: ConePenetration
) -> None:
    _, fields = run
    present = fields.point_r.notnull()
    assert present.sum("point").values.min() > 200
    for name in ("displacement_z", "mean_stress", "plastic_shear_strain", "deviatoric_stress"):
        xr.testing.assert_equal(fields[name].notnull(), present)
    # Soil goes down with the cone, and aside; most shear stress is borne where it yields.
    at_end = fields.isel(penetration=-1)
    assert -2.5 < float(at_end.displacement_z.min()) / short_test.cone_radius < -0.5
    assert float(at_end.deviatoric_stress.max()) == pytest.approx(1.0, abs=1e-6)
    assert float(at_end.plastic_shear_strain.max()) > 1.0


def test_a_run_that_fails_keeps_what_was_taken(
    short_test: ConePenetration, monkeypatch: pytest.MonkeyPatch
) -> None:
    sample = PenetrationCurves.sample

    def fails(self: PenetrationCurves) -> None:
        sample(self)
        if len(self.forces) == 8:
            raise ArithmeticError("lost")

    monkeypatch.setattr(PenetrationCurves, "sample", fails)
    snapshots = Snapshots([0.5, 1.0])
    with pytest.raises(ArithmeticError, match="lost"):
        short_test.run(snapshots=snapshots)
    assert snapshots.dataset().penetration.values.tolist() == [0.5]


@pytest.mark.parametrize("moments", [[], [0.0], [-1.0], [float("nan")], ["5"]])
def test_moments_that_are_none_are_refused(moments: list[float]) -> None:
    with pytest.raises(ValueError, match=r"^snapshots: "):
        Snapshots(moments)


def test_a_scene_that_takes_none_says_so() -> None:
    with pytest.raises(SceneError, match="gravity_column: takes no snapshots"):
        GravityColumn(cell_count=4).run(snapshots=Snapshots([1]))


def test_fields_of_a_scene_without_history_are_an_error() -> None:
    with pytest.raises(KeyError, match=r"particle\.origin"):
        soil_fields(Simulation(GravityColumn(cell_count=4).build()))
