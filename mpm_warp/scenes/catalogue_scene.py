"""The base class of all scenes."""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import xarray as xr

from mpm_warp.errors import SceneError
from mpm_warp.execution.execution import Execution
from mpm_warp.fields.checked import check_fields, compose
from mpm_warp.fields.checks import check_kind, check_known
from mpm_warp.fields.declaration import Value, groups_of, holders_of, own_parameters_of
from mpm_warp.fields.flat import check_names, nested_values, parameters_of
from mpm_warp.plan.plan import SMALLER_STEP, Plan
from mpm_warp.planning import make_plan
from mpm_warp.provenance import provenance, sources_of
from mpm_warp.results import check_results, material_as_built, parameter_variables
from mpm_warp.scenes.limits import Limits, check_limits, with_limits
from mpm_warp.scenes.run_size import RunSize, size_in_grid
from mpm_warp.scenes.shown import ShownByParameters
from mpm_warp.scenes.verification import Verification
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots

Progress = Callable[[float], None]
"""Function that a run calls now and then with the fraction done, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class CatalogueScene(ShownByParameters, ABC):
    """A scene, which has a name and parameters and can be run.

    A subclass is a frozen dataclass with keyword-only fields, its parameters, each made by
    `mpm_warp.parameter`. It builds a composition (`build`) and records its run
    (`record`).

    Raises:
        mpm_warp.errors.ParameterError: on construction, where a name is unknown or a value is not
            allowed.

    Example:
        >>> test = ConePenetration(rigidity_index=150)
        >>> test.catalogue_name(), test.rigidity_index, test.adhesion_factor
        ('cone_penetration', 150.0, 0.0)
        >>> ConePenetration(rigidity_indx=150)
        Traceback (most recent call last):
            ...
        mpm_warp.errors.ParameterError: ...did you mean 'rigidity_index'?
    """

    summary: ClassVar[str]
    """One line: what the scene simulates."""
    version: ClassVar[int] = 1
    """Raised whenever the same parameters no longer give the same numbers."""
    runs_alone: ClassVar[bool] = False
    """Whether its results measure the machine, so that no other case may run beside it."""
    method: ClassVar[tuple[str, ...]] = ()
    """Parameters of the method. They change the headline only by the numerical error."""
    verifications: ClassVar[tuple[Verification, ...]] = ()
    """Comparisons with the exact solution; the results then have a variable `error`."""
    limits: ClassVar[Limits] = {}
    """Limits of errors and balances among the results; beyond one the run is inaccurate."""
    comparable: ClassVar[str | None] = None
    """Result that is compared with published values, such as ``cone_factor``; or None."""
    snapshots_over: ClassVar[str | None] = None
    """Parameter with the length of a run, over which snapshots are taken; or None."""

    def __init_subclass__(cls, **options: object) -> None:
        """Give each scene the `__init__` below, in place of the one that `dataclass` makes."""
        super().__init_subclass__(**options)
        cls.__init__ = CatalogueScene.__init__  # type: ignore[method-assign]

    def __init__(self, **given: Any) -> None:
        """Take parameters by their flat names, and whole groups of them by those of their fields.

        An unknown name is refused, and another suggested.
        """
        flat = [name for name in given if name not in groups_of(type(self))]
        check_names(type(self), flat, own_parameters_of(type(self)))
        compose(self, given)
        self.__post_init__()

    def __post_init__(self) -> None:
        check_fields(self, self.derived)

    def __getattr__(self, name: str) -> Any:
        """A parameter of one of the groups."""
        holders = holders_of(type(self))
        if name not in holders:
            object.__getattribute__(self, name)  # raises again, also what a property raised
        return getattr(getattr(self, holders[name]), name)

    @classmethod
    def catalogue_name(cls) -> str:
        """Name in the catalogue: cone_penetration for ConePenetration."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """The scene from values in flat form, where a law has "material.its_parameter"."""
        return cls(**nested_values(cls, values))

    @property
    def likely_failure(self) -> str:
        """Why the run is likely to fail, and what to change; "" where no cause is known."""
        return ""

    @classmethod
    def replaced(cls, parameters: Mapping[str, Value | None]) -> Collection[str]:
        """Parameters that have no effect beside the given ones, which replace them."""
        return ()

    def derived(self) -> Mapping[str, float]:
        """Default values of parameters that depend on other parameters."""
        return {}

    @abstractmethod
    def build(self) -> Any:
        """The composition that is simulated: soil in a grid, bodies, or another kind."""

    @property
    def end_time(self) -> float | None:
        """Simulated time of a run of soil in a grid [s]; None where it is not known."""
        return None

    def run_size(self) -> RunSize | None:
        """The size of the run, found without a simulation; None where all runs are small.

        Raises:
            mpm_warp.errors.SceneError: the run has more steps than can be counted.
        """
        return None if self.end_time is None else size_in_grid(self.build(), self.end_time)

    @property
    def loads_solvers(self) -> bool:
        """Whether its results need solvers of SciPy, which take memory once they are loaded."""
        return False

    def plan(self) -> Plan:
        """The arrays and launches of a run."""
        return make_plan(self.build())

    def step_count_bound(self, plan: Plan) -> int | None:
        """Largest possible number of steps of a run of `plan`; None where it is not known."""
        if self.end_time is None or plan.control is not None:
            return None
        return math.ceil(self.end_time / plan.time_step)

    def run(
        self,
        progress: Progress | bool | None = None,
        execution: Execution | None = None,
        snapshots: Snapshots | None = None,
    ) -> xr.Dataset:
        """Simulate the scene.

        Args:
            progress: True for a bar on the terminal or in Jupyter; or a function, which is called
                now and then with the fraction done: with 0 before the first step, 1 at the end.
            execution: device and threads; default: one thread of the processor.
            snapshots: snapshots to take during the run; they do not change any result.

        Returns:
            Curves, scalars, computing cost and all parameters. Each variable has the attributes
            `units` and `long_name`. Variables other than ordinary results have the attribute
            `role`, one of `mpm_warp.results.ROLES`. A parameter with the name of a result is called
            ``<name>_parameter``. Attributes say what was run, where, when and by which code, with
            `source` and `history` of the CF conventions.

        Raises:
            mpm_warp.errors.SimulationDiverged: the run became unstable; its `curves` hold what was
                recorded until then.
            mpm_warp.errors.InaccurateRun: the run ended, but its result is not reliable.
            mpm_warp.errors.UnfinishedRun: the run ended too early, for example before a steady
                resistance.
            mpm_warp.errors.SceneError: the scene takes no snapshots, or has more steps than can be
                counted.
        """
        check_kind(f"{type(self).__name__}.summary", getattr(type(self), "summary", None), str)
        self.run_size()
        check_kind("execution", execution, (Execution, type(None)))
        check_kind("snapshots", snapshots, (Snapshots, type(None)))
        provenance()  # reads the commit now, because sources may be edited while the scene runs
        sources = sources_of(self, self.build())
        with _reporter(progress, self.catalogue_name()) as report:
            if snapshots is None:
                results = self.compute(report, execution)
            else:
                results = self.compute_with_snapshots(report, execution, snapshots)
            report(1.0)
        check_kind(f"{type(self).__name__}.record()", results, xr.Dataset)
        check_results(results)
        results = self.checked(results)
        parameters = parameter_variables(self, {*results.variables, *results.dims})
        if "material" in parameters and "built_law" in results:
            asked = parameters["material"]
            named = material_as_built(str(asked.values), str(results["built_law"].values))
            parameters["material"] = asked.copy(data=np.array(named))
        return results.assign(parameters).assign_attrs(
            {
                "title": self.summary,
                "scene": self.catalogue_name(),
                "scene_version": self.version,
                **provenance(),
                "device": (execution or Execution()).device,
                "sources": sources,
            }
        )

    def checked(self, results: xr.Dataset) -> xr.Dataset:
        """The results with their limits; `InaccurateRun` where one is beyond its limit."""
        limits = self.limits_of_run
        results = with_limits(limits, results)
        check_limits(limits, results)
        return results

    @property
    def limits_of_run(self) -> Limits:
        """The `limits` that hold with these parameters."""
        return self.limits

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """The results of a run without the parameters; arguments as of `run`.

        A scene that does more than run one simulation overrides it, and calls `progress` with 0
        once all is compiled.
        """
        simulation = Simulation(self.build(), execution)
        plan, instead = simulation.plan, self._instead_of_smaller_steps
        plan.remedy = plan.remedy.replace(SMALLER_STEP, instead)
        progress(0.0)  # all is set up and compiled
        return self.record(simulation, progress)

    @property
    def _instead_of_smaller_steps(self) -> str:
        """Remedy for a run that diverges: smaller steps, or else parameters of the method."""
        known = parameters_of(type(self))
        numbers = [name for name in self.method if known[name].kind is not str]
        if "time_step_fraction" in known or not numbers:
            return SMALLER_STEP
        return f"try another {' or '.join(numbers)}"

    def compute_with_snapshots(
        self, progress: Progress, execution: Execution | None, snapshots: Snapshots
    ) -> xr.Dataset:
        """Results as of `compute`, with snapshots; only in a scene with `snapshots_over`."""
        raise SceneError(f"{self.catalogue_name()}: takes no snapshots")

    @abstractmethod
    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Run a simulation of what `build` gives, and return its results."""


@contextmanager
def _reporter(progress: Progress | bool | None, name: str) -> Iterator[Progress]:
    """The function that receives the progress of a run: the one given, a bar, or none."""
    if callable(progress):
        yield progress
        return
    check_known("progress", progress, (True, False, None))
    if not progress:  # a hidden bar would still have a semaphore, which a killed worker leaves
        yield lambda fraction: None
        return
    from tqdm.auto import tqdm  # takes a while: it finds out whether Jupyter shows the bar

    layout = "{desc} {percentage:3.0f} % |{bar}| {elapsed} < {remaining}"
    with tqdm(desc=name, total=1.0, bar_format=layout) as bar:

        def show(fraction: float) -> None:
            bar.update(fraction - bar.n)

        yield show
