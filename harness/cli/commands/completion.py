"""Help, and completion by the Tab key in bash, zsh and fish: what is offered where.

The shell runs the program itself at each Tab, by argcomplete. Scenes are listed only where names
of scenes are offered, which takes a quarter of a second.
"""

import argparse
from collections.abc import Iterable

import argcomplete
from argcomplete.shell_integration import shellcode

from harness.cli.options import make_parser
from harness.cli.process import DONE
from harness.study.files import study_names
from mpm_warp.scenes import scene_names

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
            words += scene_names()
        if action.dest in RESULTS:
            endings.append("nc")
        files = argcomplete.completers.FilesCompleter(endings)(prefix) if endings else ()
        return [*words, *files]
