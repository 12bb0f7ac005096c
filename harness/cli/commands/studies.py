"""Commands on what there is: a new study; what a scene, a study, a reference, a command is."""

from __future__ import annotations

import argparse
import json
import re
import shlex
from pathlib import Path

from harness.archive.atomic_files import write_whole
from harness.cli.options import make_parser
from harness.cli.process import DONE
from harness.errors import HarnessError, tell
from harness.references.registry import all_entries, one_entry
from harness.study.description import scene_rows, study_rows, study_text
from harness.study.files import STUDY_NAME, find_study, study_names
from harness.study.schema import study_schema
from harness.study.study import is_scene, load_study
from mpm_warp.scenes import scene_class, scene_names


def new(options: argparse.Namespace) -> int:
    """Write the definition of a new study, which runs as it stands."""
    name = options.name.removesuffix(".toml")
    path = Path(f"{name}.toml")
    if not re.fullmatch(STUDY_NAME, name):
        raise HarnessError(
            f"{options.name}: is no name of a study: letters, digits, '_', '-' and '.'; it is "
            "written into the current folder"
        )
    if name in study_names():
        raise HarnessError(f"{name}: is a study that ships; their results would mix: another name")
    if path.exists() or path.is_symlink():
        raise HarnessError(f"{path}: is there already; edit it, or take another name")
    if options.scene in study_names() and options.scene not in scene_names():
        scene = load_study(options.scene).parts[0].name
        raise HarnessError(f"--scene {options.scene}: is a study; its scene is {scene}")
    write_whole(study_text(name, options.scene).encode(), path)
    tell(f"edit {path}, then: harness run {shlex.quote(str(path))}")
    print(path)
    return DONE


def list_names(options: argparse.Namespace) -> int:
    """Print the studies and scenes that there are."""
    print("studies:")
    for name in study_names():
        print(f"  {name:24} {load_study(name).title}")
    print("scenes:")
    for name in scene_names():
        print(f"  {name:24} {scene_class(name).summary}")
    return DONE


def describe(options: argparse.Namespace) -> int:
    """Print a scene's parameters, or what a study is."""
    if not is_scene(options.subject):
        print(*study_rows(load_study(options.subject)), sep="\n")
        return DONE
    print(*scene_rows(options.subject), sep="\n")
    if options.subject in study_names():
        tell(f"a study is called {options.subject}, too: harness describe {_file(options.subject)}")
    return DONE


def _file(study: str) -> str:
    return shlex.quote(str(find_study(study)))


def schema(options: argparse.Namespace) -> int:
    """Print the JSON schema of studies."""
    print(json.dumps(study_schema(), indent=2))
    return DONE


def references(options: argparse.Namespace) -> int:
    """Print all references and all experience, or one of them in full."""
    print(all_entries() if options.id is None else one_entry(options.id))
    return DONE


def show_help(options: argparse.Namespace) -> int:
    """Print the help of the program, or of one command."""
    make_parser().parse_args([*([options.about] if options.about else []), "--help"])
    return DONE
