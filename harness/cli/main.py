"""The command line: it runs a command and turns errors into messages and exit codes."""

import argparse
import importlib
import logging
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Sequence
from contextlib import suppress

from harness.cli.options import make_parser, mistake_in, unrecognised
from harness.cli.process import (
    BAD_INPUT,
    DEFECT,
    NOT_READ,
    Terminated,
    complete_streams,
    end_at_sigterm,
)
from harness.errors import HarnessError, defect, send_nowhere, tell, written
from mpm_warp.errors import ParameterError, SceneError, UnknownSceneError

REFUSALS = (HarnessError, ParameterError, SceneError, UnknownSceneError)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: words of the command line; by default those of the process.

    Returns:
        Exit code: 0 done; 1 done, but a case did not complete or a bound was missed; 2 bad input
        or unusable files; 70 an error of the program itself; 129 SIGHUP; 130 Ctrl-C; 141 the
        output is no longer read, as after `| head`; 143 SIGTERM.
    """
    complete_streams()
    parser = make_parser()
    if "_ARGCOMPLETE" in os.environ:
        importlib.import_module("harness.cli.commands.completion").complete(parser)
    given = sys.argv[1:] if arguments is None else list(arguments)
    # Names in a result may have letters that the font lacks; pictures then show a box.
    warnings.filterwarnings("ignore", message="Glyph .* missing from font")
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # the same for mathematical text
    # Jupyter names its own backend to every command, and matplotlib ends where it is not installed.
    os.environ.pop("MPLBACKEND", None)
    return _exit_code(parser, given)


def _exit_code(parser: argparse.ArgumentParser, given: Sequence[str]) -> int:
    """Run one command; an error is reported in one line."""
    try:
        end_at_sigterm()
        with written(sys.stdout):  # --version
            options = _parsed(parser, given)
        # Imported here so that help appears at once and only needed modules are loaded.
        module, function = options.function.split(".")
        command = getattr(importlib.import_module(f"harness.cli.commands.{module}"), function)
        if "matplotlib" in sys.modules:  # no matplotlibrc of the user changes a picture
            sys.modules["matplotlib"].rcdefaults()
        code: int = command(options)
    except BrokenPipeError:
        # Nobody reads the output any more, as in `harness run ... | head`: no message is needed.
        for stream in (sys.stdout, sys.stderr):
            send_nowhere(stream)
        return NOT_READ
    except (*REFUSALS, OSError, MemoryError) as error:
        tell(str(error) or "this machine does not have enough memory")
        return BAD_INPUT
    except KeyboardInterrupt as end:
        with suppress(BrokenPipeError):  # nobody reads what is told any more
            tell("interrupted")
        return 128 + (end.number if isinstance(end, Terminated) else signal.SIGINT)
    except Exception as error:
        if "--debug" in given:
            traceback.print_exc()
        tell(defect(error))
        return DEFECT
    return code


def _parsed(parser: argparse.ArgumentParser, given: Sequence[str]) -> argparse.Namespace:
    if (problem := mistake_in(given)) is not None:
        raise HarnessError(problem)
    options, unknown = parser.parse_known_args(given)
    if unknown:
        raise HarnessError(unrecognised(unknown, options.command))
    return options
