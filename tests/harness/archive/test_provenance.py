"""The digest of the sources that compute a scene."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

import mpm_warp
from harness.archive.provenance import sources_digest


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A simulator of two files."""
    package = tmp_path / "mpm_warp"
    (package / "step").mkdir(parents=True)
    (package / "scene.py").write_text("a = 1\n")
    (package / "step" / "momentum.py").write_text("b = 1\n")
    monkeypatch.setattr(mpm_warp, "__path__", [str(package)])
    return package


def digest(scene: type = object) -> str:
    """What a fresh process finds."""
    sources_digest.cache_clear()
    try:
        return sources_digest(scene)
    finally:
        sources_digest.cache_clear()


def test_every_source_of_the_simulator_counts_and_nothing_else(sources: Path) -> None:
    before = digest()
    assert len(before) == 16
    (sources / "notes.md").write_text("of no matter")
    assert digest() == before
    (sources / "step" / "momentum.py").write_text("b = 2\n")
    changed = digest()
    (sources / "step" / "momentum.py").rename(sources / "momentum.py")
    moved = digest()
    (sources / "added.py").touch()
    assert len({before, changed, moved, digest()}) == 4


def test_the_module_of_a_scene_of_another_package_counts(
    sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "dam.py"
    file.write_text("height = 1\n")
    module = ModuleType("dam")
    module.__file__ = str(file)
    monkeypatch.setitem(sys.modules, "dam", module)
    scene = type("Dam", (), {"__module__": "dam"})
    before = digest(scene)
    assert before != digest()
    file.write_text("height = 2\n")
    assert digest(scene) not in (before, digest())
