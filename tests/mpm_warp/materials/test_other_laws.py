"""A law of another package: pressure-dependent stiffness, plastic volume, a state of its own."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from mpm_warp import CavityCylinder, ConePenetration, Variation
from mpm_warp.errors import SceneError, SimulationDiverged
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cavity.exact import cavity_pressure
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.simulation import Simulation
from tests.mpm_warp.materials import cam_clay
from tests.mpm_warp.materials.cam_clay import CamClay

pytestmark = pytest.mark.slow

DENSITY = 1700.0


def clay(**changed: float) -> CamClay:
    return CamClay(density=DENSITY, **changed)


def sheared(material: CamClay, gradient: list[float], step_count: int) -> tuple[Floats, Floats]:
    """Shear stress q [Pa] and state of a point at every hundredth of a path from rest."""
    paths = StrainPaths(
        material=material,
        gradient=np.array([gradient]),
        stress=np.zeros((1, 4)),
        step_count=step_count,
    )
    simulation = Simulation(paths)
    q, state = [], []
    for _ in range(100):
        simulation.advance(step_count // 100)
        stress = simulation.array("particle.stress")[0]
        normal = stress[[0, 1, 3]] - stress[[0, 1, 3]].mean()
        q.append(math.sqrt(1.5 * float(normal @ normal) + 3.0 * stress[2] ** 2))
        state.append(simulation.array("particle.state")[0].copy())
    return np.array(q), np.array(state)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 4.0])
def test_the_undrained_triaxial_path_is_that_of_the_closed_form(ratio: float) -> None:
    """p' / p'_y = ((M^2 + eta_y^2) / (M^2 + eta^2))^Lambda, in steps of any size.

    It ends at the critical state: su = M p0' / 2 (R / 2)^Lambda.
    """
    material = clay(overconsolidation_ratio=ratio, critical_state_ratio=1.2)
    M, start = material.critical_state_ratio, material.mean_effective_stress
    q, state = sheared(material, [0.5, 0, 0, -1.0, 0.5], 40_000)
    p = state[:, 0]
    eta_y = M * math.sqrt(ratio - 1.0)
    expected = start * ((M**2 + eta_y**2) / (M**2 + (q / p) ** 2)) ** material.plastic_share
    yields = q > eta_y * start * (1.0 + 1e-9)
    np.testing.assert_allclose(p, np.where(yields, expected, start), rtol=1e-8)
    assert 0.5 * q[-1] == pytest.approx(material.strength, rel=1e-6)


def test_the_strain_that_a_path_takes_is_of_first_order_in_the_step() -> None:
    """The return is backward Euler: q at a strain of 1 %, halfway to the critical state."""
    material = clay(overconsolidation_ratio=1.0)
    ends = [sheared(material, [5e-3, 0, 0, -1e-2, 5e-3], n)[0][-1] for n in (400, 800, 1600, 3200)]
    changes = np.abs(np.diff(ends))
    orders = np.log2(changes[:-1] / changes[1:])
    np.testing.assert_allclose(orders, 1.0, atol=0.1)
    assert changes[-1] / ends[-1] < 1e-3


def test_stiffness_follows_the_effective_stress() -> None:
    """Elastic shear at R = 4 has q = 3 G e_q, with G = 3 (1 - 2 nu) / 2 (1 + nu) v p' / kappa."""
    for stress in (20e3, 80e3):
        material = clay(overconsolidation_ratio=4.0, mean_effective_stress=stress)
        q, _ = sheared(material, [5e-4, 0, 0, -1e-3, 5e-4], 100)
        stiffness = 0.6 * 2.0 * stress / 0.04  # nu 0.25, v 2, kappa 0.04
        assert q[-1] == pytest.approx(3.0 * stiffness * 1e-3, rel=1e-9)
        assert material.ground_shear_modulus == pytest.approx(stiffness)


