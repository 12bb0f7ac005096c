"""What every ready scene offers: parameters as fields, a summary, a run that gives a dataset."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from mpm_warp.parameters import Value, check_parameters

if TYPE_CHECKING:
    import xarray

    from mpm_warp.execution.execution import Execution
    from mpm_warp.plan.plan import StepPlan
    from mpm_warp.scene import Scene

Progress = Callable[[float], None]
"""Called now and then during a run with the fraction done, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class Verification:
    """How a scene is held against its exact solution.

    Attributes:
        resolution: name of the parameter that refines the solution.
        resolutions: its values, rising; the bounds hold for the last.
        bounds: scalars of the result and what they may reach at most.
        least_order: least observed order of the variable `error` in the resolution, or none.
        settings: parameters that differ from their defaults.
        extreme: whether it shows how far the method holds, a long run or a violent one, and is
            left out unless asked for.
    """

    resolution: str
    resolutions: tuple[int, ...]
    bounds: Mapping[str, float]
    least_order: float | None = None
    settings: Mapping[str, Value] = field(default_factory=dict)
    extreme: bool = False


@dataclass(frozen=True, kw_only=True)
class ReadyScene(ABC):
    """A scene that can be named, parametrised and run; subclasses add parameters as fields.

    Raises:
        mpm_warp.parameters.ParameterError: on construction, where a value is not allowed.
    """

    summary: ClassVar[str]
    """One line on what the scene simulates."""
    version: ClassVar[int]
    """Raised whenever the same parameters no longer give the same numbers."""
    headline: ClassVar[str] = "error"
    """The scalar result that the scene is run for."""
    runs_alone: ClassVar[bool] = False
    """Whether its results measure the machine, so that no other case may run beside it."""
    method: ClassVar[tuple[str, ...]] = ()
    """Parameters of the method alone: without its error, the headline would not depend on them."""
    verifications: ClassVar[tuple[Verification, ...]] = ()
    """Comparisons with the exact solution, where there is one: its results hold `error`."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if "run" in vars(cls):
            cls.run = _with_roles(cls.run)  # type: ignore[method-assign]

    def __post_init__(self) -> None:
        check_parameters(self)

    def simulated_scene(self) -> Scene | None:
        """What the simulator runs where soil fills a grid; None otherwise."""
        return None

    def plan(self) -> StepPlan | None:
        """What a run consists of; None where it runs no grid."""
        from mpm_warp.planning import make_plan

        scene = self.simulated_scene()
        return None if scene is None else make_plan(scene)

    def step_count_bound(self, plan: StepPlan) -> int | None:
        """Steps of a run of `plan` at most; None where that is not known beforehand."""
        return None

    @abstractmethod
    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """Simulate the scene.

        Args:
            progress: is told the fraction done now and then.
            execution: where and on how many threads; default: one thread of the processor.

        Returns:
            One dataset of scalars and curves, each with ``units`` and ``long_name``.

        Raises:
            mpm_warp.watch.health.SimulationDiverged: the run became unstable; its `history` holds the
                curves up to there, where the scene records any.
        """


_MEASURED = {
    *("run_time", "setup_time", "compile_time", "update_rate", "update_rate_lowest"),
    *("update_rate_highest", "thread_gain", "core_gain", "bare_step_gain", "overhead_share"),
    *("stage_time", "stage_bytes", "stage_operations", "stage_divisions", "streaming_rate"),
    *("arithmetic_rate", "division_rate"),
}


def _with_roles(run: Any) -> Any:
    """Stand-in for scenes whose variables carry their roles; dropped at the merge."""

    @functools.wraps(run)
    def wrapped(self: Any, *arguments: Any, **options: Any) -> Any:
        try:
            result = run(self, *arguments, **options)
        except Exception as error:
            error.curves = getattr(error, "history", None)  # type: ignore[attr-defined]
            raise
        for name, it in result.variables.items():
            if name == self.headline:
                it.attrs["role"] = "headline"
            elif name in _MEASURED:
                it.attrs["role"] = "measured"
            elif name.endswith("_exact"):
                it.attrs["role"] = "exact"
                it.attrs["exact_of"] = name.removesuffix("_exact")
            elif name.endswith("error") and not it.ndim:
                it.attrs["role"] = "error"
            if name == "energy_error" and self.headline == "cone_factor":
                it.attrs["limit"] = 0.05
        return result

    return wrapped
