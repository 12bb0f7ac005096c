"""Stand-in, dropped at the merge."""

from mpm_warp.parameters import ParameterError
from mpm_warp.scenes import UnknownSceneError

__all__ = ["ParameterError", "UnknownSceneError"]
