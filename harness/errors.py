"""What is printed: results by `say`, messages of one line by `tell`, and errors.

Text that comes from a file can neither set a colour nor move the cursor.
"""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

LONGEST_LINE = 1000
"""Characters that a message may have."""
DEVELOPERS = "the mpm_warp developers"
"""To whom errors of the program are reported."""


class HarnessError(Exception):
    """An error that the user can correct; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an unexpected error in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def defect(error: BaseException) -> str:
    """One line for an error of the program itself, with where to report it."""
    return (
        f"an error of the program, not of your input: {in_one_line(error)}; please report it to "
        f"{DEVELOPERS}, with the command and what --debug prints"
    )


def printable(text: str) -> str:
    """A text with every non-printable character written as its escape sequence.

    So a text from a file cannot move the cursor of the terminal or overwrite other messages.
    """
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


def shortened(text: str, longest: int = LONGEST_LINE) -> str:
    """A printable text; if it is longer than `longest` characters its middle is left out."""
    text, half = printable(text), longest // 2
    # The end is kept because it names the remedy.
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def counted(count: int, noun: str) -> str:
    """A number of things in words: ``1 file``, ``2 files``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def send_nowhere(stream: TextIO) -> None:
    """Send further output of a stream to the null device, so that closing it raises no error."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)


@contextmanager
def written(stream: TextIO) -> Iterator[None]:
    """Print to a standard stream inside a ``with``; it is flushed at the end.

    If it cannot be written, as on a full disk, standard output is an error, and what goes to
    standard error is dropped.
    """
    try:
        try:
            yield
        finally:
            stream.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno == errno.EINVAL:  # what Windows says of a closed pipe
            raise BrokenPipeError from None
        send_nowhere(stream)
        if stream is sys.stdout:
            why = f"standard output: cannot be written: {error.strerror}"
            raise HarnessError(why) from None


def say(*lines: object) -> None:
    """Print lines of a result on standard output; only line ends and tabs control the terminal."""
    text = "\n".join(map(str, lines))
    with written(sys.stdout):
        print("".join(it if it in "\n\t" else printable(it) for it in text))


def tell(message: str) -> None:
    """Print one line of limited length on standard error, apart from results."""
    with written(sys.stderr):
        print("harness:", shortened(" ".join(message.split())), file=sys.stderr)
