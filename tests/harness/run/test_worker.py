"""A case in a worker: how it ends where its scene raises an exception."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import pytest

from harness.archive import case_files
from harness.run.worker import run_case
from harness.study.study import Study
from mpm_warp.scene import SceneError
from mpm_warp.scenes.cone.cone_penetration import ConePenetration


def test_an_exception_of_the_scene_is_the_outcome(
    tmp_path: Path, small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(scene: object, progress: object, execution: object) -> NoReturn:
        raise ArithmeticError("on\ntwo lines")

    monkeypatch.setattr(ConePenetration, "run", fail)
    case = small.cases[0]
    outcome = run_case(case, tmp_path)
    assert (outcome.status, outcome.message) == ("failed", "ArithmeticError: on two lines")
    result = case_files.read_case(tmp_path, case)
    assert result is not None
    assert result.attrs["message"] == outcome.message


def test_an_exception_may_name_the_status(
    tmp_path: Path, small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    class DivergedError(Exception):
        status = "diverged"

    def diverge(scene: object, progress: object, execution: object) -> NoReturn:
        raise DivergedError("too fast")

    monkeypatch.setattr(ConePenetration, "run", diverge)
    assert run_case(small.cases[0], tmp_path).status == "diverged"


def test_a_scene_that_can_not_be_made_is_refused(
    tmp_path: Path, small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(scene: object, progress: object, execution: object) -> NoReturn:
        raise SceneError("bodies 0 and 1 overlap")

    monkeypatch.setattr(ConePenetration, "run", refuse)
    outcome = run_case(small.cases[0], tmp_path)
    assert (outcome.status, outcome.message) == ("refused", "SceneError: bodies 0 and 1 overlap")
