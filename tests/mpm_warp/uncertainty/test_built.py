"""What has an uncertainty: a scene of the catalogue as it is, with a law that was measured."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp import History, Scene, SurfaceContact, Tresca
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.full_flow.penetration import TBarPenetration
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.uncertainty import built, cone
from tests.mpm_warp.conftest import DIRECTED, MEASURABLE, SHORT_BAR
from tests.mpm_warp.uncertainty.conftest import steady_run

FACTOR = 10.0


class OwnClay(Tresca):
    """A law of one's own."""


class InOwnClay:
    """A scene in soil of one's own, put in as the guide says."""

    def build(self) -> Scene:
        scene: Scene = super().build()  # type: ignore[misc]
        return replace(scene, material=OwnClay(**vars(scene.material)))


class ConeInOwnClay(InOwnClay, ConePenetration):
    """A cone test in such soil."""


class SoundingInOwnClay(InOwnClay, Sounding):
    """A sounding in such soil."""


class TBarInOwnClay(InOwnClay, TBarPenetration):
    """A T-bar in such soil."""


def not_of_catalogue(kind: type) -> str:
    name = f"{__name__}.{kind.__name__}"
    return f"scene: the error is known for scenes of the catalogue, not for {name}"


def with_part(scene: Scene, part: type[SurfaceContact]) -> Scene:
    own = part(**{name: vars(scene[SurfaceContact])[name] for name in part.__dataclass_fields__})
    others = (own if isinstance(it, SurfaceContact) else it for it in scene.parts)
    return replace(scene, parts=tuple(others))


def stated(test: ConePenetration, scene: Scene | None = None) -> xr.Dataset:
    """What would be said of a steady run of a test, of the cone factor `FACTOR`."""
    run = test.error_of(steady_run(test, FACTOR))
    return xr.Dataset(cone.known_error(run, test, scene or test.build()))


def test_a_cone_test_of_the_catalogue_has_an_uncertainty_whatever_it_records() -> None:
    for test in (ConePenetration(), ConePenetration(energy_audit="balance")):
        said = stated(test, test.build().with_parts(History()))
        assert float(said.cone_factor_uncertainty) > 0.0
        assert float(said.cone_factor) > FACTOR


@pytest.mark.parametrize("own", ["class", "part"])
def test_a_class_or_a_part_of_ones_own_has_none_and_nothing_is_corrected(own: str) -> None:
    test = ConePenetration() if own == "part" else ConeInOwnClay()
    scene = with_part(test.build(), SurfaceContact) if own == "part" else test.build()
    said, reason = stated(test, scene), not_of_catalogue(ConeInOwnClay)
    if own == "part":
        reason = "scene: the error is not known with conservative_interpolation, fixed, "
    assert str(said.why_no_uncertainty.values).startswith(reason)
    assert str(said.why_no_uncertainty.values).endswith(": nothing is corrected")
    assert np.isnan(said.cone_factor_uncertainty)
    assert float(said.cone_factor) == FACTOR


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "given"),
    [
        (ConeInOwnClay, MEASURABLE),
        (TBarInOwnClay, SHORT_BAR),
        (TBarInOwnClay, SHORT_BAR | {"uncertainty": "measured"}),
        (SoundingInOwnClay, {"cells_per_radius": 1.5, "to_depth": 1.05}),
    ],
)
def test_a_scene_of_ones_own_states_no_u_and_makes_no_further_runs(
    kind: type[Any], given: dict[str, Any]
) -> None:
    result = kind(**given).run()
    assert str(result.why_no_uncertainty.values).startswith(not_of_catalogue(kind))
    assert str(result.built_law.values) == f"{__name__}.OwnClay"
    assert not {"uncertainty_run_time", "resistance_factor_exact"} & set(result)
    u = next(it for it in result if str(it).endswith("_uncertainty"))
    assert np.isnan(result[u]).all()


@pytest.mark.parametrize(
    ("clay", "of_cones", "of_others"),
    [
        ({}, "", ""),
        ({"material": "von_mises"}, "", ""),
        ({"remoulded_strength_ratio": 0.1, "ductility": 9.1}, "", ""),
        ({"remoulded_strength_ratio": 0.1, "ductility": 8.9}, "so brittle", "so brittle"),
        ({"remoulded_strength_ratio": 0.9, "ductility": 0.9}, "so brittle", "so brittle"),
        ({"material": "modified_cam_clay"}, "", "in modified_cam_clay"),
        (DIRECTED, "", "in anisotropic"),
        (
            DIRECTED | {"remoulded_strength_ratio": 0.5, "ductility": 10.0},
            "in Anisotropic clay whose",
            "in Anisotropic clay whose",
        ),
    ],
)
def test_further_runs_measure_the_error_in_clay_of_laws_that_were_tried(
    clay: dict[str, Any], of_cones: str, of_others: str
) -> None:
    """Up to a (1 - delta) / xi_95 of 0.1."""
    material = ConePenetration(**clay).build().material
    for laws, said in ((built.LAWS_OF_CONES, of_cones), (built.MEASURED_LAWS, of_others)):
        reasons = built.why_law_not_measured(material, laws)
        assert bool(reasons) == bool(said)
        assert said in "".join(reasons)
