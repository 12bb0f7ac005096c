"""What a scene of the catalogue is, and which scenes there are: those of this package, and others.

A scene can be named, parametrised, verified and run. It is a subclass of `CatalogueScene` without
abstract methods, in any module below `mpm_warp.scenes`. Its name is that of the class in small
letters, with underscores between the words: `ConePenetration` is "cone_penetration". A new scene is
one new file and nothing else.

Other packages offer scenes by the entry point group `mpm_warp.scenes`, in their pyproject.toml:

    [project.entry-points."mpm_warp.scenes"]
    pile_driving = "their_package.pile_driving:PileDriving"
"""

import functools
import importlib
import inspect
import math
import pkgutil
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, ClassVar, NoReturn, Self

import numpy as np
import xarray as xr
from tqdm import tqdm

from mpm_warp.arguments import check_kind, check_known, in_words
from mpm_warp.errors import ParameterError, SceneError, UnknownSceneError
from mpm_warp.execution.execution import Execution
from mpm_warp.parameters import Value, check_names, check_parameters, nearest_name, parameters_of
from mpm_warp.plan.plan import SMALLER_STEP, Plan
from mpm_warp.planning import make_plan
from mpm_warp.results import material_as_built, parameter_variables
from mpm_warp.scenes.run_size import RunSize, size_in_grid
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots

