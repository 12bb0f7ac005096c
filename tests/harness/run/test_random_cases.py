"""Cases with random parameters over all that is allowed: each ends, with a result or a reason.

With ``--deep`` and cold kernels that takes longer than the suite lets a test take: add ``-o
faulthandler_timeout=0``.
"""

import dataclasses
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
from mpm_warp import CatalogueScene, ParameterError, SceneError, scene_class, scene_names
from mpm_warp.fields import Parameter, Value, parameters_of
from tests.harness.conftest import Depth

from .conftest import Record

pytestmark = pytest.mark.slow

SECONDS, BYTES = 2.0, 1.5e9
"""What a case may take of time and of memory."""
NAMED = {COMPLETED, "refused", "diverged", "inaccurate", "unfinished", "timed_out"}
"""How a case may end; `failed` and `crashed` are errors of the program."""
WIDE = 1e3
"""Ratio to the default of what has no bound."""


def drawn(source: random.Random, definition: Parameter) -> Value | None:
    """A value of a parameter, by its logarithm where its range is wide."""
    if definition.choices is not None:
        return source.choice(definition.choices)
    default = definition.default
    bounds = definition.bounds
    low, high = max(bounds.minimum, bounds.above), min(bounds.maximum, bounds.below)
    is_bounded = math.isfinite(low) and math.isfinite(high)
    if definition.kind is str or (default is None and not is_bounded):
        return default
    size = abs(float(default or 1.0))
    low = low if math.isfinite(low) else size / WIDE
    high = high if math.isfinite(high) else max(size, low) * WIDE
    inside = 1e-6 * (high - low)
    low, high = low + inside * (low == bounds.above), high - inside * (high == bounds.below)
    if low > 0.0 and high / low > 100.0:
        number = low * math.exp(source.uniform(0.0, math.log(high / low)))
    else:
        number = source.uniform(low, high)
    number = min(max(number, low), high)
    return round(number) if definition.kind is int else number


def random_scene(source: random.Random, name: str) -> CatalogueScene:
    """A scene with random parameters.

    What it refuses together is drawn again, each time with some more at their defaults: of a
    sounding few combinations are allowed.
    """
    scene, share = scene_class(name), 1.0
    while True:
        known = {key: it for key, it in parameters_of(scene).items() if source.random() < share}
        try:
            made = scene(**{key: drawn(source, it) for key, it in known.items()})
            made.run_size()
        except (ParameterError, SceneError):
            share *= 0.9
        else:
            return made


def random_cases(count: int) -> list[Case]:
    """Cases of all scenes in turn."""
    source, cases = random.Random(23), list[Case]()
    names = sorted(scene_names(), key=lambda name: source.random())
    for name in itertools.islice(itertools.cycle(names), count):
        made = random_scene(source, name)
        complete = dataclasses.asdict(made)
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
