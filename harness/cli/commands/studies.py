"""The commands before a run: new, tour, list, describe, schema, references and plan."""

import argparse
import json
import re
import shlex
import textwrap
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from tqdm import tqdm

from harness.archive.atomic_files import prepare, write_whole
from harness.cli.process import DONE
from harness.errors import HarnessError, say, tell
from harness.interpret.description import is_site_file, site_rows, site_schema, site_text
from harness.interpret.reading.contents import NotNamedError
from harness.interpret.reading.files import read_file
from harness.interpret.reading.headings import columns_in
from harness.interpret.site import MeasuredTest
from harness.interpret.tables.evidence import evidence, evidence_table
from harness.references.listing import all_entries, one_entry
from harness.run.resources import (
    PROCESS_MEMORY,
    UPDATE_RATE,
    predicted_memory,
    spoken_time,
    tell_of_likely_failures,
)
from harness.study.cases import Case
from harness.study.description import (
    law_rows,
    law_title,
    scene_rows,
    study_rows,
    study_text,
    warn_of_unusual_values,
)
from harness.study.files import NAME_RULE, STUDY_NAME, find_study, studies_folder, study_names
from harness.study.schema import study_schema
from harness.study.study import is_scene, load_study, study_of_scene
from mpm_warp.errors import ParameterError, SceneError, UnknownSceneError
from mpm_warp.fields.flat import parameters_of
from mpm_warp.materials.clay_law import laws
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.scenes import scene_class, scene_names


def new(options: argparse.Namespace) -> int:
    """Write a new study or site file."""
    name = options.name.removesuffix(".toml")
    path = Path(f"{name}.toml")
    if not re.fullmatch(STUDY_NAME, name):
        raise HarnessError(
            f"{options.name}: is not a valid name; use {NAME_RULE}; and no folder: the file goes "
            "into the current one"
        )
    if name in study_names():
        raise HarnessError(f"{name}: a study that ships has this name; choose another")
    if path.exists() or path.is_symlink():
        raise HarnessError(f"{path}: exists already; edit it, or choose another name")
    if options.scene in study_names() and options.scene not in scene_names():
        scene = load_study(options.scene).parts[0].name
        raise HarnessError(f"--scene {options.scene}: is a study; its scene is {scene}")
    is_site = options.interpret is not None
    text = _site_text(options.interpret) if is_site else study_text(name, options.scene)
    write_whole(text.encode(), path)
    command = "interpret" if is_site else "run"
    tell(f"edit {path}, then: harness {command} {shlex.quote(str(path))}")
    say(path)
    return DONE


def _site_text(test: Path) -> str:
    """A site file for a measured test, with the values that the test's file states."""
    told: Mapping[str, float] = {}
    soundings: Sequence[str] = ()
    try:
        file = read_file(test)
        told = file.stated
        columns_in(test, file.headings, columns={}, units={})
    except NotNamedError as error:
        tell(str(error))
        soundings = error.soundings
    keys = parameters_of(MeasuredTest)
    # Values out of range are left out here; `interpret` refuses them and names their place. A water
    # level above the ground is mostly a level by a datum.
    allowed = {
        key: it
        for key, it in told.items()
        if keys[key].bounds.holds(it, it) and not (key == "water_level" and it < 0.0)
    }
    return site_text(test.as_posix(), allowed, soundings)


def tour(options: argparse.Namespace) -> int:
    """Write a copy of the notebook that ships."""
    path = Path("tour.ipynb")
    if path.exists() or path.is_symlink():
        raise HarnessError(f"{path}: exists already; open it, or go to another folder")
    write_whole((studies_folder() / path).read_bytes(), path)
    tell(
        "after pip install 'mpm-warp[notebook]' open it in JupyterLab or VS Code, or: jupyter "
        f"execute --inplace {path}"
    )
    say(path)
    return DONE


def list_names(options: argparse.Namespace) -> int:
    """Print all studies, scenes and laws of clay."""
    kinds = {
        "studies": {name: load_study(name).title for name in study_names()},
        "scenes": {name: _summary(name) for name in scene_names()},
        "laws of clay": {name: _title(name) for name in laws()},
    }
    width = max(len(name) for them in kinds.values() for name in them)
    for kind, them in kinds.items():
        say(f"{kind}:", *(f"  {name:{width}} {what}" for name, what in them.items()))
    return DONE


def _summary(scene: str) -> str:
    """What a scene simulates, or why it cannot be loaded."""
    try:
        return scene_class(scene).summary
    except UnknownSceneError as refusal:
        return str(refusal)


def _title(law: str) -> str:
    """What a law of clay is, or why it cannot be loaded."""
    try:
        return law_title(law)
    except ParameterError as refusal:
        return str(refusal)


def describe(options: argparse.Namespace) -> int:
    """Describe a scene, a law of clay, a study or a site file."""
    if is_site_file(options.subject):
        say(*site_rows(Path(options.subject)))
        return DONE
    if options.subject in laws():
        say(*law_rows(options.subject))
        return DONE
    if not is_scene(options.subject, *laws()):
        study = load_study(options.subject)
        say(*study_rows(study))
        warn_of_unusual_values(study)
        return DONE
    say(*scene_rows(options.subject))
    if options.subject in study_names():
        file = shlex.quote(str(find_study(options.subject)))
        tell(f"there is also a study of this name: harness describe {file}")
    return DONE


def schema(options: argparse.Namespace) -> int:
    """Print the JSON schema of studies, or of site files."""
    say(json.dumps(site_schema() if options.of == "site" else study_schema(), indent=2))
    return DONE


