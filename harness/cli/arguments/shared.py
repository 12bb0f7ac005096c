"""Options that several commands take."""

from __future__ import annotations

import argparse
from pathlib import Path

from mpm_warp.execution import THREAD_COUNTS


def add_study(command: argparse.ArgumentParser) -> None:
    """A study, and what is changed of it."""
    command.add_argument("study", metavar="STUDY", help="name of a study, or a TOML file")
    add_settings(command)


def add_subject(command: argparse.ArgumentParser) -> None:
    """A scene or a study."""
    command.add_argument(
        "subject", metavar="NAME", help="of a scene or a study, or the TOML file of a study"
    )


def add_settings(command: argparse.ArgumentParser) -> None:
    """Where results are, and what is changed of the study."""
    command.add_argument(
        "--out",
        type=Path,
        default=Path("results"),
        metavar="DIR",
        help="folder of the results; default: results",
    )
    add_set(command)


def add_set(command: argparse.ArgumentParser) -> None:
    """What is changed of a study or scene."""
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a parameter; a list, as in 'KEY=[1, 2]', varies it; repeatable",
    )


def add_execution(command: argparse.ArgumentParser) -> None:
    """How a case is computed: its threads and its device."""
    command.add_argument(
        "--threads",
        type=int,
        choices=THREAD_COUNTS,
        metavar="N",
        help="threads of a case, 1, 2 or 4; the result does not change; default: idle cores help",
    )
    add_device(command)


def add_device(command: argparse.ArgumentParser) -> None:
    """What computes."""
    command.add_argument(
        "--device", default="cpu", metavar="NAME", help="cpu, the default, or a GPU: cuda:0, ..."
    )
