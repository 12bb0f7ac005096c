"""A study: what to run and what to compare it with, read from TOML and changed by ``--set``.

A definition is data, nothing in it is executed. harness/README.md has its keys, with examples.
"""

import functools
import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from harness.study.cases import Case, cases_of
from harness.study.compared import OWN_REFERENCES, Compared, read_compared
from harness.study.designs import DESIGNS, FULL, LATIN_HYPERCUBE, ONE_AT_A_TIME, Design
from harness.study.files import find_study, joined, lineage, study_names, with_profile
from harness.study.scene_part import (
    LARGEST_STUDY,
    OF_SCENE,
    SNAPSHOTS,
    Scene,
    ScenePart,
    read_part,
    read_snapshots,
)
from harness.study.tables import StudyError, Table, parse_setting, parse_value, shown
from mpm_warp.errors import UnknownSceneError
from mpm_warp.parameters import known_names, nearest_name, parameters_of
from mpm_warp.scenes import scene_class, scene_names

MOST_REPEATS = 1000
"""Timed runs that a study may ask for; more is a slip."""
LARGEST_SEED = 2**32 - 1
STABILITY_MAP = "stability_map"
"""Key, and attribute of the result, of a study that asks for the map of its stability."""

OF_STUDY = (
    *("title", "base", "scene", "scenes", "design", "samples", "seed"),
    *("compare", OWN_REFERENCES, "timing", STABILITY_MAP),
)


@dataclass(frozen=True, kw_only=True)
class Study:
    """What to run and what to compare it with; every name and value is valid."""

    name: str  # stem of the definition's file; names the results
    title: str
    parts: tuple[ScenePart, ...]  # one for each scene
    design: Design
    compared: Compared
    timing_repeats: int  # times to run each case again, alone on the machine, to measure its time
    source: Path  # the definition's file
    stability_map: bool = False  # whether it asks for a map of where its cases complete

    @functools.cached_property
    def cases(self) -> tuple[Case, ...]:
        """All cases, each once, scene by scene in the order of the design; worked out once."""
        return cases_of(self.parts, self.design, str(self.source))

    @property
    def is_grid(self) -> bool:
        """Whether each varied parameter is a dimension of the result, instead of the case."""
        return self.design.kind == FULL and len(self.parts) == 1 and not self.parts[0].excluded


def load_study(study: str, settings: Iterable[str] = ()) -> Study:
    """Read the study called `study`, or in the file `study`, and apply ``key=value`` settings.

    A setting's value is a TOML value, or a bare word for a text. A list or a range varies the
    parameter, a scalar fixes it, whatever the file says; of two settings of one key the last holds.
    Of several scenes a setting is for those that have the parameter.
    """
    if study in scene_names() and study not in study_names():
        raise StudyError(
            f"{study}: is a scene; a study says what to vary in it: `harness new my_study "
            f"--scene {study}` writes one, `harness run my_study.toml` runs it"
        )
    path = find_study(study)
    assignments = dict(parse_setting(setting) for setting in settings)
    values: dict[str, Any] = {}
    for file, said in lineage(path):
        own = with_profile(file, said)
        values = joined(values, own, {**values, **own}.get("design", FULL))
        # What is wrong in a base is reported with the name of its file.
        read = _read(file, values, assignments if file == path else {})
    return read


def with_snapshots(study: Study, moments: str) -> Study:
    """The study whose scenes keep the soil at other moments, where they take snapshots at all.

    They are given as on the command line: ``5, 10``, or the list or the range of a study in TOML.
    """
    option = f"--{SNAPSHOTS}"
    given = moments if moments.lstrip().startswith(("[", "{")) else f"[{moments}]"
    table = Table(option, {SNAPSHOTS: parse_value(f"{option} {moments}", SNAPSHOTS, given)})
    taking = [part for part in study.parts if part.scene.snapshots_over is not None]
    parts = [
        replace(part, snapshots=read_snapshots(part.name, part.scene, table))
        for part in taking or study.parts[:1]
    ]
    others = {part.name: part for part in study.parts} | {part.name: part for part in parts}
    return replace(study, parts=tuple(others.values()))


def is_scene(subject: str) -> bool:
    """Whether what is named is a scene; otherwise it is a study, or should be the file of one."""
    known = (*scene_names(), *study_names())
    if subject not in known and "." not in subject and "/" not in subject:
        raise StudyError(f"{subject}: neither a scene nor a study{nearest_name(subject, known)}")
    return subject in scene_names()


