"""Studies that are run in worker processes, and how their cases end."""

from collections.abc import Iterable
from pathlib import Path

import pytest
import xarray as xr

from harness.archive import case_files
from harness.archive import collection as archive
from harness.archive.atomic_files import prepare
from harness.archive.case_files import Outcome
from harness.run.pool import Watcher, run_cases
from harness.run.resources import RunOptions
from harness.study.cases import Case
from harness.study.study import Study, load_study


class Record:
    """A watcher that remembers the outcomes, by the cases' keys."""

    def __init__(self) -> None:
        self.outcomes: dict[str, Outcome] = {}

    def advanced(self, case: Case, fraction: float) -> None:
        assert 0 <= fraction <= 1

    def finished(self, case: Case, outcome: Outcome) -> None:
        assert case.key not in self.outcomes
        self.outcomes[case.key] = outcome

    def statuses(self, cases: Iterable[Case]) -> list[str]:
        """How each of some cases has ended."""
        return [self.outcomes[case.key].status for case in cases]


def prepared(study: Study, out: Path) -> Path:
    """The folder of a study's cases in `out`, ready to be written to."""
    folder = case_files.case_folder(out, study)
    prepare(folder)
    return folder


def run(study: Study, out: Path, workers: int, watcher: Watcher) -> xr.Dataset:
    """Run a study in `out` and collect it."""
    folder = prepared(study, out)
    run_cases(study.cases, folder, workers, watcher)
    return collected(study, folder)


def collected(study: Study, folder: Path) -> xr.Dataset:
    """What was computed."""
    return archive.collect(study, folder)


@pytest.fixture
def long_and_short(tmp_path: Path, small_file: Path) -> tuple[Path, Case, Case]:
    """The folder of two cases, and the cases: one that takes minutes, one that is soon done.

    The kernels are there, for a case alone and for two together: to compile them takes time too.
    """
    settings = ["adhesion_factor=0", "penetration=5", "speed_ratio=[0.0001, 0.03, 0.04]"]
    study = load_study(str(small_file), settings)
    long, *warm = study.cases
    folder = prepared(study, tmp_path)
    for batch in (1, 2):
        run_cases(warm, folder, 1, Record(), RunOptions(batch=batch))
        case_files.discard(folder, warm)
    return folder, long, warm[0]