def test_the_pressure_in_a_cavity_is_the_integral_of_the_law_along_its_strain_path() -> None:
    """Of total stress, around a cylinder: p - p0 = int tau dgamma / (e^gamma - 1); see ExactCavity.

    The path is that of a soil that keeps its volume; here the water gives by 1 / 100 of G, as much
    as soil with a Poisson's ratio of 0.495, in which the scene is allowed 1.5 %.
    """
    material = clay(overconsolidation_ratio=1.5)
    test = CavityCylinder(cells_per_radius=4, expansion=2.0, rigidity_index=100)
    strength = material.strength
    # The wall moves as fast as in clay of that strength.
    wall = replace(test.wall, speed=test.wall.speed * math.sqrt(strength / 1e3))
    scene = test.build()
    parts = (*test.boundaries(scene.grid, material), wall)
    simulation = Simulation(replace(scene, material=material, parts=parts))
    duration = test.duration(wall)
    simulation.advance_to(0.95 * duration)
    simulation.assign("wall.impulse", 0.0)
    before, radius_before = simulation.time, float(simulation.array("wall.motion")[0, 2])
    simulation.advance_to(duration)
    radius = 0.5 * (radius_before + float(simulation.array("wall.motion")[0, 2]))
    force = simulation.array("wall.impulse").sum() / (simulation.time - before)
    pressure = force / test.wall_area(scene.grid, radius)

    # The curve of shear stress over shear strain, in three pieces: it is steep where it begins.
    end = 2.0 * math.log(2.0)
    strain, tau = np.zeros(1), np.zeros(1)
    for last, step_count in ((1e-3, 1_000), (0.02, 5_000), (1.1, 20_000)):
        half = 0.5 * last * end
        q, _ = sheared(material, [half, 0, 0, 0, -half], step_count)
        reached = last * end * np.arange(1, 101) / 100
        new = reached > strain[-1]
        strain, tau = np.append(strain, reached[new]), np.append(tau, q[new] / math.sqrt(3.0))
    expected = cavity_pressure(
        lambda gamma: np.interp(gamma, strain, tau), strain=2.0 * math.log(radius), factor=1.0
    )
    assert pressure == pytest.approx(expected, rel=0.015)


def test_a_cone_goes_through_it_and_the_watch_knows_its_volume(short_test: ConePenetration) -> None:
    """Soil enters with the state of its place; a mean stress that drifts is noticed."""
    material = clay(overconsolidation_ratio=2.0)
    scene = replace(short_test.build(), material=material)
    simulation = Simulation(scene)
    simulation.travel_to(1.5 * short_test.cone_radius)
    simulation.check()
    present = simulation.array("particle.cell")
    inside = present[:, 0] >= 0
    p, size, pressure = simulation.array("particle.state")[inside].T
    start = material.mean_effective_stress
    entered = present[inside][:, 1] == 0
    np.testing.assert_allclose(p[entered], start, rtol=0.05)
    np.testing.assert_allclose(size[entered], 2.0 * start, rtol=0.01)
    assert pressure.max() > start
    # At R = 2 points begin at the critical state: what yields keeps its effective stress.
    np.testing.assert_allclose(p, start, rtol=0.05)
    slot = int(np.flatnonzero(inside)[5])
    simulation.array("particle.stress")[slot, 2] = start
    with pytest.raises(SimulationDiverged, match=f"stress of particle {slot} .* outside the yield"):
        simulation.check()
    with pytest.raises(SimulationDiverged, match="mean stress of particle"):
        Simulation(replace(scene, material=Drifting(**vars(material)))).advance(500)


class Drifting(CamClay):
    """It says that its pores hold half as much water as they do."""

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats:
        return super().mean_stress_change(0.5 * volume_strain, properties, state)


def test_a_law_that_does_not_vary_by_place_is_not_given_a_variation() -> None:
    varied = Variation(depth=np.zeros(1), strength_ratio=np.ones(1), stiffness_ratio=np.ones(1))
    with pytest.raises(SceneError, match="has no properties that vary by place"):
        replace(clay(), variation=varied)