Progress = Callable[[float], None]
"""Called now and then during a run with the fraction done, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class Verification:
    """How a scene is compared with its exact solution.

    Attributes:
        resolution: name of the parameter that refines the solution.
        resolutions: its values, rising; the bounds hold for the last.
        bounds: scalars of the result and what they may reach at most.
        least_order: least observed order of the variable `error` in the resolution; None where no
            order is claimed.
        settings: parameters that differ from their defaults.
        extreme: whether it shows how far the method holds, in a long run or a violent one; such a
            check is made only on request.
    """

    resolution: str
    resolutions: tuple[int, ...]
    bounds: Mapping[str, float]
    least_order: float | None = None
    settings: Mapping[str, Value] = field(default_factory=dict)
    extreme: bool = False


def compared(
    resolution: str,
    resolutions: tuple[int, ...],
    *settings: Mapping[str, Value],
    least_order: float | None = None,
    extreme: bool = False,
    **bounds: float,
) -> tuple[Verification, ...]:
    """A `Verification` with each of the settings, or one with all by default; bounds by name."""
    by_default = Verification(
        resolution=resolution,
        resolutions=resolutions,
        bounds=bounds,
        least_order=least_order,
        extreme=extreme,
    )
    return tuple(replace(by_default, settings=of_one) for of_one in settings or ({},))


@dataclass(frozen=True, kw_only=True)
class CatalogueScene(ABC):
    """A scene that can be named, parametrised and run; its fields are its parameters.

    A subclass is a frozen dataclass with keyword-only fields, each made by
    `mpm_warp.parameters.parameter`. It builds a composition (`build`) and records its run
    (`record`).

    Raises:
        mpm_warp.errors.ParameterError: on construction, where a name is unknown or a value is not
            allowed.
    """

    summary: ClassVar[str]
    """One line on what the scene simulates."""
    version: ClassVar[int] = 1
    """Raised whenever the same parameters no longer give the same numbers."""
    runs_alone: ClassVar[bool] = False
    """Whether its results measure the machine, so that no other case may run beside it."""
    method: ClassVar[tuple[str, ...]] = ()
    """Parameters of the method alone: without its error, the headline would not depend on them."""
    verifications: ClassVar[tuple[Verification, ...]] = ()
    """Comparisons with the exact solution, where there is one: its results hold `error`."""
    comparable: ClassVar[str | None] = None
    """Result that published values can be set beside, as ``cone_factor``; or none."""
    of_other_laws: ClassVar[tuple[str, ...]] = ()
    """Parameters of laws of other packages; None where `material` names another law."""
    snapshots_over: ClassVar[str | None] = None
    """Parameter that says how far a run goes at most, over which snapshots are taken; or none."""

    def __new__(cls, **values: object) -> Self:
        """Refuse an unknown name with what to give instead, which `__init__` would not say."""
        check_names(cls, values)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        check_parameters(self, self.derived)

    def refuse(self, name: str, why: str) -> NoReturn:
        """Raise `ParameterError` for a parameter's value: "name = value is not allowed" and why."""
        value = in_words(getattr(self, name))
        raise ParameterError(name, f"{name} = {value} is not allowed{why}")

    @classmethod
    def catalogue_name(cls) -> str:
        """Name in the catalogue: that of the class as cone_penetration is of ConePenetration."""
        return re.sub(r"(?<!^)(?=[A-Z])", "_", cls.__name__).lower()

    @classmethod
    def offered(cls) -> "type[CatalogueScene]":
        """The class that the catalogue offers; a scene may add parameters to what it is itself."""
        return cls

    @property
    def likely_failure(self) -> str:
        """Why a run is likely not to complete, and what to change; "" where no cause is known."""
        return ""

    @classmethod
    def replaced(cls, parameters: Mapping[str, Value | None]) -> Collection[str]:
        """Parameters that say nothing beside the others: these take their place."""
        return ()

    def derived(self) -> Mapping[str, float]:
        """Values of the parameters that are worked out from others where none is given."""
        return {}

    @abstractmethod
    def build(self) -> Any:
        """The composition that is simulated: of soil in a grid, of bodies, or of another kind."""

    @property
    def end_time(self) -> float | None:
        """Simulated time from start to end of soil in a grid [s]; None where it is not known."""
        return None

    def run_size(self) -> RunSize | None:
        """How large a run is, worked out at once; None where any that is allowed is small.

        Raises:
            mpm_warp.errors.SceneError: it has more steps than can be counted.
        """
        return None if self.end_time is None else size_in_grid(self.build(), self.end_time)

    @property
    def loads_solvers(self) -> bool:
        """Whether what it gives needs solvers of SciPy, which take memory once they are loaded."""
        return False

    def plan(self) -> Plan:
        """The arrays and launches of a run."""
        return make_plan(self.build())

    def step_count_bound(self, plan: Plan) -> int | None:
        """Steps of a run of `plan` at most; None where that is not known beforehand."""
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
            progress: True for a progress bar on the terminal; or a function, which is called now
                and then with the fraction done: with 0 when the first step is begun, at the end
                with 1.
            execution: device and threads; default: one thread of the processor.
            snapshots: are taken on the way, whatever ends the run; they change no result by a bit.

        Returns:
            Curves, scalars, what they cost, and all parameters. Each variable has the attributes
            `units` and `long_name`; `role` says what it is, where it is not an ordinary result:
            one of `mpm_warp.results.ROLES`. A parameter whose name is that of a result is called
            ``<name>_parameter``.

        Raises:
            mpm_warp.errors.SimulationDiverged: the run became unstable; its `curves` hold what was
                recorded up to there.
            mpm_warp.errors.InaccurateRun: the run ended, but its result cannot be relied on.
            mpm_warp.errors.UnfinishedRun: it ended before what it is for, a steady resistance say.
            mpm_warp.errors.SceneError: the scene takes no snapshots, or has more steps than can be
                counted.
        """
        self.run_size()
        check_kind("execution", execution, (Execution, type(None)))
        check_kind("snapshots", snapshots, (Snapshots, type(None)))
        with _reporter(progress, self.catalogue_name()) as report:
            if snapshots is None:
                results = self.compute(report, execution)
            else:
                results = self.compute_with_snapshots(report, execution, snapshots)
            report(1.0)
        parameters = parameter_variables(self, {*results.variables, *results.dims})
        if "material" in parameters and "built_law" in results:
            asked = parameters["material"]
            named = material_as_built(str(asked.values), str(results["built_law"].values))
            parameters["material"] = asked.copy(data=np.array(named))
        return results.assign(parameters)

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """The results of a run, without the parameters; `run` says what the arguments are.

        A scene overrides it where it does more than run one simulation. It is to call `progress`
        with 0 once all is compiled.
        """
        simulation = Simulation(self.build(), execution)
        plan, instead = simulation.plan, self._instead_of_smaller_steps
        plan.remedy = plan.remedy.replace(SMALLER_STEP, instead)
        progress(0.0)  # set up and compiled: from here on it computes
        return self.record(simulation, progress)

    @property
    def _instead_of_smaller_steps(self) -> str:
        """What to try where a run diverges: smaller steps, or what the scene has in their place."""
        known = parameters_of(type(self))
        numbers = [name for name in self.method if known[name].kind is not str]
        if "time_step_fraction" in known or not numbers:
            return SMALLER_STEP
        return f"try another {' or '.join(numbers)}"

    def compute_with_snapshots(
        self, progress: Progress, execution: Execution | None, snapshots: Snapshots
    ) -> xr.Dataset:
        """What `compute` gives, with snapshots on the way; of a scene with `snapshots_over`."""
        raise SceneError(f"{self.catalogue_name()}: takes no snapshots")

    @abstractmethod
    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Run a simulation of what `build` gives, from its start on, and record its results."""


