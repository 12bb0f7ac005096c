"""What the tests of shared steps have in common."""

import pytest

from mpm_warp.execution.replay import ThreadChoice


@pytest.fixture
def all_take_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """All threads share the steps, even where one thread would be faster."""
    monkeypatch.setattr(ThreadChoice, "choose", lambda self, wanted: wanted)
    monkeypatch.setattr(ThreadChoice, "note", lambda self, threads, step_count, seconds: None)
