"""What the tests of shared steps have in common."""

import pytest

from mpm_warp import ConePenetration, ThickCylinder
from mpm_warp.execution.replay import ThreadChoice

CONE = ConePenetration(
    cells_per_radius=4, domain_radius=10, domain_above=4, domain_below=4, adhesion_factor=0.5
)
FEW_ROWS = ThickCylinder(cell_count=120)


@pytest.fixture
def all_take_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """All threads share the steps, even where one thread would be faster."""
    monkeypatch.setattr(ThreadChoice, "choose", lambda self, *wanted: wanted)
    monkeypatch.setattr(ThreadChoice, "note", lambda self, threads, step_count, seconds: None)
