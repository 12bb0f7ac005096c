"""A study: the cases to run and what to compare them with.

A study is read from a TOML file; ``--set`` on the command line changes it. The file is data, and
nothing in it is executed. harness/README.md explains its keys, with examples.
"""

import functools
import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from harness.study.cases import Case, cases_of
from harness.study.compared import OWN_REFERENCES, Compared, read_compared
from harness.study.designs import FULL, LATIN_HYPERCUBE, ONE_AT_A_TIME, Design
from harness.study.files import (
    find_study,
    lineage,
    merged,
    study_names,
    with_profile,
)
from harness.study.laws import flat_material, flat_tables
from harness.study.scene_part import (
    SCENE_KEYS,
    SNAPSHOTS,
    Scene,
    ScenePart,
    read_part,
    read_snapshots,
)
from harness.study.tables import LINE, StudyError, Table, parse_setting, parse_value, text_key
from mpm_warp.errors import UnknownSceneError
from mpm_warp.fields.checks import shown
from mpm_warp.fields.declaration import parameter
from mpm_warp.fields.flat import parameters_of
from mpm_warp.fields.names import known_names, nearest_name
from mpm_warp.scenes import scene_class, scene_names

MOST_REPEATS = 1000
"""Timed runs of a case that a study may ask for; a larger number is taken for a mistake."""
STABILITY_MAP = "stability_map"
"""Key of a study that asks for a map of where its cases complete; an attribute of its result."""

SCENE = text_key("scene", "what is simulated")
STUDY_KEYS = (
    *("title", "base", "scene", "scenes", "design", "samples", "seed"),
    *("compare", OWN_REFERENCES, "timing", STABILITY_MAP),
)


@dataclass(frozen=True, kw_only=True)
class Study:
    """The cases to run and what to compare them with. Every name and value has been checked."""

    name: str  # name of the study file without .toml; the results are named by it
    title: str = parameter(meaning="one line on what the study shows", form=LINE)
    parts: tuple[ScenePart, ...]  # one for each scene
    design: Design
    compared: Compared
    # each alone on the machine; 0: cases are not timed
    timing_repeats: int = parameter(
        meaning="timed runs of each case", minimum=1, maximum=MOST_REPEATS, key="repeats"
    )
    source: Path  # the study file
    stability_map: bool = parameter(False, "draw a map of where the cases complete")

    @functools.cached_property
    def cases(self) -> tuple[Case, ...]:
        """All cases without duplicates, scene by scene, each scene in the order of the design."""
        return cases_of(self.parts, self.design, str(self.source))

    @property
    def is_grid(self) -> bool:
        """Whether the dimensions of the result are the varied parameters, not the single `case`."""
        return self.design.kind == FULL and len(self.parts) == 1 and not self.parts[0].excluded


KEYS = parameters_of(Study)
"""Declared keys, by attribute of a study."""


def load_study(study: str, settings: Iterable[str] = ()) -> Study:
    """Read a study and apply ``key=value`` settings.

    Args:
        study: name of a study that ships, or path of a TOML file.
        settings: each value is a TOML value, or a bare word for a text. A list or a range varies
            the parameter and a single value fixes it, whatever the file says. If a key is set
            twice, the last setting counts. In a study of several scenes a setting applies to the
            scenes that have the parameter.

    Raises:
        StudyError: the study or a setting is not valid; the message names file, key and value.

    Example:
        >>> [case.label for case in load_study("adhesion_factor", ["rigidity_index=50"]).cases[:2]]
        ['adhesion_factor=0.0', 'adhesion_factor=0.25']
    """
    if study in scene_names() and study not in study_names():
        raise StudyError(
            f"{study}: is a scene; a study says what to vary in it: `harness new my_study "
            f"--scene {study}` writes one, `harness run my_study.toml` runs it"
        )
    path = find_study(study)
    assignments = _assignments(settings)
    values: dict[str, Any] = {}
    for file, said in lineage(path):
        own = flat_tables(Table(f"{file}:", with_profile(file, said)))
        values = merged(values, own, {**values, **own}.get("design", FULL))
        # Each base is checked by itself, so that its mistakes are reported with its file name.
        read = _read(file, values, assignments if file == path else {})
    return read


def with_snapshots(study: Study, moments: str) -> Study:
    """The study with other snapshots, in all of its scenes that can take snapshots.

    Args:
        study: the study to change.
        moments: as given on the command line: ``5, 10``, or a list or range in TOML.
    """
    option = f"--{SNAPSHOTS}"
    given = moments if moments.lstrip().startswith(("[", "{")) else f"[{moments}]"
    values = {SNAPSHOTS: parse_value(f"{option} {moments}", SNAPSHOTS, given)}
    taking = [part for part in study.parts if part.scene.snapshots_over is not None]
    parts = []
    for part in taking or study.parts[:1]:
        table = Table(option if len(study.parts) == 1 else f"{option}, for {part.name}:", values)
        parts.append(replace(part, snapshots=read_snapshots(part.name, part.scene, table)))
    others = {part.name: part for part in study.parts} | {part.name: part for part in parts}
    return replace(study, parts=tuple(others.values()))