def references(options: argparse.Namespace) -> int:
    """Print all references and bands of experience, one of them in full, or measured sites."""
    if not options.field:
        say(all_entries() if options.id is None else one_entry(options.id))
        return DONE
    from harness.pictures.drawing.plot_parts import write_figure  # only pictures need matplotlib
    from harness.pictures.measured.evidence import evidence_figure

    prepare(options.out)
    found = evidence()
    paths = write_figure(evidence_figure(found), options.out / "field_sites", options.format)
    say(evidence_table(found), *paths)
    return DONE


HEADING = f"{'points':>12}  {'memory':>9}  {'steps <':>12}  {'time <':>9}  case"


def show_plan(options: argparse.Namespace) -> int:
    """Print the kernels and arrays of one case, or a line for each case of several."""
    read = study_of_scene if is_scene(options.subject) else load_study
    study = read(options.subject, options.set)
    warn_of_unusual_values(study)
    tell_of_likely_failures(study.cases)
    if len(study.cases) > 1:
        _show_cases(study.cases)
        return DONE
    (case,) = study.cases
    scene = case.built()
    size = scene.run_size()  # refuses what has more steps than can be counted
    with _at_work(1, f"planning {study.name}") as bar:
        plan = scene.plan()
        text = _plan_text(plan, scene.step_count_bound(plan))
        bar.update()
    say(text)
    if size is not None:
        memory = predicted_memory(scene, size, len(case.snapshots))
        say(f"memory of the process: {memory / 1e6:.1f} MB")
    return DONE


def _at_work(count: int, what: str) -> "tqdm[Any]":
    """A line on a terminal that says how far the planning of cases has come."""
    layout = "{desc}, {n_fmt}/{total_fmt}, {elapsed}"
    return tqdm(total=count, desc=what, bar_format=layout, leave=False, disable=None)


def _show_cases(cases: Sequence[Case]) -> None:
    """Print what each case takes, and all of them together."""
    say(HEADING)
    total, unknown = 0.0, False
    with _at_work(len(cases), "planning") as bar:
        for case in cases:
            row, seconds = _case_row(case)
            with bar.external_write_mode():
                say(row)
            bar.update()
            total += seconds or 0.0
            unknown |= seconds is None
    more = ", and more: the steps of some are not known beforehand" if unknown else ""
    say(f"{len(cases)} cases, {spoken_time(total)} at most on one thread{more}")


def _case_row(case: Case) -> tuple[str, float | None]:
    """What a case takes, and its time [s]; None where the steps are not known beforehand."""
    try:
        scene = case.built()
        size = scene.run_size()
        if size is not None:
            points, steps = size.particle_count, size.step_count
            memory = predicted_memory(scene, size, len(case.snapshots))
        else:
            plan = scene.plan()
            points = plan.particle_count
            memory = PROCESS_MEMORY + sum(array.byte_count for array in plan.arrays.values())
            steps = float(scene.step_count_bound(plan) or 0)
    except (ParameterError, SceneError) as error:
        return f"{'refused':>12}  {'':9}  {'':12}  {'':9}  {case.label}: {error}", 0.0
    seconds = points * steps / UPDATE_RATE if steps else None
    time = "" if seconds is None else spoken_time(seconds)
    told_steps = f"{steps:,.0f}" if steps else "not known"
    row = f"{points:>12,}  {memory / 1e6:>6.1f} MB  {told_steps:>12}  {time:>9}  {case.label}"
    return row, seconds


def _plan_text(plan: Plan, step_count_bound: int | None) -> str:
    """A plan in words: kernels, arrays, number of particles, time step, steps and time."""
    lines = _kernel_lines("kernels of a step", plan.step)
    lines += _kernel_lines("kernels now and then", plan.launches[len(plan.step) :])
    byte_count = sum(array.byte_count for array in plan.arrays.values())
    lines += [f"arrays: {len(plan.arrays)}, {byte_count:,} bytes"]
    groups = groupby(sorted(plan.arrays, key=_place), key=_place)
    lines += [_array_lines(place, [*names], plan) for place, names in groups]
    lines += [f"particles: {plan.particle_count:,}", f"time step: {plan.time_step:.4g} s"]
    if step_count_bound is not None:
        seconds = step_count_bound * plan.particle_count / UPDATE_RATE
        lines.append(
            f"steps: {step_count_bound:,} at most, {spoken_time(seconds)} at "
            f"{UPDATE_RATE / 1e6:.0f} million particle updates a second"
        )
    return "\n".join(lines)


def _kernel_lines(title: str, launches: Sequence[Launch]) -> list[str]:
    """The number of kernels, and each with its threads; [] for none."""
    if not launches:
        return []
    sizes = Counter(f"{it.name} {' x '.join(map(str, it.dim))}" for it in launches)
    told = (f"{text}{f' ({count} times)' if count > 1 else ''}" for text, count in sizes.items())
    return [f"{title}: {len(launches)}", _wrapped("  ", told)]


def _array_lines(place: str, names: Sequence[str], plan: Plan) -> str:
    """The arrays over points, nodes or whatever else, with their bytes together."""
    byte_count = sum(plan.arrays[name].byte_count for name in names)
    own = (name.partition(".")[2] for name in names)
    return _wrapped(f"  {place:12} {byte_count:>11,} bytes  ", own)


def _place(array: str) -> str:
    """What an array runs over: "node" for node.mass."""
    return array.partition(".")[0]


def _wrapped(head: str, words: Iterable[str]) -> str:
    """Words in lines below one another, after a head; none is broken at its blanks."""
    text, indent = ", ".join(word.replace(" ", "\xa0") for word in words), " " * len(head)
    filled = textwrap.fill(text, 100, initial_indent=head, subsequent_indent=indent)
    return filled.replace("\xa0", " ")
