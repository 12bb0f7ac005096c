from __future__ import annotations

import pytest

from harness.study.description import unusual_values
from harness.study.files import study_names
from harness.study.study import load_study


@pytest.mark.parametrize("name", study_names())
def test_no_study_that_ships_has_a_value_that_looks_like_a_slip(name: str) -> None:
    assert unusual_values(load_study(name)) == []
