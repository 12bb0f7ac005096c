"""Slips of a command line that its parser could not explain: one line, with a remedy."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

SHOWN_LENGTH = 40
"""Characters of a word that are shown, at most."""


def slip(arguments: Sequence[str], commands: Collection[str]) -> str | None:
    """What is wrong with a command line before it is parsed; None where nothing is seen.

    Args:
        arguments: the command line without the program's name.
        commands: names of the commands.
    """
    for argument in arguments:
        if any("\ud800" <= character <= "\udfff" for character in argument):
            return f"{argument!r}: is not text, which results could not keep"
    return _unknown_command(arguments, commands) or _missing_quotes(arguments)


def unrecognised(words: Sequence[str], options: Collection[str]) -> str:
    """What a parser could make nothing of, and what was meant by it.

    Args:
        words: what is left over.
        options: those that the command has.
    """
    from mpm_warp.parameters import did_you_mean  # help is at once, without it

    first, *_ = words
    problem = f"unrecognized arguments: {' '.join(words)}"
    if first.startswith("-"):
        return problem + did_you_mean(first.partition("=")[0], options)
    if "=" in first and "--set" in options:
        return f"{problem}; a parameter is changed by --set {first}"
    return f"{problem}; what has blanks in it needs quotes"


def _unknown_command(arguments: Sequence[str], commands: Collection[str]) -> str | None:
    if not arguments or arguments[0].startswith("-") or arguments[0] in commands:
        return None
    from harness.study.files import study_names
    from mpm_warp.parameters import did_you_mean  # help is at once, without it

    word = arguments[0]
    shown = word if len(word) <= SHOWN_LENGTH else f"{word[:SHOWN_LENGTH]}..."
    if word.endswith(".toml") or word in study_names():
        return f"{shown}: is no command, but a study: run it by `harness run {shown}`"
    if word.endswith(".nc"):
        return f"{shown}: is no command, but a result: show it by `harness compare {shown}`"
    near = did_you_mean(word, commands)
    return f"{shown}: is no command{near or '; `harness --help` lists them'}"


def _missing_quotes(arguments: Sequence[str]) -> str | None:
    """Where a shell has cut the value of a setting in pieces, or has eaten its quotes."""
    for place, argument in enumerate(arguments):
        if argument == "--set" and place + 1 < len(arguments):
            start, pieces = "--set ", arguments[place + 1 :]
        elif argument.startswith("--set="):
            start, pieces = "", arguments[place:]
        else:
            continue
        if _open_brackets(pieces[0]) <= 0:
            continue
        for count in range(2, len(pieces) + 1):
            whole = " ".join(pieces[:count])
            if _open_brackets(whole) == 0:
                key, _, value = whole.removeprefix("--set=").partition("=")
                return (
                    f"{start}{pieces[0]}: the shell has cut the value at a blank; "
                    f"put quotes around it: --set '{key}={value}'"
                )
        return f"{start}{pieces[0]}: a bracket is opened and not closed"
    return None


def _open_brackets(text: str) -> int:
    """Brackets that are opened and not closed, those in texts left aside."""
    bare = re.sub(r'"[^"]*"', "", text)
    return sum(bare.count(it) for it in "[{") - sum(bare.count(it) for it in "]}")
