"""Errors: those that the user can put right, and those of the program; how each is reported."""

import sys

LONGEST_LINE = 1000
"""Characters of a line that is reported."""
DEVELOPERS = "the mpm_warp developers"
"""Who takes reports: the authors of the package."""


class HarnessError(Exception):
    """What the user can put right; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an error that nobody has foreseen, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def defect(error: BaseException) -> str:
    """An error of the program itself in one line, and where to report it."""
    return (
        f"an error of the program, not of your input: {in_one_line(error)}; please report it to "
        f"{DEVELOPERS}, with the command and what --debug prints"
    )


def printable(text: str) -> str:
    """A text in which each character that cannot be printed is written as its escape.

    A text out of a file must not move the cursor of a terminal, or say what is not so.
    """
    return "".join(it if it.isprintable() else ascii(it)[1:-1] for it in text)


def shortened(text: str, longest: int) -> str:
    """A text of at most about `longest` characters, without its middle if it has more."""
    half = longest // 2
    # The end of a message names the remedy.
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def tell(message: str) -> None:
    """Print one line of bounded length on standard error, where it does not mix with results."""
    line = shortened(printable(" ".join(message.split())), LONGEST_LINE)
    print("harness:", line, file=sys.stderr)
