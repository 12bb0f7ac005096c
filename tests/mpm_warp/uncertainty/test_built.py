"""What was built decides what is said of the error: a law, a contact or a grid of one's own.

Each is built by a scene that is derived from the cone test, whose parameters keep their names. All
would have an uncertainty if their parameters were asked.
"""

import importlib.util
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp import Grid, History, Scene, SurfaceContact, Tresca
from mpm_warp.materials.material import built_name
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.full_flow.penetration import TBarPenetration
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.uncertainty import cone
from mpm_warp.uncertainty.built import LAWS_OF_CONES, why_not_as_measured
from mpm_warp.uncertainty.samples import why_not_known
from tests.conftest import blocks
from tests.mpm_warp.conftest import DIRECTED, MEASURABLE
from tests.mpm_warp.uncertainty.conftest import steady_run

GUIDE = Path(__file__).parents[3] / "studies" / "guide.md"
FACTOR = 10.0


class OwnClay(Tresca):
    """A law of one's own."""


class InOwnClay:
    """A scene in soil of one's own, put in as the guide says."""

    def build(self) -> Scene:
        scene: Scene = super().build()  # type: ignore[misc]
        assert isinstance(scene.material, Tresca)
        return replace(scene, material=OwnClay(**vars(scene.material)))


class ConeInOwnClay(InOwnClay, ConePenetration):
    """A cone test in such soil."""


class SoundingInOwnClay(InOwnClay, Sounding):
    """A sounding in such soil."""


class TBarInOwnClay(InOwnClay, TBarPenetration):
    """A T-bar in such soil."""


class StrongerContact(SurfaceContact):
    """A contact of one's own."""


class ConeWithContact(ConePenetration):
    """A cone test with another class of contact, of the same numbers."""

    def build(self) -> Scene:
        scene = super().build()
        names = SurfaceContact.__dataclass_fields__
        own = StrongerContact(**{name: vars(scene[SurfaceContact])[name] for name in names})
        parts = (own if isinstance(it, SurfaceContact) else it for it in scene.parts)
        return replace(scene, parts=tuple(parts))


class ConeWithAdhesion(ConePenetration):
    """A cone test whose contact has an adhesion that its parameters do not know."""

    def build(self) -> Scene:
        scene = super().build()
        contact = scene[SurfaceContact]
        rough = contact.normal_areas * self.undrained_shear_strength
        return scene.with_parts(replace(contact, adhesion_forces=rough))


class ConeInStiffClay(ConePenetration):
    """A cone test in clay stiffer than its parameters say."""

    @property
    def clay(self) -> Tresca:
        clay = super().clay
        assert isinstance(clay, Tresca)
        return replace(clay, shear_modulus=2.0 * clay.shear_modulus)


class ConeOnUprightColumns(ConePenetration):
    """A cone test on a grid of another family: upright from 5 radii on."""

    @property
    def _grid(self) -> Grid:
        grid = super()._grid
        positions = grid.columns * (grid.fitted_radius - self.cone_radius)
        fitted = positions[np.argmin(np.abs(positions - 4.0 * self.cone_radius))]
        beyond = positions > fitted
        columns = np.where(
            beyond, (self.cone_radius + positions) / (self.cone_radius + fitted), positions / fitted
        )
        return replace(grid, columns=columns, fitted_radius=self.cone_radius + float(fitted))


