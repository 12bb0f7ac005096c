"""Progress of a study: a bar on a terminal, and a line for each case that has ended."""

from contextlib import AbstractContextManager
from typing import TextIO

from tqdm import tqdm

from harness.archive.case_files import Outcome
from harness.archive.conventions import COMPLETED
from harness.errors import LONGEST_LINE, coloured, printable, shortened
from harness.study.cases import Case

NOTICED = 0.05
"""Seconds to start or to compile that are shown, at least."""


class Display(AbstractContextManager["Display"]):
    """Shows so many cases as they run, with a bar where the stream is a terminal.

    It is a context that leaves the terminal's line clean.
    """

    def __init__(self, total: int, stream: TextIO) -> None:
        self.total = total
        self.stream = stream
        self.done = 0
        self.running: dict[str, float] = {}
        self.bar = tqdm(
            total=total,
            desc=f"0/{total} cases, ",
            file=stream,
            disable=not stream.isatty(),
            leave=False,
            miniters=0,
            smoothing=0,  # the time left follows from the mean speed so far
            bar_format="{bar:24} {desc}after {elapsed}, {remaining} left",
        )

    def __exit__(self, *_: object) -> None:
        self.bar.close()

    def advanced(self, case: Case, fraction: float) -> None:
        """A running case has come to `fraction`, 0 to 1."""
        self.running[case.key] = fraction
        self._update()

    def finished(self, case: Case, outcome: Outcome) -> None:
        """A case has ended, well or not."""
        self.done += 1
        self.running.pop(case.key, None)
        status = coloured(outcome.status, is_good=outcome.status == COMPLETED, stream=self.stream)
        label, message = (
            shortened(printable(text), LONGEST_LINE) for text in (case.label, outcome.message)
        )
        told = ", ".join(filter(None, (status, outcome.headline, message)))
        line = f"[{self.done}/{self.total}] {label}: {told}, {_times(outcome)}"
        self._update()
        tqdm.write(line, file=self.stream)
        self.stream.flush()

    def _update(self) -> None:
        """Bring the bar to the cases done, and the mean progress of those running."""
        told = [f"{self.done}/{self.total} cases"]
        if self.running:
            mean = sum(self.running.values()) / len(self.running)
            # Nothing is computed before all is imported, set up and compiled.
            told.append(
                f"{len(self.running)} {f'running, at {mean:.0%}' if mean else 'setting up'}"
            )
        self.bar.set_description_str(", ".join([*told, ""]), refresh=False)
        self.bar.update(self.done + sum(self.running.values()) - self.bar.n)


def _times(outcome: Outcome) -> str:
    """The time that a case computed, and apart from it those to start and to compile."""
    start, compiling = outcome.start_seconds, outcome.compile_seconds
    apart = [
        f"{seconds:.1f} s to {what}"
        for seconds, what in ((start, "start"), (compiling, "compile"))
        if seconds >= NOTICED
    ]
    computing = f"{outcome.seconds - start - compiling:.1f} s"
    return f"{computing} ({', '.join(apart)})" if apart else computing