def study_of_scene(scene: str, settings: Iterable[str] = ()) -> Study:
    """A study of one scene as it is, with settings; it has no file, and no results."""
    assignments = dict(parse_setting(setting) for setting in settings)
    return _read(Path(scene), {"title": scene, "scene": scene}, assignments)


def _read(path: Path, values: Mapping[str, Any], settings: Mapping[str, Any]) -> Study:
    document = Table(f"{path}:", values)
    if "test" in values and "scene" not in values:
        raise StudyError(f"{path}: is a site file; `harness interpret {path}` reads it")
    document.allow(*OF_STUDY, *OF_SCENE)
    design = _design(document)
    scenes = _scenes(document)
    own = document.table("scenes")
    own.allow(*scenes)
    known = {
        name: definition
        for scene in scenes.values()
        for name, definition in parameters_of(scene).items()
    }
    for key in settings:
        Table("--set", settings, known).definition(key)
    shared = {key: value for key, value in values.items() if key in OF_SCENE}
    parts = []
    for name, scene in scenes.items():
        of_scene = own.table(name)
        of_scene.allow(*OF_SCENE)
        _check_derived(document, of_scene)
        parts.append(
            _part(name, scene, of_scene, replace(document, values=shared), design, settings)
        )
    timing = document.table("timing")
    timing.allow("repeats")
    return Study(
        name=path.stem,
        title=document.text("title", "; one line on what the study shows"),
        parts=tuple(parts),
        design=design,
        compared=read_compared(document, parts, path.parent),
        timing_repeats=timing.integer("repeats", 1, MOST_REPEATS) if timing.values else 0,
        source=path,
        stability_map=_asks_for_map(document, design, len(scenes)),
    )


def _part(
    name: str,
    scene: Scene,
    own: Table,
    shared: Table,
    design: Design,
    settings: Mapping[str, Any],
) -> ScenePart:
    """What a study does with a scene; what is wrong in what all share is told of its place."""
    said, known = joined(shared.values, own.values, design.kind), parameters_of(scene)
    try:
        return read_part(name, scene, Table(own.where, said, known), design, settings)
    except StudyError as error:
        try:
            read_part(name, scene, replace(shared, known=known), design, settings)
        except StudyError as of_all:
            if str(of_all).removeprefix(shared.where) == str(error).removeprefix(own.where):
                raise of_all from None
        raise


def _scenes(document: Table) -> dict[str, Scene]:
    given = document.values.get("scene")
    if isinstance(given, list) and given:
        names = given
    else:
        names = [document.text("scene", known_names(scene_names()))]
    scenes = {}
    for name in names:
        try:
            scene = scene_class(name if isinstance(name, str) else shown(name))
        except UnknownSceneError as error:
            raise StudyError(f"{document.where} scene = {shown(given)}: {error}") from None
        if name in scenes:
            raise document.refuse("scene", "names a scene twice")
        scenes[name] = scene
    return scenes


def _design(document: Table) -> Design:
    kind = document.word("design", DESIGNS)
    if kind != LATIN_HYPERCUBE:
        for key in ("samples", "seed"):
            if key in document.values:
                raise document.refuse(key, f'goes with design = "{LATIN_HYPERCUBE}" alone')
        return Design(kind=kind)
    return Design(
        kind=kind,
        samples=document.integer("samples", 1, LARGEST_STUDY),
        seed=document.integer("seed", 0, LARGEST_SEED),
    )


def _check_derived(*tables: Table) -> None:
    """Refuse a parameter that one and the same table both derives and fixes or varies."""
    for table in tables:
        derived = table.table("derived")
        for name, key in itertools.product(("fixed", "vary"), derived.values):
            if key in table.table(name).values:
                raise derived.refuse(key, f"is under [{name}] as well; keep one of them")


def _asks_for_map(document: Table, design: Design, scene_count: int) -> bool:
    asked = document.values.get(STABILITY_MAP, False)
    if not isinstance(asked, bool):
        raise document.refuse(STABILITY_MAP, "must be true or false")
    if asked and (design.kind not in (ONE_AT_A_TIME, LATIN_HYPERCUBE) or scene_count > 1):
        of = f'design = "{ONE_AT_A_TIME}" or "{LATIN_HYPERCUBE}"'
        raise document.refuse(STABILITY_MAP, f"goes with one scene and {of}")
    return asked
