"""The command line: which command does what, and how it ends where something goes wrong."""

from __future__ import annotations

import argparse
import importlib
import os
import signal
import sys
from collections.abc import Sequence

from harness.cli.arguments import make_parser, options_of
from harness.cli.exit_codes import BAD_INPUT, Terminated, complete_streams
from harness.cli.slips import slip, unrecognised
from harness.errors import HarnessError, tell
from mpm_warp.errors import UnknownSceneError

COMMANDS = {
    "new": "study_commands.new",
    "run": "run_commands.run",
    "rerun": "run_commands.rerun_case",
    "verify": "run_commands.verify_scenes",
    "bench": "run_commands.bench",
    "status": "archive_commands.status",
    "collect": "archive_commands.collect",
    "clean": "archive_commands.clean",
    "list": "study_commands.list_names",
    "describe": "study_commands.describe",
    "schema": "study_commands.schema",
    "plan": "plan_commands.show_plan",
    "compare": "result_commands.compare",
    "plot": "result_commands.plot",
    "report": "result_commands.report",
    "recommend": "result_commands.show_recommendation",
    "references": "reference_commands.references",
    "help": "help_commands.show_help",
    "completion": "completion.completion",
}
"""Module and function of each command; it is given the options and returns the exit code."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: the command line without the program's name; default: that of the process.

    Returns:
        Exit code: 0 done, 1 a case did not complete or a bound is not reached,
        2 bad input or unusable files, 130 Ctrl-C, 141 the reader of its output has gone,
        143 SIGTERM.
    """
    complete_streams()
    parser = make_parser()
    if "_ARGCOMPLETE" in os.environ:
        importlib.import_module("harness.cli.completion").complete(parser)
    given = sys.argv[1:] if arguments is None else list(arguments)
    try:
        options = _parsed(parser, given)
        # Imported only now: help is at once, and what a command does not need is not loaded.
        module, function = COMMANDS[options.command].split(".")
        command = getattr(importlib.import_module(f"harness.cli.{module}"), function)
        code: int = command(options)
    except BrokenPipeError:
        # The reader of the output has gone, as in `harness run ... | head`: no message is needed.
        null = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(null, stream.fileno())
        return 128 + signal.SIGPIPE
    except (HarnessError, UnknownSceneError, OSError) as error:
        tell(str(error))
        return BAD_INPUT
    except Terminated:
        return 128 + signal.SIGTERM
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    return code


def _parsed(parser: argparse.ArgumentParser, given: Sequence[str]) -> argparse.Namespace:
    """The command and its options.

    Raises:
        HarnessError: something is wrong with the command line.
        SystemExit: a value is, which the parser has told; or help was asked for.
    """
    if (problem := slip(given, COMMANDS)) is not None:
        raise HarnessError(problem)
    options, unknown = parser.parse_known_args(given)
    if unknown:
        raise HarnessError(unrecognised(unknown, options_of(parser, options.command)))
    return options
