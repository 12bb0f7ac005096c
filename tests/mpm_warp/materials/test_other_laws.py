"""Laws with parameters of their own: as studies name them, and one of another package."""

import json
import os
import shutil
import sys
from dataclasses import dataclass, field
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp import (
    BallPenetration,
    CavityCylinder,
    ConePenetration,
    MaterialPoint,
    ParameterError,
    SceneError,
    Sounding,
    Tresca,
    VonMises,
    parameter,
)
from mpm_warp.materials import clay_law
from tests.conftest import finished
from tests.mpm_warp.conftest import layers
from tests.mpm_warp.materials import bonded_clay
from tests.mpm_warp.materials.bonded_clay import BondedClay

pytestmark = pytest.mark.slow


def test_a_law_that_does_not_vary_by_place_is_not_given_a_variation() -> None:
    with pytest.raises(SceneError, match="has no properties that vary by place"):
        BondedClay(density=1700.0, poissons_ratio=0.49, variation=layers((0, 1, 1)))


STUDY = """
title = "Bonded clay"
scene = "cone_penetration"

[fixed]
material = { law = "bonded_clay", isotropic_overconsolidation_ratio = 1.0 }
undrained_shear_strength = 25e3
cells_per_radius = 1.5
domain_radius = 8
domain_above = 3
domain_below = 3
penetration = 2
steady_tolerance = 0

[vary]
material.bonding = [0, 1]
"""


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of packages, one of which offers the law by an entry point."""
    folder = tmp_path_factory.mktemp("packages")
    shutil.copy(bonded_clay.__file__, folder / "their_clay.py")
    info = folder / "their_clay-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: their_clay\nVersion: 1.0\n")
    entry = "[mpm_warp.materials]\nbonded_clay = their_clay:BondedClay\nlost = nowhere:Clay\n"
    (info / "entry_points.txt").write_text(entry)
    (folder / "study.toml").write_text(STUDY)
    return folder


COMMANDS = """
import contextlib, io, json, sys
from harness.cli.main import main
for line in json.load(sys.stdin):
    with contextlib.redirect_stdout(io.StringIO()) as out:
        with contextlib.redirect_stderr(io.StringIO()) as err:
            code = main(line.split())
    print(json.dumps([code, out.getvalue(), err.getvalue()]))
"""
REFUSED = {
    "compression_slope=0.1": "did you mean 'material.compression_slope'",
    "material.swelling_slope=true": "must be a number > 0; meaning: slope kappa",
    "material.yield_stress=1": "unknown parameter 'material.yield_stress'",
    "material=lost": "the entry point 'nowhere:Clay' cannot be loaded",
    'material={law="lost",bond=1}': "the entry point 'nowhere:Clay' cannot be loaded",
}
STUDY_RUN = "run study.toml --out results --workers 1"


@pytest.fixture(scope="module")
def told(packages: Path) -> dict[str, tuple[int, str, str]]:
    """What commands end with and say in one process where the packages are installed."""
    lines = [STUDY_RUN, "schema", *(f"describe {it}" for it in ("bonded_clay", "cone_penetration"))]
    lines += [f"run study.toml --out no --set {it}" for it in REFUSED]
    paths = os.pathsep.join([str(packages), str(Path(bonded_clay.__file__).parents[3])])
    run = finished(
        [sys.executable, "-c", COMMANDS],
        cwd=packages,
        env=os.environ | {"PYTHONPATH": paths},
        input=json.dumps(lines),
    )
    assert run.returncode == 0, run.stderr
    return dict(zip(lines, map(json.loads, run.stdout.splitlines()), strict=True))


@pytest.mark.parametrize("names", [["tresca"], ["anisotropic"], ["mine", "mine"]])
def test_a_law_with_the_name_of_another_is_refused(
    names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would be taken for the other one without a word."""
    points = [EntryPoint(name, "their_clay:Clay", clay_law.GROUP) for name in names]
    monkeypatch.setattr(clay_law, "entry_points", lambda group: points)
    with pytest.raises(ParameterError, match=f"'{names[0]}': the entry point 'their_clay:Clay'"):
        clay_law.laws.__wrapped__()


class Forgotten(Tresca):
    """It has a parameter, but is no dataclass."""

    angle: float = parameter(8.0, "angle")