STUDY = """
title = "Cam clay"
scene = "cone_penetration"

[fixed]
material = "cam_clay"
undrained_shear_strength = 25e3
critical_state_ratio = 1.0
cells_per_radius = 1.5
domain_radius = 8
domain_above = 3
domain_below = 3
penetration = 2
steady_tolerance = 0

[vary]
overconsolidation_ratio = [1, 2]
"""


@pytest.fixture(scope="module")
def offered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of packages, one of which offers the law by an entry point."""
    folder = tmp_path_factory.mktemp("packages")
    shutil.copy(cam_clay.__file__, folder / "their_cam_clay.py")
    info = folder / "their_cam_clay-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: their_cam_clay\nVersion: 1.0\n")
    entry = "[mpm_warp.materials]\ncam_clay = their_cam_clay:CamClay\nlost = nowhere:Clay\n"
    (info / "entry_points.txt").write_text(entry)
    (folder / "study.toml").write_text(STUDY)
    return folder


def command(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """The command `harness` where the packages of a folder are installed."""
    paths = os.pathsep.join([str(folder), str(Path(cam_clay.__file__).parents[3])])
    return subprocess.run(
        [sys.executable, "-m", "harness", *words],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": paths, "COLUMNS": "100"},
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )


def test_a_study_names_the_law_and_varies_a_parameter_of_it(offered: Path) -> None:
    run = command(offered, "run", "study.toml", "--out", "results", "--workers", "1")
    assert run.returncode == 0, run.stdout + run.stderr
    with xr.open_dataset(offered / "results" / "study.nc") as study:
        assert list(study.overconsolidation_ratio.values) == [1.0, 2.0]
        assert set(study.status.values) == {"completed"}
        assert set(np.atleast_1d(study.built_law.values)) == {"cam_clay"}
        assert set(np.atleast_1d(study.compression_slope.values)) == {0.2}  # its default
        assert study.mean_effective_stress.attrs["units"] == "Pa"
        resistance = study.cone_factor_simulated.values
        assert resistance[1] > resistance[0] > 0.0
        assert np.isnan(study.cone_factor_uncertainty.values).all()
        assert all(
            "cam_clay" in str(reason) for reason in np.atleast_1d(study.why_no_uncertainty.values)
        )


@pytest.mark.parametrize(
    ("scene", "settings"),
    [
        ("material_point", {"step_count": "100"}),
        ("cavity_cylinder", {"cells_per_radius": "2", "expansion": "1.2"}),
    ],
)
def test_other_scenes_take_the_law(offered: Path, scene: str, settings: dict[str, str]) -> None:
    study = offered / f"{scene}.toml"
    fixed = {"material": '"cam_clay"', **settings}
    lines = [f"{name} = {value}" for name, value in fixed.items()]
    study.write_text(f'title = "x"\nscene = "{scene}"\n[fixed]\n' + "\n".join(lines) + "\n")
    run = command(offered, "run", study.name, "--out", scene, "--workers", "1")
    assert run.returncode == 0, run.stdout + run.stderr
    with xr.open_dataset(offered / scene / f"{scene}.nc") as result:
        assert set(np.atleast_1d(result.status.values)) == {"completed"}
        assert "error" not in result  # nothing exact is known of it


def test_the_law_is_described_and_its_values_are_checked(offered: Path) -> None:
    described = command(offered, "describe", "cone_penetration").stdout
    assert "compression_slope" in described
    schema = json.loads(command(offered, "schema").stdout)
    assert "swelling_slope" in json.dumps(schema)
    refused = {
        "critical_state_ratio=0": "critical_state_ratio = 0",
        "compresion_slope=0.1": "did you mean 'compression_slope'",
        "material=tresca": "is no parameter of material = 'tresca'",
        "material=lost": "the entry point 'nowhere:Clay' cannot be loaded",
        "rate_factor=0.1": "has a strength of its own",
    }
    for setting, message in refused.items():
        run = command(offered, "run", "study.toml", "--out", "no", "--set", setting)
        assert run.returncode == 2, run.stdout
        assert message in run.stderr
        assert len(run.stderr.splitlines()) == 1
