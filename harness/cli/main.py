"""The command line: which command does what, and how it ends where something goes wrong."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

from harness.cli import result_commands, scene_commands, study_commands
from harness.cli.arguments import make_parser
from harness.cli.exit_codes import BAD_INPUT, Terminated, complete_streams
from harness.errors import HarnessError, tell
from mpm_warp.scenes import UnknownSceneError

COMMANDS = {
    "run": study_commands.run,
    "status": study_commands.status,
    "collect": study_commands.collect,
    "clean": study_commands.clean,
    "rerun": study_commands.rerun_case,
    "list": scene_commands.list_names,
    "describe": scene_commands.describe,
    "schema": scene_commands.schema,
    "plan": scene_commands.show_plan,
    "verify": scene_commands.verify_scenes,
    "bench": study_commands.bench,
    "compare": result_commands.compare,
    "plot": result_commands.plot,
    "report": result_commands.report,
    "recommend": result_commands.show_recommendation,
}
"""What each command does; it returns the exit code."""


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
    given = sys.argv[1:] if arguments is None else list(arguments)
    for argument in given:
        if any("\ud800" <= character <= "\udfff" for character in argument):
            tell(f"{argument!r}: is not text, which results could not keep")
            return BAD_INPUT
    options = make_parser().parse_args(given)
    try:
        code = COMMANDS[options.command](options)
    except BrokenPipeError:
        # Whoever read the output has gone, as in `harness run ... | head`: nobody is to be told.
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