def test_a_law_that_is_no_dataclass_is_refused_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scenes run with other laws, as `own_of_variants` takes those that can be loaded."""
    point = EntryPoint("forgotten", f"{__name__}:Forgotten", clay_law.GROUP)
    monkeypatch.setattr(clay_law, "laws", lambda: {"forgotten": point})
    with pytest.raises(ParameterError, match=r"Forgotten\.angle is no field yet: put @dataclass"):
        clay_law.law_class.__wrapped__("forgotten")


@dataclass(frozen=True, kw_only=True)
class OfOneStiffness(Tresca):
    """Its strength is that of the scene, its stiffness is not."""

    shear_modulus: float = field(init=False, default=5e6)


def test_the_rigidity_index_is_that_of_a_law_whose_stiffness_alone_is_its_own() -> None:
    for kind in (ConePenetration, Sounding, BallPenetration):
        test: Any = kind(material=OfOneStiffness(), undrained_shear_strength=25e3)
        assert test.rigidity_index == 200.0
        assert test.soil.ground_shear_modulus == 5e6
        with pytest.raises(ParameterError, match=r"rigidity_index = 50 .* is its own: 250 su"):
            kind(material=OfOneStiffness(), rigidity_index=50.0)


def test_a_law_without_an_entry_point_is_named_by_its_class() -> None:
    test = ConePenetration(material=OfOneStiffness())
    assert test.material.name.endswith("test_other_laws.OfOneStiffness")
    assert "OfOneStiffness" in repr(test)


class WithAnUpdate(Tresca):
    """Its update is more than the return to the criterion."""

    def update(self) -> Any:
        return super().update()


class WithABulkModulus(Tresca):
    """It is more compressible than by its Poisson's ratio."""

    bulk_modulus = property(lambda self: 10.0 * self.shear_modulus)


class WithAState(Tresca):
    """It has a state beside that of the criterion."""

    state = ("age",)


@pytest.mark.parametrize("kind", [WithAnUpdate, WithABulkModulus, WithAState])
def test_only_the_strength_of_a_criterion_changes(kind: type[Tresca]) -> None:
    """Softening and rate take the criterion alone, so all beside it would be lost."""
    for changed in ({"rate_factor": 0.1}, {"remoulded_strength_ratio": 0.5}):
        with pytest.raises(ParameterError, match="has a strength, update or state of its own"):
            ConePenetration(material=kind(), **changed)


def test_a_criterion_with_a_measure_of_its_own_has_no_strengths_of_another() -> None:
    """They would be told as exact."""
    given = {"shear_modulus": 1e6, "poissons_ratio": 0.3, "density": 1.7e3, "strength": 1e4}
    own: Any = type("Own", (Tresca,), {"measure": VonMises.measure})
    assert own(**given).undrained_strength("simple_shear") is None
    with pytest.raises(SceneError, match="Own: the stress of the ground is outside the yield"):
        own(**given).check_stress_at_rest(np.array([0.0, -2.1e4, 0.0, 0.0]))
    same: Any = type("Same", (Tresca,), {})
    assert same(**given).undrained_strength("simple_shear") == 1e4


@pytest.mark.parametrize("name", ["measure", "within", "nearest"])
def test_a_function_of_a_criterion_is_one_of_the_device(name: str) -> None:
    clay: Any = type("Odd", (Tresca,), {name: staticmethod(lambda *_: True)})
    for changed in ({}, {"remoulded_strength_ratio": 0.5, "ductility": 10.0}):
        test = ConePenetration(material=clay(), **changed)
        with pytest.raises(SceneError, match=rf"Odd\.{name} = .* must be of type Function"):
            test.soil.law()


@pytest.mark.parametrize("name", ["moduli", "properties"])
def test_moduli_and_properties_need_an_update_that_uses_them(name: str) -> None:
    def of_its_own(self: Any) -> Any:
        return None

    with pytest.raises(TypeError, match=f"has {name} of its own, so it needs an update"):
        type("Stiffening", (Tresca,), {name: of_its_own})
    type("Stiffening", (Tresca,), {name: of_its_own, "update": WithAnUpdate.update})


def test_a_study_names_the_law_and_varies_a_parameter_of_it(packages: Path, told: Any) -> None:
    assert told[STUDY_RUN][0] == 0, told[STUDY_RUN]
    with xr.open_dataset(packages / "results" / "study.nc") as study:
        assert list(study["material.bonding"].values) == [0.0, 1.0]
        assert set(study.status.values) == {"completed"}
        assert set(np.atleast_1d(study.built_law.values)) == {"bonded_clay"}
        by_default = np.atleast_1d(study["material.compression_slope"].values)
        assert set(by_default) == {0.2}
        assert study["material.mean_effective_stress"].attrs["units"] == "Pa"
        resistance = study.cone_factor_simulated.values
        assert resistance[1] > resistance[0] > 0.0
        assert np.isnan(study.cone_factor_uncertainty.values).all()
        reasons = np.atleast_1d(study.why_no_uncertainty.values)
        assert all("bonded_clay" in str(reason) for reason in reasons)


def test_other_scenes_take_the_law_and_nothing_exact_is_known_of_it() -> None:
    cavity = CavityCylinder(material=BondedClay(), cells_per_radius=2, expansion=1.2)
    for scene in (MaterialPoint(material=BondedClay(), step_count=100), cavity):
        assert "error" not in scene.run()


def test_the_law_is_described_and_its_values_are_checked(told: Any) -> None:
    assert "material.bonding " in told["describe bonded_clay"][1]
    assert "bonding" not in told["describe cone_penetration"][1]
    assert "swelling_slope" in json.dumps(json.loads(told["schema"][1]))
    for setting, message in REFUSED.items():
        code, _, line = told[f"run study.toml --out no --set {setting}"]
        assert (code, len(line.splitlines())) == (2, 1)
        assert message in line