@contextmanager
def _reporter(progress: Progress | bool | None, name: str) -> Iterator[Progress]:
    """What receives the progress of a run: the function given, a bar, or nothing."""
    if callable(progress):
        yield progress
        return
    check_known("progress", progress, (True, False, None))
    if not progress:  # a bar, hidden too, has a semaphore, which a worker that is ended leaves
        yield lambda fraction: None
        return
    layout = "{desc} {percentage:3.0f} % |{bar}| {elapsed} < {remaining}"
    with tqdm(desc=name, total=1.0, bar_format=layout) as bar:

        def show(fraction: float) -> None:
            bar.update(fraction - bar.n)

        yield show


GROUP = "mpm_warp.scenes"
"""Group of the entry points by which other packages offer scenes."""

Offered = type[CatalogueScene] | EntryPoint
"""A scene of this package, or where to find one of another.

Where the package importlib_metadata is loaded, as by Dask, an entry point is one of its own class.
"""


def scene_names() -> tuple[str, ...]:
    """Names of all scenes, sorted.

    Raises:
        UnknownSceneError: two scenes have the same name.
    """
    return tuple(sorted(_all_scenes()))


def scene_class(name: str) -> type[CatalogueScene]:
    """The class of the scene of that name.

    Raises:
        UnknownSceneError: there is none, and the message names the nearest one; or two scenes have
            the same name; or the entry point of the scene gives none.
    """
    scenes = _all_scenes()
    if name not in scenes:
        raise UnknownSceneError(f"unknown scene {name!r}{nearest_name(name, scenes)}")
    scene = scenes[name]
    return (scene if isinstance(scene, type) else _loaded(scene)).offered()


@functools.cache
def _all_scenes() -> Mapping[str, Offered]:
    """All scenes, by name; looked for once, because that opens a file of each installed package."""
    others = [(offered.name, offered) for offered in entry_points(group=GROUP)]
    return _by_name([*own_scenes().items(), *others])


@functools.cache
def own_scenes() -> Mapping[str, Offered]:
    """The scenes of this package, by name."""
    names = pkgutil.walk_packages([str(Path(__file__).parent)], f"{__package__}.")
    modules = [importlib.import_module(module.name) for module in names]
    return _by_name(
        (found.catalogue_name(), found)
        for module in modules
        for found in vars(module).values()
        if _is_scene(found) and found.__module__ == module.__name__
    )


def _by_name(offered: Iterable[tuple[str, Offered]]) -> Mapping[str, Offered]:
    scenes: dict[str, Offered] = {}
    for name, scene in offered:
        if name in scenes:
            raise UnknownSceneError(
                f"two scenes are called {name!r}: {_origin(scenes[name])} and {_origin(scene)}; "
                "rename one of them"
            )
        scenes[name] = scene
    return scenes


def _is_scene(found: object) -> bool:
    is_class = isinstance(found, type) and issubclass(found, CatalogueScene)
    return is_class and not inspect.isabstract(found)


def _origin(scene: Offered) -> str:
    if isinstance(scene, type):
        return f"{scene.__module__}.{scene.__qualname__}"
    package = "an unknown package" if scene.dist is None else scene.dist.name
    return f"the entry point {scene.value!r} of {package}"


def _loaded(entry_point: EntryPoint) -> type[CatalogueScene]:
    """The class of an entry point; one that cannot be loaded, or is no scene, is an error."""
    where = f"scene {entry_point.name!r}: {_origin(entry_point)}"
    try:
        scene: type[CatalogueScene] = entry_point.load()
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise UnknownSceneError(f"{where} cannot be loaded: {reason}") from error
    if not _is_scene(scene):
        raise UnknownSceneError(f"{where} is not a CatalogueScene without abstract methods")
    return scene