def is_scene(subject: str, *laws: str) -> bool:
    """Whether `subject` names a scene; if not, it names a study or is the path of a study file.

    `laws` are names that a message may offer beside those of scenes and studies.
    """
    known = (*scene_names(), *study_names(), *laws)
    if subject not in known and "." not in subject and "/" not in subject:
        raise StudyError(f"{subject}: neither a scene nor a study{nearest_name(subject, known)}")
    return subject in scene_names()


def study_of_scene(scene: str, settings: Iterable[str] = ()) -> Study:
    """A study of one scene with its defaults and these settings; it has no file and no results."""
    return _read(Path(scene), {"title": scene, "scene": scene}, _assignments(settings))


def _assignments(settings: Iterable[str]) -> dict[str, Any]:
    """The values of settings by parameter, in flat form."""
    return flat_material("--set", dict(map(parse_setting, settings)))


def _read(path: Path, values: Mapping[str, Any], settings: Mapping[str, Any]) -> Study:
    document = Table(f"{path}:", values)
    if "test" in values and "scene" not in values:
        raise StudyError(f"{path}: this is a site file; `harness interpret {path}` reads it")
    document.allow(*STUDY_KEYS, *SCENE_KEYS)
    design = _design(document)
    scenes = _scenes(document)
    own = document.table("scenes")
    own.allow(*scenes)
    shared = {key: value for key, value in values.items() if key in SCENE_KEYS}
    parts = []
    for name, scene in scenes.items():
        of_scene = own.table(name)
        of_scene.allow(*SCENE_KEYS)
        _check_derived(document, of_scene)
        # Of several scenes only one may lack a parameter that the table of all of them has.
        where = document.where if len(scenes) == 1 else f"{document.where} {name}:"
        of_all = replace(document, where=where, values=shared)
        own_settings = Table(
            "--set" if len(scenes) == 1 else f"--set, for {name}:",
            {key: settings[key] for key in settings if key in parameters_of(scene)},
            parameters_of(scene),
        )
        parts.append(_part(name, scene, of_scene, of_all, design, own_settings))
    known = {name: it for part in parts for name, it in part.parameters.items()}
    for key in settings:
        Table("--set", settings, known).definition(key)
    timing = document.table("timing")
    timing.allow("repeats")
    return Study(
        name=path.stem,
        title=document.read(KEYS["title"]),
        parts=tuple(parts),
        design=design,
        compared=read_compared(document, parts, path.parent),
        timing_repeats=timing.read(KEYS["timing_repeats"]) if timing.values else 0,
        source=path,
        stability_map=_asks_for_map(document, design, len(scenes)),
    )


def _part(
    name: str,
    scene: Scene,
    own: Table,
    shared: Table,
    design: Design,
    settings: Table,
) -> ScenePart:
    """What a study does with one scene.

    A mistake in a table that all scenes share is reported at that table, not at the scene's own.
    """
    said, known = merged(shared.values, own.values, design.kind), parameters_of(scene)
    try:
        return read_part(name, scene, Table(own.where, said, known), design, settings)
    except StudyError as error:
        try:
            read_part(name, scene, replace(shared, known=known), design, settings)
        except StudyError as at_shared_place:
            if at_shared_place.whole.removeprefix(shared.where) == error.whole.removeprefix(
                own.where
            ):
                raise at_shared_place from None
        raise


def _scenes(document: Table) -> dict[str, Scene]:
    given = document.values.get("scene")
    if isinstance(given, list) and given:
        names = given
    else:
        if given is None:
            raise StudyError(f"{document.where} scene: is missing{known_names(scene_names())}")
        names = [document.read(SCENE)]
    scenes = {}
    for name in names:
        try:
            scene = scene_class(name if isinstance(name, str) else shown(name))
        except UnknownSceneError as error:
            raise StudyError(f"{document.where} scene = {shown(given)}: {error}") from None
        if name in scenes:
            raise document.refuse("scene", f"names {name} twice")
        scenes[name] = scene
    return scenes


def _design(document: Table) -> Design:
    design = document.made(Design)
    if design.kind != LATIN_HYPERCUBE:
        for key in ("samples", "seed"):
            if key in document.values:
                raise document.refuse(key, f'is allowed only with design = "{LATIN_HYPERCUBE}"')
        return design
    for name in ("samples", "seed"):
        if name not in document.values:
            raise document.missing(parameters_of(Design)[name])
    return design


def _check_derived(*tables: Table) -> None:
    """Refuse a parameter that the same table both derives and also fixes or varies."""
    for table in tables:
        derived = table.table("derived")
        for name, key in itertools.product(("fixed", "vary"), derived.values):
            if key in table.table(name).values:
                raise derived.refuse(key, f"is under [{name}] as well; keep one of them")


def _asks_for_map(document: Table, design: Design, scene_count: int) -> bool:
    asked: bool = document.read(KEYS[STABILITY_MAP])
    if asked and (design.kind not in (ONE_AT_A_TIME, LATIN_HYPERCUBE) or scene_count > 1):
        designs = f'design = "{ONE_AT_A_TIME}" or "{LATIN_HYPERCUBE}"'
        raise document.refuse(STABILITY_MAP, f"needs one scene and {designs}")
    return asked
