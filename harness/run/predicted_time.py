"""How long cases take, about, as their scenes predict it; and the order that follows from it."""

from __future__ import annotations

from collections.abc import Sequence

from harness.study.cases import Case
from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.parameters import from_mapping
from mpm_warp.scenes import scene_class

UPDATE_RATE = 20e6
"""Particle updates a second on one thread, as `harness bench` measures them."""


def predicted_time(case: Case) -> float:
    """Time of a case on one thread, about [s]; 0 where it is not known, or the case is refused."""
    try:
        size = from_mapping(scene_class(case.scene), case.parameters).run_size()
    except (ParameterError, SceneError):
        return 0.0
    return 0.0 if size is None else size.particle_updates / UPDATE_RATE


def costliest_first(cases: Sequence[Case]) -> list[Case]:
    """Cases in the order in which several workers are done soonest; equal ones as they were.

    A costly case that begins last keeps one worker busy when the others have nothing left. With
    the longest first, the time in all is at most 4/3 of the shortest possible (Graham 1969, SIAM
    J. Appl. Math. 17(2):416-429).
    """
    return sorted(cases, key=predicted_time, reverse=True)
