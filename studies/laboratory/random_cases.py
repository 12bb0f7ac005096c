"""How random cases of all scenes end, over all that their parameters may be.

``random_cases COUNT SEED`` draws so many cases that take about a second or less,
each scene in turn, and runs them in worker processes as a study does, with a limit of time and
memory. It prints how the cases of each scene have ended, and every one that ended as none should:
the program failed, the process was lost or hung, or a number called complete is not finite.
"""

import dataclasses
import itertools
import math
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from harness.archive.case_files import Outcome, read_case
from harness.archive.conventions import COMPLETED, Role, with_role
from harness.run.pool import run_cases
from harness.run.resources import UPDATE_RATE, RunOptions
from harness.study.cases import Case
from mpm_warp import CatalogueScene, ParameterError, SceneError, StepCost, scene_class, scene_names
from mpm_warp.fields.declaration import Parameter, Value, own_parameters_of
from mpm_warp.fields.flat import values_of
from mpm_warp.scenes.step_cost import LEAST_STEPS

SECONDS, STEPS = 1.0, 30_000
"""Predicted time and steps of a case, at most."""
SHARE, DRAWS = 0.15, 200
"""Share of the parameters of a case that is drawn anew while the case is too long, and how often
that is tried before another case is drawn."""
TIME_LIMIT, MEMORY_LIMIT = 60.0, 1.5e9
"""What a case may take, first runs of kernels included [s], [byte]."""


NAMED = {COMPLETED, "refused", "diverged", "inaccurate", "unfinished", "timed_out"}
"""How a case may end; `failed` and `crashed` are errors of the program."""
WIDE = 1e3
"""Ratio to the default of what has no bound."""


def drawn(source: random.Random, definition: Parameter) -> Value | None:
    """A value of a parameter, by its logarithm where its range is wide."""
    if definition.choices is not None:
        return source.choice(definition.choices)
    default: Value | None = definition.default
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
        known = {key: it for key, it in own_parameters_of(scene).items() if source.random() < share}
        try:
            made = scene(**{key: drawn(source, it) for key, it in known.items()})
            made.run_size()
        except (ParameterError, SceneError):
            share *= 0.9
        else:
            return made


def excess_of(scene: CatalogueScene) -> float:
    """Predicted time or steps of a case over what it may have."""
    size = scene.run_size()
    assert size is not None
    seconds = size.particle_updates / UPDATE_RATE
    if isinstance(scene, StepCost):  # it is told how long to measure, and takes some steps at least
        least = LEAST_STEPS * size.particle_count / UPDATE_RATE
        seconds = scene.samples * max(scene.sample_time, least)
    return max(seconds / SECONDS, size.step_count / STEPS)


def short_case(source: random.Random, name: str) -> Case:
    """A random case that is short enough: of a long one some parameters are drawn anew.

    What makes it shorter is kept, so that what costs no time is as random as ever.
    """
    known = own_parameters_of(scene_class(name)).items()
    while True:
        scene = random_scene(source, name)
        excess = excess_of(scene)
        for _ in range(DRAWS):
            if excess <= 1.0:
                values, version = values_of(scene), scene.version
                return Case(scene=name, scene_version=version, parameters=values, label=name)
            anew = {key: drawn(source, it) for key, it in known if source.random() < SHARE}
            try:
                other = dataclasses.replace(scene, **anew)
                excess_of_other = excess_of(other)
            except (ParameterError, SceneError):
                continue
            if excess_of_other < excess:
                scene, excess = other, excess_of_other


class Counts:
    """A watcher that counts outcomes by scene, and tells of those that should not be."""

    def __init__(self, folder: Path) -> None:
        self.of = Counter[tuple[str, str]]()
        self.wrong = 0
        self._folder = folder

    def advanced(self, case: Case, fraction: float) -> None:
        """Nothing is told of cases at work."""

    def finished(self, case: Case, outcome: Outcome) -> None:
        """Count a case."""
        self.of[case.scene, outcome.status] += 1
        sound = outcome.status in NAMED and (
            outcome.status != COMPLETED or self._is_finite(case, outcome)
        )
        if not sound:
            self.wrong += 1
            print(f"WRONG {case.scene}: {outcome}: {dict(case.parameters)}", flush=True)
        elif outcome.status == "timed_out":
            print(f"timed out: {case.scene}: {dict(case.parameters)}", flush=True)

    def _is_finite(self, case: Case, outcome: Outcome) -> bool:
        if outcome.message:
            return outcome.message == "by another run"
        result = read_case(self._folder, case)
        assert result is not None
        headlines = [result[name] for name in with_role(result, Role.HEADLINE)]
        return bool(headlines) and all(np.isfinite(it).all() for it in headlines)


def main() -> None:
    """Draw, run and count."""
    count, seed = int(sys.argv[1]), sys.argv[2]
    source, names = random.Random(seed), sorted(scene_names())
    cases = {
        case.key: case
        for name in itertools.islice(itertools.cycle(names), count)
        for case in [short_case(source, name)]
    }
    with tempfile.TemporaryDirectory() as folder:
        counts = Counts(Path(folder))
        options = RunOptions(threads=1, time_limit=TIME_LIMIT, memory_limit=MEMORY_LIMIT)
        run_cases(list(cases.values()), Path(folder), 1, counts, options)
    statuses = sorted({status for _, status in counts.of})
    print(f"{'scene':24}", *(f"{status:>11}" for status in statuses))
    for name in [*names, "all"]:
        row = [
            sum(
                n for (scene, it), n in counts.of.items() if it == status and name in (scene, "all")
            )
            for status in statuses
        ]
        print(f"{name:24}", *(f"{n:11}" for n in row))
    print(f"{len(cases)} cases, {counts.wrong} ended as none should")


if __name__ == "__main__":
    main()
