"""A study of a scene to which a law of another package adds parameters."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from harness.study import study as studies
from harness.study.description import unusual_values
from mpm_warp.parameters import parameter
from mpm_warp.scenes.material.material_point import MaterialPoint
from tests.harness.conftest import study_in

STUDY = 'title = "t"\nscene = "material_point"\n'


@dataclass(frozen=True, kw_only=True)
class WithLaw(MaterialPoint):
    """The scene where a package with a law is installed."""

    of_other_laws: ClassVar[tuple[str, ...]] = ("yield_stress",)

    yield_stress: float | None = parameter(None, "yield stress of my_law", unit="Pa", above=0.0)

    def _check_other_laws(self) -> None:
        """Here the law of the scene has it."""


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Installs the package."""
    monkeypatch.setattr(studies, "scene_class", lambda name: WithLaw)


def test_a_case_without_the_law_keeps_its_name(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    (before,) = study_in(tmp_path, STUDY).cases
    request.getfixturevalue("installed")
    (after,) = study_in(tmp_path, STUDY).cases
    assert after.key == before.key


@pytest.mark.usefixtures("installed")
def test_its_parameters_are_varied_and_name_the_case(tmp_path: Path) -> None:
    study = study_in(tmp_path, STUDY + "[vary]\nyield_stress = [2e4, 3e4]\n")
    assert [case.parameters["yield_stress"] for case in study.cases] == [2e4, 3e4]
    assert len({case.key for case in study.cases}) == 2


@pytest.mark.usefixtures("installed")
def test_a_stress_that_looks_like_kilopascals_is_told(tmp_path: Path) -> None:
    (line,) = unusual_values(study_in(tmp_path, STUDY + "[fixed]\nyield_stress = 20\n"))
    assert line == "yield_stress = 20 is in Pa; if 20 kPa is meant, give 20000"
