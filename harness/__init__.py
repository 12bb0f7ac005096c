"""The benchmarking harness: parametric studies of scenes, archived and compared with references."""


class HarnessError(Exception):
    """What the user can put right; the message is one line."""
