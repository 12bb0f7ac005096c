"""From a study to its cases. A case is named by the hash of all that decides its numbers."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass

from harness.study import Study, StudyError
from mpm_warp.parameters import ParameterError, Value, from_mapping
from mpm_warp.scenes import scene_class

COMPLETED = "completed"
MISSING = "missing"
CRASHED = "crashed"
TIMED_OUT = "timed_out"
DAMAGED = "damaged"
UNTIMED = "untimed"

LARGEST_STUDY = 100_000
"""Cases that a study may have; one with more is a slip in a list, not a plan."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One run of a scene.

    Attributes:
        index: position in the grid of the varied parameters; () where none varies.
        scene: name of the scene.
        scene_version: version of the scene that the parameters are meant for.
        parameters: all parameters of the scene; None is what the scene derives.
        label: the varied values, for people.
    """

    index: tuple[int, ...]
    scene: str
    scene_version: int
    parameters: Mapping[str, Value | None]
    label: str

    @property
    def key(self) -> str:
        """16 hexadecimal digits: the same parameters of the same scene version, the same key."""
        identity = [self.scene, self.scene_version, self.parameters]
        canonical = json.dumps(identity, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    Attributes:
        status: ``completed``, ``failed``, ``diverged``, ``crashed``, ``timed_out``; ``missing``
            where there is no file, ``damaged`` where the file is of no use, ``untimed`` where
            it completed without the timed runs that its study asks for.
        message: why it did not complete, one line.
        headline: name and value of the first scalar that the scene returned.
        seconds: time that the case took in all.
        repeats: warm runs that its file has the times of.
    """

    status: str
    message: str = ""
    headline: str = ""
    seconds: float = 0.0
    repeats: int = 0


def cases_of(study: Study) -> list[Case]:
    """All combinations of the varied values, the last parameter varying fastest.

    Raises:
        StudyError: the scene does not allow a combination, or there are too many.
    """
    count = math.prod(len(values) for values in study.varied.values())
    if count > LARGEST_STUDY:
        raise StudyError(
            f"{study.source}: [vary] gives {count} cases; a study has at most {LARGEST_STUDY}"
        )
    scene = scene_class(study.scene)
    cases = []
    for choice in itertools.product(*map(enumerate, study.varied.values())):
        values = dict(zip(study.varied, (value for _, value in choice), strict=True))
        label = ", ".join(f"{name}={value}" for name, value in values.items())
        try:
            complete = from_mapping(scene, {**study.fixed, **values})
        except ParameterError as error:
            raise StudyError(f"{study.source}: {label or study.scene}: {error}") from None
        case = Case(
            index=tuple(position for position, _ in choice),
            scene=study.scene,
            scene_version=scene.version,
            parameters=dataclasses.asdict(complete),
            label=label or study.scene,
        )
        cases.append(case)
    return cases
