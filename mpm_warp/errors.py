"""Errors that end a run, or prevent its start; every message is one line.

An error that is the outcome of a case has a `status`, under which the harness files the case.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray


class SceneError(ValueError):
    """A scene cannot be run: a value is not allowed, or two parts do not go together."""

    status = "refused"


class ParameterError(ValueError):
    """A parameter is unknown, or its value is not allowed.

    Attributes:
        key: name of the offending parameter, as it was given.
    """

    status = "refused"

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


class UnknownSceneError(LookupError):
    """The catalogue has no scene of that name; the message names the nearest one."""


class KernelCacheError(OSError):
    """Compiled kernels cannot be kept; the message names the folder."""

    status = "failed"


class SimulationDiverged(RuntimeError):
    """The run became unstable; the message names what, where and when.

    Attributes:
        curves: the samples up to then; None where nothing is sampled.
    """

    status = "diverged"
    curves: "xarray.Dataset | None" = None


class WindowOverfull(SimulationDiverged):
    """More soil stays in the travelling window than it has slots for: it piles up on the shaft."""


class _WithoutResult(RuntimeError):
    """The run reached its end without a result; `curves` holds curves and scalars."""

    def __init__(self, message: str, curves: "xarray.Dataset") -> None:
        super().__init__(message)
        self.curves = curves


class InaccurateRun(_WithoutResult):
    """The run reached its end, but its result is not reliable."""

    status = "inaccurate"


class UnfinishedRun(_WithoutResult):
    """The run was too short for its result; the message says what a longer run needs."""

    status = "unfinished"


class Fault(Exception):
    """A fault that a check of a run has found; the message has no time and no remedy."""
