"""The commands help and completion, and the words that the Tab key offers in bash, zsh and fish.

At each Tab the shell runs the program itself, through argcomplete. Listing scenes takes a quarter
of a second, so it is done only for arguments that name scenes.
"""

import argparse
from collections.abc import Iterable

import argcomplete
from argcomplete.shell_integration import shellcode

from harness.cli.options import make_parser
from harness.cli.process import DONE
from harness.errors import say
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
    say(shellcode(["harness"], shell=options.shell))
    return DONE


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell that requests completions by environment variables, and end the process."""
    argcomplete.autocomplete(parser, default_completer=_Words())


class _Words(argcomplete.completers.BaseCompleter):
    """Offers words for an argument that has no fixed choices."""

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
