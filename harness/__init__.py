"""The benchmarking harness: parametric studies of scenes, archived and compared with references."""


class HarnessError(Exception):
    """What the user can put right; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an error that nobody has foreseen."""
    return " ".join(f"{type(error).__name__}: {error}".split())
