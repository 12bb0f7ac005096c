"""Studies that are run in worker processes, and how their cases end."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
import xarray as xr

from harness.archive.case_files import Outcome
from harness.archive.collection import collect
from harness.run.pool import Watcher, run_cases
from harness.run.resources import DEFAULTS, RunOptions
from harness.study.cases import Case
from harness.study.study import Study
from tests.harness.conftest import prepared


@pytest.fixture
def stub_folder(stub: Study, tmp_path: Path) -> Path:
    """Where the results of these cases are kept."""
    return prepared(stub, tmp_path)


class Record:
    """A watcher that remembers the outcomes, by the cases' keys.

    Args:
        act: what else it does when a case advances.
    """

    def __init__(self, act: Callable[[Case, float], object] = lambda case, fraction: None) -> None:
        self.act = act
        self.outcomes: dict[str, Outcome] = {}

    def advanced(self, case: Case, fraction: float) -> None:
        assert 0 <= fraction <= 1
        self.act(case, fraction)

    def finished(self, case: Case, outcome: Outcome) -> None:
        assert case.key not in self.outcomes
        self.outcomes[case.key] = outcome

    def statuses(self, cases: Iterable[Case]) -> list[str]:
        """How each of some cases has ended."""
        return [self.outcomes[case.key].status for case in cases]


def kill_workers(number: int = signal.SIGKILL) -> None:
    """Kill all workers of this process by a signal."""
    for worker in multiprocessing.active_children():
        assert worker.pid is not None
        os.kill(worker.pid, number)


def run(
    study: Study, out: Path, workers: int, watcher: Watcher, options: RunOptions = DEFAULTS
) -> xr.Dataset:
    """Run a study in `out` and collect it."""
    folder = prepared(study, out)
    run_cases(study.cases, folder, workers, watcher, options)
    return collect(study, folder)
