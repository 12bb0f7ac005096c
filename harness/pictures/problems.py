"""The problems of a study: its cases by scene and soil, each solved with several settings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import is_there, over_cases, scenes_of, spoken, varied_names
from harness.pictures.drawing.symbols import assigned, plain, quantity, symbol
from harness.pictures.drawing.values import Values
from harness.pictures.studied import method_of
from harness.study.designs import ONE_AT_A_TIME


@dataclass(frozen=True)
class Problem:
    """Cases that ask the same question: they differ in parameters of the method alone.

    Attributes:
        cases: which they are.
        scene: their scene.
        soil: what else the study varies, by name, in words.
        settings: the parameters of the method that vary among them.
    """

    cases: np.ndarray
    scene: str
    soil: dict[str, str]
    settings: tuple[str, ...]


def problems_of(dataset: xr.Dataset) -> list[Problem]:
    """The problems that a study solves with different settings, in the order of the study."""
    scenes = np.array(scenes_of(dataset))
    varied = [name for name in varied_names(dataset) if name != "scene"]
    columns = {name: Values.of(dataset, name) for name in varied}
    groups: dict[tuple[object, ...], list[int]] = {}
    for case, scene in enumerate(scenes.tolist()):
        method = method_of(dataset, scene)
        key = [columns[name].numbers[case] for name in varied if name not in method]
        groups.setdefault((scene, *key), []).append(case)
    found = []
    for (scene, *_), members in groups.items():
        cases, method = np.array(members), method_of(dataset, str(scene))
        own = [name for name in varied if is_there(over_cases(dataset, name)[cases[0]])]
        different = {name: np.unique(columns[name].numbers[scenes == scene]) for name in own}
        settings = tuple(
            name
            for name in own
            if name in method and np.unique(columns[name].numbers[cases]).size > 1
        )
        soil = {
            name: assigned(dataset, name, _value(columns[name], int(cases[0])))
            for name in own
            if name not in method and different[name].size > 1
        }
        found.append(Problem(cases, str(scene), soil, settings))
    return [problem for problem in found if problem.settings]


def problem_names(problems: list[Problem]) -> list[str]:
    """What each is called among the others: its scene and soil, as far as these differ."""
    scenes = {it.scene for it in problems}
    names = []
    for problem in problems:
        of_scene = [it for it in problems if it.scene == problem.scene]
        parts = [plain(problem.scene).replace("_", " ")] if len(scenes) > 1 else []
        parts += [
            told
            for name, told in problem.soil.items()
            if len({it.soil[name] for it in of_scene}) > 1
        ]
        names.append(", ".join(parts))
    return names


def setting_of(dataset: xr.Dataset, problem: Problem, case: int) -> str:
    """The settings of a case that vary; of one at a time those that differ from the start."""
    columns = {name: Values.of(dataset, name) for name in problem.settings}
    if dataset.attrs.get("design") == ONE_AT_A_TIME:
        start = problem.cases[0]
        told = [
            assigned(dataset, name, _value(it, case))
            for name, it in columns.items()
            if it.numbers[case] != it.numbers[start]
        ]
        return ", ".join(told) or "start"
    if len(columns) == 1:
        return "".join(assigned(dataset, name, _value(it, case)) for name, it in columns.items())
    return " / ".join(quantity(_value(it, case)) for it in columns.values())


def settings_key(dataset: xr.Dataset, problems: list[Problem]) -> str:
    """What the values of :func:`setting_of` are, in a sentence."""
    if dataset.attrs.get("design") == ONE_AT_A_TIME:
        return ""
    keys = dict.fromkeys(
        " / ".join(symbol(name) or plain(spoken(name)) for name in it.settings)
        for it in problems
        if len(it.settings) > 1
    )
    return f"Beside points: {'; '.join(keys)}." if keys else ""


def _value(values: Values, case: int) -> float | str:
    return values.value(float(values.numbers[case]))
