"""Cases with random parameters over all that is allowed: each ends, with a result or a reason.

With ``--deep`` and cold kernels that takes longer than the suite lets a test take: add ``-o
faulthandler_timeout=0``.
"""

import itertools
import math
import random
import re
from pathlib import Path

import pytest

from harness.archive.case_files import read_case
from harness.archive.conventions import COMPLETED
from harness.run.pool import run_cases
from harness.run.resources import RunOptions
from harness.study.cases import Case
from mpm_warp import scene_names
from mpm_warp.fields.flat import values_of
from studies.laboratory.random_cases import NAMED, random_scene
from tests.harness.conftest import Depth

from .conftest import Record

pytestmark = pytest.mark.slow

SECONDS, BYTES = 1.0, 1.5e9
"""What a case may take of time and of memory."""


def random_cases(count: int) -> list[Case]:
    """Cases of all scenes in turn."""
    source, cases = random.Random(23), list[Case]()
    names = sorted(scene_names(), key=lambda name: source.random())
    for name in itertools.islice(itertools.cycle(names), count):
        made = random_scene(source, name)
        complete = values_of(made)
        label = ", ".join(f"{key}={value}" for key, value in complete.items())
        cases.append(Case(scene=name, scene_version=made.version, parameters=complete, label=label))
    return cases


def test_a_random_case_ends_with_a_result_or_with_a_reason(tmp_path: Path, depth: Depth) -> None:
    cases, record = random_cases(depth(6, 100)), Record()
    options = RunOptions(threads=1, time_limit=SECONDS, memory_limit=BYTES)
    run_cases(cases, tmp_path, 1, record, options)
    assert len(record.outcomes) == len(cases)
    for case in cases:
        outcome = record.outcomes[case.key]
        what = f"{case.scene}: {case.label}: {outcome}"
        assert outcome.status in NAMED, what
        assert (outcome.status == COMPLETED) == (outcome.message == ""), what
        assert not re.search(r"Error|Exception|Traceback|Errno", outcome.message), what
        result = read_case(tmp_path, case)
        assert result is not None, what
        if "peak_memory" in result:
            assert result["peak_memory"] < BYTES, what


@pytest.mark.parametrize("name", scene_names())
def test_the_size_of_a_random_case_is_predicted_at_once(name: str) -> None:
    """Whatever is allowed has a size that is a number, and is told without being built."""
    source = random.Random(name)
    for _ in range(20):
        size = random_scene(source, name).run_size()
        assert 0.0 < size.byte_count < math.inf
        assert 0.0 <= size.step_count < math.inf
