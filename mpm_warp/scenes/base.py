"""What every ready scene offers: parameters as fields, a summary, a run that gives a dataset."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import check_parameters

if TYPE_CHECKING:
    import xarray

Progress = Callable[[float], None]
"""Called now and then during a run with the fraction done, 0 to 1."""


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

    def __post_init__(self) -> None:
        check_parameters(self)

    @abstractmethod
    def run(self, progress: Progress | None = None) -> xarray.Dataset:
        """Simulate the scene.

        Returns:
            One dataset of scalars and curves, each with ``units`` and ``long_name``.

        Raises:
            mpm_warp.health.SimulationDiverged: the run became unstable.
        """
