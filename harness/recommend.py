"""The cheapest settings, among results at hand, that reach an error."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness import HarnessError
from harness.archive import read_study
from harness.cases import COMPLETED
from harness.compare import varied_along
from harness.errors import error_name
from mpm_warp.scenes import scene_class


@dataclass(frozen=True, kw_only=True)
class Recommendation:
    """Settings of a scene, and what they were measured to cost and to be worth.

    Attributes:
        settings: parameters of the method that differ between the cases at hand.
        run_time: longest wall-clock time of the time loop, over all cases with them [s].
        error: greatest error of these cases, dimensionless.
        case_count: how many there are.
        file: the result that they are from.
    """

    settings: dict[str, float | str]
    run_time: float
    error: float
    case_count: int
    file: Path

    def __str__(self) -> str:
        text = ", ".join(f"{name} = {value}" for name, value in self.settings.items())
        cases = "case" if self.case_count == 1 else "cases"
        return (
            f"{text or 'default settings'}: error {self.error:.2%} and {self.run_time:.3g} s at "
            f"most, over {self.case_count} {cases} of {self.file}"
        )


def recommend(scene: str, largest_error: float, files: Iterable[Path]) -> Recommendation | None:
    """The cheapest settings whose error is at most `largest_error` in every case that has them.

    Args:
        scene: name of the scene.
        largest_error: dimensionless, > 0.
        files: results of studies; those of other scenes, or without errors, are passed over.

    Raises:
        HarnessError: no result of the scene has an error.
        harness.whole_files.ArchiveError: a file is damaged.
    """
    known = [it for file in files for it in _measured(scene, file)]
    if not known:
        raise HarnessError(f"{scene}: no result with errors is at hand; run a study of it first")
    good = [it for it in known if it.error <= largest_error]
    return min(good, key=lambda it: it.run_time, default=None)


def _measured(scene: str, file: Path) -> list[Recommendation]:
    dataset = read_study(file)
    name = error_name(dataset)
    if dataset.attrs.get("scene") != scene or name is None or "run_time" not in dataset:
        return []
    error = dataset[name]
    method = [it for it in varied_along(dataset, error.dims) if it in scene_class(scene).method]
    columns = [dataset[it].broadcast_like(error).values.ravel().tolist() for it in method]
    seconds = dataset["run_time"].broadcast_like(error).values.ravel()
    done = (dataset["status"].broadcast_like(error) == COMPLETED).values.ravel()
    groups: dict[tuple[float | str, ...], list[int]] = {}
    for case in range(error.size):
        groups.setdefault(tuple(column[case] for column in columns), []).append(case)
    found = []
    for values, cases in groups.items():
        errors = error.values.ravel()[cases]
        # The reference has no error of its own, and nothing is known of its settings by it.
        judged = np.isfinite(errors) | ~done[cases]
        if judged.any():
            worst = float(np.max(np.where(done[cases], errors, np.inf)[judged]))
            found.append(
                Recommendation(
                    settings=dict(zip(method, values, strict=True)),
                    run_time=float(np.nanmax(seconds[cases])) if done[cases].any() else np.inf,
                    error=worst,
                    case_count=len(cases),
                    file=file,
                )
            )
    return found