@pytest.fixture(scope="module")
def of_the_page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The page's own example of a law with memory, as a reader's module."""
    script = next(it for it in blocks(GUIDE.read_text()) if "ConeInHardeningClay" in it)
    file = tmp_path_factory.mktemp("reader") / "hardening_of_a_reader.py"
    file.write_text(script)
    specification = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(specification)
    sys.modules[file.stem] = module
    specification.loader.exec_module(module)
    yield module
    del sys.modules[file.stem]


def stated(test: ConePenetration) -> xr.Dataset:
    """What would be said of a steady run of a test, of the cone factor `FACTOR`."""
    run = test.error_of(steady_run(test, FACTOR))
    return xr.Dataset(cone.known_error(run, test.build(), test._expected))


def check_nothing_is_known(test: ConePenetration, reason: str) -> None:
    known = stated(ConePenetration())
    assert float(known.cone_factor_uncertainty) > 0.0
    assert float(known.cone_factor) != FACTOR
    said = stated(test)
    assert float(said.cone_factor) == FACTOR
    assert float(said.cone_factor_correction) == 0.0
    assert np.isnan(said.cone_factor_uncertainty)
    assert str(said.why_no_uncertainty.values) == reason


def test_nothing_is_known_in_the_clay_that_hardens_of_the_page(of_the_page: ModuleType) -> None:
    check_nothing_is_known(
        of_the_page.ConeInHardeningClay(hardening_ratio=0.5),
        "law: the error is not known with the soil built, "
        "hardening_of_a_reader.HardeningClay instead of tresca",
    )


@pytest.mark.parametrize(
    ("test", "word", "what", "difference"),
    [
        (ConeInOwnClay, "law", "soil", f"{__name__}.OwnClay instead of tresca"),
        (ConeInStiffClay, "law", "soil", "shear_modulus = 4e+06 instead of 2e+06"),
        (
            ConeWithContact,
            "contact",
            "contact",
            f"{__name__}.StrongerContact instead of penetrometer_contact",
        ),
        (ConeWithAdhesion, "contact", "contact", "with other adhesion_forces"),
        (ConeOnUprightColumns, "grid", "grid", "with other columns"),
    ],
    ids=["law", "stiffness", "contact", "adhesion", "grid"],
)
def test_nothing_is_known_of_what_one_builds_oneself(
    test: type[ConePenetration], word: str, what: str, difference: str
) -> None:
    reason = f"{word}: the error is not known with the {what} built, {difference}"
    check_nothing_is_known(test(), reason)


def test_parts_may_stand_in_any_order_unless_they_act_at_one_place() -> None:
    scene = ConePenetration().build()
    fixed, ground, *others = scene.parts
    assert why_not_as_measured(replace(scene, parts=(*others, fixed, ground)), scene) == []
    (reason,) = why_not_as_measured(replace(scene, parts=(ground, fixed, *others)), scene)
    assert reason == (
        "scene: the error is not known with the scene built, the order of its parts = "
        "surrounding_ground, fixed instead of fixed, surrounding_ground"
    )


def test_what_only_records_changes_nothing() -> None:
    test = ConePenetration(energy_audit="balance")
    assert float(stated(test).cone_factor_uncertainty) > 0.0
    recorded = test.build().with_parts(History())
    assert why_not_as_measured(recorded, ConePenetration().build()) == []


@pytest.mark.slow
def test_a_run_says_what_was_built_and_measures_nothing_where_it_cannot() -> None:
    """Small and short; the further runs would cost ten times as much, and are not made."""
    result = ConeInOwnClay(**MEASURABLE).run()
    own = f"{__name__}.OwnClay"
    assert str(result.built_law.values) == own
    assert str(result.material.values) == own
    assert str(result.built_contact.values) == "penetrometer_contact"
    assert str(result.why_no_uncertainty.values).startswith("law: the error is not known with")
    assert "uncertainty_run_time" not in result
    assert float(result.cone_factor) == float(result.cone_factor_simulated)


@pytest.mark.slow
@pytest.mark.parametrize("uncertainty", ["none", "measured"])
def test_the_error_of_a_t_bar_in_soil_of_ones_own_is_not_measured(uncertainty: str) -> None:
    bar = TBarInOwnClay(uncertainty=uncertainty, cells_per_radius=3, domain_extent=4, penetration=6)
    result = bar.run()
    assert np.isnan(result.resistance_factor_uncertainty)
    assert str(result.why_no_uncertainty.values).startswith("law: the error is not known with")
    assert "uncertainty_run_time" not in result
    assert "resistance_factor_exact" not in result  # which is that of perfectly plastic clay


def test_nothing_is_known_of_a_sounding_in_soil_of_ones_own() -> None:
    sounding = SoundingInOwnClay()
    plain = Sounding().build()
    assert why_not_known(plain, plain) == []
    (reason,) = why_not_known(sounding.build(), plain)
    assert reason.startswith("law: the error is not known with the soil built")


def test_the_laws_of_this_package_are_called_by_their_names() -> None:
    clay = ConePenetration(remoulded_strength_ratio=0.5, ductility=10.0).build().material
    assert built_name(clay) == "einav_randolph"
    assert built_name(ConePenetration(material="von_mises").build().material) == "von_mises"


def test_of_clay_with_strength_by_direction_a_cone_is_known_unless_it_softens() -> None:
    offered: Any = ConePenetration.offered()
    for changing, named in (
        ({}, "in anisotropic"),
        ({"remoulded_strength_ratio": 0.5, "ductility": 10.0}, "in Anisotropic clay whose"),
    ):
        scene = offered(**DIRECTED, **changing).build()
        assert why_not_as_measured(scene, scene)[0].startswith(
            f"law: the error is not known {named}"
        )
        assert bool(why_not_as_measured(scene, scene, LAWS_OF_CONES)) == bool(changing)


@pytest.mark.parametrize(("ratio", "ductility"), [(0.1, 8.9), (0.5, 4.9), (0.9, 0.9)])
def test_in_brittle_clay_further_runs_tell_nothing(ratio: float, ductility: float) -> None:
    """They tell it up to a (1 - delta) / xi_95 of 0.1."""
    brittle, ductile = (
        ConePenetration(remoulded_strength_ratio=ratio, ductility=xi).build()
        for xi in (ductility, ductility + 0.2)
    )
    (reason,) = why_not_as_measured(brittle, brittle, LAWS_OF_CONES)
    assert reason.endswith("in clay so brittle, (1 - delta) / xi_95 above 0.1")
    assert why_not_as_measured(ductile, ductile, LAWS_OF_CONES) == []


def test_further_runs_tell_the_error_of_a_cone_in_cam_clay_and_of_no_other_body() -> None:
    scene = ConePenetration.offered()(material="modified_cam_clay").build()
    assert why_not_as_measured(scene, scene, LAWS_OF_CONES) == []
    assert why_not_as_measured(scene, scene) == why_not_known(scene, scene) != []
