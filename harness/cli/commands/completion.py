"""Help, and completion by the Tab key in bash, zsh and fish: what is offered where, found at once.

The shell runs the program itself at each Tab, by argcomplete. So nothing that computes is imported
here: names of scenes are read out of their source files.
"""

import argparse
import importlib.util
import re
from collections.abc import Iterable
from importlib.metadata import entry_points
from pathlib import Path

import argcomplete
from argcomplete.shell_integration import shellcode

from harness.cli.options import make_parser
from harness.cli.process import DONE
from harness.study.files import study_names

STUDIES = ("study", "subject")
RESULTS = ("file", "other", "study")
"""Names of arguments that take studies, and those that take results."""


def show_help(options: argparse.Namespace) -> int:
    """Print the help of the program, or of one command."""
    make_parser().parse_args([*([options.about] if options.about else []), "--help"])
    return DONE


def completion(options: argparse.Namespace) -> int:
    """Print the code by which a shell completes the command line."""
    print(shellcode(["harness"], shell=options.shell))
    return DONE


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell that asks by its environment for completions, and end the process."""
    argcomplete.autocomplete(parser, default_completer=_Words())


class _Words(argcomplete.completers.BaseCompleter):
    """What fits an argument that has no fixed choices."""

    def __call__(
        self,
        *,
        prefix: str,
        action: argparse.Action,
        parser: argparse.ArgumentParser,
        parsed_args: argparse.Namespace,
    ) -> Iterable[str]:
        words: list[str] = []
        endings: list[str] = []
        if action.dest in STUDIES:
            words += study_names()
            endings.append("toml")
        if action.dest in ("scene", "subject"):
            words += scene_names_at_once()
        if action.dest in RESULTS:
            endings.append("nc")
        if action.dest in ("out", "results", "set"):
            return ()
        files = argcomplete.completers.FilesCompleter(endings)(prefix) if endings else ()
        return [*words, *files]


def scene_names_at_once() -> list[str]:
    """Names of all scenes, sorted, without importing any: a scene says its `summary` itself."""
    package = importlib.util.find_spec("mpm_warp")
    assert package is not None, "it has imported this module"
    assert package.submodule_search_locations is not None
    folder = Path(package.submodule_search_locations[0]) / "scenes"
    names = {point.name for point in entry_points(group="mpm_warp.scenes")}
    for file in folder.rglob("*.py"):
        for definition in re.split(r"^class ", file.read_text("utf-8"), flags=re.MULTILINE)[1:]:
            if "\n    summary = " in definition:
                name = re.match(r"\w+", definition)
                assert name is not None
                names.add(re.sub(r"(?<!^)(?=[A-Z])", "_", name[0]).lower())
    return sorted(names)
