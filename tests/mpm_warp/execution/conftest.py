"""What the tests of shared steps have in common."""

import pytest

import mpm_warp.execution.threads
from mpm_warp.execution.replay import ThreadChoice


@pytest.fixture
def all_take_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """All threads share the steps, with dynamic chunks, even where one thread would be faster."""
    monkeypatch.setattr(mpm_warp.execution.threads, "DYNAMIC_FROM", 1000)
    monkeypatch.setattr(ThreadChoice, "choose", lambda self, wanted: wanted)
    monkeypatch.setattr(ThreadChoice, "note", lambda self, threads, step_count, seconds: None)
