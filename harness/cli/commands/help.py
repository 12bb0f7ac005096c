"""The command `help`."""

from __future__ import annotations

import argparse

from harness.cli.arguments.command_line import make_parser
from harness.cli.exit_codes import DONE


def show_help(options: argparse.Namespace) -> int:
    """Print the help of the program, or of one command."""
    make_parser().parse_args([*([options.about] if options.about else []), "--help"])
    return DONE
